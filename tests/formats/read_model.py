"""Reader and evaluator of model.txt written from formats/model.md alone, standard library only.

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
        self.lines = iter(lines)

    def fields(self, keyword=None):
        fields = next(self.lines).split(" ")
        if keyword is not None and fields.pop(0) != keyword:
            sys.exit("expected " + keyword)
        return fields

    def count(self, keyword):
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


def read_model(data):
    reader = Reader(checked_lines(data))
    if reader.fields("phynness-model") != ["1"]:
        sys.exit("another version")
    family = reader.fields("family")[0]
    if family not in ("rbfn", "linear"):
        sys.exit("another family")
    for key in ("title", "software", "mesh_hash", "physics_hash", "max_displacement_m", "mesh_nodes"):
        reader.fields(key)
    directions = [reader.floats() for _ in range(reader.count("directions"))]
    displacements = [reader.floats() for _ in range(reader.count("displacements"))]
    for _ in range(reader.count("fixed")):
        reader.fields()
    output = [reader.fields() for _ in range(reader.count("output"))]
    points = [[float.fromhex(f) for f in fields[1:]] for fields in output]
    model = {"output": [int(fields[0]) for fields in output], "points": points, "nodes": {}}
    for _ in range(reader.count("active")):
        node = {}
        number = reader.count("node")
        node["point"] = reader.floats("point")
        prescribed = [reader.fields() for _ in range(reader.count("prescribed"))]
        node["prescribed"] = {int(i): float.fromhex(w) for i, w in prescribed}
        reader.count("incomplete")
        reader.fields("trained_depth")
        node["trained_depth"] = [reader.floats()[0] for _ in directions]
        if family == "linear":
            read_linear(reader, node, len(points))
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


def force(node, d):
    if "stiffness" in node:
        return [sum(k * v for k, v in zip(row, d)) for row in node["stiffness"]]
    return evaluate(node["force"], d)


def displacement(node, position, point, d):
    if "stiffness" in node:
        unit = node["unit_responses"][position]
        return [sum(unit[3 * axis + k] * d[axis] for axis in range(3)) for k in range(3)]
    return evaluate(node["deformation"], d + point)


def main():
    with open(sys.argv[1], "rb") as file:
        model = read_model(file.read())
    for line in sys.stdin:
        number, *d = line.split()
        node, d = model["nodes"][int(number)], [float.fromhex(v) for v in d]
        answer = force(node, d)
        for position, (index, point) in enumerate(zip(model["output"], model["points"])):
            if index in node["prescribed"]:
                answer += [node["prescribed"][index] * v for v in d]
            else:
                answer += displacement(node, position, point, d)
        print(*(v.hex() for v in answer))


main()
