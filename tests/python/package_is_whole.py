#!/usr/bin/env python3
"""Claim: examples of docstrings, tutorials and every line of docs/howto/python.md agree with the Python package, and its wheel is
installed without an index.

Usage: package_is_whole.py SOURCES BUILD PHYNNESS
"""
import doctest
import importlib.util
import inspect
import os
import re
import sys
import unittest

from built import BUILD, COMMAND, MODEL, SOURCES, main, run, work  # before phynness, whose place it adds to the path

import numpy as np
import phynness


class Package(unittest.TestCase):
    def test_examples_of_docstrings(self):
        os.chdir(SOURCES)
        runner, parser = doctest.DocTestRunner(), doctest.DocTestParser()
        for name in phynness.__all__:
            of = getattr(phynness, name)
            for member in [of] + (list(vars(of).values()) if inspect.isclass(of) else []):
                text = inspect.getdoc(member) if not isinstance(member, str) else ""
                runner.run(parser.get_doctest(text or "", {"phynness": phynness, "np": np}, name, None, 0))
        self.assertEqual(runner.failures, 0)
        self.assertGreaterEqual(runner.tries, 12)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib") and COMMAND.exists(), "no matplotlib, or no command")
    def test_tutorials_say_what_the_page_says(self):
        tutorials, out = SOURCES / "examples/python", work / "tutorials"
        environment = {**os.environ, "PYTHONPATH": str(BUILD / "python"), "PHYNNESS_COMMAND": str(COMMAND)}

        def said(script, *arguments):
            return run(sys.executable, tutorials / script, *arguments, cwd=work, env=environment)

        small = work / "small.toml"
        scene = (MODEL / "scene.toml").read_text()
        for old, new in (("radius_m = 0.055", "radius_m = 0.03"), ("increments = 4", "increments = 3"), ("check_probes = 6", "check_probes = 0")):
            self.assertIn(old, scene)
            scene = scene.replace(old, new)
        small.write_text(scene)
        said("own_organ.py", small, out)
        fell = said("environments.py", MODEL, 300)
        self.assertIn("300 balls touched", fell)
        speed = float(re.search(r"contact: ([0-9.]+) m/s", fell)[1])  # the steps of the balls add a little energy
        self.assertTrue(0.05 < speed < 0.105, fell)
        for name in ("organ.png", "organ.html", "model/model.txt"):
            self.assertGreater((out / name).stat().st_size, 5000)

    def test_every_line_of_the_page(self):
        """In the order of the page, in a folder that has the examples; without a solver only what needs none."""
        page = (SOURCES / "docs/howto/python.md").read_text()
        blocks = re.findall(r"(?ms)^```python\n(.*?)^```", page)
        self.assertGreaterEqual(len(blocks), 3)
        folder = work / "page"
        folder.mkdir()
        (folder / "examples").symlink_to(SOURCES / "examples")
        os.chdir(folder)
        os.environ["PHYNNESS_COMMAND"] = str(COMMAND)
        solves = COMMAND.exists() and " solve " in run(COMMAND, "--help") and importlib.util.find_spec("h5py")
        names = {}
        for number, block in enumerate(blocks):
            if solves or "database" not in block:
                exec(compile(block, f"block {number} of docs/howto/python.md", "exec"), names)
        self.assertEqual(names["forces"].shape, (5, 3))
        self.assertTrue(names["touched"].in_contact[0])
        if solves:
            self.assertEqual((list(names["solved"].status), names["page"].path.exists()), ([0], True))

    def test_the_wheel_is_installed_without_an_index(self):
        run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-index", "-w", work / "wheel", SOURCES / "python")
        (wheel,), venv = (work / "wheel").glob("*.whl"), work / "venv"
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", venv)
        run(sys.executable, "-m", "pip", "--python", venv / "bin/python", "install", "--no-index", wheel, cwd=work)
        said = run(venv / "bin/python", "-c", "import phynness; print(phynness.__file__, phynness.__version__)", cwd=work)
        self.assertIn(str(venv), said)
        said = run(venv / "bin/python", SOURCES / "examples/python/press.py", MODEL, cwd=work)
        self.assertIn("beyond: warned", said)
        # It answers as the package of the build.
        ask = ("import hashlib, numpy as np, phynness\nmodel = phynness.Model({!r})\n"
               "d = 0.01 * np.random.default_rng(1).normal(size=(62, 3))\nimport warnings; warnings.simplefilter('ignore')\n"
               "answers = model.response(model.active_nodes, d) + (model.deform(model.active_nodes, d),)\n"
               "print(hashlib.sha256(b''.join(a.tobytes() for a in answers)).hexdigest())").format(str(MODEL))
        built = run(sys.executable, "-c", ask, cwd=work, env={**os.environ, "PYTHONPATH": str(BUILD / "python")})
        self.assertEqual(run(venv / "bin/python", "-c", ask, cwd=work), built)


main()
