"""Which stabilization should the equal-order element p1-p1 have, if a round tool moves a weighted mean of the surface?

Packages (Debian): python3-dolfinx-real, python3-gmsh, python3-scipy. The meshes are those of `phynness mesh SCENE -o NAME.msh`:

    lab/study element reproduce demo.toml --phynness build/release/phynness
    lab/study element rest fields rigid demo.msh liver736.msh ...
    lab/study element order resolved stable depth demo.msh ...

`reproduce` compares the force at a node with `phynness solve`. At rest: `rest` gives the errors of the force of all candidates,
`chosen` those of p1-p1 and es-p1-p1 under the product's tool, `order` the uncertainty of the references, `resolved` the errors on
cells of half the size, `fields` displacements, pressures and their oscillation, `rigid` a rigid patch for comparison, `stable` the
inf-sup constant, `cost` the time of a factorization. `depth`
presses, pulls and slides up to the tool's radius. Surface nodes are fixed in the first quarter along x (the paper's liver: a fifth;
cylinder and tube: a fifth along z). The liver181 and liver507 of the results are those of SOFA (share/mesh). Figures are kept in results.json beside this file by section and mesh.
OMP_NUM_THREADS=1; about 20 minutes.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import ufl
from edges import Smoothed, cells, smoothed
from rest import Factors, Organ, Spaces, blocks, errors, fem, forces, frame, scipy, surface, tool, weights

RATIOS = (5, 20, 50, 200, 1000)
MINI, MODES = ("bubble", 0.42857 / 160), ("variance", 0.0375)  # condensed bubble; condensed conformal quadratic modes
DIAMETER = [("diameter", a) for a in (0.01, 0.015, 0.02, 0.025, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)]
OTHER = [(name, a) for name in ("edges", "variance", "volume", "heights", "bubble") for a in (0.025, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)]
SMOOTHED = [("diameter", a) for a in (0.02, 0.05, 0.1, 0.2)]
LEADING = [("diameter", a) for a in (0.025, 0.05, 0.5, 1.0)]
WAYS = (("press", 0, 1), ("pull", 0, -1), ("slide", 1, 1))


def label(candidate):
    return "{} {:.4g}".format(*candidate)


def extrapolated(S0, S1, order=1.4):
    """The limit of compliances of Taylor-Hood on the mesh and on half its cells; for the order see `order`."""
    return S1 + (S1 - S0) / (2**order - 1)


def references(organ, phi="Hertz"):
    coarse = Spaces(organ, organ.domain, 2, phi).taylor_hood(RATIOS)
    fine = Spaces(organ, organ.refined(1), 2, phi).taylor_hood(RATIOS)
    return {K: extrapolated(coarse[K], fine[K]) for K in RATIOS}, coarse, fine


def sample(S, reference, organ):
    e, size = errors(S, reference, organ)
    return np.round(np.array([e, size]).reshape(2, -1), 4).tolist()  # relative errors and ratios of size


def candidates(spaces, organ, limit, chosen, prefix=""):
    return {prefix + label(c): {K: sample(spaces.p1p1(K, *c), limit[K], organ) for K in RATIOS} for c in chosen}


def rest(path, phi="Hertz"):
    """Errors by candidate and K/mu. The samples are kept outside of the results: `summary` condenses them."""
    organ = Organ(path)
    limit, coarse, fine = references(organ, phi)
    out = {name: {K: sample(S[K], limit[K], organ) for K in RATIOS} for name, S in (("TH", coarse), ("TH h/2", fine))}
    spaces = Spaces(organ, organ.domain, 1, phi)
    out |= candidates(spaces.condense(), organ, limit, DIAMETER + OTHER + [MINI, MODES])
    spaces.A = smoothed(spaces)
    return out | candidates(spaces.condense(), organ, limit, SMOOTHED, "edge-smoothed, ")


def chosen(path):
    """p1-p1 and es-p1-p1 as in the product, with an even pressure."""
    organ = Organ(path)
    limit, coarse, _ = references(organ, "even")
    out = {"TH": {K: sample(coarse[K], limit[K], organ) for K in RATIOS}}
    spaces = Spaces(organ, organ.domain, 1, "even")
    cells_only = spaces.A
    out |= candidates(spaces.condense(), organ, limit, [("diameter", 0.05)], "p1-p1, ")
    spaces.A = 0.9 * smoothed(spaces) + 0.1 * cells_only
    return out | candidates(spaces.condense(), organ, limit, [("diameter", 0.1)], "es-p1-p1, ")


def order(path):
    """Taylor-Hood on the mesh, h/2 and h/4, K/mu = 200: orders of the compliance, and errors of the extrapolated limit."""
    organ, S = Organ(path), []
    for level in range(3):
        s = Spaces(organ, organ.refined(level), 2)
        S.append(s.taylor_hood((200,), (200.0,))[200])
    traces = [np.trace(s, axis1=1, axis2=2) for s in S]
    rate = (traces[1] - traces[0]) / (traces[2] - traces[1])
    best = S[2] + (S[2] - S[1]) / (rate.clip(1.5, 8) - 1)[:, None, None]
    out = {"orders": np.log2(rate).round(2).tolist(), "unknowns": len(s.free) + s.M.shape[0]}
    for name, s in (("TH", S[0]), ("TH h/2", S[1]), ("TH h/4", S[2]), ("extrapolated", extrapolated(*S[:2]))):
        e = errors(s, best, organ)[0]
        out[name] = np.round([np.median(e), np.percentile(e, 95), e.max()], 4).tolist()
    return out


def resolved(path):
    """p1-p1 on half the cells, tools of 4 to 8 edges."""
    organ = Organ(path)
    limit, spaces = references(organ)[0], Spaces(organ, organ.refined(1), 1)
    out = candidates(spaces.condense(), organ, limit, DIAMETER)
    spaces.A = smoothed(spaces)
    return out | candidates(spaces.condense(), organ, limit, SMOOTHED, "edge-smoothed, ")


def cost(path, K=200):
    """CPU milliseconds of a factorization and solve, medians of five, and millions of entries of the matrix."""
    organ, out = Organ(path), {}
    for name, degree in (("p1-p1", 1), ("edge-smoothed", 1), ("taylor-hood", 2)):
        s = Spaces(organ, organ.domain, degree)
        C = 0.05 * s.stabilization("diameter") if degree == 1 else 0 * s.M
        A = scipy.sparse.bmat([[smoothed(s) if name == "edge-smoothed" else s.A, s.B.T], [s.B, -s.M / (K - 2 / 3) - C]])
        times = []
        for _ in range(5):
            start = time.process_time()
            Factors(A).solve(np.ones((A.shape[0], 1)))
            times.append(time.process_time() - start)
        out[name] = [round(1000 * float(np.median(times))), round(A.nnz / 1e6, 3)]
    return out


def fields(path, K=200):
    """Presses, K/mu = 200: medians of the errors of the surface's displacement and of the pressure within 1.5 radii, of the
    oscillating part of that pressure, and of Taylor-Hood's on half the cells, at the same nodes."""
    organ, out = Organ(path), {}
    fine = Spaces(organ, organ.refined(1), 2)
    fine.taylor_hood((K,), (float(K),))
    spaces = Spaces(organ, organ.domain, 1).condense()
    skin = np.unique(scipy.spatial.cKDTree(spaces.x).query(surface(organ.domain)[1].reshape(-1, 3))[1])
    at_x, at_p = [scipy.spatial.cKDTree(a).query(b)[1] for a, b in ((fine.x, spaces.x), (fine.xp, spaces.xp))]
    nodes, volume, _ = cells(spaces)
    nodes = scipy.spatial.cKDTree(spaces.xp).query(spaces.x)[1][nodes]
    mass = np.bincount(nodes.ravel(), np.repeat(volume, 4)) / 4

    def rough(p, near):  # the part of p that a mean over cells and back removes
        q = np.bincount(nodes.ravel(), np.repeat(volume * p[nodes].mean(1), 4)) / 4 / mass
        return np.sqrt((mass * (p - q) ** 2)[near].sum() / (mass * p**2)[near].sum())

    for prefix, c in [("", c) for c in DIAMETER + [MODES, MINI]] + [("edge-smoothed, ", c) for c in SMOOTHED]:
        if prefix and not out.get(prefix + label(SMOOTHED[0])):
            spaces.A = smoothed(spaces)
            spaces.condense()
        u_errors, p_errors, roughness = [], [], []
        S, X, P = spaces.p1p1(K, *c, states=True)
        for i, (at, normal, R) in enumerate(organ.places):
            d = frame(normal)[0]
            u, p = [a[:, 3 * i:3 * i + 3] @ np.linalg.solve(S[i], d) for a in (spaces.full(X), P)]
            limit = np.linalg.solve(fine.state[0][i], d)
            v, q = fine.full(fine.state[1])[:, 3 * i:3 * i + 3] @ limit, fine.state[2][:, 3 * i:3 * i + 3] @ limit
            difference = (u.reshape(-1, 3) - v.reshape(-1, 3)[at_x])[skin]
            u_errors.append(np.linalg.norm(difference) / np.linalg.norm(v.reshape(-1, 3)[at_x][skin]))
            q, near = q[at_p], np.linalg.norm(spaces.xp - at, axis=1) < 1.5 * R
            p_errors.append(np.sqrt((mass * (p - q) ** 2)[near].sum() / (mass * q**2)[near].sum()))
            roughness.append([rough(p, near), rough(q, near)])
        figures = np.median(u_errors), np.median(p_errors), *np.median(roughness, axis=0)
        out[prefix + label(c)] = np.round(figures, 3).tolist()
    return out


def rigid(path, K=200):
    """Force of a rigid patch, weights (1 - s^2)^2, radius 2.8 edges, over Taylor-Hood on the same mesh and on half its cells."""
    organ, forces_by = Organ(path, radii=(2.8,)), {}
    for level, degree, alphas in ((0, 1, [a for _, a in DIAMETER]), (0, 2, [0]), (1, 2, [0])):
        s = Spaces(organ, organ.refined(level), degree)
        C = s.stabilization("diameter")
        skin = fem.locate_dofs_topological(fem.VectorFunctionSpace(s.domain, ("Lagrange", degree)), 2, surface(s.domain)[0])
        for i, (at, normal, R) in enumerate(organ.places):
            s2 = ((s.x[skin] - at) ** 2).sum(1) / R**2
            w = np.zeros(len(s.x))
            w[skin[s2 < 1]] = (1 - s2[s2 < 1]) ** 2
            free = np.repeat(w == 0, 3)[s.free]
            held = np.kron(w[:, None], frame(normal)[:1].T)[s.free]
            for a in alphas:
                A = scipy.sparse.bmat([[s.A[free][:, free], s.B[:, free].T], [s.B[:, free], -s.M / (K - 2 / 3) - a * C]])
                x = Factors(A).solve(-np.vstack([(s.A @ held)[free], s.B @ held]))
                u = held.copy()
                u[free] += x[:free.sum()]
                forces_by.setdefault((level, degree, a), []).append((held.T @ (s.A @ u + s.B.T @ x[free.sum():])).item())
    return {f"diameter {a:.4g}": [round(float(np.median(np.divide(f, forces_by[k, 2, 0]))), 3) for k in (0, 1)]
            for (level, degree, a), f in forces_by.items() if degree == 1}


def stable(path):
    """The numerical inf-sup constant on the mesh and on its refinements."""
    organ, out = Organ(path), {}
    for level in range(3):
        domain = organ.refined(level)
        if domain.topology.index_map(0).size_local > 1500:
            break
        s = Spaces(organ, domain, 1).condense()
        for c in DIAMETER + [("variance", 0.1), ("variance", 0.5), MODES, MINI, ("bubble", 0.1), ("diameter", 0.0)]:
            out.setdefault(label(c), []).append(round(s.infsup(*c), 4))
        s.A = smoothed(s)
        s.condense()
        for c in SMOOTHED:
            out.setdefault("edge-smoothed, " + label(c), []).append(round(s.infsup(*c), 4))
    return out


def finite(organ, level, element, K, current=True):
    """A body with the stabilization of the diameter; current: with F^-T grad p, as today."""
    domain = organ.refined(level)
    alpha = fem.Constant(domain, 0.05)

    def klaas(F, p, domain):
        g = ufl.dot(ufl.inv(F).T, ufl.grad(p)) if current else ufl.grad(p)
        return alpha * ufl.CellDiameter(domain) ** 2 / 2 * ufl.inner(g, g)

    body = tool.Body(domain, lambda x: organ.is_fixed(x.T), K=K, element=element,
                     stabilization=klaas if element == "p1-p1" else None)
    body.alpha, body.skin, body.degree = alpha, surface(domain), 1 if element == "p1-p1" else 2
    return body


def ray(body, place, direction, depths, steps=2):
    """Forces, negative pivots and least J at the depths in radii; None from where Newton's method stops."""
    w = weights(body.skin, place, body.x, body.degree)
    rows = np.zeros((3, len(body.w.x.array)))
    for k in range(3):
        rows[k][body.component[k]] = w
        rows[k][body.fixed] = 0
    body.w.x.array[:], body.multipliers, out, last = 0, np.zeros(3), [], 0.0
    for target in depths:
        step = (target - last) / steps
        while last < target - 1e-9:
            start, multipliers, to = body.w.x.array.copy(), body.multipliers.copy(), min(last + step, target)
            try:
                force = body.solve(rows=rows, d=direction * to * place[2], tolerance=1e-6)
                last = to
            except tool.Stopped:
                body.w.x.array[:], body.multipliers, step = start, multipliers, step / 2
                if step < depths[0] / steps / 5:
                    return out + [None] * (len(depths) - len(out))
        out.append((force, body.negative_pivots(), float(body.J().min())))
    return out


def depth(path, ratios=(20, 200), places=(1, 3), depths=(1 / 3, 2 / 3, 1.0)):
    """By K/mu, element and alpha: errors of the force at the depths (all rays), largest, ends of rays, negative pivots."""
    organ, out = Organ(path), {}
    rays = [(organ.places[i], s * frame(organ.places[i][1])[k]) for i in places for _, k, s in WAYS]
    for K in ratios:
        fine = finite(organ, 1, "taylor-hood", K)
        limit = [ray(fine, *r, depths) for r in rays]
        for name, alphas in (("taylor-hood", (0,)), ("F^-T grad p", (0.025, 0.05, 0.1, 0.2, 0.5, 1.0)), ("grad p", (0.05, 0.2, 1.0)),
                             ("edge-smoothed, grad p", (0.05, 0.1))):
            if "edge" not in name:
                body = finite(organ, 0, "taylor-hood" if name == "taylor-hood" else "p1-p1", K, name != "grad p")
            for a in alphas:
                if "edge" in name:
                    element = Smoothed(Spaces(organ, organ.domain, 1), K, a)
                    found = [element.ray(*r, depths) for r in rays]
                else:
                    body.alpha.value = a
                    found = [ray(body, *r, depths) for r in rays]
                e = np.array([[np.nan if x is None or y is None else np.linalg.norm(x[0] - y[0]) / np.linalg.norm(y[0])
                               for x, y in zip(f, g)] for f, g in zip(found, limit)])
                out[f"K/mu {K}, {name} {a:.4g}"] = {
                    "median": np.nanmedian(e, axis=0).round(3).tolist(), "largest": np.nanmax(e, axis=0).round(3).tolist(),
                    "ends": [sum(f[j] is None for f in found) for j in range(len(depths))],
                    "ends of the reference": [sum(f[j] is None for f in limit) for j in range(len(depths))],
                    "least_J": round(min(x[2] for f in found for x in f if x), 3)}
                print(K, name, a, out[f"K/mu {K}, {name} {a:.4g}"], flush=True)
    return out


def reproduce(scene, program):
    """The force at a node from this p1-p1 and from `phynness solve`: largest difference over the force."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "mesh", scene, "-o", f"{folder}/body.msh"], check=True, capture_output=True)
        organ = Organ(f"{folder}/body.msh")
        place = organ.places[1][0]
        x = organ.domain.geometry.x
        node = x[np.argmin(np.linalg.norm(x - place, axis=1))].copy()
        d = 0.3 * organ.edge * np.array([0.5, -0.3, 0.8])
        body = finite(organ, 0, "p1-p1", 200.0)
        i = int(np.argmin(np.linalg.norm(body.x - node, axis=1)))
        for k in range(1, 5):
            force = body.solve(patch=([i], np.ones(1)), d=d / organ.edge * k / 4, tolerance=1e-11) * 500 * organ.edge**2
        subprocess.run([program, "solve", scene, "--point", ",".join(map(str, node * organ.edge)), "--displacement",
                        ",".join(map(str, d)), "--increments", "4", "--json", f"{folder}/s.json"], check=True, capture_output=True)
        other = np.array(json.loads(pathlib.Path(f"{folder}/s.json").read_text())["tools"][0]["force"])
    return {"force_N": force.tolist(), "of phynness solve": other.tolist(), "difference": float(np.abs(force - other).max() / np.linalg.norm(other))}


def summary(samples):
    """Samples by body, candidate, K/mu -> [median, p95, largest, median ratio]; leading candidates by body and K/mu, too."""
    def figures(rows):
        e, size = np.concatenate([np.array(r) for r in rows], axis=1)
        return [round(float(v), 3) for v in (np.median(e), np.percentile(e, 95), e.max(), np.median(size))]
    out = {n: figures([r for body in samples.values() for r in body[n].values()]) for n in next(iter(samples.values()))}
    kept = ["TH", "edge-smoothed, diameter 0.05", "p1-p1, diameter 0.05", "es-p1-p1, diameter 0.1"] + [label(c) for c in LEADING]
    return {"all": out, "by body and K/mu": {n: {b: {K: figures([r])[:3] for K, r in body[n].items()} for b, body in samples.items()} for n in kept if n in out}}


def main():
    sections = {f.__name__: f for f in (rest, chosen, order, resolved, fields, rigid, stable, cost, depth)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="+", help="sections, then meshes (a scene after `reproduce`)")
    parser.add_argument("--phynness", default="build/release/phynness")
    options = parser.parse_args()
    here = pathlib.Path(__file__).parent
    path, raw = here / "results.json", pathlib.Path(tempfile.gettempdir()) / "element_samples.json"  # these are large
    load = lambda file: json.loads(file.read_text()) if file.exists() else {}
    for name in [w for w in options.words if w in sections or w == "reproduce"]:
        for file in [w for w in options.words if w not in sections and w != "reproduce"]:
            start = time.process_time()
            result = reproduce(file, options.phynness) if name == "reproduce" else sections[name](file)
            result["cpu_s"] = round(time.process_time() - start)
            kept, samples, body = load(path), load(raw), pathlib.Path(file).stem
            if name in ("rest", "chosen", "resolved"):
                del result["cpu_s"]
                samples.setdefault(name, {})[body] = result
                raw.write_text(json.dumps(samples))
                kept[name] = summary(samples[name])["all"] if name == "resolved" else summary(samples[name])
            else:
                kept.setdefault(name, {})[body] = result
            path.write_text(json.dumps(kept).replace("NaN", "null").replace("}, ", "},\n") + "\n")
            print(name, body, round(time.process_time() - start), "s", flush=True)


if __name__ == "__main__":
    main()
