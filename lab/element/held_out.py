"""p1-p1 and es-p1-p1 on bodies that were not used to choose the element: maps of a sphere that look like organs.

    lab/study held-out bodies FOLDER              kidney.stl, spleen.stl, stomach.stl, bladder.stl
    lab/study held-out rest NAME.msh ...          even pressure, shares of the cells and alphas
    lab/study held-out depth NAME.msh ...         to the tool's radius, by `phynness precompute`
    lab/study held-out reproduce NAME.msh ...     `phynness solve` against edges.py

The meshes are those of `phynness mesh` with target_size_m of 12.5 mm (bladder 13.5, stomach 19) and the first quarter along x fixed.
Packages, and the rest, as in study.py.
"""
import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from commands import read_msh, surface_faces, write_msh  # noqa: E402

WAYS, INCREMENTS, RATIOS = 3, 4, (5, 50, 200)  # +x, +y, +z
RADII = {"kidney": 3.0, "spleen": 2.5, "stomach": 3.5, "bladder": 2.0}  # in mean edges of the surface
SCENE = """[mesh]
file = "{msh}"
[material]
law = "neo-hookean"
c10_Pa = 250.0
bulk_modulus_Pa = {bulk}
[solver]
element = "{element}"
[nodes]
fixed = {{ group = "phynness_fixed" }}
active = {{ nodes = {nodes} }}
[probe]
kind = "patch"
tool_radius_m = {radius}
directions = {ways}
increments = {increments}
max_displacement_m = {radius}
"""


def sphere(times):
    """Points and triangles of an icosahedron whose triangles are divided into four, `times` times."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1),
              (-g, 0, -1), (-g, 0, 1)]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
                 (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    points = [np.array(p) / np.linalg.norm(p) for p in points]
    for _ in range(times):
        middle, finer = {}, []
        for t in triangles:
            m = []
            for a, b in zip(t, t[1:] + t[:1]):
                if (key := (min(a, b), max(a, b))) not in middle:
                    middle[key] = len(points)
                    points.append((points[a] + points[b]) / np.linalg.norm(points[a] + points[b]))
                m.append(middle[key])
            finer += [(t[0], m[0], m[2]), (t[1], m[1], m[0]), (t[2], m[2], m[1]), tuple(m)]
        triangles = finer
    return np.array(points), np.array(triangles)


def bodies(folder):
    points, triangles = sphere(4)
    x, y, z = points.T

    def bent(x, y, z, radius):
        return np.column_stack([(radius - y) * np.sin(x / radius), radius - (radius - y) * np.cos(x / radius), z])

    shapes = {"kidney": bent(0.060 * x, 0.027 * y * (1 + 0.1 * x), 0.021 * z, 0.055),
              "spleen": bent(0.062 * x, 0.017 * y, 0.036 * z * (1 - 0.25 * x), 0.075),
              "stomach": bent(0.10 * x, 0.036 * y * (1 + 0.35 * x), 0.034 * z * (1 + 0.35 * x), 0.085),
              "bladder": np.column_stack([0.042 * x, 0.036 * y, 0.032 * z * (1 - 0.35 * x**2) + 0.006 * y**2])}
    for name, shape in shapes.items():
        corners = shape[triangles]
        records = [struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in corners]
        (pathlib.Path(folder) / f"{name}.stl").write_bytes(b" " * 80 + struct.pack("<I", len(records)) + b"".join(records))


def show(name, errors):
    e = np.asarray(errors).ravel()
    print(f"{name:24s} median {np.nanmedian(e):.3f}, p95 {np.nanpercentile(e, 95):.3f}, largest {np.nanmax(e):.3f}", flush=True)


def rest(paths):
    import study

    study.RATIOS, found = RATIOS, {}
    for path in paths:
        organ = study.Organ(path)
        limit, coarse, _ = study.references(organ, "uniform")
        spaces = study.Spaces(organ, organ.domain, 1, "uniform")
        cells, edges = spaces.A, study.smoothed(spaces)

        def add(name, S):
            found.setdefault(name, []).extend(study.errors(S[K], limit[K], organ)[0] for K in RATIOS)

        add("taylor-hood", coarse)
        for share in (1, 0, 0.05, 0.1, 0.2):
            spaces.A = (share * cells + (1 - share) * edges).tocsr()
            spaces.condense()
            for alpha in (0.05, 0.1):
                add(f"share {share}, alpha {alpha}", {K: spaces.p1p1(K, "diameter", alpha) for K in RATIOS})
    for name, errors in found.items():
        show(name, np.concatenate(errors))


def halved(x, cells, fixed):
    """Each cell in eight; a middle is fixed if both of its ends are."""
    pairs = np.sort(np.concatenate([cells[:, p] for p in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))]), axis=1)
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    a, b, c, d = cells.T
    ab, ac, ad, bc, bd, cd = len(x) + which.reshape(6, -1)
    x, is_fixed = np.vstack([x, x[edges].mean(1)]), np.isin(np.arange(len(x)), fixed)
    out = [np.column_stack(t) for t in ((a, ab, ac, ad), (b, ab, bc, bd), (c, ac, bc, cd), (d, ad, bd, cd))]
    diagonals = ((ab, cd, (ac, bc, bd, ad)), (ac, bd, (ab, bc, cd, ad)), (ad, bc, (ab, bd, cd, ac)))
    shortest = np.argmin([np.linalg.norm(x[p] - x[q], axis=1) for p, q, _ in diagonals], axis=0)
    for i, (p, q, ring) in enumerate(diagonals):
        out += [np.column_stack([p, q, ring[j], ring[(j + 1) % 4]])[shortest == i] for j in range(4)]
    out = np.concatenate(out)
    inverted = np.linalg.det(x[out[:, 1:]] - x[out[:, :1]]) < 0
    out[inverted] = out[inverted][:, [0, 2, 1, 3]]
    return x, out, np.concatenate([fixed, len(is_fixed) + np.flatnonzero(is_fixed[edges].all(1))])


def places(x, cells, fixed, radius_in_edges, number=3):
    """Free nodes of the surface farther than the tool's radius from the fixed ones, and far from each other; the radius."""
    faces = surface_faces(cells)
    radius = radius_in_edges * np.mean([np.linalg.norm(x[faces[:, a]] - x[faces[:, b]], axis=1) for a, b in ((0, 1), (1, 2), (2, 0))])
    nodes = np.setdiff1d(faces, fixed)
    nodes = nodes[np.linalg.norm(x[nodes][:, None] - x[fixed], axis=2).min(1) > 1.1 * radius]
    chosen = [nodes[np.random.default_rng(11).integers(len(nodes))]]
    while len(chosen) < number:
        chosen.append(nodes[np.argmax(np.linalg.norm(x[nodes][:, None] - x[chosen], axis=2).min(1))])
    return list(map(int, chosen)), radius


def depth(paths, program="build/release/phynness"):
    import h5py

    found = {}
    for path in map(pathlib.Path, paths):
        body = read_msh(path)
        nodes, radius = places(*body, RADII[path.stem])
        with tempfile.TemporaryDirectory() as folder:
            write_msh(f"{folder}/fine.msh", *halved(*body))

            def solve(element, msh, K):
                scene = SCENE.format(msh=msh, bulk=500.0 * K, element=element, nodes=nodes, radius=radius, ways=WAYS, increments=INCREMENTS)
                pathlib.Path(f"{folder}/scene.toml").write_text(scene)
                pathlib.Path(f"{folder}/d.h5").unlink(missing_ok=True)
                subprocess.run([program, "precompute", f"{folder}/scene.toml", "-o", f"{folder}/d.h5"], check=True, capture_output=True)
                with h5py.File(f"{folder}/d.h5") as file:
                    force, good = file["responses/force"][...], file["responses/status"][...] == 0
                return np.where(good[..., None], force, np.nan)

            for K in RATIOS:
                reference = solve("taylor-hood", "fine.msh", K)
                for element in ("p1-p1", "es-p1-p1", "taylor-hood"):
                    difference = solve(element, path.resolve(), K) - reference
                    errors = np.linalg.norm(difference, axis=-1) / np.linalg.norm(reference, axis=-1)
                    found.setdefault((element, K), []).append(errors.reshape(-1, INCREMENTS))
    for (element, K), errors in found.items():
        errors = np.concatenate(errors)
        show(f"{element}, K/mu {K}", errors)
        print("    medians by depth", np.round(np.nanmedian(errors, axis=0), 3), "without reference or solution",
              np.isnan(errors).sum(axis=0), flush=True)


def reproduce(paths, program="build/release/phynness", K=200):
    """The force at a node, one edge deep, from edges.py and from `phynness solve`."""
    from edges import Smoothed, scipy
    from rest import Organ, Spaces

    for path in map(pathlib.Path, paths):
        organ = Organ(path)
        spaces = Spaces(organ, organ.domain, 1)
        element = Smoothed(spaces, K, 0.1, 0.1, current=True)
        i = int(np.argmin(np.linalg.norm(spaces.x - organ.places[1][0], axis=1)))
        rows, d = np.zeros((3, element.n + len(spaces.xp))), np.array([0.5, -0.3, 0.8])
        rows[range(3), range(3 * i, 3 * i + 3)] = 1
        rows, state = scipy.sparse.csr_matrix(rows[:, element.free]), (np.zeros(rows.shape[1]), np.zeros(3))
        for step in range(1, 9):
            state = element.newton(*state, rows, d * step / 8, 1e-12)
        force, text = state[1] * 500 * organ.edge**2, lambda v: ",".join(map(repr, (v * organ.edge).tolist()))
        with tempfile.TemporaryDirectory() as folder:
            scene = SCENE.format(msh=path.resolve(), bulk=500.0 * K, element='es-p1-p1"\nrelative_tolerance = 1e-12 #', nodes="[0]",
                                 radius=organ.edge, ways=WAYS, increments=INCREMENTS)
            scene = scene.replace('kind = "patch"\ntool_radius_m', 'kind = "node"\n# tool_radius_m').replace("{ nodes = [0] }", '"free-surface"')
            pathlib.Path(f"{folder}/scene.toml").write_text(scene)
            subprocess.run([program, "solve", f"{folder}/scene.toml", "--point", text(spaces.x[i]), "--displacement", text(d),
                            "--increments", "8", "--json", f"{folder}/s.json"], check=True, capture_output=True)
            other = np.array(json.loads(pathlib.Path(f"{folder}/s.json").read_text())["tools"][0]["force"])
        print(path.stem, force, other, "difference", np.abs(force - other).max() / np.linalg.norm(force), flush=True)


if __name__ == "__main__":
    parts = {"bodies": lambda files: bodies(*files), "rest": rest, "depth": depth, "reproduce": reproduce}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=parts)
    parser.add_argument("files", nargs="+")
    words = parser.parse_args()
    parts[words.part](words.files)
