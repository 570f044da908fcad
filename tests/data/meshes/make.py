"""Makes own/ and broken/ from built-in shapes: /usr/bin/python3 make.py PHYNNESS (the command, build/release/phynness).

Needs meshio (Debian: python3-meshio). Another version of gmsh makes other meshes; the tests are valid for the files of the
repository.
"""
import os
import struct
import subprocess
import sys
import tempfile

import meshio
import numpy

here = os.path.dirname(os.path.abspath(__file__))


def built_in(phynness, mesh_keys):
    """Nodes in m, triangles of the boundary pointing outward and tetrahedra, of a built-in shape."""
    with tempfile.TemporaryDirectory() as folder:
        scene, mesh = os.path.join(folder, "scene.toml"), os.path.join(folder, "body.msh")
        with open(scene, "w") as out:
            out.write(f"[mesh]\n{mesh_keys}\n[material]\nlaw = \"neo-hookean\"\nc10_Pa = 250.0\nbulk_modulus_Pa = 1e4\n"
                      "[nodes]\nfixed = { box = { min_fraction = [0,0,0], max_fraction = [0.3,1,1] } }\n"
                      "active = [{ nearest = { point_fraction = [0.9,0.5,1] }, surface_only = true }]\n"
                      "[probe]\nmax_displacement_m = 0.001\n")
        subprocess.run([phynness, "mesh", scene, "-o", mesh], check=True, capture_output=True)
        body = meshio.read(mesh)
    return list(body.points), *([tuple(map(int, cell)) for cell in body.get_cells_type(kind)] for kind in ("triangle", "tetra"))


def surface_only(nodes, triangles):
    used = sorted({i for t in triangles for i in t})
    number = {i: k for k, i in enumerate(used)}
    return [nodes[i] for i in used], [tuple(number[i] for i in t) for t in triangles]


def write_msh_1(name, scale, nodes, tetrahedra, triangles=(), lines=()):
    elements = [(1, line) for line in lines] + [(2, t) for t in triangles] + [(4, t) for t in tetrahedra]
    with open(os.path.join(here, name), "w") as out:
        out.write(f"$NOD\n{len(nodes)}\n")
        for i, x in enumerate(nodes):
            out.write(f"{i + 1} " + " ".join(f"{c / scale:.6g}" for c in x) + "\n")
        out.write(f"$ENDNOD\n$ELM\n{len(elements)}\n")
        for i, (kind, element) in enumerate(elements):
            out.write(f"{i + 1} {kind} 1 1 {len(element)} " + " ".join(str(n + 1) for n in element) + "\n")
        out.write("$ENDELM\n")


def write_obj(name, scale, nodes, triangles):
    with open(os.path.join(here, name), "w") as out:
        out.write("# Centimetres.\nmtllib liver.mtl\ng default\n")
        for x in nodes:
            out.write("v " + " ".join(f"{c / scale:.5f}" for c in x) + "\n")
        out.write("vt 0 0\nvn 0 0 1\ns 1\ng liver\nusemtl tissue\n")
        for t in triangles:
            out.write("f " + " ".join(f"{n + 1}/1/1" for n in t) + "\n")


def write_stl(name, scale, nodes, triangles):
    with open(os.path.join(here, name), "wb") as out:
        out.write(b"binary STL in millimetres".ljust(80) + struct.pack("<I", len(triangles)))
        for t in triangles:
            out.write(struct.pack("<12fH", 0, 0, 0, *[c / scale for n in t for c in nodes[n]], 0))


def write_vtk(name, scale, nodes, triangles=(), tetrahedra=()):
    cells = triangles or tetrahedra
    size = 1 + len(cells[0])
    with open(os.path.join(here, name), "wb") as out:
        out.write(b"# vtk DataFile Version 3.0\nmillimetres\nBINARY\n")
        out.write(b"DATASET POLYDATA\n" if triangles else b"DATASET UNSTRUCTURED_GRID\n")
        out.write(b"POINTS %d float\n" % len(nodes))
        out.write(b"".join(struct.pack(">3f", *[c / scale for c in x]) for x in nodes) + b"\n")
        out.write((b"POLYGONS" if triangles else b"CELLS") + b" %d %d\n" % (len(cells), size * len(cells)))
        out.write(b"".join(struct.pack(f">{size}i", size - 1, *cell) for cell in cells) + b"\n")
        if tetrahedra:
            out.write(b"CELL_TYPES %d\n" % len(cells) + struct.pack(">i", 10) * len(cells) + b"\n")


def tetrahedron(nodes, corners):
    """Four triangles of a closed tetrahedron, pointing outward."""
    a, b, c, d = corners
    x = [nodes[i] for i in corners]
    if numpy.linalg.det([x[1] - x[0], x[2] - x[0], x[3] - x[0]]) < 0:
        b, c = c, b
    return [(a, c, b), (a, b, d), (b, c, d), (a, d, c)]


def unit(x):
    return x / (x * x).sum() ** 0.5


def outward(nodes, triangle):
    a, b, c = (nodes[i] for i in triangle)
    return unit(numpy.cross(b - a, c - a))


def apart(triangles, count):
    """Triangles of which no two share a node."""
    chosen, taken = [], set()
    for t in triangles:
        if not taken.intersection(t):
            chosen.append(t)
            taken.update(i for other in triangles if taken.intersection(other) or set(t).intersection(other)
                         for i in other if set(t).intersection(other))
        if len(chosen) == count:
            return chosen
    raise RuntimeError("too few triangles")


def with_small_bodies(nodes, triangles, count):
    """The surface and `count` small tetrahedra beside it."""
    nodes, triangles = list(nodes), list(triangles)
    start = max(x[0] for x in nodes) + 0.01
    for k in range(count):
        first = len(nodes)
        origin = numpy.array([start + 0.01 * k, 0.0, 0.0])
        nodes += [origin, *(origin + 0.005 * numpy.eye(3))]
        triangles += tetrahedron(nodes, range(first, first + 4))
    return nodes, triangles


def non_manifold(nodes, triangles):
    """Eight tetrahedra share one edge each with the surface, a ninth one node."""
    nodes, triangles = list(nodes), list(triangles)
    for k, t in enumerate(apart(triangles, 9)):
        n = outward(nodes, t)
        a, b = nodes[t[0]], nodes[t[1]]
        above, sideways = a + 0.5 * (b - a) + 0.004 * n, 0.001 * unit(numpy.cross(n, b - a))
        first = len(nodes)
        nodes += [above + sideways, above - sideways]
        corners = [t[0], t[1], first, first + 1]
        if k == 8:
            nodes.append(a + 0.004 * n + 3 * sideways)
            corners = [t[0], first, first + 1, first + 2]
        triangles += tetrahedron(nodes, corners)
    return nodes, triangles


def with_slivers(nodes, tetrahedra):
    """Inner nodes of a few tetrahedra moved almost into the opposite face."""
    boundary = {}
    for cell in tetrahedra:
        for k in range(4):
            face = tuple(sorted(cell[:k] + cell[k + 1:]))
            boundary[face] = boundary.get(face, 0) + 1
    outer = {i for face, n in boundary.items() if n == 1 for i in face}
    nodes, moved = list(nodes), set()

    def volume(cell):
        a, b, c, d = (nodes[i] for i in cell)
        return numpy.linalg.det([b - a, c - a, d - a])

    for cell in tetrahedra:
        inner = [i for i in cell if i not in outer]
        if len(inner) != 1 or moved.intersection(cell) or len(moved) == 6:
            continue
        i = inner[0]
        centre, old = sum(nodes[j] for j in cell if j != i) / 3, nodes[i]
        nodes[i] = centre + 0.03 * (old - centre)
        if min(volume(other) for other in tetrahedra if i in other) <= 0:
            nodes[i] = old
        else:
            moved.add(i)
    if not moved:
        raise RuntimeError("no sliver could be made")
    return nodes


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    phynness = os.path.abspath(sys.argv[1])
    coarse = built_in(phynness, 'shape = "liver"\ntarget_nodes = 180')
    write_msh_1("own/liver_coarse.msh", 0.025, coarse[0], coarse[2])
    fine = built_in(phynness, 'shape = "liver"\ntarget_nodes = 500')
    edges = sorted({tuple(sorted((t[k], t[k - 1]))) for t in fine[1] for k in range(3)})[:40]
    write_msh_1("own/liver_elements.msh", 0.1, fine[0], fine[2], fine[1], edges)
    cylinder = built_in(phynness, 'shape = "cylinder"\ntarget_nodes = 500')
    write_msh_1("own/cylinder.msh", 0.1, cylinder[0], cylinder[2])
    surface = surface_only(*built_in(phynness, 'shape = "liver"\ntarget_nodes = 4000')[:2])
    write_obj("own/liver_surface.obj", 0.01, *surface)

    nodes, triangles = surface_only(*fine[:2])
    write_stl("broken/non_manifold_liver.stl", 0.001, *non_manifold(nodes, triangles))
    several = with_small_bodies(nodes, triangles, 3)
    write_vtk("broken/inward_normals_four_components.vtk", 0.001, several[0], [t[::-1] for t in several[1]])
    write_vtk("broken/sliver_liver.vtk", 0.001, with_slivers(fine[0], fine[2]), tetrahedra=fine[2])


main()
