#!/usr/bin/python3
"""Reproduces the paper: runs its cases, and writes a page (paper.html) and a JSON file (paper.json) with its tables and figures
and the numbers of the paper: docs/paper.md. It takes about an hour; --quick: coarse meshes, some minutes.

Usage: lab/study paper [--quick] [-o DIR] [--cases 1,2,3,3-p1-p1,4] [--scenes DIR] [--ranks N]
DIR: default out/paper or out/paper-quick; finished stages there are kept.
"""

import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import time

import h5py
import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from commands import PHYNNESS, SOURCE, changed, run, text  # noqa: E402
from report import report as paper_report  # noqa: E402

PROGRAM = os.environ.get("PHYNNESS_PAPER_STUDY", str(SOURCE / "build/release/lab/phynness_paper_study"))
CASES = [  # liver: a column of Table 1; element: instead of the scene's
    {"id": "1", "title": "Case 1: liver, linear", "scene": "liver_case1.toml", "linear": True},
    {"id": "2", "title": "Case 2: liver, St. Venant-Kirchhoff", "scene": "liver_case2.toml"},
    {"id": "3", "title": "Case 3: liver, neo-Hookean", "scene": "liver_case3.toml", "two_tools": True},
    {"id": "3-p1-p1", "title": "Case 3 without locking (p1-p1)", "scene": "liver_case3.toml", "element": "p1-p1", "two_tools": True},
    {"id": "4", "title": "Case 4: Penrose drain, Mooney-Rivlin", "scene": "penrose_case4.toml", "liver": False},
]
CASES = [{"linear": False, "two_tools": False, "liver": True, "element": "", **case} for case in CASES]
SIZES = {"nodes": 10, "probes_per_node": 20}  # the others are the defaults of StudySizes
QUICK = {
    "nodes": 5, "probes_per_node": 8, "neurons": [20, 50, 100, 200, 300], "spreads": [0.375, 0.5, 0.75, 1.0, 1.5],
    "samples": [500, 1000, 2000, 4000, 6000], "force_neurons": [10, 20, 30, 40, 50, 60, 70, 80, 90], "test_pairs": 1000,
    "tool_pairs": 12,
}
QUICK_NODES, QUICK_DRAIN_NODES, QUICK_INCREMENTS = 150, 70, 4


class Refused(Exception):
    """Ends the study with a message and status 2."""


class Case:
    """A case in its folder. A stage is kept if its key, of all that it depends on, is that of the last run."""

    def __init__(self, options, of):
        self.of, self.ranks, self.sizes = of, options.ranks, options.sizes
        self.source, self.folder = options.scenes / of["scene"], options.output / ("case-" + of["id"])
        self.journal = self.folder / "stages.json"
        values = {("solver", "element"): f'"{of["element"]}"'} if of["element"] else {}
        if options.quick:
            values["mesh", "target_nodes"] = QUICK_NODES if of["liver"] else QUICK_DRAIN_NODES
            if not of["linear"]:
                values["probe", "increments"] = QUICK_INCREMENTS
        self.text = changed(self.source.read_text(), values) if self.source.exists() else None

    def at(self, name):
        return self.folder / name

    def done(self):
        return json.loads(self.journal.read_text()) if self.journal.exists() else {}

    def key(self, *more):
        return hashlib.sha256("".join([self.text, *map(str, more)]).encode()).hexdigest()[:16]

    def settings(self):
        return {"sizes": self.sizes, "two_tools": self.of["two_tools"]}

    def is_finished(self):
        return self.text is not None and self.at("measured.json").exists() and self.done().get("measure") == self.key(self.settings())

    def stage(self, name, key, result, words, ranks=1):
        if self.done().get(name) == key and self.at(result).exists():
            return
        print(f"\n== {self.of['title']}: {name}", flush=True)
        launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        if subprocess.run(launch + [str(w) for w in words]).returncode != 0:
            raise SystemExit(f"{name} of {self.of['title']} failed; finished stages are kept in {self.folder}")
        self.journal.write_text(json.dumps({**self.done(), name: key}, indent=1))

    def command(self, name, result, *words, ranks=1, key=""):
        record = self.at(name + ".json")
        self.stage(name, self.key(key), result, [PHYNNESS, *words, "--json", record], ranks)

    def run(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        scene, database = self.at("scene.toml"), self.at("database.h5")
        if scene.exists() and scene.read_text() != self.text:  # its results may have taken an hour
            raise Refused(f"the folder holds a study of another scene: {self.folder}; remove it, or give another folder with -o")
        scene.write_text(self.text)
        self.command("mesh", "mesh.msh", "mesh", scene, "-o", self.at("mesh.msh"))
        resumed = ["--resume"] if database.exists() else []
        self.command("precompute", "database.h5", "precompute", scene, "-o", database, *resumed, ranks=self.ranks)
        probes = 2 * self.sizes["nodes"] * self.sizes["probes_per_node"]
        families = {"ours": "linear"} if self.of["linear"] else {"networks": "rbfn", "ours": "modal"}
        for model, family in families.items():
            self.command(f"train-{model}", f"{model}/model.txt", "train", scene, database, "-o", self.at(model), "--family", family)
            self.command(f"validate-{model}", f"validate-{model}.json", "validate", scene, self.at(model), "--probes", probes,
                         ranks=self.ranks, key=probes)
        self.at("study.json").write_text(json.dumps(self.settings()))
        self.stage("measure", self.key(self.settings()), "measured.json", [PROGRAM, "measure", self.folder], self.ranks)

    def facts(self):
        def record(name, key):
            file = self.at(name + ".json")
            return json.loads(file.read_text()).get(key, 0) if file.exists() else 0

        with h5py.File(self.at("database.h5")) as f:
            status = f["responses/status"]
            names = dict(zip(status.attrs["flag_values"].tolist(), text(status.attrs["flag_meanings"]).split()))
            counts = {names[int(s)]: int(n) for s, n in zip(*np.unique(status[()], return_counts=True))}
            rays = (status[()][..., 0] != next(s for s, n in names.items() if n == "not_requested")).sum()
            facts = {"nodes": len(f["mesh/nodes"]), "free_nodes": len(f["sets/active"]), "cells": len(f["mesh/cells"]),
                     "corners": f["mesh/cells"].shape[1], "surface_nodes": len(np.unique(f["mesh/surface"][()])), "rays": int(rays),
                     "solve_cpu_s": float(f["responses/seconds"][()].sum())}
        solved = {n: k for n, k in counts.items() if n not in ("not_requested", "after_end")}
        return {**facts, "increments": sum(solved.values()), "failed": sum(solved.values()) - solved.get("converged", 0),
                "setup_s": record("precompute", "setup_seconds"), "networks_train_s": record("train-networks", "seconds"),
                "ours_train_s": record("train-ours", "seconds"), "database_bytes": self.at("database.h5").stat().st_size,
                "model_bytes": record("train-networks", "model_bytes"), "ours_bytes": record("train-ours", "model_bytes"),
                "networks": record("train-networks", "networks")}  # fmt: skip


def report(of, folder):
    for entry in of["cases"]:
        if entry["missing"]:
            continue
        case = folder / ("case-" + entry["of"]["id"])
        subprocess.run([PROGRAM, "time", case], check=True)
        read = lambda name: json.loads((case / name).read_text()) if (case / name).exists() else None
        entry.update(read("times.json"), measured=read("measured.json"), networks_errors=read("validate-networks.json"),
                     ours_errors=read("validate-ours.json"))
        entry["facts"]["samples"] = entry.pop("samples")
    data, sections = paper_report(of)
    (folder / "paper.json").write_text(json.dumps(data, indent=1) + "\n")
    (folder / "blocks.json").write_text(json.dumps({"title": "The paper's tables and figures, from our runs", "sections": sections}))
    subprocess.run([PROGRAM, "page", folder / "blocks.json", folder / "paper.html"], check=True)
    for row in data["summary"]:
        print(" | ".join([row[0].ljust(62), *row[1:]]))


def machine():
    model = [line.split(": ", 1)[1] for line in open("/proc/cpuinfo") if line.startswith("model name")]
    return f"{(model or ['unknown processor'])[0].strip()}, {os.cpu_count()} cores"


def chosen(words):
    known = [case["id"] for case in CASES]
    asked = known if words is None else [w.strip() for w in words.split(",")]
    for word in asked:
        if word not in known:
            raise Refused(f"the study has no such case: {word or 'an empty word'}; give with --cases some of {', '.join(known)}")
    return asked


def study(options):
    begun, asked = time.time(), chosen(options.cases)
    if not options.scenes.is_dir():
        raise Refused(f"the folder of scenes does not exist: {options.scenes}; give that of liver_case1.toml ... with --scenes")
    try:
        options.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refused(f"cannot make the output folder: {error}; give -o a folder that can be written") from error
    if not os.environ.get("PHYNNESS_PAPER_STUDY"):
        subprocess.run([SOURCE / "tools/build", "lab", "phynness_paper_study", "phynness_cli"], stdout=sys.stderr, check=True)
    entries = []
    for of in CASES:
        case, missing = Case(options, of), ""
        if case.text is None:
            missing = f"there is no scenes/{of['scene']}"
        elif of["id"] in asked:
            case.run()
        elif not case.is_finished():  # a case that was finished before is part of the page
            missing = "not asked for (--cases)"
        entries.append({"of": of, "missing": missing} if missing else {"of": of, "missing": "", "facts": case.facts()})
    words = f"meshes of about {QUICK_NODES} nodes (drain: {QUICK_DRAIN_NODES}), {QUICK_INCREMENTS} increments, and " + \
        ", ".join(f"{k} = {v}" for k, v in QUICK.items())  # fmt: skip
    file = options.output / "study.json"
    file.write_text(json.dumps({"less_than_full": words if options.quick else "", "software": run("--version").strip(),
                                "machine": machine(), "seconds": time.time() - begun, "cases": entries}))  # fmt: skip
    print("\n== times and report", flush=True)
    report(json.loads(file.read_text()), options.output)
    print(f"{time.time() - begun:.0f} s -> {options.output / 'paper.html'}, {options.output / 'paper.json'}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="coarser meshes and fewer points")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="folder, in which an interrupted study is resumed")
    parser.add_argument("--cases", help="some of 1,2,3,3-p1-p1,4 (default: all)")
    parser.add_argument("--scenes", type=pathlib.Path, default=SOURCE / "scenes", help="folder with the scenes of the cases")
    parser.add_argument("--ranks", type=int, default=2, help="processes of the finite element stages (mpirun)")
    parser.add_argument("--sizes", type=pathlib.Path, help=argparse.SUPPRESS)  # JSON with other numbers of measurements
    options = parser.parse_args()
    options.output = options.output or SOURCE / ("out/paper-quick" if options.quick else "out/paper")
    options.sizes = {**SIZES, **(QUICK if options.quick else {}), **(json.loads(options.sizes.read_text()) if options.sizes else {})}
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    try:
        study(options)
    except Refused as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
