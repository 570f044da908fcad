"""Responses of another program, or measurements, as the file that `phynness import` takes (formats/imported.md).

Usage: python3 responses.py FILE.h5
then:  phynness import FILE.h5 -o database.h5 && phynness train database.h5 -o model

Here the other program is a formula, `force`: springs at five places of a plate that stiffen exponentially. Put your program in its
place. The last place is measured at random displacements: an interpolation puts them on the rays of the others.
"""
import sys

import h5py  # type: ignore[import]
import numpy as np

random = np.random.default_rng(3)
stiffness = 5000 * np.eye(3) + 750 * sum(m + m.T for m in [random.normal(size=(3, 3))])


def force(d):
    """(n, 3) [m] -> (n, 3) [N]: the force that holds each displacement."""
    return 0.02 * np.exp(np.einsum("ni,ij,nj->n", d, stiffness, d))[:, None] * (d @ stiffness)


def interpolated(d, forces, to):
    """Cubic radial functions with a linear part through measurements (d, forces), zero at rest, evaluated at `to`."""
    d, forces = np.vstack([[0, 0, 0], d]), np.vstack([[0, 0, 0], forces])
    size = np.abs(d).max()
    kernel = lambda a, b: np.linalg.norm(a[:, None] - b[None], axis=2) ** 3
    linear = np.hstack([np.ones((len(d), 1)), d / size])
    matrix = np.block([[kernel(d / size, d / size), linear], [linear.T, np.zeros((4, 4))]])
    weights = np.linalg.solve(matrix, np.vstack([forces, np.zeros((4, 3))]))
    return np.hstack([kernel(to / size, d / size), np.ones((len(to), 1)), to / size]) @ weights


def main(path):
    x, y = np.meshgrid(np.linspace(0, 0.1, 11), np.linspace(0, 0.08, 9), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.01 * np.sin(30 * x.ravel())], axis=1)
    corner = np.add.outer(9 * np.arange(10), np.arange(8)).ravel()
    triangles = np.concatenate([np.stack([corner, corner + 9, corner + 10], 1), np.stack([corner, corner + 10, corner + 1], 1)])
    touched = [21, 30, 48, 66, 75]
    directions = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)]) - 1.0
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    magnitudes = 0.012 * np.arange(1, 7) / 6
    d = (directions[:, None] * magnitudes[:, None]).reshape(-1, 3)
    measured = random.normal(size=(300, 3))
    measured *= 0.013 * random.random((300, 1)) ** (1 / 3) / np.linalg.norm(measured, axis=1)[:, None]
    forces = np.array([force(d)] * 4 + [interpolated(measured, force(measured), d)])
    with h5py.File(path, "w") as file:
        file.attrs["title"] = "springs of a plate"
        file["points"], file["triangles"], file["touched"] = points, triangles, touched
        file["directions"], file["magnitudes"] = directions, magnitudes
        file["forces"] = forces.reshape(len(touched), len(directions), len(magnitudes), 3)
        file["forces"].attrs["unit"] = "N"


if __name__ == "__main__":
    main(sys.argv[1])
