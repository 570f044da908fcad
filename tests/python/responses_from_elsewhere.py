#!/usr/bin/env python3
"""Claim: responses of other programs and measurements become databases that every later stage takes, and what cannot be such
responses is refused in words.

Usage: responses_from_elsewhere.py SOURCES BUILD PHYNNESS

Needs h5py. The sources of examples/python/elsewhere run where ccx and python3-dolfinx are installed.
"""
import importlib.util
import json
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

SOURCES, BUILD, COMMAND = map(Path, sys.argv[1:4])
sys.path[:0] = [str(BUILD / "python"), str(SOURCES / "examples/python/elsewhere")]
try:
    import h5py
except ImportError:
    sys.exit(77)
import numpy as np  # noqa: E402
import phynness  # noqa: E402
from compare import compare  # noqa: E402

work = Path(tempfile.mkdtemp(prefix="phynness-elsewhere-"))
numbers = np.random.default_rng(4)


def command(*words):
    return subprocess.run([str(word) for word in (COMMAND, *words)], capture_output=True, text=True, cwd=work)


def run(*words):
    done = command(*words)
    if done.returncode != 0:
        raise AssertionError(f"{words} failed\n{done.stdout}{done.stderr}")
    return done.stdout


def springs(rows=120):
    """Two stiffening springs on a tetrahedron. Energy 20 |d|^2 (1 + 2000 |d|^2) + 50 d_z^2 d_x; the other nodes follow in part."""
    d = numbers.normal(size=(2 * rows, 3))
    d *= 0.012 * numbers.random((2 * rows, 1)) ** (1 / 3) / np.linalg.norm(d, axis=1)[:, None]
    square, z = (d**2).sum(axis=1), d[:, 2]
    energy = 20 * square * (1 + 2000 * square) + 50 * z**2 * d[:, 0]
    force = (40 + 160_000 * square)[:, None] * d + np.stack([50 * z**2, 0 * z, 100 * d[:, 0] * z], axis=1)
    touched = np.repeat([1, 3], rows)
    share = np.where(np.arange(1, 4)[None] == touched[:, None], 1, 0.4)
    u = (share + 20 * (share < 1) * np.linalg.norm(d, axis=1)[:, None])[:, :, None] * d[:, None]
    return {"points": np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]), "cells": [[0, 1, 2, 3]], "fixed": [0],
            "touched": touched, "displacements": d, "forces": force, "energies": energy, "output": [1, 2, 3],
            "output_displacements": u}


def write(file, data, title="two springs", **units):
    with h5py.File(file, "w") as h5:
        h5.attrs["title"] = title
        for name, values in data.items():
            h5[{"cells": "tetrahedra"}.get(name, name)] = values
        for name, unit in units.items():
            h5[name].attrs["unit"] = unit
    return file


def arrays(name, **changed):
    data = {**springs(), **changed}
    return phynness.Database.from_arrays(work / name, **{key: value for key, value in data.items() if value is not None})


class Imports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.data = springs()
        write(work / "springs.h5", cls.data, displacements="m", forces="N")
        run("import", "springs.h5", "-o", "database.h5", "--json", "import.json")

    def test_command_and_arrays_store_the_same(self):
        figures = json.loads((work / "import.json").read_text())
        self.assertEqual((figures["rows"], figures["displacements"], figures["warnings"]), (240, 240, []))
        self.assertTrue(0.3 < figures["energy_over_work"] < 0.5)
        with phynness.Database(work / "database.h5") as a, phynness.Database.from_arrays(
            work / "arrays.h5", **{**self.data, "output_displacements": self.data["output_displacements"].astype("f4")}) as b:
            self.assertEqual(a.keys(), b.keys())
            self.assertEqual(a.displacements.tobytes(), b.displacements.tobytes())
            for name in a.keys():
                self.assertEqual(np.asarray(a[name]).tobytes(), np.asarray(b[name]).tobytes(), name)
            known = np.asarray(a["status"])[1] == 0
            self.assertEqual(known.sum(), 120)
            order = np.lexsort(a.displacements[known].T)
            rows = slice(120, 240)
            wanted = np.lexsort(self.data["displacements"][rows].T)
            self.assertEqual(a.displacements[known][order].tobytes(), self.data["displacements"][rows][wanted].tobytes())
            self.assertEqual(np.asarray(a["force"])[1][known][order].tobytes(), self.data["forces"][rows][wanted].tobytes())
            self.assertEqual(a.scene.title, "two springs")

    def test_every_stage_takes_them(self):
        fresh = springs(40)
        for family in ("modal", "rbfn"):
            run("train", "database.h5", "-o", family, "--family", family)
            with phynness.Database(work / "database.h5") as database:
                trained = phynness.train(database, family=family)
            self.assertEqual(trained.text, (work / family / "model.txt").read_bytes())
            model = phynness.Model(work / family)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a little beyond the range
                for node, rows in ((1, slice(0, 40)), (3, slice(40, 80))):
                    d, f = fresh["displacements"][rows], fresh["forces"][rows]
                    u = fresh["output_displacements"][rows]
                    of = self.data["touched"] == node
                    linear = d @ np.linalg.lstsq(self.data["displacements"][of], self.data["forces"][of], rcond=None)[0]
                    size = np.linalg.norm(f, axis=1).max()
                    error = np.linalg.norm(model.force(node, d) - f, axis=1).mean() / size
                    # 120 states of a function with terms up to the third degree.
                    self.assertLess(error, 0.01)
                    self.assertGreater(np.linalg.norm(linear - f, axis=1).mean() / size, 0.04)
                    self.assertLess(np.linalg.norm(model.deform(node, d) - u, axis=2).mean() / np.abs(u).max(), 0.02)
            self.assertGreater(model.trained_depth(1, [0, 0, -1]), 0)
            self.assertLessEqual(model.trained_depth(1, [0, 0, -1]), model.max_displacement_m)
        said = run("eval", "modal", "--node", 3, "--displacement", "0,0,0.004")
        self.assertIn("N", said)
        self.assertIn("imported", run("info", "database.h5"))
        run("show", "database.h5", "--node", 3, "--direction", 3, "-o", "shown.pvd")
        page = command("view", "modal", "--database", "database.h5", "-o", "page.html")
        self.assertTrue(page.returncode == 0 or "no page" in page.stderr, page.stderr)
        # Of linear responses every family is exact to the rounding of float32.
        d, k = self.data["displacements"], np.diag([10.0, 20, 30])
        u = self.data["output_displacements"] * 0
        for i, node in enumerate((1, 2, 3)):
            u[:, i] = np.where((self.data["touched"] == node)[:, None], d, 0.25 * d)
        database = arrays("linear.h5", displacements=d, forces=d @ k, energies=None, touched=self.data["touched"], output_displacements=u)
        self.assertLess(np.abs(phynness.train(database, family="linear").stiffness(1, [0, 0, 0]) - k).max(), 1e-9)
        with phynness.Database(work / "database.h5") as database:
            self.assertRaisesRegex(phynness.Error, "not linear", phynness.train, database, family="linear")

    def test_forces_alone_are_a_model(self):
        database = arrays("forces.h5", output=[], output_displacements=None)
        for family in ("modal", "rbfn"):
            model = phynness.train(database, family=family)
            self.assertGreater(np.linalg.norm(model.force(1, [0, 0, 0.005])), 0.1)
            if family == "modal":
                self.assertRaisesRegex(phynness.Error, "no deformation", model.deform, 1, [0, 0, 0.005])
            else:
                self.assertEqual(model.deform(1, [0, 0, 0.005]).shape, (0, 3))
            run("train", "forces.h5", "-o", "forces-" + family, "--family", family)
            self.assertEqual(model.text, (work / ("forces-" + family) / "model.txt").read_bytes())
            run("eval", "forces-" + family, "--node", 1, "--displacement", "0,0,0.004")

    def test_round_tools_are_answered_as_such(self):
        data = springs()
        with arrays("tool.h5", **data, tool_radius_m=0.05) as database:
            self.assertEqual(database.scene.settings["probe.kind"], "patch")
            model = phynness.train(database, family="modal")
        some = slice(0, 120)  # the training itself, of node 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            said = model.force(1, data["displacements"][some])
        error = np.linalg.norm(said - data["forces"][some], axis=1).mean()
        self.assertLess(error, 0.01 * np.abs(data["forces"]).max())

    def test_what_needs_a_scene_refuses(self):
        scene = work / "block.toml"
        scene.write_text('[mesh]\nshape = "block"\ntarget_nodes = 100\n[material]\nlaw = "neo-hookean"\nshear_modulus_Pa = 1e3\n'
                         'poisson_ratio = 0.3\n[nodes]\nfixed = { box = { min_fraction = [0, 0, 0], max_fraction = [1, 1, 0.01] } }\n'
                         'active = { nearest = { point_fraction = [0.5, 0.5, 1] } }\n[probe]\nmax_displacement_m = 0.01\n'
                         .replace("shear_modulus_Pa = 1e3", "youngs_modulus_Pa = 1e3"))
        run("train", "database.h5", "-o", "refusing", "--modes", 2)
        for line in ("train block.toml database.h5 -o no", "solve database.h5 --node 3 --displacement 0,0,0.001",
                     "calibrate refusing database.h5 -o no", "precompute block.toml -o database.h5 --resume",
                     "validate block.toml refusing", "train block.toml -o no",
                     "import springs.h5 -o database.h5"):
            done = command(*line.split())
            self.assertEqual(done.returncode, 2, line + done.stdout + done.stderr)
            self.assertRegex(done.stderr, "(?m)^error: .+\n(  .+\n)*  remedy: .+", line)

    def test_wrong_files_are_told_in_words(self):
        def refuse(words, data, **units):
            write(work / "wrong.h5", data, **units)
            done = command("import", "wrong.h5", "-o", "no.h5")
            self.assertEqual(done.returncode, 2, words + done.stdout + done.stderr)
            self.assertIn(words, done.stderr)
            self.assertIn("\n  remedy: ", done.stderr)
            self.assertFalse((work / "no.h5").exists() or (work / "no.h5.log").exists())

        data = self.data
        without = lambda *names: {key: value for key, value in data.items() if key not in names}
        for name in ("points", "touched", "displacements", "forces"):
            refuse(f"/{name} is missing", without(name))
        refuse("has neither", without("cells"))
        refuse("has both", {**data, "triangles": [[0, 1, 2]]})
        refuse("/displacements has another unit: mm", data, displacements="mm")
        refuse("/forces has the wrong shape: 240 x 2", {**data, "forces": data["forces"][:, :2]})
        refuse("/touched has the wrong type: int16", {**data, "touched": data["touched"].astype("i2")})
        refuse("/forces has the wrong type: text", {**data, "forces": [["a", "b", "c"]] * 240})
        refuse("must hold numbers of points: -1", {**data, "touched": -1 * data["touched"]})
        refuse("belong together", without("output"))
        refuse("/output_displacements has the wrong shape", {**data, "output": [1, 2]})
        refuse("239 energies", {**data, "energies": data["energies"][1:]})
        refuse("no responses", {**data, **{key: data[key][:0] for key in
                                           ("displacements", "forces", "energies", "touched", "output_displacements")}})
        refuse("not finite: row 5", {**data, "forces": np.where(np.arange(240)[:, None] == 5, np.nan, data["forces"])})
        refuse("point against", {**data, "forces": -data["forces"]})
        refuse("implausible size", {**data, "points": 1e3 * data["points"], "displacements": 1e3 * data["displacements"]})
        with h5py.File(work / "huge.h5", "w") as h5:  # 2.4 GB that were never written
            for name, values in without("displacements", "cells").items():
                h5[name] = values
            h5["tetrahedra"] = data["cells"]
            h5.create_dataset("displacements", shape=(10**8, 3), dtype="f8", chunks=(10**6, 3))
        for name in ("huge.h5", "block.toml", "springs.h5/x", ".", "none.h5"):
            done = command("import", name, "-o", "no.h5")
            self.assertEqual(done.returncode, 2, name + done.stderr)
            self.assertIn("\n  remedy: ", done.stderr)
        whole = (work / "springs.h5").read_bytes()
        dice = random.Random(1)
        for _ in range(60):  # truncated, and with a damaged byte
            broken = bytearray(whole[: dice.randrange(len(whole))] if dice.random() < 0.3 else whole)
            if len(broken) == len(whole):
                broken[dice.randrange(4000)] ^= 1 << dice.randrange(8)
            (work / "broken.h5").write_bytes(broken)
            (work / "no.h5").unlink(missing_ok=True)
            done = command("import", "broken.h5", "-o", "no.h5")
            self.assertIn(done.returncode, (0, 2), done.stderr)

    def test_wrong_arrays_are_told_in_words(self):
        data = springs()
        for error, words, changed in (
            (phynness.Error, "too many", {"displacements": np.broadcast_to(np.zeros(3), (10**8, 3))}),
            (phynness.Error, "too many", {"displacements": np.ones((10**6 + 1, 3)), "energies": None, "output": None, "output_displacements": None}),
            (phynness.Error, "no responses", {name: data[name][:0] for name in
                                              ("displacements", "forces", "energies", "touched", "output_displacements")}),
            (TypeError, "integers", {"touched": data["touched"] + 0.5}), (ValueError, "cells", {"cells": [1, 2, 3]}),
            (ValueError, "numbers of points", {"touched": 2**40 + data["touched"]}), (ValueError, "shape", {"forces": data["energies"]}),
            (ValueError, "output_displacements", {"output": [1, 2]}), (TypeError, "integers", {"cells": "abc"}),
            (ValueError, "energies", {"energies": data["energies"][1:]}), (TypeError, "float", {"output_displacements": np.zeros((240, 3, 3), "S3")}),
        ):
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            with self.assertRaisesRegex(error, words):
                arrays("no.h5", **{**data, **changed})
            self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 2e5)  # kB; 10^8 rows have 2.4 GB
            self.assertFalse((work / "no.h5").exists())
        with self.assertWarnsRegex(UserWarning, "metres"):
            arrays("large.h5", **{**data, "points": 15 * data["points"]})

    def test_random_arguments(self):
        dice = random.Random(2)
        data = springs(8)
        junk = [None, "x", [], 0, -1, np.nan, np.zeros((0, 3)), np.zeros((4, 3)), np.full((16, 3), np.inf), np.arange(12).reshape(4, 3),
                [[2**31] * 4], np.zeros((16, 3, 3)), object(), [[]], 1e300 * np.ones((16, 3)), np.ones((16, 3), "c16")]
        refused = 0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(3000):
                (work / "any.h5").unlink(missing_ok=True)
                try:
                    arrays("any.h5", **{**data, **{dice.choice(list(data)): dice.choice(junk) for _ in range(dice.randrange(1, 3))}})
                except (TypeError, ValueError) as error:
                    refused += 1
                    self.assertTrue(str(error))
        self.assertTrue(2000 < refused < 3000, refused)


class Sources(unittest.TestCase):
    """Each model against responses of its source that it was not trained on; the table is that of docs/howto/python.md."""

    # About three times the errors of the table, because other versions of the programs and of numpy draw and solve otherwise.
    def check(self, script, most_force, least_linear, most_displacement=None):
        file = work / (script + ".h5")
        subprocess.run([sys.executable, SOURCES / f"examples/python/elsewhere/{script}.py", file], check=True, capture_output=True,
                       cwd=work)
        run("import", file, "-o", script + "-database.h5")
        found = compare(file)
        linear = found["linear", "force"].mean()
        self.assertGreater(linear, least_linear)
        self.assertLess(found["modal", "force"].mean(), most_force)
        self.assertLess(found["rbfn", "force"].mean(), 0.5 * linear)
        if most_displacement is not None:
            self.assertLess(found["modal", "displacement"].mean(), most_displacement)
            self.assertGreater(found["linear", "displacement"].mean(), 2 * most_displacement)

    def test_measurements(self):
        self.check("measurements", 0.03, 0.05)  # noise of 1 % in each component has a mean size of 1.6 %

    @unittest.skipUnless(shutil.which("ccx"), "CalculiX is not installed")
    def test_calculix(self):
        self.check("calculix", 0.006, 0.02, 0.0035)

    @unittest.skipUnless(importlib.util.find_spec("dolfinx"), "python3-dolfinx is not installed")
    def test_law_of_fibres(self):
        self.check("law_of_fibres", 0.004, 0.03, 0.003)


try:
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
finally:
    shutil.rmtree(work)
