#!/usr/bin/env python3
"""Claim: the Python package gives what the command gives, in every layout and any thread, and answers bad input in words.

Usage: answers_as_the_command.py SOURCES BUILD PHYNNESS WRITE_DATABASE WRITE_MODELS

Results are compared bit for bit; the JSON of the command has all digits.
"""
import base64
import copy
import gzip
import json
import os
import pickle
import random
import re
import shutil
import signal
import threading
import time
import unittest
import warnings
from pathlib import Path

from built import COMMAND, MODEL, OTHERS, SOURCES, main, run, work  # before phynness, whose place it adds to the path

import h5py
import numpy as np
import phynness

WRITE_DATABASE, WRITE_MODELS = OTHERS
NODE = 95
model = phynness.Model(MODEL)
# Triangles that can be touched.
inner = [t for t in model.triangles if max(t) < len(model.output_nodes) and np.isin(model.output_nodes[t], model.active_nodes).all()]
numbers = np.random.default_rng(1)
directions = numbers.normal(size=(500, 3))
d = 0.01 * directions / np.linalg.norm(directions, axis=1)[:, None] * numbers.random((500, 1))


def without_times(figures):
    """The figures without those that differ from run to run."""
    if isinstance(figures, dict):
        return {name: without_times(value) for name, value in figures.items() if not any(part in name for part in ("seconds", "_us", "_ms"))}
    return [without_times(value) for value in figures] if isinstance(figures, list) else figures


def with_training(scene, lines):
    """The text of a scene with these lines as its section [training]."""
    return re.sub(r"(?ms)^\[training\].*?(?=^\[|\Z)", "", scene) + "\n[training]\n" + lines


class Models(unittest.TestCase):
    def same(self, a, b):
        self.assertEqual(np.asarray(a).tobytes(), np.asarray(b).tobytes())

    @unittest.skipUnless(COMMAND.exists(), "the command is not built")
    def test_the_command_prints_the_same(self):
        out = work / "eval.json"
        run(COMMAND, "eval", MODEL, "--node", NODE, "--displacement", "0.002,0.001,-0.01", "--json", out)
        said, x = json.loads(out.read_text()), [0.002, 0.001, -0.01]
        self.same(said["tools"][0]["force"], model.force(NODE, x))
        for name, now in (("energy", model.energy), ("bound_N", model.bound)):
            self.assertEqual(said[name], now(NODE, x))

    @unittest.skipUnless(COMMAND.exists(), "the command is not built")
    def test_the_provenance_is_that_of_info(self):
        run(WRITE_MODELS, work / "models")
        for folder, element in ((work / "models/rbfn", "p1-p1"), (MODEL, "")):
            run(COMMAND, "info", folder, "--json", work / "info.json")
            said = json.loads((work / "info.json").read_text())["provenance"]
            now = phynness.Model(folder).provenance
            self.assertEqual(now["element"], element)
            self.assertEqual({name: value or None for name, value in now.items()}, said)

    def test_every_layout_has_the_bits_of_single_calls(self):
        one = np.array([model.force(NODE, x) for x in d])
        whole = np.zeros((500, 7))
        whole[:, 1:7:2] = d
        packed = np.frombuffer(b"x" + d.tobytes(), np.uint8)[1:].view(np.float64).reshape(-1, 3)  # not aligned
        for layout in (d, np.asfortranarray(d), whole[:, 1:7:2], d[::-1][::-1], packed, d.astype(">f8"), d.tolist()):
            self.same(model.force(NODE, layout), one)
        self.same(model.force(NODE, d[::-3]), one[::-3])
        self.same(model.force(NODE, d.astype(np.float32)), model.force(NODE, d.astype(np.float32).astype(float)))
        self.same(model.force(np.int64(NODE), [[0, 0, 0]]), np.zeros((1, 3)))
        self.assertEqual(model.force(NODE, np.zeros((0, 3))).shape, (0, 3))

    def test_what_is_asked_for_together_is_as_alone(self):
        force, energy, stiffness = model.response(NODE, d)
        self.same(force, model.force(NODE, d))
        self.same(energy, model.energy(NODE, d))
        self.same(stiffness, model.stiffness(NODE, d))
        self.same(stiffness[7], model.stiffness(NODE, d[7]))
        self.assertIsInstance(model.energy(NODE, d[0]), float)
        # A difference of 1e-6 m has an error of 1e-12 times the third derivative, below 1e-5 N here.
        for k in range(3):
            step = 1e-6 * np.eye(3)[k]
            slope = (model.energy(NODE, d[:50] + step) - model.energy(NODE, d[:50] - step)) / 2e-6
            self.assertLess(np.abs(slope - force[:50, k]).max(), 1e-5)
        self.same(model.deform(NODE, d[:3])[2], model.deform(NODE, d[2]))
        point = phynness.SurfacePoint([NODE], [1.0])
        self.same(model.force(point, d), model.force(NODE, d))
        self.same(model.deform(point, d[0]), model.deform(NODE, d[0]))
        corner = inner[0][0]
        point = model.nearest(model.output_points[corner])
        self.assertLess(np.abs(point.position - model.output_points[corner]).max(), 1e-15)  # rounding, of points of 0.1 m
        self.assertLess(abs(point.distance), 1e-15)
        self.assertEqual(point.nodes[int(np.argmax(point.weights))], model.output_nodes[corner])

    def test_places_are_one_or_many(self):
        nodes = model.active_nodes[:5]
        for answers in (model.force, model.energy, model.stiffness, model.deform, model.bound, model.trained_depth):
            each = [answers(int(n), x) for n, x in zip(nodes, d)]
            for places in (nodes, nodes.tolist(), tuple(nodes), [phynness.SurfacePoint([n], [1.0]) for n in nodes]):
                self.same(answers(places, d[:5]), each)
            self.same(answers(nodes, d[0]), [answers(int(n), d[0]) for n in nodes])
        above = np.array([model.output_points[t].mean(axis=0) for t in inner[:4]]) + 1e-5
        points = model.nearest(above)
        for one, x in zip(points, above):
            alone = model.nearest(x)
            self.assertEqual((one.nodes, one.weights, one.distance), (alone.nodes, alone.weights, alone.distance))
            self.assertLess(abs(np.linalg.norm(x - one.position) - abs(one.distance)), 1e-15)  # rounding, of 0.1 m
        self.same(model.force(points, d[:4]), [model.force(point, x) for point, x in zip(points, d)])
        self.assertEqual(model.force([], np.zeros((0, 3))).shape, (0, 3))
        self.assertRaisesRegex(ValueError, "5 places, but 3", model.force, nodes, d[:3])
        with self.assertRaisesRegex(phynness.Error, "node -1") as caught:
            model.force([NODE, -1], d[:2])
        self.assertEqual(caught.exception.status, -2)

    def test_a_batch_answers_each_tool_alone(self):
        organ = phynness.Organ(model)
        x = np.array([model.output_points[t].mean(axis=0) for t in inner[:300]]) + 1e-5
        x = np.tile(x, (10, 1))  # enough for two threads
        moved = np.resize(d, x.shape)
        places = organ.nearest_batch(x)
        points = model.nearest(x)
        for row, point in zip(places, points):
            self.assertEqual(tuple(row["nodes"][:len(point.nodes)]), point.nodes)
            self.assertEqual(row["distance"], point.distance)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            alone = model.force(points, moved)
        forces, status = organ.hold_batch(places, moved)
        self.same(forces, alone)
        self.assertEqual(status.shape, (len(x),))
        self.assertTrue((status >= 0).all())
        self.same(organ.hold_batch(points, moved)[0], alone)
        self.same(organ.hold_batch(places[::-1], moved[::-1])[0], alone[::-1])
        self.same(organ.hold_batch(np.full(len(x), NODE), moved)[0], model.force(NODE, moved))
        x[7] = np.nan
        places[::2], moved[4] = organ.nearest_batch(x[::2]), np.inf
        lost = organ.nearest_batch(x[7:8])
        self.assertEqual((lost["status"][0], tuple(lost["nodes"][0])), (-3, (-1, -1, -1)))
        places[7] = lost[0]
        forces, status = organ.hold_batch(places, moved)
        self.assertTrue(status[4] == -3 and status[7] < 0 and not forces[[4, 7]].any())
        rest = [i for i in range(len(x)) if i not in (4, 7)]
        self.same(forces[rest], alone[rest])
        self.assertEqual(organ.hold_batch([], np.zeros((0, 3)))[0].shape, (0, 3))
        self.assertRaisesRegex(ValueError, "places, but 3", organ.hold_batch, places, d[:3])
        self.assertRaisesRegex(ValueError, r"\(n, 3\)", organ.hold_batch, places, d[0])
        self.assertRaisesRegex(TypeError, "nearest_batch", organ.hold_batch, np.zeros(3, [("a", int)]), d[:3])
        # A child that fork made has no threads of its parent.
        child = os.fork()
        if child == 0:
            os._exit(0 if np.array_equal(organ.hold_batch(points, np.resize(d, x.shape))[0], alone) else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)

    def test_copies_and_pickles_answer_the_same(self):
        organ = phynness.Organ(model, max_tools=2)
        point = model.nearest([0, 0, 0.1])
        for made in (copy.copy, copy.deepcopy, *(
                lambda given, p=p: pickle.loads(pickle.dumps(given, p)) for p in range(pickle.HIGHEST_PROTOCOL + 1))):
            self.same(made(model).response(NODE, d)[2], model.response(NODE, d)[2])
            self.assertEqual((made(model).text, made(model).mesh_text), (model.text, model.mesh_text))
            self.same(made(organ).hold([NODE, point], d[:2]).forces, organ.hold([NODE, point], d[:2]).forces)
            again = made(point)
            self.assertEqual((again.nodes, again.weights, again.distance), (point.nodes, point.weights, point.distance))
            self.same(again.position, point.position)
        held, touched = organ.hold(NODE, d[0]), organ.touch([0, 0, 1], 0.005)
        for given in (model, organ, point, held, touched):
            bare = type(given).__new__(type(given))
            for name in dir(type(given)):
                if isinstance(getattr(type(given), name), property):
                    self.assertRaisesRegex(TypeError, "call its class", getattr, bare, name)
            self.assertRaisesRegex(TypeError, "call its class", bare.__reduce__)
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                if given in (held, touched):
                    self.assertRaisesRegex(TypeError, "not pickled", pickle.dumps, given, protocol)

    def test_names_are_those_of_the_package(self):
        self.assertEqual(dir(phynness), sorted(phynness.__all__))
        self.assertEqual(dir(phynness._phynness), sorted({name for name in phynness.__all__ if hasattr(phynness._phynness, name)}))
        self.assertEqual(dir(phynness.command), sorted(phynness.command.__all__))
        self.assertEqual(set(dir(phynness)), set(dir(phynness._phynness)) | set(dir(phynness.command)) - {"save"})

    def test_levels_and_bounds(self):
        self.assertEqual(len(model.levels), 1)
        self.same(model.force(NODE, d, level=0), model.force(NODE, d))
        bound = model.bound(NODE, [[0, 0, -0.01], [0, 0, -1]])
        self.assertTrue(0 < bound[0] < 0.1 and np.isinf(bound[1]))
        self.assertTrue(0 < model.trained_depth(NODE, [0, 0, -1]) <= model.max_displacement_m)

    def test_several_tools(self):
        organ = phynness.Organ(MODEL, max_tools=2)
        self.same(organ.deform(), np.zeros_like(model.output_points))
        pair = organ.hold([NODE, organ.nearest([0, 0, 0.1])], [[0, 0, -0.01], [0, 0, 0.002]])
        self.assertEqual((pair.forces.shape, organ.deform().shape), ((2, 3), (len(model.output_nodes), 3)))
        self.assertLess(pair.residual, 1e-12)  # rounding, of displacements of 0.01 m
        self.assertRaisesRegex(phynness.Error, "bound", organ.bound)  # a model has none of coupled tools
        one = organ.hold(NODE, d[0])
        self.same(one.forces, model.force(NODE, d[0]))
        self.assertEqual(one.energy, model.energy(NODE, d[0]))
        numbers = [*one.forces, one.energy]
        said = re.fullmatch(r"Held\(forces=\[ *(\S+), +(\S+), +(\S+)\] N, energy=(\S+) J, status=0\)", repr(one))
        np.testing.assert_allclose([float(word) for word in said.groups()], numbers, rtol=5e-4)  # four digits
        self.assertRegex(repr(pair), r"^Held\(forces=\[\[.*\], \[.*\]\] N, energy=")
        self.same(organ.deform(), model.deform(NODE, d[0]))
        self.same(organ.bound(), [model.bound(NODE, d[0])])
        self.same(organ.points, model.output_points)

    def test_spheres_touch(self):
        organ = phynness.Organ(model)
        place = organ.nearest(model.output_points[list(model.output_nodes).index(NODE)])
        outward = organ.touch(place.position + [0, 0, 1], 0.005)
        self.assertFalse(outward.in_contact[0] or outward.forces.any())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", phynness.OutsideWarning)
            for depth in np.linspace(0.02, -0.009, 30):
                touched = organ.touch([place.position + [0, 0, depth]], 0.005)
        self.assertTrue(touched.in_contact[0] and touched.forces[0, 2] < 0 and touched.energy > 0)
        self.assertRegex(repr(touched), r"^Touched\(forces=\[\[.*\]\] N, in_contact=\[ ?True\], energy=.* J, status=\d\)$")
        self.assertLess(organ.deform()[:, 2].min(), -0.003)
        organ.reset()
        self.same(organ.deform(), np.zeros_like(model.output_points))
        self.assertRaisesRegex(ValueError, "mode", organ.touch, [0, 0, 0], 0.005, mode="x")

    def test_statuses_are_warnings_and_errors(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            model.force(NODE, [[0, 0, -1], [0, 0, 0], [0, 0, 1]])
        self.assertEqual([(w.category, w.message.count, w.message.status) for w in caught], [(phynness.OutsideWarning, 2, 1)])
        self.assertEqual(caught[0].filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertRaises(phynness.OutsideWarning, model.force, NODE, [0, 0, -1])
        for status, node, x in ((-2, -1, [0, 0, 0]), (-2, 2**40, [0, 0, 0]), (-3, NODE, [[0, 0, 0], [0, np.nan, 0]])):
            with self.assertRaises(phynness.Error) as caught_error:
                model.force(node, x)
            self.assertEqual(caught_error.exception.status, status)
        self.assertIn("row 1", str(caught_error.exception))

    def test_bad_arguments_are_told_in_words(self):
        for wrong in ([1, 2], np.zeros((3, 2)), np.zeros((1, 1, 3)), 0.0, []):
            self.assertRaisesRegex(ValueError, "shape", model.force, NODE, wrong)
        for wrong in ("abc", [1j, 0, 0], [None] * 3, np.zeros(3, "M8[s]"), [[1, 2, 3], [1]], object()):
            self.assertRaises((TypeError, ValueError), model.force, NODE, wrong)
        for node in (1.5, "95", None, [1.5], [[95]], b"95"):
            self.assertRaises(TypeError, model.force, node, [0, 0, 0])
        self.assertRaisesRegex(phynness.Error, "levels 0 to 0", model.force, NODE, [0, 0, 0], level=5)
        self.assertRaisesRegex(phynness.Error, "no field", model.field, NODE, [0, 0, 0], "x")
        organ = phynness.Organ(model, max_tools=2)
        self.assertRaisesRegex(ValueError, "1 places, but 2", organ.hold, [NODE], d[:2])
        self.assertRaises(phynness.Error, organ.hold, [NODE] * 9, np.zeros((9, 3)))
        self.assertRaises(phynness.Error, organ.hold, model.active_nodes[:3], np.zeros((3, 3)))
        self.assertRaises(phynness.Error, phynness.Organ, None)
        for keys in ({"max_tools": 0}, {"steps": 0}):
            self.assertRaises(ValueError, phynness.Organ, model, **keys)
        self.assertRaises(ValueError, organ.hold, [NODE], d[:1], increments=-1)
        self.assertRaises(ValueError, phynness.SurfacePoint, [1, 2], [1.0])
        with self.assertRaises(ValueError):
            model.triangles[0, 0] = 1

    def test_texts_and_files(self):
        text = (MODEL / "model.txt").read_bytes()
        copied_from = work / "copied"
        shutil.copytree(MODEL, copied_from)
        copied = phynness.Model(copied_from)
        shutil.rmtree(copied_from)
        for other in (copied, phynness.Model(text), phynness.Model(str(MODEL / "model.txt"))):
            self.same(other.force(NODE, d), model.force(NODE, d))
        copied.save(work / "saved")
        for name in ("model.txt", "mesh.txt"):
            self.assertEqual((work / "saved" / name).read_bytes(), (MODEL / name).read_bytes())
        self.assertRaisesRegex(phynness.Error, "No such file", phynness.Model, copied_from)
        with self.assertRaisesRegex(phynness.Error, "checksum.*line") as caught:
            phynness.Model(text.replace(b"title Demo", b"title demo"))
        self.assertEqual(caught.exception.status, -12)
        points = copied.output_points
        kept = points.copy()
        del copied, other
        self.same(points, kept)  # a view keeps its model

    def test_other_families(self):
        run(WRITE_MODELS, work / "families")
        network = phynness.Model(work / "families/rbfn")
        node = network.active_nodes[0]
        self.assertRaises(phynness.Error, network.energy, node, [0, 0, 0])
        linear = phynness.Model(work / "families/linear")
        x = [0.001, -0.002, 0.003]
        force, energy, stiffness = linear.response(node, x)
        self.assertLess(abs(force @ x / 2 - energy), 1e-12 * energy)  # rounding
        self.assertRaises(phynness.Error, linear.bound, node, x)

    def test_threads_and_forks(self):
        nodes = [int(n) for n in model.active_nodes[:8]]
        alone = [model.response(n, d[:200]) + (model.deform(n, d),) for n in nodes]
        failures = []

        def ask(k):
            for _ in range(10):
                now = model.response(nodes[k], d[:200]) + (model.deform(nodes[k], d),)
                if any(a.tobytes() != b.tobytes() for a, b in zip(now, alone[k])):
                    failures.append(k)

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            threads = [threading.Thread(target=ask, args=[k]) for k in range(8)]
            for thread in threads:
                thread.start()
            child = os.fork()
            if child == 0:
                os._exit(0 if (model.force(nodes[0], d[:200]) == alone[0][0]).all() else 1)
            for thread in threads:
                thread.join()
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.assertEqual(failures, [])

    def test_random_calls(self):
        """100,000 calls with any arguments end with a result or an exception in words."""
        dice = random.Random(1)
        point = model.nearest([0, 0, 0])
        organ = phynness.Organ(model, max_tools=3)
        places = [NODE, int(model.active_nodes[0]), 0, -1, 2**31, 2**70, 1.5, None, point, phynness.SurfacePoint([95, 96], [2, -1]),
                  phynness.SurfacePoint([7], [float("nan")]), "x"]
        vectors = [[0, 0, 0], d[0], d[:7], d[:4, :2], d.T[:, :3], np.nan * d[0], np.inf * d[:2], 1e308 * d[:3], [], "x", None,
                   np.zeros((0, 3)), np.zeros((3, 3), "c16"), d[:8].astype("f4")[::-2], np.zeros(3, object), d[0] * 0 - 1e-320]
        levels = [None, None, None, 0, -1, 7, 2**40, "x"]
        functions = [model.force, model.energy, model.stiffness, model.response, model.deform, model.bound,
                     model.trained_depth, model.field, model.nearest, organ.hold, phynness.SurfacePoint]
        refused = 0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(100_000):
                function = dice.choice(functions)
                arguments = [dice.choice(places), dice.choice(vectors)]
                if function == model.field:
                    arguments.append(dice.choice(["x", ""]))
                elif function == model.nearest:
                    arguments = [dice.choice(vectors)]
                elif function == organ.hold:
                    arguments[0] = dice.choices(places, k=dice.randrange(4))
                keys = {"level": dice.choice(levels)} if dice.random() < 0.2 else {}
                try:
                    result = function(*arguments, **keys)
                    if isinstance(result, np.ndarray) and function != model.bound:
                        assert np.isfinite(result).all()
                except (TypeError, ValueError) as error:
                    refused += 1
                    assert str(error)
        self.assertTrue(20_000 < refused < 95_000, refused)


class Training(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.environ["PHYNNESS_COMMAND"] = str(COMMAND)
        cls.file = work / "database.h5"
        run(WRITE_DATABASE, cls.file)

    @unittest.skipUnless(COMMAND.exists(), "the command is not built")
    def test_training_is_that_of_the_command(self):
        database, scene = self.file, work / "small.toml"
        with h5py.File(self.file) as opened:
            text = opened["scene"][()].decode()
        self.assertRaisesRegex(phynness.Error, "does not exist", phynness.train, work / "none.h5")
        for family, keys in (("modal", {"modes": 2, "shared_modes": 4}),
                             ("rbfn", {"deformation_neurons": 9, "force_neurons": np.int64(5)})):
            lines = "".join(f"{key} = {value}\n" for key, value in keys.items())
            scene.write_text(with_training(text, lines))
            run(COMMAND, "train", scene, self.file, "-o", work / family, "--family", family)
            trained = phynness.train(database, family=family, **keys)
            trained.save(work / (family + "-saved"))
            for name in ("model.txt", "mesh.txt"):
                self.assertEqual((work / (family + "-saved") / name).read_bytes(), (work / family / name).read_bytes())
            self.assertEqual(trained.training["networks"], 3)
        self.assertRaisesRegex(phynness.Error, "family", phynness.train, database, family="x")
        self.assertRaisesRegex(phynness.Error, "linear law", phynness.train, database, family="linear")
        self.assertRaisesRegex(phynness.Error, "modes", phynness.train, database, modes=-1)
        self.assertRaisesRegex(phynness.Error, "depth", phynness.train, database, depth=1)
        self.assertRaises(phynness.Error, phynness.train, database, modes=None)

        def stop(*_):
            raise KeyboardInterrupt

        # A signal of the timer, as Ctrl-C would be.
        before = signal.signal(signal.SIGALRM, stop)
        signal.setitimer(signal.ITIMER_REAL, 1e-3)
        with self.assertRaises(KeyboardInterrupt):
            while True:
                phynness.train(database, family="rbfn", force_neurons=5)
        signal.signal(signal.SIGALRM, before)


SMALL = """title = "A small block"
[mesh]
shape = "block"
target_nodes = 56
[material]
law = "neo-hookean"
c10_Pa = 250.0
bulk_modulus_Pa = 5e3
[nodes]
fixed = { plane = { point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = 1e-6 } }
active = { count = 2 }
[probe]
kind = "node"
max_displacement_m = 0.008
increments = 2
directions = 26
[validation]
probes = 4
"""


@unittest.skipUnless(COMMAND.exists() and " solve " in run(COMMAND, "--help"), "the command has no solver")
class Solves(unittest.TestCase):
    """What is solved from Python is what the command solves."""

    @classmethod
    def setUpClass(cls):
        os.environ["PHYNNESS_COMMAND"] = str(COMMAND)
        cls.scene = work / "block.toml"
        cls.scene.write_text(SMALL)
        cls.database = work / "block.h5"
        phynness.precompute(cls.scene, cls.database)

    def test_a_database_is_that_of_the_command(self):
        run(COMMAND, "precompute", self.scene, "-o", work / "command.h5")
        phynness.precompute(self.scene, self.database, resume=True, ranks=2)
        with h5py.File(self.database) as ours, h5py.File(work / "command.h5") as other:
            for name in other["responses"]:
                if name != "seconds":
                    self.assertEqual(ours["responses"][name][()].tobytes(), other["responses"][name][()].tobytes(), name)

    def test_solves_are_the_rays(self):
        with h5py.File(self.database) as file:
            node = int(file["sets/active"][1])
            d, force = file["magnitudes"][()][:, None] * file["directions"][3], file["responses/force"][1, 3]
        solved = phynness.solve(self.database, node, np.vstack([d, [[0, 0, -0.2]]]))
        self.assertEqual((list(solved.status[:2]), len(solved.note)), ([0, 0], 3))
        self.assertNotEqual(solved.status[2], 0)
        self.assertTrue(np.isnan(solved.force[2]).all() and solved.note[2])
        # Rays go on from the increment before; the solver's tolerance is 1e-8.
        self.assertLess(np.abs(solved.force[:2] - force).max(), 1e-6 * np.abs(force).max())

    def test_validation_and_page(self):
        model = phynness.train(self.database, modes=2)
        model.save(work / "block-model")
        run(COMMAND, "validate", self.scene, work / "block-model", "--seed", 3, "--json", work / "block.json")
        self.assertEqual(json.dumps(without_times(phynness.validate(self.scene, model, seed=3))),
                         json.dumps(without_times(json.loads((work / "block.json").read_text()))))
        page = model.show(work / "block.html", database=self.database, errors=work / "block.json")
        self.assertIn("srcdoc=", page._repr_html_())
        data = re.search(rb'id="phynness-data">([^<]*)', page.path.read_bytes()).group(1)
        self.assertIn(b"A small block", gzip.decompress(base64.b64decode(data)))

    def test_a_body_answers_as_the_command(self):
        scene = work / "free.toml"
        scene.write_text(SMALL.replace("[probe]", 'output = "free"\n[probe]').replace("= 56", "= 140"))
        phynness.precompute(scene, work / "free.h5")
        run(COMMAND, "train", work / "free.h5", "-o", work / "free")
        file = work / "body.txt"
        run(COMMAND, "reduce", work / "free.h5", "-o", file)
        body, model = phynness.Organ(None, file), phynness.Model(work / "free")
        self.assertEqual((body.mesh_hash, body.max_displacement_m), (model.mesh_hash, model.max_displacement_m))
        at, d = [int(n) for n in model.active_nodes], np.array([[0, 0.001, -0.004], [0.002, 0, -0.003]])
        both = body.hold(at, d, increments=8)
        displacements = body.deform()
        tools = [word for n, x in zip(at, d) for word in ("--node", n, "--displacement", ",".join(map(repr, x.tolist())))]
        run(COMMAND, "eval", work / "free", "--body", file, *tools, "--json", work / "both.json")
        said = json.loads((work / "both.json").read_text())
        self.assertEqual(both.forces.tolist(), [tool["force"] for tool in said["tools"]])
        self.assertEqual((both.energy, both.residual), (said["energy"], said["residual"]))
        self.assertEqual(np.linalg.norm(displacements, axis=1).max(), said["max_displacement"])
        self.assertEqual(displacements.shape, body.points.shape)
        self.assertRaisesRegex(phynness.Error, "bound", body.bound)
        # Beside a model the body answers several tools, the model one; both move the model's nodes.
        organ = pickle.loads(pickle.dumps(phynness.Organ(model, file)))
        self.assertEqual(organ.hold(at, d, increments=8).forces.tobytes(), both.forces.tobytes())
        shared = np.isin(organ.nodes, body.nodes)
        self.assertEqual(organ.deform()[shared].tobytes(), displacements[np.isin(body.nodes, organ.nodes)].tobytes())
        self.assertEqual(organ.hold(at[0], d[0]).forces.tobytes(), model.force(at[0], d[0]).tobytes())
        run(COMMAND, "calibrate", work / "free", work / "free.h5", "--rays", 100, "--body", file)
        bounded = phynness.Organ(None, file.read_bytes())
        self.assertEqual(bounded.hold(at, d, increments=8).forces.tobytes(), both.forces.tobytes())
        self.assertTrue((bounded.bound() > 0).all())
        self.assertRaisesRegex(phynness.Error, scene.name, phynness.Organ, None, scene)
        self.assertRaisesRegex(phynness.Error, "No such file", phynness.Organ, None, work / "none.txt")
        self.assertRaisesRegex(phynness.Error, "another mesh", phynness.Organ, MODEL, file)
        self.assertRaises(phynness.Error, body.hold, [10**6], [[0, 0, 0]])

    def test_what_the_command_refuses_is_an_error_in_words(self):
        self.assertRaisesRegex(phynness.Error, "does not exist", phynness.precompute, work / "none.toml", work / "none.h5")
        self.assertRaisesRegex(phynness.Error, "shape", phynness.solve, self.scene, 1, [1, 2])
        self.assertRaisesRegex(phynness.Error, "node", phynness.solve, self.database, 10**6, [0, 0, 0])
        self.assertRaisesRegex(phynness.Error, "ranks", phynness.precompute, self.scene, work / "none.h5", ranks=0)
        os.environ["PHYNNESS_COMMAND"] = str(work / "nothing")
        path, os.environ["PATH"] = os.environ["PATH"], ""
        try:
            self.assertRaisesRegex(phynness.Error, "PHYNNESS_COMMAND", phynness.solve, self.scene, 1, [0, 0, 0])
        finally:
            os.environ.update(PATH=path, PHYNNESS_COMMAND=str(COMMAND))

    def test_an_interruption_keeps_what_is_solved(self):
        scene = work / "many.toml"
        scene.write_text(SMALL.replace("count = 2", "count = 12").replace("directions = 26", "directions = 98"))

        def stop(*_):
            raise KeyboardInterrupt

        def stop_after_the_first_rays():
            while sum(log.stat().st_size for log in work.glob("many.h5.log/rank-*")) < 40_000:
                time.sleep(0.01)
            os.kill(os.getpid(), signal.SIGALRM)

        before = signal.signal(signal.SIGALRM, stop)
        threading.Thread(target=stop_after_the_first_rays, daemon=True).start()
        with self.assertRaises(KeyboardInterrupt):
            phynness.precompute(scene, work / "many.h5")
        signal.signal(signal.SIGALRM, before)
        phynness.precompute(scene, work / "many.h5", resume=True)


main()
