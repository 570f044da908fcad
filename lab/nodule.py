"""The map of stiffness above a nodule, with it and without, at rest and at 5 mm: of a model and of a reduced body
beside solves of the same finite elements, at nodes and at centres of triangles.

Usage: lab/study nodule FOLDER [--scene FILE] [--places N] [--ranks N]. Databases, models and bodies in FOLDER are used
again; a model without a body is enough. It writes FOLDER/nodule.csv and, where matplotlib is installed, nodule.png.
"""

import argparse
import pathlib
import re

import h5py
import numpy as np
from commands import SOURCE, answer, run, vector

DEPTH_M = 0.005
KINDS = ("dF/dd at rest", "dF/dd at 5 mm", "F/d at 5 mm")
STEP_M = 1e-4  # of central differences: the error is of its square over that of the tool's radius


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--scene", type=pathlib.Path, default=SOURCE / "scenes/liver_nodule.toml")
    parser.add_argument("--places", type=int, default=44, help="most nodes, and most centres of triangles, that the "
                        "model answers, the nearest to the nodule")
    parser.add_argument("--ranks", type=int, default=1)
    return parser.parse_args()


def without_region(text):
    """The same scene, and the same mesh, with a region that has the parameters of the body."""
    body, region = text.split("[[region]]")
    for key, value in re.findall(r"^(\w+_Pa|poisson_ratio) *= *(\S+)", body, re.M):
        region = re.sub(rf"^{key} *=.*$", f"{key} = {value}", region, flags=re.M)
    return body + "[[region]]" + region


def made(scene, folder, ranks):
    if not (folder / "model").exists():
        run("run", scene, "-o", folder, "--ranks", ranks)
    return folder


def where(place):
    return ["--node", place] if np.ndim(place) == 0 else ["--point", vector(place)]


def is_answered(model, place, d):
    try:
        found = answer("eval", model, *where(place), "--displacement", vector(d))
    except SystemExit:  # not between probed nodes
        return False
    return found is not None and found["status"] == 0


def places_of(folder, count):
    """The nodes and the centres of triangles nearest to the nodule that the model answers, as numbers and as points; of
    all of them the inward normals, whether they are probed, and x; and the middle of the nodule."""
    with h5py.File(folder / "database.h5") as f:
        x, faces, active = f["mesh/nodes"][:], f["mesh/surface"][:], f["sets/active"][:]
        regions, cells, fixed = f["mesh/regions"][:], f["mesh/cells"][:], f["sets/fixed"][:]
    nodule = x[cells[regions == 1]].mean(axis=(0, 1))
    area = np.cross(x[faces[:, 2]] - x[faces[:, 0]], x[faces[:, 1]] - x[faces[:, 0]])
    of_nodes = np.zeros_like(x)
    for k in range(3):
        np.add.at(of_nodes, faces[:, k], area)
    farthest = np.linalg.norm(x[active] - nodule, axis=1).max()
    places, inward, at = [], [], []
    for of, candidates, normals in ((x, np.setdiff1d(np.unique(faces), fixed), of_nodes),
                                    (x[faces].mean(axis=1), range(len(faces)), area)):
        far, near = np.linalg.norm(of - nodule, axis=1), []
        for n in sorted((n for n in candidates if far[n] <= farthest), key=lambda n: far[n]):
            place, normal = n if of is x else of[n], normals[n] / np.linalg.norm(normals[n])
            if len(near) < count and is_answered(folder / "model", place, DEPTH_M * normal):
                near.append(n)
                inward.append(normal)
        places.append(np.array(near) if of is x else of[near])
        at.append(of[near])
    probed = np.concatenate([np.isin(places[0], active), np.zeros(len(places[1]), bool)])
    return places, np.array(inward), probed, np.concatenate(at), nodule


def forces_along(command, places, inward, steps, folder):
    """Forces in the direction of pushes of these lengths, a row for each place; NaN without an equilibrium."""
    nodes, points = places
    queries = folder / "queries.csv"
    queries.write_text("node,ux_m,uy_m,uz_m\n" + "".join(
        "%d,%.17g,%.17g,%.17g\n" % (node, *(step * d)) for node, d in zip(nodes, inward) for step in steps))
    table = np.genfromtxt(run(*command, "--queries", queries).splitlines(), delimiter=",", names=True, dtype=None,
                          encoding=None)
    force = np.column_stack([table[k].astype(float) for k in ("fx_N", "fy_N", "fz_N")])
    single = [[answer(*command, *where(p), "--displacement", vector(step * d)) for step in steps]
              for p, d in zip(points, inward[len(nodes):])]
    force = np.concatenate([force.reshape(len(nodes), len(steps), 3),
                            [[f["tools"][0]["force"] if f else 3 * [np.nan] for f in row] for row in single]])
    return (force * inward[:, None, :]).sum(axis=2)


def stiffnesses(command, places, inward, folder):
    """N/m in the direction of the push, a column for each of KINDS."""
    along = forces_along(command, places, inward, (STEP_M, -STEP_M, DEPTH_M + STEP_M, DEPTH_M - STEP_M), folder)
    slopes = (along[:, 0::2] - along[:, 1::2]) / (2 * STEP_M)
    return np.column_stack([slopes, along[:, 2:].mean(axis=1) / DEPTH_M])


def draw(x, nodule, rises, file):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(len(KINDS), len(rises), figsize=(4 * len(rises), 10))
    for row, kind in enumerate(KINDS):
        top = np.nanmax(rises["dolfinx"][:, row])
        for axis, (who, rise) in zip(axes[row], rises.items()):
            drawn = axis.scatter(1e3 * x[:, 0], 1e3 * x[:, 1], c=rise[:, row], vmin=0, vmax=top, s=80)
            axis.plot(1e3 * nodule[0], 1e3 * nodule[1], "k+")
            axis.set(title=f"rise of {kind}, {who}, N/m", aspect="equal", xlabel="x, mm", ylabel="y, mm")
            figure.colorbar(drawn, ax=axis)
    figure.tight_layout()
    figure.savefig(file, dpi=100)


def main():
    options = arguments()
    options.folder.mkdir(parents=True, exist_ok=True)
    text = options.scene.read_text()
    found = {}
    for name, scene_text in (("with", text), ("without", without_region(text))):
        scene = options.folder / f"{name}.toml"
        scene.write_text(scene_text)
        folder = made(scene, options.folder / name, options.ranks)
        if not found:
            places, inward, probed, x, nodule = places_of(folder, options.places)
        found[name] = {who: stiffnesses(command, places, inward, options.folder) for who, command in (
            ("dolfinx", ("solve", folder / "database.h5")), ("model", ("eval", folder / "model")),
            ("body", ("eval", folder / "model", "--body", folder / "body.txt"))) if who != "body" or
            (folder / "body.txt").exists()}
    rises = {who: found["with"][who] - found["without"][who] for who in found["with"]}
    columns = [f"{name} {kind} {who}" for name in found for kind in KINDS for who in rises]
    values = [found[name][who][:, k] for name in found for k in range(len(KINDS)) for who in rises]
    np.savetxt(options.folder / "nodule.csv", np.column_stack([x, probed, *values]), delimiter=",", comments="",
               fmt="%.9g", header=",".join(["x_m", "y_m", "z_m", "is_probed", *columns]))
    print(f"{len(x)} places, {probed.sum()} of them probed; stiffness in N/m; errors: largest and mean")
    for k, kind in enumerate(KINDS):
        top = np.nanmax(rises["dolfinx"][:, k])
        base = found["without"]["dolfinx"][:, k]
        print(f"{kind}: without the nodule {np.nanmin(base):.1f} to {np.nanmax(base):.1f}, largest rise {top:.2f}")
        for who in [who for who in rises if who != "dolfinx"]:
            off = 100 * np.abs(rises[who][:, k] - rises["dolfinx"][:, k]) / top
            for part, of in (("at points", probed), ("between them", ~probed)):
                if of.any():
                    print(f"  {who:6} rise off by {np.nanmax(off[of]):.2f}, {np.nanmean(off[of]):.2f} % of the largest "
                          f"{part}, {np.isnan(off[of]).sum()} of {of.sum()} without an answer")
    try:
        draw(x, nodule, rises, options.folder / "nodule.png")
    except ImportError:
        pass


main()
