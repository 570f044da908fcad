"""Claim: h5py reads a database as formats/database.md describes: the table of datasets lists exactly those that there are,
with their shapes, types and units; the names of outcomes are those of the page.

Usage: database_reads_with_h5py.py PROGRAM DOCUMENT, where PROGRAM FILE [fields] writes a database to FILE.
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

# path -> shape, type, unit: "A x D x I x 3" with the counts below; n is any number.
rows = {path: (re.sub(r" \(.*", "", shape).split(" x ") if shape != "scalar" else [], types.split(" or "), unit)
        for path, shape, types, unit in
        re.findall(r"^\| `(/[^`]+)`[^|]*\| ([^|]+) \| ([^|]+) \| ([^|]+) \|", document, re.M)}
assert len(rows) > 25, rows


def check_datasets(f, everything):
    counts = {"A": len(f["sets/active"]), "D": len(f["directions"]), "I": len(f["magnitudes"]),
              "O": len(f["sets/output"]), "L": len(f["rest/points"]), "N": len(f["mesh/nodes"])}
    found = {}
    f.visititems(lambda name, item: found.update({"/" + name: item}) if isinstance(item, h5py.Dataset) else None)
    for path, item in found.items():
        row = "/mesh/groups/0" if path.startswith("/mesh/groups/") else path
        assert row in rows, (path, "has no row in the table")
        shape, types, unit = rows[row]
        assert item.attrs["unit"] == unit and item.attrs["description"], path
        assert ("text" if h5py.check_string_dtype(item.dtype) else item.dtype) in types, (path, item.dtype, types)
        assert len(shape) == item.ndim, (path, item.shape, shape)
        for extent, said in zip(item.shape, shape):
            assert said == "n" or extent == counts.get(said, said) or str(extent) == said, (path, item.shape, shape)
    # Imported responses are read in tests/python/responses_from_elsewhere.py.
    optional = {path for path in rows if "/fields/" in path}
    documented = set(rows) - {"/mesh/groups/0", "/displacements"} - (set() if everything else optional)
    assert {path for path in found if not path.startswith("/mesh/groups/")} == documented, documented ^ set(found)


with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "database.h5")
    subprocess.run([program, path], check=True)
    with h5py.File(path) as f:
        attributes = dict(f.attrs)
        assert attributes["format"] == "phynness database", attributes
        assert attributes["complete"] == 1 and attributes["format_version"] == 5
        assert re.fullmatch("[0-9a-f]{16}", attributes["physics_hash"])
        assert re.fullmatch("[0-9a-f]{16}", attributes["mesh_hash"])
        assert "c10_Pa" in f["scene"].asstr()[()]

        A, D, I, O = (len(f[x]) for x in ("sets/active", "directions", "magnitudes", "sets/output"))
        check_datasets(f, everything=False)

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

    path = os.path.join(folder, "fields.h5")
    subprocess.run([program, path, "fields"], check=True)
    with h5py.File(path) as f:
        check_datasets(f, everything=True)
print("read", 2 * A * D, "rays")
