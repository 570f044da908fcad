#!/usr/bin/python3
"""Compares databases of the same scene and mesh, made by different programs or on different machines.

Usage: compare_databases.py TOLERANCE REFERENCE.h5 OTHER.h5 ...
Prints for each OTHER the largest difference of each quantity over the largest value of this quantity in the reference.
Exit status: 0 every difference of a quantity is at most TOLERANCE and outcomes are the same, 1 otherwise, 2 wrong usage.
"""

import sys
from pathlib import Path

import h5py
import numpy as np

QUANTITIES = ("force", "displacement", "energy", "min_jacobian", "tangent")


def difference(ours, reference):
    """Largest difference over the largest value; NaN if any value is NaN. Shapes must agree."""
    if ours.shape != reference.shape:
        raise ValueError(f"shape {ours.shape} instead of {reference.shape}")
    if reference.size == 0:
        raise ValueError("no values")
    scale = np.abs(reference).max()
    return np.abs(ours - reference).max() / (scale if scale > 0 else 1.0)


def compare(path, reference, tolerance):
    """Prints the line of `path`. Returns True if it agrees."""
    with h5py.File(path) as f, h5py.File(reference) as r:
        for kind in ("physics_hash", "mesh_hash"):
            if f.attrs[kind] != r.attrs[kind]:
                raise ValueError(f"not the same scene and mesh: {kind} {f.attrs[kind]} instead of {r.attrs[kind]}")
        ours, theirs = f["responses"], r["responses"]
        differing = int((ours["status"][()] != theirs["status"][()]).sum())
        converged = int((theirs["status"][()] == 0).sum())
        found = {q: difference(ours[q][()], theirs[q][()]) for q in QUANTITIES if q in theirs}
    words = ", ".join(f"{q} {d:.1e}" for q, d in found.items())
    print(f"{Path(path).stem}: {converged} states, {differing} with other outcomes; {words}")
    # The comparison is false for NaN.
    return converged > 0 and differing == 0 and all(d <= tolerance for d in found.values())


def main(arguments):
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    tolerance, reference, *others = arguments
    agree = True
    for path in others:
        try:
            agree = compare(path, reference, float(tolerance)) and agree
        except (OSError, KeyError, ValueError) as error:
            print(f"{path} against {reference}: {error}", file=sys.stderr)
            agree = False
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
