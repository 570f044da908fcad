"""Claim: the example of responses of another program makes a database, whose model repeats the program's forces.

Usage: responses_are_imported.py SOURCES PHYNNESS
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import h5py  # noqa: F401
    import numpy as np
except ImportError:
    sys.exit(77)
sources, phynness = Path(sys.argv[1]), sys.argv[2]
sys.path.insert(0, str(sources / "examples/python"))
import responses  # noqa: E402

with tempfile.TemporaryDirectory() as folder:
    def run(*words):
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (words, done.stderr)
        return done.stdout

    responses.main(Path(folder, "given.h5"))
    run(phynness, "import", "given.h5", "-o", "database.h5")
    assert "imported" in run(phynness, "info", "database.h5")
    run(phynness, "train", "database.h5", "-o", "model")
    # Of the last place an interpolation of 300 measurements was trained. Linear responses are 33 % off at this depth.
    for node, most in ((21, 0.01), (75, 0.06)):
        d = np.array([0.004, -0.003, -0.006])
        run(phynness, "eval", "model", "--node", str(node), "--displacement", ",".join(map(str, d)), "--json", "answer.json")
        found = json.loads(Path(folder, "answer.json").read_text())["tools"][0]["force"]
        wanted = responses.force(d[None])[0]
        error = np.linalg.norm(found - wanted) / np.linalg.norm(wanted)
        assert error < most, (node, error)
    done = subprocess.run([phynness, "solve", "database.h5", "--node", "21", "--displacement", "0,0,0.001"], cwd=folder,
                          capture_output=True, text=True)
    assert done.returncode == 2 and "imported" in done.stderr, done.stderr
