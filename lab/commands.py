"""Runs the commands of phynness for the studies of this folder, and reads and writes their files. The program is
build/release/phynness, or $PHYNNESS."""

import json
import os
import pathlib
import subprocess

import h5py
import numpy as np

SOURCE = pathlib.Path(__file__).resolve().parent.parent
PHYNNESS = os.environ.get("PHYNNESS", str(SOURCE / "build/release/phynness"))
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")


def run(*words):
    """Standard output. Ends the study if the command fails."""
    done = subprocess.run([PHYNNESS, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit("phynness " + " ".join(map(str, words)) + "\n" + done.stderr)
    return done.stdout


def answer(*words):
    """What --json writes; None if the command fails, as a solve without an equilibrium does."""
    done = subprocess.run([PHYNNESS, *map(str, words), "--json", "-"], capture_output=True, text=True)
    if done.returncode == 2:
        raise SystemExit("phynness " + " ".join(map(str, words)) + "\n" + done.stderr)
    return json.loads(done.stdout[done.stdout.index("{"):]) if done.returncode == 0 else None


def vector(v):
    return ",".join("%.17g" % x for x in v)


def solve(scene, place, d, increments=3):
    """Force [N] and answer of a solve at a point (three numbers) or a node; None without an equilibrium."""
    where = ["--node", place] if np.ndim(place) == 0 else ["--point", vector(place)]
    found = answer("solve", scene, *where, "--displacement", vector(d), "--increments", increments, "--tangent")
    return found and (np.array(found["tools"][0]["force"]), found)


def forces(model, nodes, displacements, folder):
    """Forces [N] of a model, n x 3."""
    queries = pathlib.Path(folder) / "queries.csv"
    queries.write_text("node,ux_m,uy_m,uz_m\n" + "".join("%d,%s\n" % (n, vector(d)) for n, d in zip(nodes, displacements)))
    table = np.genfromtxt(run("eval", model, "--queries", queries).splitlines(), delimiter=",", names=True)
    return np.column_stack([np.atleast_1d(table[k]) for k in ("fx_N", "fy_N", "fz_N")])


def changed(text, values):
    """A scene with other values; values: {(section, key): value as in the scene}. A key that is absent is added."""
    lines, section, left = [], "", dict(values)
    for line in text.splitlines() + ["[end]"]:
        if line.startswith("["):
            lines += [f"{key} = {left.pop((of, key))}" for of, key in list(left) if of == section]
            section = line[1:line.index("]")]
        key = line.split("=")[0].strip()
        if (section, key) in left:
            line = f"{key} = {left.pop((section, key))}"
        lines.append(line)
    return "\n".join(lines[:-1]) + "".join(f"\n[{of}]\n{key} = {value}" for (of, key), value in left.items()) + "\n"


def shipped(name, values=None):
    return changed((SOURCE / "scenes" / name).read_text(), values or {})


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def tally(database):
    """Outcomes of the rays of a database: a dictionary whose values are printed in the order of HEAD."""
    with h5py.File(database) as f:
        r = f["responses"]
        status, names = r["status"][()], {}
        for what in ("status", "end_reason"):
            a = r[what].attrs
            names[what] = dict(zip(a["flag_values"].tolist(), text(a["flag_meanings"]).split()))
        asked = np.array([names["status"][s] != "not_requested" for s in status.ravel()]).reshape(status.shape).all(2)
        status, reason = status[asked], r["end_reason"][()][asked]
        J, cut, pivots = (r[k][()][asked] for k in ("min_jacobian", "cutbacks", "negative_pivots"))
        cpu_s = r["seconds"][()].sum()
    good = status == 0
    full = good.all(1)
    first = [names["status"][s[~g][0]] for s, g in zip(status, good) if not g.all()]
    ends = [names["end_reason"][e] for e in reason[~full]]
    count = lambda words: ", ".join(f"{words.count(w)} {w}" for w in sorted(set(words))) or "none"
    return {
        "rays": len(status), "reached": good.cumprod(axis=1).mean(0),
        "upright": (full & np.where(good, J > 0, True).all(1)).mean(), "cut": int((cut > 0).sum()),
        "failed": count(first), "ends": count(ends), "indefinite": int((good & (pivots > 0)).sum()),
        "min_J": J[good].min(initial=1), "ms": 1000 * cpu_s / max(1, good.sum()),
    }


def print_tally(what, t, increments):
    reached = " ".join("%5.1f %%" % (100 * t["reached"][i]) for i in increments)
    print(f"{what:34s} {t['rays']:4d} rays, reach {reached}; with J > 0 {100 * t['upright']:.1f} %; {t['cut']} increments cut; "
          f"failed: {t['failed']}; ends: {t['ends']}; {t['indefinite']} indefinite; min J {t['min_J']:.3f}; "
          f"{t['ms']:.1f} ms an increment", flush=True)


def read_msh(path):
    """Nodes [m], tetrahedra and fixed nodes of a file of `phynness mesh`."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(path))
    tags, x, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    x, tags = x.reshape(-1, 3)[order], tags[order]
    cells = np.searchsorted(tags, gmsh.model.mesh.getElementsByType(4)[1]).reshape(-1, 4)
    (group,) = [t for d, t in gmsh.model.getPhysicalGroups(0) if gmsh.model.getPhysicalName(d, t) == "phynness_fixed"]
    fixed = np.unique(np.searchsorted(tags, gmsh.model.mesh.getNodesForPhysicalGroup(0, group)[0]))
    gmsh.finalize()
    return x, cells, fixed


def write_msh(path, x, cells, fixed):
    lines = ["$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n0 1 \"phynness_fixed\"\n3 2 \"body\"\n$EndPhysicalNames\n$Nodes",
             str(len(x)), *("{} {!r} {!r} {!r}".format(i + 1, *map(float, p)) for i, p in enumerate(x)), "$EndNodes\n$Elements",
             str(len(fixed) + len(cells)), *(f"{i + 1} 15 2 1 1 {n + 1}" for i, n in enumerate(fixed)),
             *("{} 4 2 2 1 {} {} {} {}".format(len(fixed) + i + 1, *(c + 1)) for i, c in enumerate(cells)), "$EndElements\n"]
    pathlib.Path(path).write_text("\n".join(lines))


def surface_faces(cells):
    faces = np.sort(np.concatenate([cells[:, k] for k in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))]), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    return faces[count == 1]
