"""Writes responses of a law that phynness does not have: a soft matrix with one family of fibres, solved by dolfinx (0.5).

Usage: python3 law_of_fibres.py FILE.h5          on Debian 12: apt-get install python3-dolfinx

psi = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 + k1 / (2 k2) (exp(k2 (I4 - 1)^2) - 1), fibres along (1, 1, 0), also in
compression (Holzapfel, Gasser & Ogden 2000, doi 10.1023/A:1010835316564, without dispersion).
"""
import sys

import h5py
import numpy as np
import ufl
from dolfinx import fem, mesh, nls
from mpi4py import MPI
from petsc4py import PETSc

MU, LAMBDA, K1, K2 = 1000.0, 4000.0, 1500.0, 5.0  # Pa, Pa, Pa, 1

box = mesh.create_box(MPI.COMM_SELF, [[0, 0, 0], [0.06, 0.06, 0.03]], [8, 8, 4])
V = fem.VectorFunctionSpace(box, ("CG", 1))
u, v = fem.Function(V), ufl.TestFunction(V)
F = ufl.Identity(3) + ufl.grad(u)
C, J, a = F.T * F, ufl.det(F), ufl.as_vector((2**-0.5, 2**-0.5, 0))
fibre = ufl.exp(K2 * (ufl.dot(a, C * a) - 1) ** 2) - 1
energy = (MU / 2 * (ufl.tr(C) - 3) - MU * ufl.ln(J) + LAMBDA / 2 * ufl.ln(J) ** 2 + K1 / (2 * K2) * fibre) * ufl.dx
residual = ufl.derivative(energy, u, v)
energy_form, residual_form = fem.form(energy), fem.form(residual)

x = V.tabulate_dof_coordinates()
fixed = np.flatnonzero(x[:, 2] < 1e-9).astype(np.int32)
rows = {name: [] for name in ("touched", "displacements", "forces", "energies", "output_displacements")}
random = np.random.default_rng(2)
top = np.flatnonzero(x[:, 2] > 0.03 - 1e-9)
for place in ([0.03, 0.03, 0.03], [0.015, 0.0375, 0.03]):
    node = int(np.argmin(np.linalg.norm(x - place, axis=1)))
    d = fem.Constant(box, PETSc.ScalarType((0, 0, 0)))
    conditions = [fem.dirichletbc(PETSc.ScalarType((0, 0, 0)), fixed, V), fem.dirichletbc(d, np.array([node], np.int32), V)]
    solver = nls.petsc.NewtonSolver(MPI.COMM_SELF, fem.petsc.NonlinearProblem(residual, u, conditions))
    for _ in range(100):
        to = random.normal(size=3)
        to *= 0.007 * random.random() ** (1 / 3) / np.linalg.norm(to)
        u.x.array[:] = 0
        for step in (1 / 3, 2 / 3, 1):  # from rest
            d.value[:] = step * to
            solver.solve(u)
        force = fem.petsc.assemble_vector(residual_form).array.reshape(-1, 3)[node]  # what the node does not balance itself
        for name, value in zip(rows, (node, to, force, fem.assemble_scalar(energy_form), u.x.array.reshape(-1, 3)[top])):
            rows[name].append(np.array(value))
with h5py.File(sys.argv[1], "w") as file:
    file.attrs["title"] = "fibres by dolfinx"
    file["points"], file["tetrahedra"], file["fixed"], file["output"] = x, V.dofmap.list.array.reshape(-1, 4), fixed, top
    for name, values in rows.items():
        file[name] = np.array(values)
