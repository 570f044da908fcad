"""Reader and evaluator of model.txt written from formats/model.md alone, standard library only: a model without the
optional sections, its forces and deformations.

Usage: read_model.py model.txt < queries
One query a line: node dx dy dz (hexadecimal floats as in model.txt).
One answer a line: the force, then the displacements of all output nodes, as hexadecimal floats.
"""
import math
import sys


def checked_lines(data):
    body, last = data[: data.rstrip(b"\n").rfind(b"\n") + 1], data.rstrip(b"\n").split(b"\n")[-1]
    state = 0xCBF29CE484222325
    for byte in body:
        state = ((state ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    if last != b"checksum %016x" % state:
        sys.exit("checksum differs")
    return body.decode("utf-8").split("\n")


class Reader:
    def __init__(self, lines):
        self.lines, self.at = lines, 0

    def next_is(self, keyword):
        return self.lines[self.at].split(" ")[0] == keyword

    def fields(self, keyword=None):
        fields = self.lines[self.at].split(" ")
        self.at += 1
        if keyword is not None and fields.pop(0) != keyword:
            sys.exit("expected " + keyword)
        return fields

    def count(self, keyword=None):
        return int(self.fields(keyword)[0])

    def floats(self, keyword=None):
        return [float.fromhex(f) for f in self.fields(keyword)]


def read_network(reader, keyword, tables):
    net = {}
    n = reader.count(keyword)
    for key in ("input_center", "input_half_range", "output_center", "output_half_range", "spread", "bias"):
        net[key] = reader.floats(key)
    net["neurons"] = []
    for _ in range(n):
        fields = reader.fields()
        indices, weights = fields[:-3], [float.fromhex(f) for f in fields[-3:]]
        values = [v for table, i in zip(tables, indices) for v in table[int(i)]]
        center = [(v - c) / h for v, c, h in zip(values, net["input_center"], net["input_half_range"])]
        net["neurons"].append((center, weights))
    return net


def read_linear(reader, node, n_output):
    xx, xy, xz, yy, yz, zz = reader.floats("stiffness")
    node["stiffness"] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    reader.fields("unit_responses")
    node["unit_responses"] = [reader.floats() for _ in range(n_output)]


def read_table(reader, keyword, n_rows):
    scale = reader.floats(keyword)
    rows = [reader.fields() for _ in range(n_rows)] if scale else [[]] * n_rows
    return [[s * int(v) for s, v in zip(scale, row)] for row in rows]


def read_shared(reader, model):
    n_modes = reader.count("shared_modes")
    model["modes"] = read_table(reader, "modes", 3 * len(model["points"]))
    n_centers = reader.count("amplitude_centers")
    model["shape"] = reader.floats("shape")[0]
    model["centers"] = [model["displacements"][reader.count()] for _ in range(n_centers)]
    model["n_shared"] = n_modes


def read_modal(reader, model, node):
    n = reader.count("force")
    node["shape"] = reader.floats("shape")[0]
    xx, xy, xz, yy, yz, zz = reader.floats("stiffness")
    node["stiffness"] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    node["centers"] = []
    for _ in range(n):
        row, *b = reader.fields()
        node["centers"].append((model["displacements"][int(row)], [float.fromhex(v) for v in b]))
    reader.count("deformation")
    node["weights"] = read_table(reader, "weights", len(model["centers"]) + 3)
    node["mixing"] = read_table(reader, "mixing", model["n_shared"])
    node["near"] = [reader.count() for _ in range(reader.count("near"))]
    node["near_modes"] = read_table(reader, "near_modes", 3 * len(node["near"]))


def read_model(data):
    reader = Reader(checked_lines(data))
    if reader.fields("phynness-model") != ["4"]:
        sys.exit("another version")
    family = reader.fields("family")[0]
    if family not in ("rbfn", "linear", "modal"):
        sys.exit("another family")
    for key in ("title", "software", "mesh_hash", "physics_hash"):
        reader.fields(key)
    largest = reader.floats("max_displacement_m")[0]
    reader.fields("mesh_nodes")
    directions = [reader.floats() for _ in range(reader.count("directions"))]
    displacements = [reader.floats() for _ in range(reader.count("displacements"))]
    for _ in range(reader.count("fixed")):
        reader.fields()
    output = [reader.fields() for _ in range(reader.count("output"))]
    points = [[float.fromhex(f) for f in fields[1:]] for fields in output]
    for _ in range(reader.count("surface")):
        reader.fields()
    model = {"family": family, "output": [int(fields[0]) for fields in output], "points": points, "nodes": {}}
    if family == "modal":
        model["largest"] = largest
        model["displacements"] = [[v / largest for v in row] for row in displacements]
        read_shared(reader, model)
    for key in ("solved", "finer"):  # no answer depends on them
        if reader.next_is(key):
            reader.fields(key)
    for _ in range(reader.count("active")):
        node = {}
        number = reader.count("node")
        node["point"] = reader.floats("point")
        node["mean"] = reader.next_is("mean")
        if node["mean"]:
            reader.fields("mean")
        prescribed = [reader.fields() for _ in range(reader.count("prescribed"))]
        node["prescribed"] = {int(i): float.fromhex(w) for i, w in prescribed}
        reader.count("incomplete")
        reader.fields("trained_depth")
        for _ in directions:
            reader.floats()
        if family == "linear":
            read_linear(reader, node, len(points))
        elif family == "modal":
            read_modal(reader, model, node)
        else:
            node["force"] = read_network(reader, "force", [displacements])
            node["deformation"] = read_network(reader, "deformation", [displacements, points])
        model["nodes"][number] = node
    return model


def evaluate(net, inputs):
    x = [(v - c) / h for v, c, h in zip(inputs, net["input_center"], net["input_half_range"])]
    y = list(net["bias"])
    for center, weights in net["neurons"]:
        square = math.fsum((a - b) ** 2 for a, b in zip(x, center))
        h = math.exp(-square / net["spread"][0] ** 2)
        y = [s + w * h for s, w in zip(y, weights)]
    return [c + h * s for c, h, s in zip(net["output_center"], net["output_half_range"], y)]


def dot(a, b):
    return math.fsum(u * v for u, v in zip(a, b))


def apply(matrix, vector):
    return [dot(row, vector) for row in matrix]


def minus(a, b):
    return [u - v for u, v in zip(a, b)]


def q(y, s):
    return math.sqrt(dot(y, y) + s * s)


def phi(y, s):
    return [[q(y, s) * (i == j) + y[i] * y[j] / q(y, s) for j in range(3)] for i in range(3)]


def modal_force(model, node, d):
    s, x, zero, total = node["shape"], [v / model["largest"] for v in d], [0, 0, 0], apply(node["stiffness"], d)
    for c, b in node["centers"]:
        terms = [apply(phi(y, s), b) for y in (minus(x, c), x, c, zero)]
        total = [t + p - q - r + u for t, p, q, r, u in zip(total, *terms)]
    return total


def force(model, node, d):
    if model["family"] == "modal":
        return modal_force(model, node, d)
    if model["family"] == "linear":
        return apply(node["stiffness"], d)
    return evaluate(node["force"], d)


def modal_displacements(model, node, d):
    s, x, zero = model["shape"], [v / model["largest"] for v in d], [0, 0, 0]
    basis = [q(minus(x, c), s) - q(x, s) - q(c, s) + q(zero, s) for c in model["centers"]] + x
    a = [dot(column, basis) for column in zip(*node["weights"])]
    all_nodes = apply(model["modes"], apply(node["mixing"], a))
    near = apply(node["near_modes"], a)
    u = [all_nodes[3 * o : 3 * o + 3] for o in range(len(model["points"]))]
    for i, position in enumerate(node["near"]):
        u[position] = near[3 * i : 3 * i + 3]
    return u


def displacements(model, node, d):
    if model["family"] == "modal":
        return modal_displacements(model, node, d)
    if model["family"] == "linear":
        return [[sum(unit[3 * axis + k] * d[axis] for axis in range(3)) for k in range(3)]
                for unit in node["unit_responses"]]
    return [evaluate(node["deformation"], d + point) for point in model["points"]]


def main():
    with open(sys.argv[1], "rb") as file:
        model = read_model(file.read())
    for line in sys.stdin:
        number, *d = line.split()
        node, d = model["nodes"][int(number)], [float.fromhex(v) for v in d]
        answer = force(model, node, d)
        for index, u in zip(model["output"], displacements(model, node, d)):
            if index in node["prescribed"] and not node["mean"]:
                u = [node["prescribed"][index] * v for v in d]
            answer += u
        print(*(v.hex() for v in answer))


main()
