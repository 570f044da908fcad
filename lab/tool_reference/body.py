"""Finite elements of the study of round tools: bodies, tools and tips. Lengths are in units of the punch's radius a,
stresses in units of the shear modulus mu. Bodies are tetrahedra, or triangles (r, z) of a body of revolution; the last
coordinate is the height, and the tool presses at the origin."""
import logging

import gmsh
import numpy as np
import ufl
from dolfinx import cpp, fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

logging.disable(logging.INFO)
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
    gmsh.option.setNumber("Mesh.MeshSize" + name, 0)


def _mesh_of_model(dim):
    tags, x, _ = gmsh.model.mesh.getNodes()
    cells = gmsh.model.mesh.getElementsByType(2 if dim == 2 else 4)[1]
    used, cells = np.unique(cells, return_inverse=True)
    order = np.argsort(tags)
    x = x.reshape(-1, 3)[order[np.searchsorted(tags[order], used)]]
    shape = "triangle" if dim == 2 else "tetrahedron"
    element = ufl.Mesh(ufl.VectorElement("Lagrange", shape, 1))
    return mesh.create_mesh(MPI.COMM_SELF, cells.reshape(-1, dim + 1), x[:, :dim], element)


def box(low, high, size):
    """Rectangle or box with edges of the length size(point)."""
    gmsh.clear()
    low, span = np.array(low, float), np.array(high, float) - low
    if len(low) == 2:
        gmsh.model.occ.addRectangle(*low, 0, *span)
    else:
        gmsh.model.occ.addBox(*low, *span)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, *_: size(np.array([x, y, z])[:len(low)]))
    gmsh.model.mesh.generate(len(low))
    gmsh.model.mesh.removeSizeCallback()
    return _mesh_of_model(len(low))


def organ(path, a, near_fraction, refinements):
    """The organ in units of a, moved so that the surface node nearest to a point of its bounding box is the origin;
    edges with a middle where refine(points) holds are halved, once for each of the refinements. Returns the mesh and
    the mean outward normal of the surface within one length."""
    gmsh.clear()
    gmsh.open(path)
    domain = _mesh_of_model(3)
    x = domain.geometry.x
    x /= a
    corners, normals = boundary(domain)
    low, high = x.min(0), x.max(0)
    surface = np.unique(corners)
    x -= x[surface[np.argmin(np.linalg.norm(x[surface] - low - near_fraction * (high - low), axis=1))]].copy()
    normal = normals[np.linalg.norm(x[corners].mean(axis=1), axis=1) < 1].sum(0)
    for refine in refinements:
        domain.topology.create_entities(1)
        ends = cpp.mesh.entities_to_geometry(domain._mesh, 1, np.arange(domain.topology.index_map(1).size_local, dtype=np.int32), False)
        domain = mesh.refine(domain, np.flatnonzero(refine(domain.geometry.x[ends].mean(axis=1))).astype(np.int32), redistribute=False)
    return domain, normal / np.linalg.norm(normal)


def boundary(domain):
    """Corners and outward normals (times area) of the triangles of the surface."""
    domain.topology.create_connectivity(2, 3)
    facets = mesh.exterior_facet_indices(domain.topology)
    corners = cpp.mesh.entities_to_geometry(domain._mesh, 2, facets, False)
    cells = [domain.topology.connectivity(2, 3).links(f)[0] for f in facets]
    x = domain.geometry.x
    inside = x[cpp.mesh.entities_to_geometry(domain._mesh, 3, np.array(cells, np.int32), False)].mean(axis=1)
    normals = np.cross(x[corners[:, 1]] - x[corners[:, 0]], x[corners[:, 2]] - x[corners[:, 0]]) / 2
    return corners, normals * np.sign(np.einsum("ij,ij->i", normals, x[corners].mean(axis=1) - inside))[:, None]


class Stopped(Exception):
    """No converged state, or cells turned inside out."""


class Body:
    """A body held where `held(x)` is true, with components held at 0 on planes of symmetry (the axis r = 0). Tools act
    on facets with a middle where `touched(x)` is true."""

    def __init__(self, domain, held, touched, K=10.0, element="P2", law="neo-hookean", normal=None, symmetric=()):
        self.domain, self.dim, self.law = domain, domain.geometry.dim, law
        dim, mu, lmbda = self.dim, 1.0, K - 2 / 3
        self.normal = np.eye(dim)[-1] if normal is None else np.array(normal)
        self.copies = 2 ** len(symmetric) if dim == 3 else 1
        self.Estar = 4 * mu * (lmbda + mu) / (lmbda + 2 * mu)
        degree = 1 if element in ("P1", "p1-p1") else 2
        self.mixed = element in ("p1-p1", "taylor-hood")
        cell = domain.ufl_cell()
        space = ufl.VectorElement("Lagrange", cell, degree)
        self.W = fem.FunctionSpace(domain, ufl.MixedElement(space, ufl.FiniteElement("Lagrange", cell, 1)) if self.mixed else space)
        self.w, self.other = fem.Function(self.W), fem.Function(self.W)
        split = ufl.split if self.mixed else lambda f: (f, None)
        (self.u, p), self.v, other = split(self.w), split(ufl.TestFunction(self.W))[0], split(self.other)[0]
        V, dofs = self.W.sub(0).collapse() if self.mixed else (self.W, np.arange(len(self.w.x.array)))
        self.x, self.dofs = V.tabulate_dof_coordinates(), np.array(dofs).reshape(-1, dim)  # points, dofs of components
        fixed = [self.dofs[held(self.x.T)].ravel()] + [self.dofs[np.abs(self.x[:, k]) < 1e-9, k] for k in symmetric]
        self.fixed = np.unique(np.concatenate(fixed)).astype(np.int32)
        domain.topology.create_connectivity(dim - 1, dim)
        facets = mesh.exterior_facet_indices(domain.topology)
        ends = domain.geometry.x[cpp.mesh.entities_to_geometry(domain._mesh, dim - 1, facets, False)]
        facets = facets[touched(ends.mean(axis=1).T)]
        self.tags = mesh.meshtags(domain, dim - 1, facets, np.ones(len(facets), np.int32))
        self.surface = np.unique(fem.locate_dofs_topological(V, dim - 1, facets))
        self.center = int(np.argmin(np.linalg.norm(self.x, axis=1)))
        self.place = ufl.SpatialCoordinate(domain)
        self.around = 2 * np.pi * self.place[0] if dim == 2 else 1
        H = ufl.grad(self.u)
        if dim == 2:
            H = ufl.as_matrix([[H[0, 0], 0, H[0, 1]], [0, self.u[0] / self.place[0], 0], [H[1, 0], 0, H[1, 1]]])  # r, angle, z
        F = ufl.Identity(3) + H
        J = ufl.det(F)
        if law == "linear":
            e = ufl.sym(H)
            energy = mu * ufl.inner(e, e) + lmbda / 2 * ufl.tr(e) ** 2
        elif element == "p1-p1":  # the product's, with its stabilization 0.05
            slope = ufl.grad(p)
            slope = ufl.dot(ufl.inv(F).T, ufl.as_vector([slope[0], 0, slope[1]]) if dim == 2 else slope)
            energy = (mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + p * ufl.ln(J) - p**2 / (2 * lmbda)
                      - 0.05 * ufl.CellDiameter(domain) ** 2 / (2 * mu) * ufl.inner(slope, slope))
        elif self.mixed:
            energy = (mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + p * ufl.exp(-p / lmbda) * J - p + p**2 / (2 * lmbda))
        else:
            energy = mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2
        self.energy = energy * self.around * ufl.dx(metadata={"quadrature_degree": 2 * degree})
        self.internal = fem.form(ufl.derivative(self.energy, self.w))
        points = np.vstack([np.full(dim, 1 / (dim + 1)), np.full(dim, 0.1), 0.6 * np.eye(dim) + 0.1])
        self.F = fem.Expression(F, points)
        near = ufl.conditional(ufl.lt(ufl.inner(self.place, self.place), 9.0), 1.0, 0.0)
        self.L2 = fem.form(self.over_surface(ufl.inner(self.u - other, self.u - other) * near, 6))
        self.at = fem.Constant(domain, np.zeros(dim))
        self.release()

    def over_surface(self, f, degree):
        return f * self.around * ufl.Measure("ds", self.domain, subdomain_data=self.tags, metadata={"quadrature_degree": degree})(1)

    def release(self, added=None):
        """Starts from rest, with an energy added to that of the body: a tip's."""
        energy = self.energy if added is None else self.energy + added
        self.pressing = added is not None and not self.mixed
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
        self.multipliers = np.zeros(0)

    def punch(self, r, depth, stiffness):
        """The energy of a penalty, stiffness / 2 gap^2 inside a flat punch of radius 1 with an edge rounded by r that
        has approached by `depth` against the normal at the origin."""
        n = ufl.as_vector(self.normal)
        x = self.place + (ufl.inner(self.u, n) * n if self.law == "linear" else self.u)
        z = ufl.inner(x, n) + depth
        across = x - ufl.inner(x, n) * n
        q, h = ufl.sqrt(ufl.inner(across, across) + 1e-16) - (1 - r), r - z
        positive = lambda y: ufl.conditional(ufl.gt(y, 0), y, 0.0)
        gap = ufl.sqrt(positive(q) ** 2 + positive(h) ** 2 + 1e-16) - positive(-ufl.conditional(ufl.gt(q, h), q, h)) - r
        return self.over_surface(stiffness / 2 * gap**2 * ufl.conditional(ufl.lt(gap, 0), 1.0, 0.0), 12 if self.dim == 2 else 8)

    def weights(self, phi, R, degree=24):
        """Weights of the points of self.x, by integrals of the degree; degree 0: phi at the surface's points."""
        def of(s2, where):
            t = where(s2 < 1, 1 - s2, 0 * s2)
            return {"bump": t**2, "Hertz": t**0.5, "uniform": where(s2 < 1, 1 + 0 * s2, 0 * s2)}[phi]
        w = np.zeros(len(self.x))
        if degree == 0:
            x = self.x[self.surface, :self.dim]
            w[self.surface] = of(((x - self.at.value) ** 2).sum(1) / R**2, np.where)
        else:
            offset = (self.place - self.at) / fem.Constant(self.domain, float(R))
            f = of(ufl.inner(offset, offset), ufl.conditional)
            w[:] = fem.petsc.assemble_vector(fem.form(self.over_surface(f * self.v[self.dim - 1], degree))).array[self.dofs[:, -1]]
        return w / w.sum()

    def rows(self, weights, frame):
        """Rows of sum w_i frame u_i = d."""
        rows = np.zeros((len(frame), len(self.w.x.array)))
        for row, direction in zip(rows, frame):
            row[self.dofs] = np.outer(weights, direction)
            row[self.fixed] = 0
        return rows

    def patch(self, R):
        """The rigid patch: points of the surface within R, weights (1 - s^2)^2."""
        s2 = ((self.x[self.surface, :self.dim] - self.at.value) ** 2).sum(1) / R**2
        return self.surface[s2 < 1], (1 - s2[s2 < 1]) ** 2

    def solve(self, rows=None, d=None, patch=None, tolerance=1e-8, iterations=25):
        """Newton's method from the present state. rows u = d by multipliers; patch: (points, weights), u_i = w_i d.
        Returns the force on the tool, of the whole body."""
        w = self.w.x.array
        rows = np.zeros((0, len(w))) if rows is None else rows
        if len(self.multipliers) != len(rows):
            self.multipliers = np.zeros(len(rows))
        fixed, target = self.fixed, np.zeros(len(self.fixed))
        if patch is not None:
            held, values = self.dofs[patch[0]].ravel(), np.outer(patch[1], d).ravel()
            free = ~np.isin(held, self.fixed)
            fixed, target = np.append(fixed, held[free]).astype(np.int32), np.append(target, values[free])
        last = None
        for _ in range(iterations):
            r = fem.petsc.assemble_vector(self.residual)
            scale = np.abs(r.array).max()
            r.array[:] -= rows.T @ self.multipliers
            lift = r.duplicate()
            lift.array[fixed] = r.array[fixed] = w[fixed] - target
            missing = rows @ w - d if len(rows) else np.zeros(0)
            if last is not None and np.abs(r.array).max() < tolerance * max(scale, 1e-9) and np.abs(missing).max(initial=0) < 1e-10:
                break
            self.A.zeroEntries()
            fem.petsc.assemble_matrix(self.A, self.tangent)
            self.A.assemble()
            self.A.zeroRowsColumns(fixed, 1.0, lift, r)
            step, column, columns = r.duplicate(), r.duplicate(), np.zeros((len(rows), len(w)))
            self.ksp.solve(r, step)
            move, change = -step.array.copy(), np.zeros(len(rows))
            for k, row in enumerate(rows):
                column.array[:] = row
                self.ksp.solve(column, step)
                columns[k] = step.array
            if len(rows):
                change = np.linalg.solve(rows @ columns.T, -missing - rows @ move)
                move = move + columns.T @ change
            old, length, slope = w.copy(), 1.0, abs(r.array @ move)
            while True:  # shorter steps while cells are inside out, or while a residual grows
                w[:] = old + length * move
                with np.errstate(all="ignore"):
                    new = fem.petsc.assemble_vector(self.residual)
                new.array[:] -= rows.T @ (self.multipliers + length * change)
                new.array[fixed] = 0
                size = np.linalg.norm(new.array)
                if np.isfinite(size) and (self.law == "linear" or np.linalg.det(self.gradients()).min() > 0):
                    if self.pressing:  # a minimum of the energy along the step
                        if abs(new.array @ move) < 0.9 * slope:
                            break
                    elif last is None or length < 0.1 or size < 2 * last:
                        break
                length /= 2
                if length < 1e-3:
                    w[:] = old
                    raise Stopped("line search")
            self.multipliers, last = self.multipliers + length * change, size
        else:
            raise Stopped("iterations")
        if len(rows):
            return self.copies * self.multipliers
        r = fem.petsc.assemble_vector(self.internal).array.copy()
        if patch is not None:
            return self.copies * patch[1] @ r[self.dofs[patch[0]]]
        r[self.fixed] = 0
        return self.copies * r[self.dofs].sum(0)

    def gradients(self):
        cells = np.arange(self.domain.topology.index_map(self.dim).size_local, dtype=np.int32)
        return self.F.eval(cells).reshape(-1, 3, 3)

    def least_stretch(self):
        return float(np.linalg.svd(self.gradients(), compute_uv=False).min())

    def surface_difference(self, state, reference):
        """L2 difference of two states on the surface within three lengths, over the L2 norm of the reference."""
        self.w.x.array[:], self.other.x.array[:] = state, reference
        difference = fem.assemble_scalar(self.L2)
        self.w.x.array[:], self.other.x.array[:] = reference, 0
        return float(np.sqrt(difference / fem.assemble_scalar(self.L2)))
