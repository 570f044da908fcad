"""Small displacements from rest: condensed pressure of p1-p1 for every stabilization, and Taylor-Hood references.

Lengths are in units of the mean surface edge, stresses in units of the shear modulus. A tool is a 3 x 3 compliance: mean displacement per
force, the mean being weighted by phi = sqrt(1 - s^2) (or 1) as element functions see it.
"""

import body as tool
import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.spatial
import ufl
from body import fem, mesh
from petsc4py import PETSc
from scipy.spatial import cKDTree

# Tensors S(M, h) of the stabilization alpha / (2 mu) grad p . S grad p, M the covariance of a cell, as functions of its
# Jacobian; all are a^2 I in a regular tetrahedron with the edge a.
ONE = ufl.as_vector((1, 1, 1))
I = ufl.Identity(3)


def tensors(domain):
    J = ufl.Jacobian(domain)
    M = J * (4 * I - ufl.outer(ONE, ONE)) / 80 * J.T
    inverse = ufl.inv(J).T * (20 * (I + ufl.outer(ONE, ONE))) * ufl.inv(J)
    return {"diameter": ufl.CellDiameter(domain) ** 2 * I, "edges": ufl.tr(M) / 0.075 * I, "variance": M / 0.025,
            "volume": (abs(ufl.det(J)) / 2 ** 0.5 * 2) ** (2 / 3) * I, "heights": 120 / ufl.tr(inverse) * I,
            "bubble": 160 * ufl.inv(ufl.tr(inverse) * I + inverse)}


class Organ:
    """A mesh file, its fixed triangles and places for tools: (point, normal, radius)."""

    def __init__(self, path, places=6, radii=(2, 3, 4), seed=1):
        tool.gmsh.clear()
        tool.gmsh.open(str(path))
        (group,) = [t for d, t in tool.gmsh.model.getPhysicalGroups(0) if tool.gmsh.model.getPhysicalName(d, t) == "phynness_fixed"]
        fixed = tool.gmsh.model.mesh.getNodesForPhysicalGroup(0, group)[1].reshape(-1, 3)
        self.domain = tool._mesh_of_model()
        points, normals = surface(self.domain)[1:3]
        self.edge = np.linalg.norm(points - np.roll(points, 1, 1), axis=2).mean()
        self.domain.geometry.x[:] /= self.edge
        points /= self.edge
        self.held = points[(cKDTree(fixed / self.edge).query(points)[0] < 1e-6).all(axis=1)]
        rng, self.places, chosen = np.random.default_rng(seed), [], np.zeros((0, 3))
        candidates = np.einsum("fi,fix->fx", rng.dirichlet((1, 1, 1), len(points)), points)
        far = cKDTree(self.held.reshape(-1, 3)).query(candidates)[0]
        for i in range(places):
            R = radii[i % len(radii)]
            gap = cKDTree(np.vstack([chosen, [[1e9] * 3]])).query(candidates)[0].clip(0, 20) + 1e-3 * rng.random(len(far))
            gap[far < R + 0.5] = -1
            f = int(np.argmax(gap)) if len(chosen) else int(np.argmax(np.where(gap < 0, -1, rng.random(len(far)))))
            if gap[f] < 0:
                continue
            chosen = np.vstack([chosen, candidates[f]])
            self.places.append((candidates[f], normals[f], float(R)))

    def is_fixed(self, x):
        """Whether points lie on fixed triangles of the first mesh."""
        e1, e2 = self.held[:, 1] - self.held[:, 0], self.held[:, 2] - self.held[:, 0]
        n = np.cross(e1, e2)
        r = x[:, None] - self.held[None, :, 0]
        b = np.einsum("fhx,hx->fh", np.cross(r, e2), n) / (n**2).sum(1)
        c = np.einsum("fhx,hx->fh", np.cross(e1, r), n) / (n**2).sum(1)
        off = np.abs(np.einsum("fhx,hx->fh", r, n)) / np.linalg.norm(n, axis=1)
        return ((b > -1e-6) & (c > -1e-6) & (b + c < 1 + 1e-6) & (off < 1e-6)).any(axis=1)

    def refined(self, times):
        domain = self.domain
        for _ in range(times):
            domain.topology.create_entities(1)
            domain = mesh.refine(domain, redistribute=False)
        return domain


def surface(domain):
    """Exterior facets, their corners and outward unit normals."""
    domain.topology.create_connectivity(2, 3)
    domain.topology.create_connectivity(3, 0)
    facets = np.sort(mesh.exterior_facet_indices(domain.topology))
    points = domain.geometry.x[tool.cpp.mesh.entities_to_geometry(domain._mesh, 2, facets, False)]
    cells = domain.topology.connectivity(2, 3)
    middle = domain.geometry.x[np.array([domain.geometry.dofmap.links(cells.links(f)[0]) for f in facets])].mean(1)
    n = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    n *= np.sign(np.einsum("fx,fx->f", n, points.mean(1) - middle))[:, None]
    return facets, points, n / np.linalg.norm(n, axis=1)[:, None]


def weights(skin, place, coordinates, degree, phi="Hertz", cuts=10):
    """w_i of the points with the coordinates; the triangles of skin that face like the place's are each cut into cuts^2."""
    (at, normal, R), (_, points, normals) = place, skin
    near = (normals @ normal > 0.3) & (np.linalg.norm(points.mean(1) - at, axis=1) < R + np.linalg.norm(
        points - points.mean(1)[:, None], axis=2).max(axis=1))
    corners = points[near]
    i, j = np.meshgrid(np.arange(3 * cuts), np.arange(3 * cuts))
    inside = (i + j <= 3 * cuts - 2) & ((i - j) % 3 == 0) & (i % 3 < 2)  # centroids of the small triangles of both orientations
    L = np.column_stack([i[inside] + 1, j[inside] + 1]) / (3.0 * cuts)
    L = np.column_stack([L, 1 - L.sum(1)])
    t = 1 - ((np.einsum("qi,fix->fqx", L, corners) - at) ** 2).sum(2) / R**2
    value = np.where(t > 0, np.sqrt(t.clip(0)) if phi == "Hertz" else 1.0, 0.0)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    value *= area[:, None]
    if degree == 1:
        N, at_points = L, corners
    else:
        pairs = ((0, 1), (1, 2), (2, 0))
        N = np.column_stack([L * (2 * L - 1)] + [4 * L[:, a] * L[:, b] for a, b in pairs])
        at_points = np.concatenate([corners] + [corners[:, [a, b]].mean(1, keepdims=True) for a, b in pairs], axis=1)
    w = np.zeros(len(coordinates))
    distance, index = cKDTree(coordinates).query(at_points.reshape(-1, 3))
    assert distance.max() < 1e-6
    np.add.at(w, index, (value @ N).ravel())
    return w / w.sum()


def sparse(form):
    A = fem.petsc.assemble_matrix(fem.form(form))
    A.assemble()
    i, j, v = A.getValuesCSR()
    return scipy.sparse.csr_matrix((v, j, i), A.getSize())


class Factors:
    """Symmetric factors of MUMPS."""

    def __init__(self, A):
        A = scipy.sparse.csr_matrix(A)
        A.sort_indices()
        self.A = PETSc.Mat().createAIJ(A.shape, csr=(A.indptr, A.indices, A.data))
        self.A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.ksp = PETSc.KSP().create(tool.MPI.COMM_SELF)
        self.ksp.setType("preonly")
        self.ksp.getPC().setType("cholesky")
        self.ksp.getPC().setFactorSolverType("mumps")
        self.ksp.setOperators(self.A)
        self.ksp.setUp()

    def solve(self, B):
        X, x = np.empty_like(B), self.A.createVecRight()
        for k in range(B.shape[1]):
            self.ksp.solve(PETSc.Vec().createWithArray(B[:, k].copy()), x)
            X[:, k] = x.array
        return X


class Spaces:
    """Blocks at rest of an element with displacements of the degree and linear pressures: uu, pu, pp; tools' loads."""

    def __init__(self, organ, domain, degree, phi="Hertz"):
        V, Q = fem.VectorFunctionSpace(domain, ("Lagrange", degree)), fem.FunctionSpace(domain, ("Lagrange", 1))
        u, v, p, q = ufl.TrialFunction(V), ufl.TestFunction(V), ufl.TrialFunction(Q), ufl.TestFunction(Q)
        self.domain, self.p, self.q = domain, p, q
        x, skin = V.tabulate_dof_coordinates(), surface(domain)
        held = fem.locate_dofs_topological(V, 2, skin[0][organ.is_fixed(skin[1].mean(1))])
        self.x, self.xp = x, Q.tabulate_dof_coordinates()
        self.free = np.setdiff1d(np.arange(3 * len(x)), (3 * held[:, None] + np.arange(3)).ravel())
        self.loads = []
        for place in organ.places:
            w = weights(skin, place, x, degree, phi)
            self.loads.append(np.kron(w[:, None], np.eye(3))[self.free])
        self.U = np.hstack(self.loads)
        self.A = sparse(2 * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * ufl.dx)[self.free][:, self.free]
        self.B = sparse(ufl.div(u) * q * ufl.dx)[:, self.free]
        self.M = sparse(p * q * ufl.dx)

    def taylor_hood(self, ratios, nodes=(5.0, 200.0)):
        """Compliances by K/mu: two factorizations, between them Hermite's cubic in the compressibility 1 / (1 + 2 / lambda)."""
        at, values = [], []
        n, b = self.A.shape[0], self.U.shape[1]
        for K in nodes:
            l = K - 2 / 3
            X = Factors(scipy.sparse.bmat([[self.A, self.B.T], [self.B, -self.M / l]])).solve(np.vstack([self.U, np.zeros((self.M.shape[0], b))]))
            S, dS = blocks(self.U.T @ X[:n]), blocks(X[n:].T @ (self.M @ X[n:]))
            self.state = S, X[:n], X[n:]
            at.append(l)
            values.append((S, dS))
        z = lambda l: 1 / (1 + 2 / l)  # dz/d(1/l) = -2 z^2
        if len(nodes) == 1:
            return {nodes[0]: S}
        (z0, z1), (a, b_) = [z(l) for l in at], [v[0] for v in values]
        m0, m1 = [-v[1] / (2 * z(l) ** 2) * (z1 - z0) for v, l in zip(values, at)]
        out = {}
        for K in ratios:
            t = (z(K - 2 / 3) - z0) / (z1 - z0)
            out[K] = ((2 * t**3 - 3 * t**2 + 1) * a + (t**3 - 2 * t**2 + t) * m0 + (3 * t**2 - 2 * t**3) * b_ + (t**3 - t**2) * m1)
        return out

    def stabilization(self, name):
        return sparse(ufl.inner(tensors(self.domain)[name] * ufl.grad(self.p), ufl.grad(self.q)) * ufl.dx)

    def condense(self):
        solution = Factors(self.A).solve(np.hstack([self.U, self.B.T.toarray()]))
        b = self.U.shape[1]
        self.S0, self.T, self.solution = self.U.T @ solution[:, :b], self.B @ solution[:, :b], solution
        self.schur = self.B @ solution[:, b:]
        self.schur = (self.schur + self.schur.T) / 2
        self.C = {name: self.stabilization(name).toarray() for name in tensors(self.domain)}
        self.mass = self.M.toarray()
        return self

    def p1p1(self, K, name, alpha, states=False):
        """Compliances, and with states the displacements and pressures of unit forces."""
        p = scipy.linalg.solve(self.schur + self.mass / (K - 2 / 3) + alpha * self.C[name], self.T, assume_a="pos")
        S, b = blocks(self.S0 - self.T.T @ p), self.U.shape[1]
        return (S, self.solution[:, :b] - self.solution[:, b:] @ p, p) if states else S

    def full(self, u):
        out = np.zeros((3 * len(self.x), u.shape[1]))
        out[self.free] = u
        return out

    def infsup(self, name, alpha):
        return float(np.sqrt(scipy.linalg.eigh(self.schur + alpha * self.C[name], self.mass, eigvals_only=True, subset_by_index=[0, 0])[0]))


def blocks(S):
    return np.array([S[3 * i:3 * i + 3, 3 * i:3 * i + 3] for i in range(len(S) // 3)])


def frame(normal):
    t = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    t /= np.linalg.norm(t)
    return np.array([-normal, t, np.cross(normal, t)])


def forces(S, organ):
    """places x directions x 3: forces at unit means, pressing and sliding."""
    return np.array([np.linalg.solve(s, frame(p[1]).T).T for s, p in zip(S, organ.places)])


def errors(S, reference, organ):
    f, g = forces(S, organ), forces(reference, organ)
    return np.linalg.norm(f - g, axis=2) / np.linalg.norm(g, axis=2), np.linalg.norm(f, axis=2) / np.linalg.norm(g, axis=2)
