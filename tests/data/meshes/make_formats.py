"""Makes formats/: a cube of 27 nodes and 48 tetrahedra, or its surface, as other programs write it.

/usr/bin/python3 make_formats.py: needs VTK (Debian: python3-vtk9), whose writers are those of ParaView and PyVista, and
meshio (python3-meshio). The tests hold for the files that are committed.
"""
import os

import meshio
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkCellArray, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkIOPLY import vtkPLYWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "formats")


def cube():
    """Nodes at multiples of 1/64 m, which are exact in every format, the x coordinate first; Kuhn's tetrahedra."""
    nodes = numpy.array([(i % 3, i // 3 % 3, i // 9) for i in range(27)]) / numpy.array([64.0, 32.0, 64.0])
    cells = []
    for c in range(8):
        a = c % 2 + 3 * (c // 2 % 2) + 9 * (c // 4)
        for p, q in ((1, 3), (1, 9), (3, 1), (3, 9), (9, 1), (9, 3)):
            cell = [a, a + p, a + p + q, a + 13]
            x = nodes[cell]
            if numpy.linalg.det(x[1:] - x[0]) < 0:
                cell[1], cell[2] = cell[2], cell[1]
            cells.append(cell)
    return nodes, numpy.array(cells)


def surface(nodes, cells):
    """Nodes and outward triangles of the boundary."""
    faces = {}
    for a, b, c, d in cells:
        for face in ((b, c, d), (a, d, c), (a, b, d), (a, c, b)):
            key = tuple(sorted(face))
            faces[key] = None if key in faces else face
    triangles = numpy.array([face for face in faces.values() if face])
    used, renumbered = numpy.unique(triangles, return_inverse=True)
    return nodes[used], renumbered.reshape(-1, 3)


def cell_array(cells):
    array = vtkCellArray()
    array.SetData(numpy_to_vtkIdTypeArray(numpy.arange(0, cells.size + 1, cells.shape[1], dtype=numpy.int64), deep=True),
                  numpy_to_vtkIdTypeArray(cells.astype(numpy.int64).ravel(), deep=True))
    return array


def vtk_data(data, nodes, cells, kind):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(nodes, deep=True))
    data.SetPoints(points)
    if kind:
        data.SetCells(kind, cell_array(cells))
    else:
        data.SetPolys(cell_array(cells))
    values = numpy_to_vtk(numpy.arange(3.0 * len(nodes)).reshape(-1, 3), deep=True)
    values.SetName("displacement")
    data.GetPointData().AddArray(values)
    return data


def write_xml(writer, data, name, mode, compressor, header, big_endian=False):
    writer.SetInputData(data)
    writer.SetFileName(os.path.join(folder, name))
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary,
     "appended": writer.SetDataModeToAppended, "base64": writer.SetDataModeToAppended}[mode]()
    writer.SetEncodeAppendedData(mode == "base64")
    {None: writer.SetCompressorTypeToNone, "zlib": writer.SetCompressorTypeToZLib, "lz4": writer.SetCompressorTypeToLZ4,
     "lzma": writer.SetCompressorTypeToLZMA}[compressor]()
    writer.SetBlockSize(264)  # several blocks an array
    writer.SetHeaderTypeToUInt32() if header == 32 else writer.SetHeaderTypeToUInt64()
    writer.SetByteOrderToBigEndian() if big_endian else writer.SetByteOrderToLittleEndian()
    assert writer.Write() == 1


def main():
    nodes, cells = cube()
    body = vtk_data(vtkUnstructuredGrid(), nodes, cells, VTK_TETRA)
    single = vtk_data(vtkUnstructuredGrid(), nodes.astype(numpy.float32), cells, VTK_TETRA)
    for name, data, *how in (("vtk_ascii.vtu", body, "ascii", None, 64),
                             ("vtk_binary.vtu", body, "binary", None, 32),
                             ("vtk_binary_zlib.vtu", body, "binary", "zlib", 32),
                             ("vtk_binary_zlib_float.vtu", single, "binary", "zlib", 64),
                             ("vtk_raw.vtu", body, "appended", None, 64),
                             ("vtk_raw_big_endian.vtu", body, "appended", None, 32, True),
                             ("vtk_raw_zlib.vtu", body, "appended", "zlib", 32),
                             ("vtk_base64.vtu", body, "base64", None, 32),
                             ("vtk_base64_zlib_big_endian.vtu", single, "base64", "zlib", 64, True),
                             ("refused_lz4.vtu", body, "appended", "lz4", 32),
                             ("refused_lzma.vtu", body, "binary", "lzma", 32)):
        write_xml(vtkXMLUnstructuredGridWriter(), data, name, *how)
    mesh = meshio.Mesh(nodes, [("tetra", cells)], point_data={"height": nodes[:, 2].copy()})
    for name, binary, compression in (("meshio_ascii.vtu", False, None), ("meshio_binary.vtu", True, None),
                                      ("meshio_zlib.vtu", True, "zlib")):
        meshio.vtu.write(os.path.join(folder, name), mesh, binary=binary, compression=compression)
    meshio.abaqus.write(os.path.join(folder, "meshio.inp"), mesh)

    outside = surface(nodes, cells)
    skin = vtk_data(vtkPolyData(), *outside, None)
    for name, ascii_file in (("vtk_ascii.ply", True), ("vtk_binary.ply", False), ("vtk_big_endian.ply", False)):
        writer = vtkPLYWriter()
        writer.SetInputData(skin)
        writer.SetFileName(os.path.join(folder, name))
        writer.SetFileTypeToASCII() if ascii_file else writer.SetFileTypeToBinary()
        writer.SetDataByteOrderToBigEndian() if "big" in name else writer.SetDataByteOrderToLittleEndian()
        writer.Write()
    shell = meshio.Mesh(outside[0], [("triangle", outside[1])])
    meshio.ply.write(os.path.join(folder, "meshio_ascii.ply"), shell, binary=False)
    meshio.ply.write(os.path.join(folder, "meshio_binary.ply"), shell, binary=True)
    meshio.off.write(os.path.join(folder, "meshio.off"), shell)


main()
