"""A body of finite elements at large strains. Stresses are in units of the shear modulus mu."""
import logging

import gmsh
import numpy as np
import ufl
from dolfinx import cpp, fem, mesh  # rest.py takes them from here
from mpi4py import MPI
from petsc4py import PETSc

logging.disable(logging.INFO)
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)


def _mesh_of_model():
    tags, x, _ = gmsh.model.mesh.getNodes()
    cells = gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4)
    used, cells = np.unique(cells, return_inverse=True)
    x = x.reshape(-1, 3)[np.searchsorted(tags, used, sorter=np.argsort(tags))] if np.all(np.diff(tags) > 0) else \
        x.reshape(-1, 3)[np.argsort(tags)[np.searchsorted(np.sort(tags), used)]]
    element = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    return mesh.create_mesh(MPI.COMM_SELF, cells.reshape(-1, 4), x, element)


def variance(p, domain):
    """Of a linear function in a cell; the element p1-p1 has one quadrature point (mechanics.py)."""
    slope = ufl.dot(ufl.Jacobian(domain).T, ufl.grad(p))
    return (4 * ufl.inner(slope, slope) - (slope[0] + slope[1] + slope[2]) ** 2) / 80


class Stopped(Exception):
    """No converged state, or cells turned inside out."""


class Body:
    """A neo-Hookean body, held where `held(x)` is true.

    stabilization(F, p, domain), for p1-p1: energy density that is subtracted."""

    def __init__(self, domain, held, K=10.0, element="P2", stabilization=None):
        mu, lmbda = 1.0, fem.Constant(domain, K - 2 / 3)
        degree = 1 if element in ("P1", "p1-p1") else 2
        vector = ufl.VectorElement("Lagrange", "tetrahedron", degree)
        mixed = element in ("taylor-hood", "p1-p1")
        if mixed:
            self.W = fem.FunctionSpace(domain, ufl.MixedElement(vector, ufl.FiniteElement("Lagrange", "tetrahedron", 1)))
        else:
            self.W = fem.FunctionSpace(domain, vector)
        self.w = fem.Function(self.W)
        self.u, p = ufl.split(self.w) if mixed else (self.w, None)
        maps = [self._dofs(k, mixed) for k in range(3)]
        self.x, self.component = maps[0][1], [m[0] for m in maps]  # points and dofs of the components
        self.fixed = np.unique(np.concatenate([d[held(self.x.T)] for d in self.component])).astype(np.int32)
        self.domain = domain
        F = ufl.Identity(3) + ufl.grad(self.u)
        J = ufl.det(F)
        if mixed:
            energy = (mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + p * ufl.exp(-p / lmbda) * J - p + p**2 / (2 * lmbda))
        else:
            energy = mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2
        if stabilization:
            energy -= stabilization(F, p, domain) + variance(p, domain) / (2 * lmbda)
        energy = energy * ufl.dx(metadata={"quadrature_degree": 1 if element == "p1-p1" else 2 * degree})
        self.F = fem.Expression(F, np.array([[0.25] * 3, [0.1] * 3, [0.7, 0.1, 0.1], [0.1, 0.7, 0.1], [0.1, 0.1, 0.7]]))
        self._forms(energy)

    def _dofs(self, k, mixed):
        space = self.W.sub(0).sub(k) if mixed else self.W.sub(k)
        V, dofs = space.collapse()
        order = np.lexsort(np.round(V.tabulate_dof_coordinates(), 9).T)
        return np.array(dofs)[order], V.tabulate_dof_coordinates()[order]

    def _forms(self, energy):
        self.residual = fem.form(ufl.derivative(energy, self.w))
        self.tangent = fem.form(ufl.derivative(ufl.derivative(energy, self.w), self.w))
        self.A = fem.petsc.create_matrix(self.tangent)
        self.A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.A.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self.ksp = PETSc.KSP().create(MPI.COMM_SELF)
        self.ksp.setType("preonly")
        self.ksp.getPC().setType("cholesky")
        self.ksp.getPC().setFactorSolverType("mumps")
        self.ksp.setOperators(self.A)
        self.w.x.array[:] = 0

    def solve(self, rows=None, d=None, patch=None, tolerance=1e-8, iterations=25):
        """Newton's method from the present state. rows u = d by multipliers; patch: (points, weights), u_i = w_i d.
        Returns the force on the tool."""
        w = self.w.x.array
        multipliers = np.zeros(0) if rows is None else getattr(self, "multipliers", np.zeros(len(rows)))
        target = np.zeros(len(self.fixed))
        fixed = self.fixed
        if patch is not None:
            points, weights = patch
            held = np.concatenate([self.component[k][points] for k in range(3)])
            values = np.concatenate([weights * d[k] for k in range(3)])
            keep = ~np.isin(held, self.fixed)
            fixed, target = np.concatenate([fixed, held[keep]]), np.concatenate([target, values[keep]])
        fixed = fixed.astype(np.int32)
        first, last = None, np.inf
        for _ in range(iterations):
            r = fem.petsc.assemble_vector(self.residual)
            scale = np.abs(r.array).max()
            if rows is not None:
                r.array[:] -= rows.T @ multipliers
            lift = r.duplicate()
            lift.array[fixed] = r.array[fixed] = w[fixed] - target
            missing = np.zeros(0) if rows is None else rows @ w - d
            if first and np.abs(r.array).max() < tolerance * max(scale, 1e-9) and np.abs(missing).max(initial=0) < 1e-10:
                break
            self.A.zeroEntries()
            fem.petsc.assemble_matrix(self.A, self.tangent)
            self.A.assemble()
            self.A.zeroRowsColumns(fixed, 1.0, lift, r)
            step, column = r.duplicate(), r.duplicate()
            self.ksp.solve(r, step)
            move, change = -step.array.copy(), None
            if rows is not None:
                columns = []
                for row in rows:
                    column.array[:] = row
                    self.ksp.solve(column, step)
                    columns.append(step.array.copy())
                change = np.linalg.solve(rows @ np.array(columns).T, -missing - rows @ move)
                move = move + np.array(columns).T @ change
            old, length = w.copy(), 1.0
            while True:  # shorter steps while cells are inside out, or while a residual grows
                w[:] = old + length * move
                with np.errstate(all="ignore"):
                    new = fem.petsc.assemble_vector(self.residual)
                    if rows is not None:
                        new.array[:] -= rows.T @ (multipliers + length * change)
                    new.array[fixed] = 0
                    size = np.linalg.norm(new.array)
                if np.isfinite(size) and self.J().min() > 0:
                    if first is None or length < 0.1 or size < 2 * last:
                        break
                length /= 2
                if length < 1e-3:
                    w[:] = old
                    raise Stopped("line search")
            if rows is not None:
                multipliers = multipliers + length * change
            first, last = True, size
        else:
            raise Stopped("iterations")
        if rows is not None:
            self.multipliers = multipliers
            return multipliers
        r = fem.petsc.assemble_vector(self.residual).array
        if patch is not None:
            return np.array([weights @ r[self.component[k][points]] for k in range(3)])
        free = np.ones(len(r))
        free[self.fixed] = 0
        return np.array([(r * free)[self.component[k]].sum() for k in range(3)])

    def negative_pivots(self):
        return int(self.ksp.getPC().getFactorMatrix().getMumpsInfog(12))

    def gradients(self):
        cells = np.arange(self.domain.topology.index_map(3).size_local, dtype=np.int32)
        return self.F.eval(cells).reshape(-1, 3, 3)

    def J(self):
        return np.linalg.det(self.gradients())
