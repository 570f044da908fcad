"""p1-p1 and es-p1-p1 under tools within 1.1 radii of fixed nodes, at rest: what the edges and what the tool contribute.

    lab/study near-fixed NAME.msh ...     packages and meshes as in study.py and held_out.py

Prints |f - f*| / |f*| and |f| / |f*| of eight places by the fixed nodes (radii of 2 and 3 edges, even pressure, three directions)
and of the six places of the study; K/mu 5, 50, 200. f* is Taylor-Hood on the mesh and on half its cells, extrapolated.

Rules of the edges: `all-fixed cells out` of the means; `fixed edges alone`: cells keep their own gradient at edges between fixed nodes;
`touching 0.3`: also a share of 0.3 in cells with a fixed node. Tools: `normalized` as in the product; `free surface`: the mean over
the free triangles, fixed nodes counting as zero; `a third`: free corners take a third of the weights of the fixed corners of
their triangles, which is exact to 0.03 for displacements that grow with the root of the distance from fixed nodes.
"""
import argparse

import numpy as np
from edges import SYMMETRIC, cells
from rest import Organ, Spaces, cKDTree, errors, fem, scipy, surface
from study import extrapolated

RATIOS, TOOLS = (5, 50, 200), ("normalized", "free surface", "a third")


def near_places(organ, number=8, radii=(2.0, 3.0), low=0.15, high=1.1):
    """Places far from each other, at distances between low and high radii of the fixed nodes."""
    points, normals = surface(organ.domain)[1:]
    free = ~organ.is_fixed(points.mean(1))
    points, normals, rng, chosen, places = points[free], normals[free], np.random.default_rng(3), np.zeros((0, 3)), []
    candidates = np.einsum("fi,fix->fx", rng.dirichlet((1, 1, 1), len(points)), points)
    far = cKDTree(organ.held.reshape(-1, 3)).query(candidates)[0]
    for i in range(number):
        R, wanted = radii[i % 2], low + (high - low) * (2 * (i // 2) + 1) / number
        gap = cKDTree(np.vstack([chosen, [[1e9] * 3]])).query(candidates)[0].clip(0, 20) + 1e-3 * rng.random(len(far))
        gap[np.abs(far / R - wanted) >= 1.2 * (high - low) / number] = -1
        if gap.max() >= 0:
            f = int(np.argmax(gap))
            chosen = np.vstack([chosen, candidates[f]])
            places.append((candidates[f], normals[f], R))
    return places


def loads(organ, spaces, degree, tool, cuts=20):
    """As those of Spaces: weights of the points times unit forces, without the rows of fixed points."""
    _, points, normals = surface(spaces.domain)
    facing = ~organ.is_fixed(points.mean(1))
    points, normals = points[facing], normals[facing]
    is_fixed = ~np.isin(np.arange(len(spaces.x)), spaces.free // 3)
    i, j = [a.ravel() for a in np.meshgrid(np.arange(3 * cuts), np.arange(3 * cuts))]
    inside = (i + j <= 3 * cuts - 2) & ((i - j) % 3 == 0) & (i % 3 < 2)
    L = np.column_stack([i[inside] + 1, j[inside] + 1]) / (3.0 * cuts)
    N = L = np.column_stack([L, 1 - L.sum(1)])
    pairs, out = ((0, 1), (1, 2), (2, 0)), []
    if degree == 2:
        N = np.column_stack([L * (2 * L - 1)] + [4 * L[:, a] * L[:, b] for a, b in pairs])
    for at, normal, R in organ.places:
        corners = points[(normals @ normal > 0.3) & (np.linalg.norm(points - at, axis=2).min(1) < 2 * R)]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        parts = (((np.einsum("qi,fix->fqx", L, corners) - at) ** 2).sum(2) < R**2) * area[:, None] @ N
        at_points = corners if degree == 1 else np.concatenate([corners] + [corners[:, p].mean(1, keepdims=True) for p in pairs], axis=1)
        index = cKDTree(spaces.x).query(at_points.reshape(-1, 3))[1].reshape(parts.shape)
        whole, lost = parts.sum(), parts * is_fixed[index]
        parts = parts - lost
        if tool == "a third":
            parts += ~is_fixed[index] * (lost.sum(1) / 3 / np.maximum((~is_fixed[index]).sum(1), 1))[:, None]
        w = np.bincount(index.ravel(), parts.ravel(), len(spaces.x))
        out.append(np.kron(w[:, None] / (w.sum() if tool == "normalized" else whole), np.eye(3))[spaces.free])
    return np.hstack(out)


def energy(spaces, share, alone):
    """The uu block at rest. @param share  of the cells; alone: flags of edges, by flags of their ends"""
    nodes, volumes, G = cells(spaces)
    pairs = np.sort(np.concatenate([nodes[:, p] for p in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))]), axis=1)
    edge, cell = np.unique(pairs, axis=0, return_inverse=True)[1].ravel(), np.tile(np.arange(len(nodes)), 6)
    part, single = (volumes * (1 - share))[cell] / 6, alone[pairs].all(1)
    own = volumes * share + np.bincount(cell[single], part[single], len(volumes))
    total = np.bincount(edge, part * ~single)
    mean = scipy.sparse.csr_matrix((part * ~single / np.maximum(total, 1e-30)[edge], (edge, cell)), (len(total), len(nodes)))
    H = scipy.sparse.kron(mean, scipy.sparse.eye(9)).tocsr() @ G
    A = sum(g.T @ scipy.sparse.kron(scipy.sparse.diags(2 * v), SYMMETRIC) @ g for g, v in ((H, total), (G, own)))
    return A.tocsr()[spaces.free][:, spaces.free]


def candidates(spaces):
    """Name, uu block, alpha."""
    is_fixed = ~np.isin(np.arange(len(spaces.x)), spaces.free // 3)
    nodes, none = cells(spaces)[0], np.zeros(len(spaces.x), bool)
    share = np.full(len(nodes), 0.1)
    yield "p1-p1", spaces.A, 0.05
    yield "es-p1-p1", energy(spaces, share, none), 0.1
    yield "all-fixed cells out", energy(spaces, np.where(is_fixed[nodes].all(1), 1, share), none), 0.1
    yield "fixed edges alone", energy(spaces, share, is_fixed), 0.1
    yield "touching 0.3", energy(spaces, np.where(is_fixed[nodes].any(1), 0.3, share), is_fixed), 0.1


def main(paths):
    found = {}
    for path in paths:
        organ = Organ(path)
        count = len(organ.places)
        organ.places += near_places(organ)
        taylor_hood = []
        for level in (0, 1):
            spaces = Spaces(organ, organ.refined(level), 2, "even")
            for tool in TOOLS[:2]:
                spaces.U = loads(organ, spaces, 2, tool)
                taylor_hood.append(spaces.taylor_hood(RATIOS))
        limit = {K: extrapolated(taylor_hood[0][K], taylor_hood[2][K]) for K in RATIOS}

        def add(tool, name, S):
            for K in RATIOS:
                e = np.array(errors(S[K], limit[K], organ))
                for where, part in (("elsewhere", e[:, :count]), ("near", e[:, count:])):
                    found.setdefault((where, tool, name), []).append(part.reshape(2, -1))

        add("normalized", "taylor-hood", taylor_hood[0])
        add("free surface", "taylor-hood", taylor_hood[1])
        add("free surface", "taylor-hood h/2", taylor_hood[3])
        spaces = Spaces(organ, organ.domain, 1, "even")
        spaces.U = np.hstack([loads(organ, spaces, 1, tool) for tool in TOOLS])
        for name, spaces.A, alpha in list(candidates(spaces)):
            spaces.condense()
            S = {K: np.split(spaces.p1p1(K, "diameter", alpha), 3) for K in RATIOS}
            for i, tool in enumerate(TOOLS):
                add(tool, name, {K: S[K][i] for K in RATIOS})
        print(path, flush=True)
    for (where, tool, name), samples in sorted(found.items()):
        e, size = np.concatenate(samples, axis=1)
        print(f"{where:10s}{tool:14s}{name:20s} median {np.median(e):.3f}, p95 {np.percentile(e, 95):.3f}, largest {e.max():.3f}; "
              "ratio p5, median, p95 {:.2f} {:.2f} {:.2f}".format(*np.percentile(size, (5, 50, 95))), len(e), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", metavar="NAME.msh")
    main(parser.parse_args().meshes)
