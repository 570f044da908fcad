"""Tutorial: what accuracy costs: the error of the force against the time of a force and of a deformation, by size of model.

Usage: python3 what_accuracy_costs.py DATABASE.h5 FOLDER [SOLVES]          30 fresh finite element solves without SOLVES

FOLDER then has the picture costs.png. The distance of the finite elements to a finer solution is not in it: phynness check.
"""
import sys
import time
from collections.abc import Callable
from pathlib import Path

import matplotlib  # type: ignore[import]
import numpy as np
from numpy.typing import NDArray

import phynness

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402


def microseconds(call: Callable[[], object], rows: int) -> float:
    """Time of one row: the median of nine calls with many rows."""
    times = []
    for _ in range(9):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return 1e6 * float(np.median(times)) / rows


def main(file: str, out: Path, solves: int) -> None:
    out.mkdir(parents=True, exist_ok=True)
    models = {n: phynness.train(file, force_centers=5 * n, amplitude_centers=5 * n, modes=n, shared_modes=4 * n)
              for n in (2, 4, 8, 16)}
    largest = models[16]

    # Fresh states: random nodes, directions, and depths within the trained range.
    random = np.random.default_rng(1)
    states = []
    for node in random.choice(largest.active_nodes, solves):
        way = random.normal(size=3)
        way /= np.linalg.norm(way)
        states.append((int(node), way * float(largest.trained_depth(int(node), way)) * random.uniform(0.05, 0.99)))
    truth = np.concatenate([phynness.solve(file, node, d).force for node, d in states])
    solved = np.isfinite(truth[:, 0])
    linear = np.array([largest.stiffness(node, [0, 0, 0]) @ d for node, d in states])

    def error(forces: NDArray[np.float64]) -> NDArray[np.float64]:
        percent: NDArray[np.float64] = 100 * np.linalg.norm((forces - truth)[solved], axis=1) / np.linalg.norm(truth[solved], axis=1)
        return percent

    print(f"{solved.sum()} of {solves} fresh states solved; errors in % of each force, mean and p95")
    print(f"linear predictor     {error(linear).mean():6.2f} {np.quantile(error(linear), 0.95):6.2f}")
    costs = []
    for n, model in models.items():
        e = error(np.array([model.force(node, d) for node, d in states]))
        node, d = states[0][0], np.linalg.norm(states[0][1]) * random.uniform(-0.5, 0.5, (20000, 3))
        costs.append((microseconds(lambda: model.force(node, d), 20000), microseconds(lambda: model.deform(node, d[:200]), 200),
                      e.mean(), np.quantile(e, 0.95)))
        print(f"{n:2} modes, {5 * n:2} centers {costs[-1][2]:6.2f} {costs[-1][3]:6.2f}   force {costs[-1][0]:.2f} us, "
              f"deformation {costs[-1][1]:.1f} us, model.txt {len(model.text) // 1000} kB")
    _, deform_us, mean, p95 = np.array(costs).T
    picture, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    axes.loglog(deform_us, mean, "o-", label="mean")
    axes.loglog(deform_us, p95, "^:", label="95 % of the states")
    axes.axhline(error(linear).mean(), color="gray", label="linear predictor, mean")
    axes.set(xlabel="time of a deformation on one core [us]", ylabel="error of the force [%]", title=largest.title)
    axes.legend(fontsize="x-small")
    picture.savefig(out / "costs.png", dpi=120)
    print(f"written: {out}/costs.png")


main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 30)
