#!/usr/bin/python3
"""Compares databases of the same scene ray by ray: which rays have other outcomes, and which have other forces.

Usage: compare_rays.py REFERENCE.h5 OTHER.h5 ... [--folder DIR] [--tolerance T]
A force differs if the difference exceeds T (1e-5) times the largest force of the ray in both databases. Every ray that
differs is printed with its first different increment, and with J and the energy there.
Exit status: 0 also if rays differ; 2 wrong usage or files that cannot be compared.
"""

import argparse
import sys
from pathlib import Path

import h5py
import numpy as np


def read(path):
    with h5py.File(path) as f:
        r = f["responses"]
        names = dict(zip(r["status"].attrs["flag_values"].tolist(), text(r["status"].attrs["flag_meanings"]).split()))
        return {
            "hashes": (text(f.attrs["physics_hash"]), text(f.attrs["mesh_hash"])),
            "active": f["sets/active"][()],
            "names": names,
            **{k: r[k][()] for k in ("status", "force", "energy", "min_jacobian", "iterations", "negative_pivots")},
        }


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def describe(data, name):
    status = data["status"]
    asked = status != 1
    outcomes = {label: int((status == code).sum()) for code, label in data["names"].items()}
    kept = ", ".join(f"{n} {label}" for label, n in outcomes.items() if n and label != "not_requested")
    rays = int(((status < 0) & asked).any(axis=2).sum())
    unstable = int(((data["negative_pivots"] > 0) & (status == 0)).sum())
    print(f"{name}: {kept}; {rays} rays without full depth, {unstable} unstable states, "
          f"{data['iterations'].sum() / max(1, (status == 0).sum()):.3f} iterations for each converged increment")


def compare(reference, other, name, tolerance):
    if reference["hashes"] != other["hashes"]:
        raise ValueError(f"{name} belongs to another scene or mesh")
    both = (reference["status"] == 0) & (other["status"] == 0)
    scale = np.maximum(np.abs(reference["force"]).max(axis=(2, 3)), np.abs(other["force"]).max(axis=(2, 3)))
    gap = np.abs(reference["force"] - other["force"]).max(axis=3) / np.where(scale > 0, scale, 1)[..., None]
    gap = np.where(both, gap, 0)
    outcome = (reference["status"] != other["status"]).any(axis=2)
    force = (gap > tolerance).any(axis=2)
    print(f"\n{name}: of {outcome.size} rays {int(outcome.sum())} have another outcome, "
          f"{int((force & ~outcome).sum())} others have another force; "
          f"all remaining forces agree to {gap[~(outcome | force)].max(initial=0):.1e}")
    for a, d in np.argwhere(outcome | force):
        differs = (reference["status"][a, d] != other["status"][a, d]) | (gap[a, d] > tolerance)
        i = int(np.argmax(differs))
        last = max(0, i - 1)
        print(f"  node {reference['active'][a]}, direction {d}, from increment {i + 1}: "
              f"{label(reference, a, d, i)} | {label(other, a, d, i)}; "
              f"J before it {reference['min_jacobian'][a, d, last]:.4f}, force differs by {gap[a, d].max():.1e}")


def label(data, a, d, i):
    name = data["names"][int(data["status"][a, d, i])]
    if name != "converged":
        return name
    return f"energy {data['energy'][a, d, i]:.6g} J, J {data['min_jacobian'][a, d, i]:.4f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--folder", type=Path, default=Path())
    parser.add_argument("--tolerance", type=float, default=1e-5)
    arguments = parser.parse_args()
    try:
        data = [(path.stem, read(arguments.folder / path)) for path in arguments.files]
        for name, d in data:
            describe(d, name)
        for name, d in data[1:]:
            compare(data[0][1], d, f"{name} against {data[0][0]}", arguments.tolerance)
    except (OSError, KeyError, ValueError) as error:
        print(f"compare_rays: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
