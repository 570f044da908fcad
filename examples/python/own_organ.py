"""Tutorial: your own organ: solve a scene, train, compare with fresh solves, and draw what a tool feels.

Usage: python3 own_organ.py SCENE FOLDER [RANKS]          for example scenes/demo.toml out/own 2

FOLDER then has the database, the model, the page organ.html and the picture organ.png.
"""
import sys
import warnings
from pathlib import Path

import matplotlib  # type: ignore[import]
import numpy as np

import phynness

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402


def main(scene: str, out: Path, ranks: int) -> None:
    out.mkdir(parents=True, exist_ok=True)
    file = out / "database.h5"
    phynness.precompute(scene, file, ranks=ranks, resume=file.exists())
    model = phynness.train(file)
    model.save(out / "model")
    figures = phynness.validate(scene, model, probes=20, ranks=ranks)
    for name in ("force", "displacement"):
        here, linear = figures["inside"][name], figures["linear"]["inside"][name]
        print(f"{name}: mean {100 * here['mean']:.2f} %, p95 {100 * here['p95']:.2f} %, linear predictor {100 * linear['mean']:.2f} %")

    # What a tool feels at one place: the model, the linear predictor, and fresh finite element solves.
    node = int(model.active_nodes[len(model.active_nodes) // 2])
    picture, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    for color, (name, way) in zip(("C0", "C1", "C2"), {"push": (0, 0, -1.0), "pull": (0, 0, 1.0), "slide": (1.0, 0, 0)}.items()):
        depth = 0.999 * float(model.trained_depth(node, way))
        d = np.linspace(0, depth, 50)[:, None] * way
        solved = phynness.solve(file, node, d[9::10])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", phynness.OutsideWarning)  # near the end of the range
            forces = model.force(node, d)
        mm, size = 1000 * np.linalg.norm(d, axis=1), np.linalg.norm
        axes.plot(mm, size(forces, axis=1), color, label=f"{name}: model")
        axes.plot(mm, size(d @ model.stiffness(node, [0, 0, 0]), axis=1), color, ls=":", label="linear predictor")
        axes.plot(mm[9::10], size(solved.force, axis=1), color, ls="", marker="o", label="finite elements")
    axes.set(xlabel="displacement of the tool [mm]", ylabel="force [N]", title=f"{model.title}: node {node}")
    axes.legend(ncols=3, fontsize="x-small")
    picture.savefig(out / "organ.png", dpi=120)
    model.show(out / "organ.html", database=file)
    print(f"written: {out}/model, {out}/organ.html, {out}/organ.png")


main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 1)
