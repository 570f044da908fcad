#!/usr/bin/env python3
"""Claim: stubs, examples of docstrings and tutorials agree with the Python package, and its wheel is installed without an index.

Usage: package_is_whole.py SOURCES BUILD PHYNNESS
"""
import ast
import doctest
import importlib.util
import inspect
import os
import shutil
import sys
import unittest

from built import BUILD, COMMAND, MODEL, SOURCES, main, run, work  # before phynness, whose place it adds to the path

import numpy as np
import phynness


class Package(unittest.TestCase):
    def test_stubs_have_what_the_module_has(self):
        stubs = ast.parse((SOURCES / "python/phynness/_phynness.pyi").read_text())
        public = {}
        for node in stubs.body:
            if isinstance(node, ast.ClassDef):
                public[node.name] = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
            elif isinstance(node, ast.FunctionDef):
                public[node.name] = None
        elsewhere = {name for name in phynness.__all__ if not getattr(getattr(phynness, name), "__module__", "").endswith("_phynness")}
        self.assertEqual(set(public) | elsewhere, set(phynness.__all__))
        for name, members in public.items():
            if members and not issubclass(getattr(phynness, name), BaseException):
                found = {m for m in vars(getattr(phynness, name)) if not m.startswith("_")}
                self.assertEqual(found, {m for m in members if not m.startswith("_")}, name)

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

    @unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
    def test_types_of_the_tutorials(self):
        for tutorial in ("press.py", "own_organ.py", "what_accuracy_costs.py"):
            run("mypy", "--python-executable", sys.executable, "--strict", "--cache-dir", work / "mypy", tutorial,
                cwd=SOURCES / "examples/python", env={**os.environ, "MYPYPATH": str(BUILD / "python")})

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
        costs = said("what_accuracy_costs.py", out / "database.h5", out, 6).splitlines()
        errors = [float(line[20:].split()[0]) for line in costs[1:6]]  # of the linear predictor and four models
        self.assertLess(errors[-1], errors[0] / 10)  # 0.07 and 6 % with 30 solves of examples/model
        for name in ("organ.png", "costs.png", "organ.html", "model/model.txt"):
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
