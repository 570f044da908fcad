"""Claim: VTK and meshio read the output of `phynness show` with exactly the numbers of the database.
The cells are tetrahedra, triangles or points, according to the stored nodes.

Usage: shown_responses_open_elsewhere.py WRITE_DATABASE PHYNNESS
Exit status 77: h5py or both readers are missing, skipped. With one of the two readers it checks with that one.
"""

import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

try:
    import h5py
    import numpy as np
except ImportError as error:
    print("skipped:", error)
    sys.exit(77)
try:
    import meshio
except ImportError:
    meshio = None
try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None
if meshio is None and vtk is None:
    print("skipped: neither python3-meshio nor python3-vtk9 is installed")
    sys.exit(77)

write_database, phynness = sys.argv[1:3]
width = {"vertex": 1, "triangle": 3, "tetra": 4}


def of_meshio(mesh):
    (cells,) = mesh.cells
    assert cells.data.shape[1] == width[cells.type]
    return mesh.points, cells.data, mesh.point_data


def of_vtk(grid):
    assert {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())} in ({1}, {5}, {10})
    cells = [[grid.GetCell(i).GetPointId(k) for k in range(grid.GetCell(i).GetNumberOfPoints())]
             for i in range(grid.GetNumberOfCells())]
    data = grid.GetPointData()
    fields = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
    return vtk_to_numpy(grid.GetPoints().GetData()), np.array(cells), fields


def vtk_reader(reader, file):
    reader.SetFileName(file)
    reader.Update()
    return reader.GetOutput()


def meshio_states(file):
    """[(time or None, points, cells, fields), ...]"""
    return [(None, *of_meshio(meshio.read(file)))]


def vtk_states(file):
    grid = vtk_reader(vtk.vtkXMLUnstructuredGridReader(), file)
    return [(grid.GetFieldData().GetArray("TimeValue").GetValue(0), *of_vtk(grid))]


readers = [r for r, there in ((meshio_states, meshio), (vtk_states, vtk)) if there]
print("readers:", *(r.__name__.split("_")[0] for r in readers))

n_checked = 0


def check(state, time, f, active, direction, increment, known, n_cells, cell_width):
    """One state read back, against the database."""
    global n_checked
    read_time, points, cells, fields = state
    nodes = fields["node"].ravel()
    assert list(nodes) == sorted(known), (nodes, known)
    assert np.array_equal(points, f["mesh/nodes"][...][nodes])
    assert cells.shape == (n_cells, cell_width), cells.shape
    expected_faces = {4: f["mesh/cells"], 3: f["mesh/surface"]}.get(cell_width)
    if expected_faces is not None:
        kept = [list(c) for c in expected_faces[...] if set(c) <= set(known)]
        assert nodes[cells].tolist() == kept
    if time is not None and read_time is not None:
        assert read_time == f["magnitudes"][increment], (read_time, time)
    # Known: prescribed, fixed (zero), stored; in this order of precedence the last wins.
    node = f["sets/active"][active]
    u = np.zeros((len(f["mesh/nodes"]), 3))
    u[node] = f["directions"][direction] * f["magnitudes"][increment]
    u[f["sets/output"][...]] = f["responses/displacement"][active, direction, increment]
    assert np.array_equal(fields["displacement"], u[nodes])
    force = np.zeros_like(u)
    force[node] = f["responses/force"][active, direction, increment]
    assert np.array_equal(fields["force"], force[nodes])
    assert np.array_equal(fields["prescribed"].ravel(), (nodes == node).astype(float))
    n_checked += 1


def show(database, node, direction, output):
    return subprocess.run([phynness, "show", database, "--node", str(node), "--direction", str(direction), "-o", output],
                          capture_output=True, text=True)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    # Output nodes -> nodes known when node 1 is touched, cells, nodes of a cell. Node 0 is fixed.
    cases = {
        "all": ([1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 5], 2, 4),
        "some": ([2, 3], [0, 1, 2, 3], 3, 3),
        "one": ([4], [0, 1, 4], 3, 1),
    }
    for name, (output, known, n_cells, cell_width) in cases.items():
        database = name + ".h5"
        subprocess.run([write_database, database, *map(str, output)], check=True)
        with h5py.File(database) as f:
            n = len(f["magnitudes"])
            done = show(database, 1, 1, name + ".pvd")
            assert done.returncode == 0, done.stderr
            assert ("displacements of" in done.stderr) == (cell_width != 4), done.stderr
            for increment in range(n):
                for states in readers:
                    (state,) = states(f"{name}-{increment + 1:04d}.vtu")
                    check(state, f["magnitudes"][increment], f, 0, 1, increment, known, n_cells, cell_width)

    # A collection: its own VTU files, in order. Ray (active 0, direction 0) fails at its last increment: left out,
    # said.
    with h5py.File("all.h5") as f:
        done = show("all.h5", 1, 0, "ray.pvd")
        assert done.returncode == 0 and "increment 3 is left out: inverted" in done.stderr, done.stderr
        entries = xml.etree.ElementTree.parse("ray.pvd").getroot().findall("Collection/DataSet")
        assert [float(e.get("timestep")) for e in entries] == list(f["magnitudes"][:2])
        for increment, entry in enumerate(entries):
            for states in readers:
                check(states(entry.get("file"))[0], None, f, 0, 0, increment, range(6), 2, 4)

    # What cannot be shown is refused, with the remedy, and leaves no file.
    for arguments, words in (((0, 0, "no.pvd"), "--node 0"), ((1, 7, "no.pvd"), "--direction 7"), ((1, 1, "no.vtu"), "no.vtu"),
                             ((1, 1, "no.xdmf"), "ends in .pvd"), ((1, 1, "no/folder.pvd"), "no/folder.pvd")):
        done = show("all.h5", *arguments)
        assert done.returncode == 2 and words in done.stderr and "remedy" in done.stderr, (arguments, done)
        assert not os.path.exists("no.pvd")
print("checked", n_checked, "states")
