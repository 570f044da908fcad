"""Writes measurements that were never on a grid: five places of a plate of which only the surface is known.

Usage: python3 measurements.py FILE.h5

Each place has 150 displacements at random, those into the body only; a cone of them is missing. The forces are those of a
potential that stiffens exponentially, U = a (exp(q) - 1) / 2 with q = d . B d, a material that needs no finite elements here.
They have noise of 1 % of the largest force in each component. `true_forces` is without noise, for compare.py.
"""
import sys

import h5py
import numpy as np


def main(path):
    random = np.random.default_rng(3)
    x, y = np.meshgrid(np.linspace(0, 0.1, 11), np.linspace(0, 0.08, 9), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.01 * np.sin(30 * x.ravel())], axis=1)
    corner = np.add.outer(9 * np.arange(10), np.arange(8)).ravel()
    triangles = np.concatenate([np.stack([corner, corner + 9, corner + 10], 1), np.stack([corner, corner + 10, corner + 1], 1)])
    touched, displacements, forces = [], [], []
    for place in (21, 30, 48, 66, 75):
        d = random.normal(size=(400, 3))
        d *= 0.012 * random.random((400, 1)) ** (1 / 3) / np.linalg.norm(d, axis=1)[:, None]
        d = d[(d[:, 2] < 0.002) & ~((d[:, 0] > 0.003) & (d[:, 1] > 0.003))][:150]
        q_of = random.normal(size=(3, 3))
        b = 5000 * (np.eye(3) + 0.15 * (q_of + q_of.T))
        force = 0.02 * (1 + 0.5 * random.random()) * np.exp(np.einsum("ni,ij,nj->n", d, b, d))[:, None] * (d @ b)
        touched += [place] * len(d)
        displacements.append(d)
        forces.append(force)
    forces = np.concatenate(forces)
    noise = 0.01 * np.linalg.norm(forces, axis=1).max() * random.normal(size=forces.shape)
    with h5py.File(path, "w") as file:
        file.attrs["title"] = "measurements with noise"
        for name, unit, values in (("points", "m", points), ("displacements", "m", np.concatenate(displacements)),
                                   ("forces", "N", forces + noise), ("true_forces", "N", forces)):
            file.create_dataset(name, data=values).attrs["unit"] = unit
        file["triangles"], file["touched"] = triangles, touched


main(sys.argv[1])
