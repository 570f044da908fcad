"""The cube of 10 cm of docs/extremes.md and docs/robustness.md, held at its bottom, with five elements along an edge: so
small that every element and every ratio of moduli can be tried."""

import pathlib

import numpy as np
from commands import read_msh, run, surface_faces, write_msh

ELEMENTS = ("P1", "P2", "p1-p1", "taylor-hood")
EDGE_M = 0.1
H_M = EDGE_M / 5  # size of an element
TOP = (EDGE_M / 2, EDGE_M / 2, EDGE_M)  # middle of the top
AT_TOP = "{ nearest = { point_fraction = [0.5, 0.5, 1.0] } }"


def material(law, bulk_to_shear, shear_Pa):
    bulk = f"bulk_modulus_Pa = {bulk_to_shear * shear_Pa!r}"
    if law != "mooney-rivlin":
        return f'law = "{law}"\nshear_modulus_Pa = {shear_Pa!r}\n{bulk}'
    c01 = shear_Pa / 22  # the ratio of the Penrose drain
    return f'law = "{law}"\nc10_Pa = {shear_Pa / 2 - c01!r}\nc01_Pa = {c01!r}\n{bulk}'


def scene(element, bulk_to_shear, law="neo-hookean", edge_m=EDGE_M, shear_Pa=500.0, size_m=None, mesh=None, active=AT_TOP,
          radius_m=2 * H_M, depth_m=H_M, increments=3, directions=26, tolerance=None):
    """Text of a scene. radius_m: of a patch; 0: node probes. mesh: a file instead of the built-in shape."""
    body = f'file = "{mesh}"' if mesh else f'shape = "block"\nsize_m = [{edge_m}, {edge_m}, {edge_m}]\ntarget_size_m = {size_m or edge_m / 5}'
    fixed = '{ group = "phynness_fixed" }' if mesh else \
        f"{{ plane = {{ point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = {1e-6 * edge_m} }} }}"
    tool = f'kind = "patch"\ntool_radius_m = {radius_m}' if radius_m else 'kind = "node"'
    return (f'[mesh]\n{body}\n[material]\n{material(law, bulk_to_shear, shear_Pa)}\n[solver]\nelement = "{element}"\n'
            + (f"relative_tolerance = {tolerance}\n" if tolerance else "")
            + f"[nodes]\nfixed = {fixed}\nactive = {active}\n[probe]\n{tool}\ndirections = {directions}\nincrements = {increments}\n"
            f"max_displacement_m = {depth_m}\n")


def write(folder, *arguments, name="scene.toml", **options):
    path = pathlib.Path(folder) / name
    path.write_text(scene(*arguments, **options))
    return path


def meshed(folder):
    """Nodes, cells and fixed nodes of the cube."""
    msh = pathlib.Path(folder) / "cube.msh"
    run("mesh", write(folder, "P1", 200), "-o", msh)
    return read_msh(msh)


def drawn(folder, n, seed=1):
    """Random nodes of the free surface, as a selection."""
    x, cells, fixed = meshed(folder)
    free = np.setdiff1d(surface_faces(cells), fixed)
    nodes = np.sort(np.random.default_rng(seed).choice(free, n, replace=False))
    return "{ nodes = [" + ", ".join(map(str, nodes)) + "] }"


def quality(x):
    """Radius ratio of tetrahedra, n x 4 x 3: 3 r / R."""
    a, b, c = (x[..., k, :] - x[..., 0, :] for k in (1, 2, 3))
    volume = np.einsum("...i,...i", np.cross(a, b), c) / 6
    areas = sum(np.linalg.norm(np.cross(p, q), axis=-1) for p, q in ((a, b), (b, c), (c, a), (b - a, c - a))) / 2
    la, lb, lc = (np.linalg.norm(p, axis=-1) * np.linalg.norm(q, axis=-1) for p, q in ((a, c - b), (b, c - a), (c, b - a)))
    area = np.sqrt(np.maximum((la + lb + lc) * (la + lb - lc) * (la - lb + lc) * (-la + lb + lc), 1e-300))
    return 216 * volume * np.abs(volume) / (areas * area)  # r = 3 V / areas, R = area / (24 V)


def with_slivers(folder, worst, n=5):
    """A file of the cube in which up to n cells without common nodes have the quality `worst`: one inner corner of each was
    moved towards the opposite face. No other cell is worse."""
    x, cells, fixed = meshed(folder)
    taken, made = set(surface_faces(cells).ravel()), 0
    for cell in cells:
        for corner in cell:
            if made == n or corner in taken:
                continue
            a, b, c = x[[k for k in cell if k != corner]]
            normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
            around, start = cells[(cells == corner).any(1)], x[corner].copy()
            low, high = 0.0, 1.0
            for _ in range(60):
                x[corner] = start - (low + high) / 2 * ((start - a) @ normal) * normal
                low, high = ((low + high) / 2, high) if quality(x[around]).min() > worst else (low, (low + high) / 2)
            x[corner] = start - low * ((start - a) @ normal) * normal
            if (around[quality(x[around]).argmin()] == cell).all():
                taken.update(around.ravel())
                made += 1
                break
            x[corner] = start  # another cell became flat first
    path = pathlib.Path(folder) / f"slivers-{worst:g}.msh"
    write_msh(path, x, cells, fixed)
    return path
