"""Tutorial: your own data: a conservative force from measurements of one place, which need no finite elements.

Usage: python3 own_data.py MEASUREMENTS.h5 FOLDER          a file as elsewhere/measurements.py writes it

FOLDER then has model.txt, which every program of the runtime evaluates, and the picture measured.png.
"""
import sys
import warnings
from pathlib import Path

import h5py  # type: ignore[import]
import matplotlib  # type: ignore[import]
import numpy as np

import phynness

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402


def main(file: str, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    with h5py.File(file) as data:
        of_place = data["touched"][()] == data["touched"][0]
        d, forces, truth = (data[name][()][of_place] for name in ("displacements", "forces", "true_forces"))
    fitted_rows = np.arange(len(d)) % 5 != 0
    fitted = phynness.ConservativeForce(centers=40).fit(d[fitted_rows], forces[fitted_rows])
    fitted.save(out / "model.txt")
    stiffness = np.linalg.lstsq(d[fitted_rows], forces[fitted_rows], rcond=None)[0]

    rows, largest = ~fitted_rows, np.linalg.norm(truth, axis=1).max()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", phynness.OutsideWarning)  # a few rows lie at the edge of the others
        predicted = fitted.predict(d[rows])
    answers = {"model": predicted, "linear predictor": d[rows] @ stiffness, "measured": forces[rows]}
    picture, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    for name, answer in answers.items():
        error = np.linalg.norm(answer - truth[rows], axis=1) / largest
        print(f"{name}: off by {100 * error.mean():.1f} % in the mean, p95 {100 * np.quantile(error, 0.95):.1f} %")
        axes.plot(1000 * np.linalg.norm(d[rows], axis=1), 100 * error, "o", ms=4, label=name)
    axes.set(xlabel="displacement [mm]", ylabel="error [% of the largest force]",
             title=f"{rows.sum()} held-out of {len(d)} measurements, 1 % noise")
    axes.legend()
    picture.savefig(out / "measured.png", dpi=120)
    print(f"written: {out}/model.txt, {out}/measured.png")


main(sys.argv[1], Path(sys.argv[2]))
