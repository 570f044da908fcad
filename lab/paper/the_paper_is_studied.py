#!/usr/bin/python3
"""Claim: the study runs every case whose scene exists and writes a page and a JSON file with every table and figure. The
numbers agree with those of eval and solve. An interrupted study is resumed. Results do not depend on the number of ranks, and a
folder of another scene is refused. Blocks of some dozen nodes are used instead of the paper's bodies.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
SCENE = """title = "small block"
[mesh]
shape = "block"
size_m = [0.1, 0.08, 0.05]
target_size_m = 0.025
[material]
law = "neo-hookean"
youngs_modulus_Pa = 2000.0
poisson_ratio = 0.45
[solver]
element = "P1"
[nodes]
fixed = { plane = { point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = 1e-6 } }
active = [{ nearest = { point_fraction = [0.3, 0.4, 1.0] }, surface_only = true }, { nearest = { point_fraction = [0.7, 0.6, 1.0] }, surface_only = true }]
[probe]
directions = 26
increments = 2
max_displacement_m = 0.008
[training]
family = "rbfn"
deformation_neurons = 40
force_neurons = 20
force_spread = 2.0
samples = 500
"""
SIZES = {"nodes": 2, "probes_per_node": 3, "neurons": [5, 20, 100, 200, 300], "histogram_neurons": [5, 10, 20], "spreads": [0.75, 1.5],
         "samples": [100, 300], "force_neurons": [5, 10, 20], "curve_neurons": [5, 10, 20], "study_neurons": 20, "training_pairs": 400,
         "test_pairs": 200, "curve_points": 4, "tool_pairs": 2}


def study(*words):
    return subprocess.run([sys.executable, HERE / "study.py", *words], capture_output=True, text=True)


def small(*words):
    return study("--scenes", "scenes", "--sizes", "sizes.json", "-o", "out", *words)


def phynness(*words):
    subprocess.run([os.environ["PHYNNESS"], *map(str, words)], check=True, capture_output=True)
    return json.loads(pathlib.Path("answer.json").read_text()) if "answer.json" in words else None


def field(file):
    table = np.genfromtxt(file, delimiter=",", names=True)
    return table["node"], np.stack([table[k] for k in ("ux", "uy", "uz")], 1)


def expect_no_null(value, where):
    """NaN and infinity become null in JSON."""
    assert value is not None, where
    for key, entry in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        expect_no_null(entry, f"{where}/{key}")


def expect_numbers(report):
    assert len(report["tables"]["1"]) == 18 and len(report["tables"]["2"]) == 5 and report["tables"]["2"][1][1] == "596"
    assert all(row[column] not in ("not run", "-") for row in report["tables"]["1"][1:] for column in (2, 4)), report["tables"]["1"]
    for number in ("6", "7", "8", "9", "10", "11", "12", "14", "15", "P1 and p1-p1"):
        figure = report["figures"][number]
        assert figure["panels"] and all(len(figure[w]) > 10 for w in ("title", "conditions", "paper", "found")), number
        assert all(len(s["x"]) == len(s["y"]) >= 2 for p in figure["panels"] for s in p["series"]), number
        expect_no_null(figure, number)
    assert len(report["figures"]["13"]["table"]) == 5
    for name in ("1", "3", "3-p1-p1", "4"):
        expect_no_null(report["cases"][name]["measured"], name)
        assert len(report["cases"][name]["measured"]["nodes"]) == 2
    assert report["cases"]["2"]["not_run"] == "there is no scenes/liver_case2.toml" and not report["quick"]


def expect_curve(report):
    """The top of the block is flat, so that its inward normal is -z. The forces of the curve are those of a single solve and of
    the model, up to the solver's tolerance of 1e-8 of the force and rounding."""
    node = report["cases"]["3"]["measured"]["nodes"][1]
    curves, depth = node["curves"], node["curves"]["depth_m"][2]
    assert abs(depth - 0.75 * 0.008 * 4 / 2.8) < 1e-12
    tool = ("--node", node["node"], "--displacement", f"0,0,{-depth!r}", "--json", "answer.json")
    solved = -phynness("solve", "out/case-3/database.h5", *tool)["tools"][0]["force"][2]
    said = -phynness("eval", "out/case-3/ours", *tool)["tools"][0]["force"][2]
    assert solved > 0 and abs(curves["finite_elements"][2] - solved) < 1e-6 * solved
    assert abs(curves["ours"][2] - said) < 1e-9 * solved
    linear = depth * node["stiffness_N_per_m"]
    assert abs(curves["linear"][2] - linear) < 1e-12 * linear


def expect_pair(report):
    """A pair of tools by eval with the paper's weights and by a solve with both nodes prescribed. Tolerance 1e-6: the solver's
    tolerance and a file with nine digits."""
    pair = report["cases"]["3"]["measured"]["pairs"][0]
    assert len(pair["depths"]) == 2
    solved, said = [], []
    for depth in pair["depths"]:
        tools = [w for node, way in (("a", "first"), ("b", "second"))
                 for w in ("--node", pair[node], "--displacement", ",".join(repr(depth["depth_m"] * x) for x in pair[way]))]
        phynness("solve", "out/case-3/database.h5", *tools, "--deformation", "s.csv")
        phynness("eval", "out/case-3/networks", "--tools", "paper", *tools, "--deformation", "e.csv")
        nodes, u = field("s.csv")
        kept = ~np.isin(nodes, (pair["a"], pair["b"]))
        solved.append(u[kept])
        said.append(field("e.csv")[1][kept])
    largest = max(np.linalg.norm(u, axis=1).max() for u in solved)
    assert len(solved[0]) > 10
    for depth, u, v in zip(pair["depths"], solved, said):
        mean = np.linalg.norm(u - v, axis=1).mean() / largest
        assert abs(depth["paper_mean"] - mean) < 1e-6 * mean, (depth["paper_mean"], mean)


def expect_page():
    page = pathlib.Path("out/paper.html").read_text()
    for part in ["Table 1", "Table 2", *(f"Figure {n}:" for n in range(6, 16)), "P1 and p1-p1",
                 "not run: there is no scenes/liver_case2.toml", "Errata"]:
        assert part in page, part
    assert "Quick study" not in page and page.count('<svg class="chart"') >= 20
    assert not re.search(r"(src|href)=[\"'](?!#)", page) and not re.search(r"[ >(,-](nan|inf)[ <),]", page)


def main():
    linear = SCENE.replace('"neo-hookean"', '"linear"').replace("directions = 26", "directions = 3").replace("increments = 2", "increments = 1")
    os.mkdir("scenes")
    for name, text in {"liver_case1": linear, "liver_case3": SCENE, "penrose_case4": SCENE}.items():
        pathlib.Path(f"scenes/{name}.toml").write_text(text)
    pathlib.Path("sizes.json").write_text(json.dumps(SIZES))
    read = lambda: json.loads(pathlib.Path("out/paper.json").read_text())

    first = small("--ranks", "1")
    assert first.returncode == 0, first.stderr + first.stdout
    report = read()
    expect_numbers(report)
    expect_curve(report)
    expect_pair(report)
    expect_page()

    # After the measurements of two cases were lost, those of the selected case are repeated on two ranks and are the same.
    for name in ("3", "4"):
        os.remove(f"out/case-{name}/measured.json")
    again = small("--ranks", "2", "--cases", "3")
    assert again.returncode == 0, again.stderr
    assert "precompute" not in again.stdout and ": measure" in again.stdout, again.stdout
    cases = read()["cases"]
    assert cases["1"]["measured"] == report["cases"]["1"]["measured"], "finished cases remain on the page"
    assert cases["4"]["not_run"] == "not asked for (--cases)"
    both = [report["cases"]["3"]["measured"], cases["3"]["measured"]]
    for measured in both:
        del measured["seconds"]
        for node in measured["nodes"]:
            del node["training_cpu_s"]
    assert both[0] == both[1]

    pathlib.Path("scenes/liver_case3.toml").write_text(SCENE.replace("2000.0", "2100.0"))
    # An empty value, such as an unset variable of a shell, does not select all cases.
    for words, part in ((("--cases", "3"), "another scene"), (("--cases", "3,7"), "no such case: 7"), (("--cases", ""), "no such case"),
                        (("-o", "/proc/nowhere"), "can be written"), (("--scenes", "nowhere"), "nowhere")):
        refused = small(*words)
        assert refused.returncode == 2 and part in refused.stderr, (words, refused.stderr)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    main()
