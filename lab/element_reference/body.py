"""Finite elements of the study of round tools: bodies, tools and tips. Lengths are in units of the punch's radius a,
stresses in units of the shear modulus mu."""
import gmsh
import numpy as np
import ufl
import logging

from dolfinx import cpp, fem, mesh
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


def block(low, high, edge, near, growth):
    """Box with a node at the origin, on its top z = 0. Edges have the length `edge` within `near` of the origin and
    grow by `growth` per length beyond."""
    gmsh.clear()
    low, high = np.array(low, float), np.array(high, float)
    gmsh.model.occ.addBox(*low, *(high - low))
    gmsh.model.occ.synchronize()
    if not any(np.allclose(gmsh.model.getValue(0, t, []), 0) for _, t in gmsh.model.getEntities(0)):
        gmsh.model.occ.fragment([(3, 1)], [(0, gmsh.model.occ.addPoint(0, 0, 0))])
        gmsh.model.occ.synchronize()
    field = gmsh.model.mesh.field.add("MathEval")
    gmsh.model.mesh.field.setString(field, "F", f"{edge}+{growth}*max(0,sqrt(x^2+y^2+z^2)-{near})".replace(
        f"max(0,sqrt(x^2+y^2+z^2)-{near})", f"(sqrt(x^2+y^2+z^2)-{near}+abs(sqrt(x^2+y^2+z^2)-{near}))/2"))
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber("Mesh." + ("MeshSize" + name if name != "FromCurvature" else "MeshSizeFromCurvature"), 0)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("")
    return _mesh_of_model()


def refined_organ(path, a, near_fraction, refinements):
    """The organ in units of a, moved so that the surface node nearest to a point of its bounding box is the origin, and
    refined within the given distances of it. Returns mesh and outward normal there."""
    gmsh.clear()
    gmsh.open(path)
    domain = _mesh_of_model()
    x = domain.geometry.x
    x /= a
    low, high = x.min(0), x.max(0)
    domain.topology.create_connectivity(2, 3)
    corners = cpp.mesh.entities_to_geometry(domain._mesh, 2, mesh.exterior_facet_indices(domain.topology), False)
    surface = np.unique(corners)
    node = surface[np.argmin(np.linalg.norm(x[surface] - low - near_fraction * (high - low), axis=1))]
    x -= x[node].copy()
    around = x[corners[(corners == node).any(axis=1)]]
    normals = np.cross(around[:, 1] - around[:, 0], around[:, 2] - around[:, 0])
    inside = x[np.argsort(np.linalg.norm(x, axis=1))[:40]].mean(0)
    normals *= -np.sign(normals @ inside)[:, None]
    for distance in refinements:
        domain.topology.create_entities(1)
        edges = mesh.locate_entities(domain, 1, lambda p: np.linalg.norm(p, axis=0) < distance)
        domain = mesh.refine(domain, edges, redistribute=False)
    normal = normals.sum(0)
    return domain, normal / np.linalg.norm(normal)


def variance(p, domain):
    """Of a linear function in a cell; the element p1-p1 has one quadrature point (mechanics.py)."""
    slope = ufl.dot(ufl.Jacobian(domain).T, ufl.grad(p))
    return (4 * ufl.inner(slope, slope) - (slope[0] + slope[1] + slope[2]) ** 2) / 80


class Stopped(Exception):
    """No converged state, or cells turned inside out."""


class Body:
    """A body with the origin on its surface, held where `held(x)` is true; symmetric: components held on planes.

    stabilization(F, p, domain), for p1-p1: energy density that is subtracted."""

    def __init__(self, domain, held, K=10.0, element="P2", law="neo-hookean", normal=(0, 0, 1), symmetric=(), reach=4.0,
                 stabilization=None):
        self.normal, self.copies = np.array(normal, float), 2 ** len(symmetric)
        mu, lmbda = 1.0, fem.Constant(domain, K - 2 / 3)
        self.Estar = 4 * mu * (K - 2 / 3 + mu) / (K - 2 / 3 + 2 * mu)
        degree = 1 if element in ("P1", "p1-p1") else 2
        vector = ufl.VectorElement("Lagrange", "tetrahedron", degree)
        self.mixed = mixed = element in ("taylor-hood", "p1-p1")
        if mixed:
            self.W = fem.FunctionSpace(domain, ufl.MixedElement(vector, ufl.FiniteElement("Lagrange", "tetrahedron", 1)))
        else:
            self.W = fem.FunctionSpace(domain, vector)
        self.w, self.other = fem.Function(self.W), fem.Function(self.W)
        test = ufl.TestFunction(self.W)
        self.u, p = ufl.split(self.w) if mixed else (self.w, None)
        self.v = ufl.split(test)[0] if mixed else test
        other = ufl.split(self.other)[0] if mixed else self.other
        maps = [self._dofs(k, mixed) for k in range(3)]
        self.x, self.component = maps[0][1], [m[0] for m in maps]  # points and dofs of the components
        fixed = [d[held(self.x.T)] for d in self.component]
        fixed += [self.component[k][np.abs(self.x[:, k]) < 1e-9] for k in symmetric]
        self.fixed = np.unique(np.concatenate(fixed)).astype(np.int32)
        domain.topology.create_connectivity(2, 3)
        facets = mesh.exterior_facet_indices(domain.topology)
        corners = cpp.mesh.entities_to_geometry(domain._mesh, 2, facets, False)
        points = domain.geometry.x[corners]
        normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        facing = np.abs(normals @ self.normal) > 0.3 * np.linalg.norm(normals, axis=1)  # not the sides, not the back
        near = np.linalg.norm(points, axis=2).min(axis=1) < reach
        front = (points.mean(axis=1) @ self.normal) > -0.5 * reach
        on_plane = [(np.abs(points[:, :, k]) < 1e-9).all(axis=1) for k in symmetric]
        chosen = np.sort(facets[facing & near & front & ~np.any(on_plane, axis=0)] if symmetric else facets[facing & near & front])
        self.tags = mesh.meshtags(domain, 2, chosen, np.ones(len(chosen), np.int32))
        self.domain = domain
        c = corners[np.isin(facets, chosen)]
        self.surface = np.unique(np.concatenate([self._near_dof_points(domain.geometry.x[c].reshape(-1, 3))] + (
            [self._near_dof_points((domain.geometry.x[c] + domain.geometry.x[np.roll(c, 1, 1)]).reshape(-1, 3) / 2)]
            if degree == 2 else [])))
        self.center = int(np.argmin(np.linalg.norm(self.x, axis=1)))
        F = ufl.Identity(3) + ufl.grad(self.u)
        J = ufl.det(F)
        if law == "linear":
            e = ufl.sym(ufl.grad(self.u))
            energy = mu * ufl.inner(e, e) + lmbda / 2 * ufl.tr(e) ** 2
        elif mixed:
            energy = (mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + p * ufl.exp(-p / lmbda) * J - p + p**2 / (2 * lmbda))
        else:
            energy = mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2
        if stabilization:
            energy -= stabilization(F, p, domain) + variance(p, domain) / (2 * lmbda)
        self.law, self.energy = law, energy * ufl.dx(metadata={"quadrature_degree": 1 if element == "p1-p1" else 2 * degree})
        self.internal = fem.form(ufl.derivative(self.energy, self.w))
        self.F = fem.Expression(F, np.array([[0.25] * 3, [0.1] * 3, [0.7, 0.1, 0.1], [0.1, 0.7, 0.1], [0.1, 0.1, 0.7]]))
        s = ufl.sqrt(ufl.inner(self.place(), self.place()))
        near = ufl.conditional(ufl.lt(s, 3.0), 1.0, 0.0)
        self.L2 = fem.form(ufl.inner(self.u - other, self.u - other) * near * self.ds(6))
        self.at = fem.Constant(domain, np.zeros(3))
        self.contact(None)

    def _dofs(self, k, mixed):
        space = self.W.sub(0).sub(k) if mixed else self.W.sub(k)
        V, dofs = space.collapse()
        order = np.lexsort(np.round(V.tabulate_dof_coordinates(), 9).T)
        return np.array(dofs)[order], V.tabulate_dof_coordinates()[order]

    def _near_dof_points(self, points):
        from scipy.spatial import cKDTree
        return cKDTree(self.x).query(points)[1]

    def ds(self, degree):
        return ufl.Measure("ds", self.domain, subdomain_data=self.tags, metadata={"quadrature_degree": degree})(1)

    def place(self):
        return ufl.SpatialCoordinate(self.domain)

    def contact(self, gap, stiffness=1.0):
        """Adds the energy of a penalty: stiffness / 2 gap^2 where the gap is negative."""
        energy, self.pressing = self.energy, gap is not None and not self.mixed
        if gap is not None:
            square = gap**2 * ufl.conditional(ufl.lt(gap, 0), 1.0, 0.0)
            energy = energy + stiffness / 2 * square * self.ds(8)
        self._forms(energy)

    def glue(self, a, d, stiffness):
        """Holds the surface within a at the displacement d by a penalty: a flat punch with full friction."""
        x = self.place()
        inside = ufl.conditional(ufl.lt(ufl.inner(x, x), a**2), 1.0, 0.0)
        self.pressing = False
        self._forms(self.energy + stiffness / 2 * inside * ufl.inner(self.u - d, self.u - d) * self.ds(24))

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

    def mean_rows(self, phi, R, degree=24):
        """Rows of the constraints sum w_i u_i = d, and the weights w_i of the points of self.x."""
        x = self.place()
        R = fem.Constant(self.domain, float(R))
        s2 = ufl.inner(x - self.at, x - self.at) / R**2
        t = ufl.conditional(ufl.lt(s2, 1.0), 1 - s2, 0.0)
        inside = ufl.conditional(ufl.lt(s2, 1.0), 1.0, 0.0)
        f = {"bump": t**2, "Hertz": ufl.sqrt(t), "uniform": inside}[phi]
        v = fem.petsc.assemble_vector(fem.form(f * self.v[2] * self.ds(degree))).array.copy()
        weights = v[self.component[2]] / v.sum()
        rows = []
        for k in range(3):
            row = np.zeros(len(v))
            row[self.component[k]] = weights
            row[self.fixed] = 0
            rows.append(row)
        return np.array(rows), weights

    def solve(self, rows=None, d=None, patch=None, tolerance=1e-8, iterations=25):
        """Newton's method from the present state. rows u = d by multipliers; patch: (points, weights), u_i = w_i d.
        Returns the force on the tool, of the whole body."""
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
            old, length, slope = w.copy(), 1.0, abs(r.array @ move)
            while True:  # shorter steps while cells are inside out, or while a residual grows
                w[:] = old + length * move
                with np.errstate(all="ignore"):
                    new = fem.petsc.assemble_vector(self.residual)
                    if rows is not None:
                        new.array[:] -= rows.T @ (multipliers + length * change)
                    new.array[fixed] = 0
                    size = np.linalg.norm(new.array)
                if np.isfinite(size) and (self.law == "linear" or self.J().min() > 0):
                    if self.pressing:  # a minimum of the energy along the step
                        if abs(new.array @ move) < 0.9 * slope:
                            break
                    elif first is None or length < 0.1 or size < 2 * last:
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
            return self.copies * multipliers
        r = fem.petsc.assemble_vector(self.internal).array
        if patch is not None:
            return self.copies * np.array([weights @ r[self.component[k][points]] for k in range(3)])
        free = np.ones(len(r))
        free[self.fixed] = 0
        return self.copies * np.array([(r * free)[self.component[k]].sum() for k in range(3)])

    def negative_pivots(self):
        return int(self.ksp.getPC().getFactorMatrix().getMumpsInfog(12))

    def gradients(self):
        cells = np.arange(self.domain.topology.index_map(3).size_local, dtype=np.int32)
        return self.F.eval(cells).reshape(-1, 3, 3)

    def J(self):
        return np.linalg.det(self.gradients())

    def least_stretch(self):
        F = self.gradients()
        return float(np.linalg.svd(F, compute_uv=False).min()) if np.isfinite(F).all() else np.nan

    def displacement(self, point=None):
        i = self.center if point is None else point
        return np.array([self.w.x.array[self.component[k][i]] for k in range(3)])

    def surface_difference(self, state, reference):
        """L2 difference of two states on the surface within three lengths, over the L2 norm of the reference."""
        self.w.x.array[:], self.other.x.array[:] = state, reference
        difference = fem.assemble_scalar(self.L2)
        self.w.x.array[:], self.other.x.array[:] = reference, 0
        return float(np.sqrt(difference / fem.assemble_scalar(self.L2)))

    def patch(self, R):
        """The rigid patch: points of the surface within R, weights (1 - s^2)^2."""
        s2 = ((self.x[self.surface] - self.at.value) ** 2).sum(1) / R**2
        return self.surface[s2 < 1], (1 - s2[s2 < 1]) ** 2


def gap_of(body, tip, depth, linear=False):
    """Distance to a rigid tip that has approached by `depth` against the normal at the origin. tip: ("sphere", R) or
    ("punch", a, r): a flat punch with an edge rounded by r."""
    n = ufl.as_vector(body.normal)
    x = body.place()
    x = x + (ufl.inner(body.u, n) * n if linear else body.u)
    z = ufl.inner(x, n) + depth
    across = x - ufl.inner(x, n) * n
    rho = ufl.sqrt(ufl.inner(across, across) + 1e-16)
    if tip[0] == "sphere":
        return ufl.sqrt(rho**2 + (z - tip[1]) ** 2) - tip[1]
    q, h = rho - (tip[1] - tip[2]), tip[2] - z
    positive = lambda y: ufl.conditional(ufl.gt(y, 0), y, 0.0)
    inner = ufl.conditional(ufl.gt(q, h), q, h)
    return ufl.sqrt(positive(q) ** 2 + positive(h) ** 2 + 1e-16) - positive(-inner) - tip[2]
