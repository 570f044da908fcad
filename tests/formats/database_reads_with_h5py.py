"""Claim: h5py reads a database as formats/database.md describes: paths, shapes, types, units, names of outcomes.

Usage: database_reads_with_h5py.py PROGRAM DOCUMENT, where PROGRAM FILE [symmetric] writes a database to FILE.
Exit status 77: h5py is not installed, skipped.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy as np
except ImportError as error:
    print("skipped:", error)
    sys.exit(77)

program, document = sys.argv[1], pathlib.Path(sys.argv[2]).read_text()

with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "database.h5")
    subprocess.run([program, path], check=True)
    with h5py.File(path) as f:
        attributes = dict(f.attrs)
        assert attributes["format"] == "phynness database", attributes
        assert attributes["complete"] == 1 and attributes["format_version"] == 1
        assert re.fullmatch("[0-9a-f]{16}", attributes["physics_hash"])
        assert re.fullmatch("[0-9a-f]{16}", attributes["mesh_hash"])
        assert "c10_Pa" in f["scene"].asstr()[()]

        A, D, I, O = (len(f[x]) for x in ("sets/active", "directions", "magnitudes", "sets/output"))
        expected = {
            "status": ("int8", "1", ()), "force": ("float64", "N", (3,)), "energy": ("float64", "J", ()),
            "displacement": ("float64", "m", (O, 3)), "tangent": ("float64", "N/m", (3, 3)),
            "negative_pivots": ("int32", "1", ()), "iterations": ("int32", "1", ()), "cutbacks": ("int32", "1", ()),
            "min_jacobian": ("float64", "1", ()), "seconds": ("float64", "s", ()),
        }
        ends = {"end_reason": ("int8", "1"), "end_depth": ("float64", "m"), "fold_depth": ("float64", "m"),
                "energy_lost": ("float64", "J")}
        assert attributes["format_minor"] == 1
        assert set(f["responses"]) == set(expected) | set(ends)
        for name, (dtype, unit) in ends.items():
            data = f["responses"][name]
            assert data.shape == (A, D) and data.dtype == dtype and data.attrs["unit"] == unit, name
        for name, (dtype, unit, tail) in expected.items():
            data = f["responses"][name]
            assert data.shape == (A, D, I) + tail, name
            assert data.dtype == dtype and data.attrs["unit"] == unit, name

        documented = set(re.findall(r"^\| `(/[a-z_/]+[a-z])`", document, re.M))
        def check(name, item):
            if isinstance(item, h5py.Dataset):
                assert item.attrs["unit"] and item.attrs["description"], name
                assert "/" + name in documented or name.startswith("mesh/groups/"), name
        f.visititems(check)
        symmetric_only = {"/symmetry/normal", "/symmetry/image", "/responses/solved_as"}
        assert {x.lstrip("/") for x in documented - symmetric_only if x != "/mesh/groups"} <= {
            *[k for k in ("scene", "directions", "magnitudes")],
            *["mesh/" + k for k in f["mesh"]], *["sets/" + k for k in f["sets"]],
            *["responses/" + k for k in f["responses"]]}, documented

        meaning = dict(zip(f["responses/status"].attrs["flag_values"],
                           f["responses/status"].attrs["flag_meanings"].split()))
        for value, name in meaning.items():
            assert f"| {value} | `{name}` |" in document, (value, name)
        ends = f["responses/end_reason"].attrs
        for value, name in zip(ends["flag_values"], ends["flag_meanings"].split()):
            assert f"| {value} | `{name}` |" in document, (value, name)
        # The writer fails every third ray at its last increment.
        status = f["responses/status"][...]
        a, d = np.meshgrid(range(A), range(D), indexing="ij")
        assert ((status[:, :, -1] == -1) == ((a + d) % 3 == 0)).all()
        assert meaning[-1] == "inverted"
        assert np.allclose(np.linalg.norm(f["directions"][...], axis=1), 1, atol=1e-15)
        assert np.isfinite(f["responses/displacement"][...]).all()

    path = os.path.join(folder, "symmetric.h5")
    subprocess.run([program, path, "symmetric"], check=True)
    with h5py.File(path) as f:
        assert symmetric_only == {"/" + x for x in ("symmetry/normal", "symmetry/image", "responses/solved_as") if x in f}
        f.visititems(check)
        assert f["symmetry"].attrs["odd"] == 0
        n = f["symmetry/normal"][...]
        solved_as = f["responses/solved_as"][...]
        force = f["responses/force"][...].reshape(A * D, I, 3)
        mirrored = solved_as.ravel() != np.arange(A * D)
        assert 0 < mirrored.sum() < A * D
        assert not mirrored[solved_as.ravel()].any()
        reflection = np.eye(3) - 2 * np.outer(n, n)
        assert (force[mirrored] == force[solved_as.ravel()[mirrored]] @ reflection).all()
        assert (f["responses/seconds"][...].reshape(A * D, I)[mirrored] == 0).all()
print("read", 2 * A * D, "rays")
