#!/usr/bin/env python3
"""Claim: examples of docstrings and tutorials agree with the Python package, and its wheel is installed without an index.

Usage: package_is_whole.py SOURCES BUILD PHYNNESS
"""
import doctest
import importlib.util
import inspect
import os
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
        for name in ("organ.png", "organ.html", "model/model.txt"):
            self.assertGreater((out / name).stat().st_size, 5000)

    def test_the_wheel_is_installed_without_an_index(self):
        wheel = run(SOURCES / "tools/build-wheel", "--build", BUILD, "-o", work / "wheel").strip()
        venv = work / "venv"
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", venv)
        run(sys.executable, "-m", "pip", "--python", venv / "bin/python", "install", "--no-index", wheel, cwd=work)
        said = run(venv / "bin/python", "-c", "import phynness; print(phynness.__file__, phynness.__version__)", cwd=work)
        self.assertIn(str(venv), said)
        said = run(venv / "bin/python", SOURCES / "examples/python/press.py", MODEL, cwd=work)
        self.assertIn("beyond: warned", said)


main()
