#!/usr/bin/python3
"""Prints what disturbed data do to a model: rays that failed, rays that end early, noise, and spreads of the paper's networks
(docs/stability.md). Every row is compared with the same fresh solves at ten nodes.

Usage: lab/study stability SCENE DATABASE.h5 [--probes N] [--seed N]
"""

import argparse
import pathlib
import shutil
import tempfile

import h5py
import numpy as np
from commands import answer, changed, run, text

SEED = 7


def disturbed(source, copy, change):
    """A copy of a database in which change(status, values, code) replaced outcomes and values; values: force, displacement."""
    shutil.copyfile(source, copy)
    with h5py.File(copy, "r+") as f:
        r = f["responses"]
        code = dict(zip(text(r["status"].attrs["flag_meanings"]).split(), r["status"].attrs["flag_values"].tolist()))
        status, values = r["status"][()], {k: r[k][()] for k in ("force", "displacement")}
        change(status, values, code)
        r["status"][...] = status
        for name, value in values.items():
            r[name][...] = value


def fail(status, code, rays, first):
    """Rays (A x D, true) fail at the increment `first`."""
    for a, d in np.argwhere(rays & (status[..., first] == 0)):
        status[a, d, first:] = code["after_failure"]
        status[a, d, first] = code["diverged"]


def with_failed_rays(source, copy, share):
    def change(status, values, code):
        random, rays = np.random.default_rng(SEED), np.zeros(status.shape[:2], bool)
        for of_node in rays:
            of_node[random.permutation(len(of_node))[:round(share * len(of_node))]] = True
        fail(status, code, rays, 0)

    disturbed(source, copy, change)


def ending_at_half(status, values, code):
    fail(status, code, np.ones(status.shape[:2], bool), status.shape[2] // 2)


def one_ray(status, values, code):
    rays = np.ones(status.shape[:2], bool)
    rays[:, 0] = False
    fail(status, code, rays, 0)


def noise(level):
    """Normal, in each component: its deviation is `level` times the node's largest force, or largest displacement."""

    def change(status, values, code):
        random = np.random.default_rng(SEED)
        for value in values.values():
            size = np.linalg.norm(np.where(np.isfinite(value), value, 0), axis=-1)
            largest = size.reshape(len(size), -1).max(1).reshape(-1, *(1,) * (value.ndim - 1))
            value += (level * largest * random.normal(size=value.shape)).astype(value.dtype)

    return change


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("database")
    parser.add_argument("--probes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        copy, model, scene = (pathlib.Path(folder) / name for name in ("disturbed.h5", "model", "spreads.toml"))

        def row(name, family, database, trained=options.scene):
            run("train", trained, database, "-o", model, "--family", family)
            found = answer("validate", options.scene, model, "--probes", options.probes, "--nodes", 10, "--seed", options.seed)
            figures = [" ".join("%.3g" % (100 * found["inside"][what][k]) for k in ("mean", "p95", "max"))
                       for what in ("force", "displacement")]
            print(f"{family}, {name}: force {figures[0]}; displacement {figures[1]} (mean, p95, max in %)", flush=True)

        for family in ("modal", "rbfn"):
            row("as it is", family, options.database)
            for share in (0.1, 1 / 3, 2 / 3):
                with_failed_rays(options.database, copy, share)
                row(f"{100 * share:.0f} % of the rays failed", family, copy)
            for name, change in [("all rays failed but one", one_ray), ("rays end at half depth", ending_at_half)] + [
                    (f"noise {level:g}", noise(level)) for level in (1e-4, 1e-3, 1e-2)]:
                disturbed(options.database, copy, change)
                row(name, family, copy)
        for spread in (0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0):
            spreads = {("training", "deformation_spread"): spread, ("training", "force_spread"): spread}
            scene.write_text(changed(pathlib.Path(options.scene).read_text(), spreads))
            row(f"both spreads {spread:g}", "rbfn", options.database, scene)


if __name__ == "__main__":
    main()
