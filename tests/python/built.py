"""What the tests of the Python package share: what was built, a folder of their own, and how commands are run.

Arguments of a test: SOURCES BUILD PHYNNESS and the programs that it needs.
"""
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCES, BUILD, COMMAND, *OTHERS = map(Path, sys.argv[1:])
sys.path.insert(0, str(BUILD / "python"))
MODEL = SOURCES / "examples/model"
work = Path(tempfile.mkdtemp(prefix="phynness-python-"))


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command} failed\n{done.stdout}{done.stderr}")
    return done.stdout


def main():
    try:
        unittest.main(argv=sys.argv[:1])
    finally:
        shutil.rmtree(work)
