"""Makes own/ and broken/ from built-in shapes: python3 make.py PHYNNESS (the command, build/release/phynness).

Another version of gmsh makes other meshes; the tests are valid for the files of the repository.
"""
import os
import struct
import subprocess
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))


def built_in(phynness, mesh_keys):
    """Nodes in m, triangles of the boundary pointing outward and tetrahedra, of a built-in shape."""
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.toml")
        with open(scene, "w") as out:
            out.write(f"[mesh]\n{mesh_keys}\n[material]\nlaw = \"neo-hookean\"\nc10_Pa = 250.0\nbulk_modulus_Pa = 1e4\n"
                      "[nodes]\nfixed = { box = { min_fraction = [0,0,0], max_fraction = [0.3,1,1] } }\n"
                      "active = [{ nearest = { point_fraction = [0.9,0.5,1] }, surface_only = true }]\n"
                      "[probe]\nmax_displacement_m = 0.001\n")
        subprocess.run([phynness, "mesh", scene, "-o", os.path.join(folder, "body.msh")], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(os.path.join(folder, "body.msh")) as text:
            lines = text.read().split("\n")
    nodes, triangles, tetrahedra = [], [], []
    i = lines.index("$Nodes") + 2
    while lines[i] != "$EndNodes":
        n = int(lines[i].split()[3])
        nodes += [tuple(map(float, row.split())) for row in lines[i + 1 + n:i + 1 + 2 * n]]
        i += 1 + 2 * n
    i = lines.index("$Elements") + 2
    while lines[i] != "$EndElements":
        _, _, kind, n = map(int, lines[i].split())
        rows = [tuple(int(word) - 1 for word in row.split()[1:]) for row in lines[i + 1:i + 1 + n]]
        if kind == 2:
            triangles += rows
        if kind == 4:
            tetrahedra += rows
        i += 1 + n
    return nodes, triangles, tetrahedra


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


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def plus(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def tetrahedron(nodes, corners):
    """Four triangles of a closed tetrahedron, pointing outward."""
    a, b, c, d = corners
    x = [nodes[i] for i in corners]
    if dot(cross(minus(x[1], x[0]), minus(x[2], x[0])), minus(x[3], x[0])) < 0:
        b, c = c, b
    return [(a, c, b), (a, b, d), (b, c, d), (a, d, c)]


def outward(nodes, triangle):
    a, b, c = (nodes[i] for i in triangle)
    n = cross(minus(b, a), minus(c, a))
    size = dot(n, n) ** 0.5
    return tuple(x / size for x in n)


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
        origin = (start + 0.01 * k, 0.0, 0.0)
        nodes += [origin] + [plus(origin, e, 0.005) for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        triangles += tetrahedron(nodes, range(first, first + 4))
    return nodes, triangles


def non_manifold(nodes, triangles):
    """Eight tetrahedra share one edge each with the surface, a ninth one node."""
    nodes, triangles = list(nodes), list(triangles)
    for k, t in enumerate(apart(triangles, 9)):
        n = outward(nodes, t)
        a, b = nodes[t[0]], nodes[t[1]]
        middle = plus(a, minus(b, a), 0.5)
        sideways = tuple(0.003 * x for x in cross(n, minus(b, a)))
        length = dot(sideways, sideways) ** 0.5
        sideways = tuple(0.001 * x / length for x in sideways)
        first = len(nodes)
        nodes += [plus(plus(middle, n, 0.004), sideways), plus(plus(middle, n, 0.004), sideways, -1.0)]
        corners = [t[0], t[1], first, first + 1]
        if k == 8:
            nodes.append(plus(plus(a, n, 0.004), sideways, 3.0))
            corners = [t[0], first, first + 1, first + 2]
        triangles += tetrahedron(nodes, corners)
    return nodes, triangles


def opened(triangles):
    """Nine holes of one triangle and one of two: 31 open edges."""
    holes = apart(triangles, 10)
    last = holes[-1]
    neighbour = next(t for t in triangles if t != last and len(set(t).intersection(last)) == 2)
    return [t for t in triangles if t not in holes and t != neighbour]


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
        return dot(cross(minus(b, a), minus(c, a)), minus(d, a))

    for cell in tetrahedra:
        inner = [i for i in cell if i not in outer]
        if len(inner) != 1 or moved.intersection(cell) or len(moved) == 6:
            continue
        i = inner[0]
        face = [nodes[j] for j in cell if j != i]
        centre = tuple(sum(x) / 3 for x in zip(*face))
        old = nodes[i]
        nodes[i] = plus(centre, minus(old, centre), 0.03)
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
    scattered = with_small_bodies(nodes, triangles, 15)
    write_stl("broken/open_liver.stl", 0.001, scattered[0], opened(triangles) + scattered[1][len(triangles):])
    write_vtk("broken/sliver_liver.vtk", 0.001, with_slivers(fine[0], fine[2]), tetrahedra=fine[2])


main()
