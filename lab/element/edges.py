"""The element p1-p1 whose shear energy sees the mean deformation gradient of the cells at each edge (weights: volumes)."""
import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from rest import cKDTree, fem, surface, weights

I3 = np.eye(3)
SYMMETRIC = (np.eye(9) + np.eye(9).reshape(3, 3, 9).transpose(1, 0, 2).reshape(9, 9)) / 2


def cells(spaces):
    """Nodes, volumes, and the operator from displacements to the gradients of the cells, 9 rows each."""
    nodes = fem.VectorFunctionSpace(spaces.domain, ("Lagrange", 1)).dofmap.list.array.reshape(-1, 4)
    J = np.swapaxes(spaces.x[nodes[:, 1:]] - spaces.x[nodes[:, :1]], 1, 2)
    G, cell = np.linalg.inv(J), np.arange(len(nodes))
    g = np.concatenate([-G.sum(1, keepdims=True), G], axis=1)
    c, i, a, b = [k.ravel() for k in np.meshgrid(cell, range(4), range(3), range(3), indexing="ij")]
    G = scipy.sparse.csr_matrix((g[c, i, b], (9 * c + 3 * a + b, 3 * nodes[c, i] + a)), (9 * len(cell), 3 * len(spaces.x)))
    return nodes, np.abs(np.linalg.det(J)) / 6, G


def edges(nodes, volumes, G):
    """Volumes of the edges, a sixth of each of their cells, and the operator to their mean gradients."""
    pairs = np.sort(np.concatenate([nodes[:, p] for p in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))]), axis=1)
    edge, share = np.unique(pairs, axis=0, return_inverse=True)[1].ravel(), np.tile(volumes, 6) / 6
    total = np.bincount(edge, share)
    mean = scipy.sparse.csr_matrix((share / total[edge], (edge, np.tile(np.arange(len(nodes)), 6))), (len(total), len(nodes)))
    return total, scipy.sparse.kron(mean, scipy.sparse.eye(9)).tocsr() @ G


def smoothed(spaces):
    """The uu block at rest, in place of Spaces.A."""
    volumes, G = edges(*cells(spaces))
    return (G.T @ scipy.sparse.kron(scipy.sparse.diags(2 * volumes), SYMMETRIC) @ G).tocsr()[spaces.free][:, spaces.free]


def each(blocks, factors):
    return scipy.sparse.block_diag(list(blocks.reshape(-1, 9, 9) * factors[:, None, None]), format="csr")


class Smoothed:
    """Neo-Hookean at large strains, coupling and one quadrature point of p1-p1; share: of the shear energy, in the cells;
    current: the stabilization has F^-T grad p, as in the product, else grad p."""

    def __init__(self, spaces, K, alpha, share=0.0, current=False):
        self.spaces, self.l, self.n = spaces, K - 2 / 3, 3 * len(spaces.x)
        nodes, self.V, self.G = cells(spaces)
        self.Ve, self.Ge = edges(nodes, self.V, self.G)
        here = cKDTree(spaces.xp).query(spaces.x)[1][nodes]
        cell = np.repeat(np.arange(len(nodes)), 4)
        self.Q = scipy.sparse.csr_matrix((np.full(len(cell), 0.25), (cell, here.ravel())), (len(nodes), len(spaces.xp)))
        variance = spaces.M - self.Q.T @ scipy.sparse.diags(self.V) @ self.Q
        self.pp = variance / self.l + (0 if current else alpha) * spaces.stabilization("diameter")
        self.share, self.current = share, current
        h = np.array([np.linalg.norm(x[:, None] - x[None], axis=2).max() for x in spaces.x[nodes]])  # the longest edge
        self.a = alpha * h**2 * self.V  # times |F^-T grad p|^2 / 2
        slopes = np.linalg.inv(np.swapaxes(spaces.x[nodes[:, 1:]] - spaces.x[nodes[:, :1]], 1, 2))
        slopes = np.concatenate([-slopes.sum(1, keepdims=True), slopes], axis=1)
        c, k, b = [i.ravel() for i in np.meshgrid(np.arange(len(nodes)), range(4), range(3), indexing="ij")]
        self.Gp = scipy.sparse.csr_matrix((slopes[c, k, b], (3 * c + b, here[c, k])), (3 * len(nodes), len(spaces.xp)))
        self.free = np.concatenate([spaces.free, self.n + np.arange(len(spaces.xp))])

    def gradients(self, w):
        return [(G @ w[:self.n]).reshape(-1, 3, 3) + I3 for G in (self.Ge, self.G)]

    def system(self, w):
        """Residual and tangent."""
        (Fe, F), p, l = self.gradients(w), w[self.n:], self.l
        inverse, f, J, q = np.linalg.inv(Fe), np.linalg.inv(F), np.linalg.det(F), self.Q @ p
        P = Fe - np.swapaxes(inverse, 1, 2)
        H = np.einsum("ik,jl->ijkl", I3, I3) + np.einsum("nli,njk->nijkl", inverse, inverse)
        of_edges, of_cells = (1 - self.share) * self.Ve, self.share * self.V
        e0, e1, e2 = q * np.exp(-q / l), (1 - q / l) * np.exp(-q / l), (q / l - 2) / l * np.exp(-q / l)
        cof = J[:, None, None] * np.swapaxes(f, 1, 2)
        C = np.einsum("nji,nlk->nijkl", f, f) - np.einsum("nli,njk->nijkl", f, f)
        uu = self.Ge.T @ each(H, of_edges) @ self.Ge + self.G.T @ each(C, e0 * J * self.V) @ self.G
        slopes = (cof * (e1 * self.V)[:, None, None]).ravel()
        up = self.G.T @ scipy.sparse.csr_matrix((slopes, (np.arange(len(slopes)), np.arange(len(slopes)) // 9))) @ self.Q
        pp = self.Q.T @ scipy.sparse.diags(self.V * (e2 * J + 1 / l)) @ self.Q - self.pp
        u = self.Ge.T @ (P * of_edges[:, None, None]).ravel() + self.G.T @ (cof * (e0 * self.V)[:, None, None]).ravel()
        rp = self.Q.T @ (self.V * (e1 * J - 1 + q / l)) - self.pp @ p
        if self.share:
            H = np.einsum("ik,jl->ijkl", I3, I3) + np.einsum("nli,njk->nijkl", f, f)
            uu += self.G.T @ each(H, of_cells) @ self.G
            u += self.G.T @ ((F - np.swapaxes(f, 1, 2)) * of_cells[:, None, None]).ravel()
        if self.current:  # minus a/2 |g|^2 with g = F^-T grad p, k = F^-1 g
            g = np.einsum("nji,nj->ni", f, (self.Gp @ p).reshape(-1, 3))
            k, metric = np.einsum("nij,nj->ni", f, g), np.einsum("nik,njk->nij", f, f)
            H = (np.einsum("nmi,nl,nj->nijlm", f, g, k) + np.einsum("ni,njl,nm->nijlm", g, f, k)
                 + np.einsum("ni,njm,nl->nijlm", g, metric, g))
            dk = -np.einsum("njl,nm->njlm", f, k) - np.einsum("njm,nl->njlm", metric, g)
            block = lambda values, n: scipy.sparse.block_diag(list(values.reshape(len(values), n, -1) * self.a[:, None, None]), format="csr")
            uu -= self.G.T @ block(H, 9) @ self.G
            up -= (self.Gp.T @ block(dk, 3) @ self.G).T
            pp -= self.Gp.T @ block(metric, 3) @ self.Gp
            u += self.G.T @ (np.einsum("ni,nj->nij", g, k) * self.a[:, None, None]).ravel()
            rp -= self.Gp.T @ (k * self.a[:, None]).ravel()
        r = np.concatenate([u, rp])
        return r[self.free], scipy.sparse.bmat([[uu, up], [up.T, pp]]).tocsr()[self.free][:, self.free]

    def J(self, w):
        return min(np.linalg.det(F).min() for F in self.gradients(w))

    def newton(self, w, m, rows, target, tolerance=1e-8):
        """State and multipliers with rows u = target, or None."""
        for iteration in range(25):
            r, A = self.system(w)
            r = np.concatenate([r - rows.T @ m, rows @ w[self.free] - target])
            if iteration and np.abs(r).max() < tolerance:
                return w, m
            step = scipy.sparse.linalg.spsolve(scipy.sparse.bmat([[A, -rows.T], [rows, None]]).tocsc(), -r)
            move = np.zeros(len(w))
            move[self.free] = step[:-3]
            length = next((2.0**-k for k in range(10) if self.J(w + 2.0**-k * move) > 0), 0.0)
            if length == 0:
                break
            w, m = w + length * move, m + length * step[-3:]
        return None

    def ray(self, place, direction, depths, steps=2):
        """As study.ray; there are no pivots."""
        w = weights(surface(self.spaces.domain), place, self.spaces.x, 1)
        rows = scipy.sparse.csr_matrix(np.hstack([np.kron(w, I3.T).reshape(3, -1), np.zeros((3, len(self.spaces.xp)))])[:, self.free])
        state, out, last = (np.zeros(self.n + len(self.spaces.xp)), np.zeros(3)), [], 0.0
        for target in depths:
            step = (target - last) / steps
            while last < target - 1e-9:
                to = min(last + step, target)
                found = self.newton(*state, rows, direction * to * place[2])
                state, last, step = (found, to, step) if found else (state, last, step / 2)
                if step < depths[0] / steps / 5:
                    return out + [None] * (len(depths) - len(out))
            out.append((state[1], None, self.J(state[0])))
        return out
