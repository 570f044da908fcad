"""Trains on four fifths of the rows of a file of responses (formats/imported.md), and compares with the others.

Usage: python3 compare.py FILE.h5 [FAMILY ...]          families: modal, rbfn

Errors are fractions of the largest force, or displacement, of the touched node: mean / 95th percentile / maximum. Beside the
model stands the linear predictor, f = K d with K by least squares over the same rows. If the file has `true_forces`, as that of
measurements, these are compared with.
"""
import sys
import tempfile
import warnings
from pathlib import Path

import h5py
import numpy as np

import phynness


def three(errors):
    return " / ".join(f"{100 * e:.2f}" for e in (errors.mean(), np.quantile(errors, 0.95), errors.max())) + " %"


def compare(file, families=("modal", "rbfn"), **keys):
    """Prints a table. Keys are those of [training]. Returns {(family or "linear", "force" or "displacement"): errors}, one for each held-out row."""
    with h5py.File(file) as h5:
        data = {name: dataset[()] for name, dataset in h5.items()}
        title = h5.attrs.get("title", "")
    touched = np.broadcast_to(data["touched"], len(data["forces"]))
    d, forces = data["displacements"], data["forces"]
    truth, u = data.get("true_forces", forces), data.get("output_displacements")
    held_out = np.random.default_rng(1).permutation(len(d)) % 5 == 0
    given = {"points": data["points"], "cells": data.get("tetrahedra", data.get("triangles")), "title": title}
    given.update({name: data[name] for name in ("fixed", "output") if name in data})
    for name in ("energies", "output_displacements"):
        if name in data:
            given[name] = data[name][~held_out]
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        database = phynness.Database.from_arrays(
            Path(folder) / "database.h5", touched=touched[~held_out], displacements=d[~held_out], forces=forces[~held_out], **given)
        for family in families:
            model = phynness.train(database, family=family, **keys)
            for node in np.unique(touched):
                test, train = held_out & (touched == node), ~held_out & (touched == node)
                add = lambda who, what, errors: found.setdefault((who, what), []).extend(errors)
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # some of these are a little longer than those of the training
                    said, moved = model.force(node, d[test]), model.deform(node, d[test]) if u is not None else None
                size = np.linalg.norm(forces[train], axis=1).max()
                add(family, "force", np.linalg.norm(said - truth[test], axis=1) / size)
                if family == families[0]:
                    linear = d[test] @ np.linalg.lstsq(d[train], forces[train], rcond=None)[0]
                    add("linear", "force", np.linalg.norm(linear - truth[test], axis=1) / size)
                if u is None:
                    continue
                order = np.argsort(data["output"])
                free = data["output"][order] != node
                size = np.linalg.norm(u[train], axis=2).max()
                mean = lambda values: np.linalg.norm(values - u[test][:, order], axis=2)[:, free].mean(axis=1) / size
                add(family, "displacement", mean(moved))
                if family == families[0]:
                    fit = np.linalg.lstsq(d[train], u[train].reshape(train.sum(), -1), rcond=None)[0]
                    add("linear", "displacement", mean((d[test] @ fit).reshape(-1, *u.shape[1:])[:, order]))
        database.close()
    print(f"{title}: {(~held_out).sum()} rows of {len(np.unique(touched))} nodes trained, {held_out.sum()} held out")
    for (who, what), errors in found.items():
        found[who, what] = np.array(errors)
        print(f"  {what:12} {who:7} {three(found[who, what])}")
    return found


if __name__ == "__main__":
    compare(sys.argv[1], sys.argv[2:] or ("modal", "rbfn"))
