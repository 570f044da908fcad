// Claim: what other programs write in a format in more than one way is the same mesh: cells once for each group,
// sections between those of the mesh, capitals, vertices of their own for each face, other cells than tetrahedra, names
// of files of the other kind of VTK, a last line without a break. The volumes are those of exact coordinates.
#include <map>

#include "mesh_under_test.hpp"
#include "read/raw_mesh.hpp"
#include "small_files.hpp"

namespace phynness::test {
namespace {

std::string hash_of(const std::string& bytes, const char* extension) {
  return mesh_hash(import_bytes(bytes, extension).mesh);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("no " + from);
  return text.replace(at, from.size(), to);
}

TEST(Groups, MayRepeatTheirCells) {
  const std::string whole = "$PhysicalNames\n2\n3 1 \"whole\"\n3 2 \"part\"\n$EndPhysicalNames\n";
  const std::string cells = "1 4 2 1 1 1 2 3 4\n2 4 2 1 1 2 5 3 4\n3 4 2 2 1 5 2 3 4\n";
  const MeshResult result =
      import_bytes(replaced(msh_2(cells, 3), "$EndMeshFormat\n", "$EndMeshFormat\n" + whole), ".msh");
  EXPECT_EQ(result.mesh.n_cells(), 2);
  EXPECT_TRUE(contains(joined(result.notes), "dropped 1 repeated cell,")) << joined(result.notes);
  EXPECT_EQ(result.mesh.groups.at("whole").size(), 5u);
  EXPECT_EQ(result.mesh.groups.at("part"), (std::vector<std::int32_t>{1, 2, 3, 4}));
}

TEST(Groups, MayRepeatTheirTriangles) {
  const std::string twice =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
      "$EndNodes\n$Elements\n5\n1 2 2 1 1 1 3 2\n2 2 2 1 1 1 2 4\n3 2 2 2 1 2 4 1\n"
      "4 2 2 1 1 2 3 4\n5 2 2 1 1 3 1 4\n$EndElements\n";
  EXPECT_EQ(meshes::read_mesh_file(TemporaryFile(twice, ".msh").path).triangles.size(), 4u);
}

const std::string field = "FIELD FieldData 2\nTIME 1 1 double\n172800\nCELLS 1 2 int\n4 5\n";
const std::string metadata = "METADATA\nINFORMATION 1\nNAME L2_NORM LOCATION vtkDataArray\nDATA 2 0 1\n\n";
const std::string attributes = "POINT_DATA 5\nSCALARS s float 1\nLOOKUP_TABLE default\n1 2 3 4 5\n";

TEST(LegacyVtk, MayHaveOtherSectionsAnywhere) {
  for (const std::string& file : {small_vtk_4, small_vtk_5}) {
    const std::string hash = hash_of(file, ".vtk");
    for (const std::string& section : {field, metadata, attributes}) {
      for (const char* place : {"POINTS", "CELLS", "CELL_TYPES"})
        EXPECT_EQ(hash_of(replaced(file, place, section + place), ".vtk"), hash) << section << place;
      EXPECT_EQ(hash_of(file + section, ".vtk"), hash) << section;
    }
    EXPECT_EQ(hash_of(replaced(file, "POINTS", "Points"), ".vtk"), hash);
  }
  const std::string binary = small_vtk_binary(), hash = hash_of(binary, ".vtk");
  EXPECT_EQ(hash_of(replaced(small_vtk_4, " double", " DOUBLE"), ".vtk"), hash);
  EXPECT_EQ(hash_of(replaced(binary, "POINTS", "FIELD FieldData 1\nTIME 1 1 double\n12345678\nPOINTS"), ".vtk"), hash);
  EXPECT_EQ(hash_of(replaced(binary, "\nCELLS", "\nMETADATA\nINFORMATION 0\n\nCELLS"), ".vtk"), hash);
}

TEST(LegacyVtk, MayHoldItsSurfaceAsStrips) {
  const std::string head =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
      "0 0 0 1 0 0 0 1 0 0 0 1\nVERTICES 1 2\n1 0\n";
  const TemporaryFile file(head + "TRIANGLE_STRIPS 1 7\n6 0 2 1 3 0 2\n", ".vtk");
  EXPECT_EQ(meshes::read_mesh_file(file.path).triangles,
            (std::vector<meshes::Triangle>{{0, 2, 1}, {1, 2, 3}, {1, 3, 0}, {0, 3, 2}}));
}

TEST(Vtk, IsReadByItsContents) {
  EXPECT_EQ(hash_of(small_vtk_4, ".vtu"), hash_of(small_vtk_4, ".vtk"));
  const std::string xml =
      "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>"
      "<Piece NumberOfPoints=\"5\" NumberOfCells=\"2\"><Points><DataArray type=\"Float64\" format=\"ascii\">"
      "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1</DataArray></Points><Cells>"
      "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 1 4 2 3</DataArray>"
      "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 8</DataArray>"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 10</DataArray>"
      "</Cells></Piece></UnstructuredGrid></VTKFile>";
  for (const std::string begin : {"", "\xef\xbb\xbf", "<?xml version=\"1.0\"?>\n"})
    EXPECT_EQ(hash_of(begin + xml, ".vtk"), hash_of(small_vtk_4, ".vtk"));
}

/// A .vtu file of the two cells with an array of these cells.
std::string vtu_with(const std::string& array) {
  return "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>"
         "<Piece NumberOfPoints=\"5\" NumberOfCells=\"2\"><Points><DataArray type=\"Float64\" format=\"ascii\">"
         "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1</DataArray></Points><Cells>"
         "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 1 4 2 3</DataArray>"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 8</DataArray>"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 10</DataArray></Cells><CellData>" +
         array + "</CellData></Piece></UnstructuredGrid></VTKFile>";
}

TEST(Vtk, IntegersOfCellsAreGroups) {
  const auto xml = [](const char* name, const char* type, const char* values) {
    return vtu_with(std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" format=\"ascii\">" + values +
                    "</DataArray>");
  };
  // The triangle of the first file is a cell of VTK, but none of the body.
  const std::string scalars = "CELL_DATA 3\nSCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n1\n2\n7\n";
  const std::string in_field = "CELL_DATA 2\nFIELD FieldData 2\nheat 1 2 double\n0 0\nmedit:ref 1 2 int\n2 7\n";
  const std::string points = "POINT_DATA 5\nSCALARS region int 1\nLOOKUP_TABLE default\n1\n2\n3\n4\n5\n";
  for (const auto& [bytes, extension] : std::vector<std::pair<std::string, const char*>>{
           {small_vtk_4 + scalars, ".vtk"},
           {small_vtk_4 + scalars + points, ".vtk"},
           {small_vtk_5 + points + in_field, ".vtk"},
           {replaced(small_vtk_4 + scalars, "Ids int", "Ids long"), ".vtk"},
           {xml("region", "Int32", "2 7"), ".vtu"},
           {xml("gmsh:physical", "UInt8", "2 7"), ".vtu"}}) {
    SCOPED_TRACE(bytes);
    const Mesh mesh = import_bytes(bytes, extension).mesh;
    EXPECT_EQ(mesh.cell_groups, (std::map<std::string, std::vector<std::int32_t>>{{"2", {0}}, {"7", {1}}}));
  }
  EXPECT_TRUE(import_bytes(small_vtk_4 + points, ".vtk").mesh.cell_groups.empty());
  for (const auto& [bytes, extension] : std::vector<std::pair<std::string, const char*>>{
           {replaced(small_vtk_4 + scalars, "Ids int", "Ids float"), ".vtk"},
           {xml("region", "Float64", "2 7"), ".vtu"}}) {
    const MeshResult result = import_bytes(bytes, extension);
    EXPECT_TRUE(result.mesh.cell_groups.empty());
    EXPECT_TRUE(contains(joined(result.notes), "save it as one integer for each cell")) << joined(result.notes);
  }
  EXPECT_TRUE(contains(import_error(xml("region", "Int32", "2"), ".vtu"), "1 instead of 2"));
  EXPECT_TRUE(contains(import_error(small_vtk_5 + replaced(in_field, "ref 1 2 int\n2 7", "ref 1 1 int\n2"), ".vtk"),
                       "'medit:ref' has another number of values"));
}

TEST(Stl, MayBeInCapitalsAndEndInSeveralWays) {
  const char* x[] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string stl = "solid corner\n";
  for (const auto& face : faces) {
    stl += "  facet normal 0 0 0\n    outer loop\n";
    for (const int i : face) stl += std::string("      vertex ") + x[i] + "\n";
    stl += "    endloop\n  endfacet\n";
  }
  for (const char* end : {"endsolid corner\n", "endsolid", "end solid\n", "ENDSOLID", "end\n"})
    for (const bool capitals : {false, true}) {
      std::string text = (capitals ? "\n" : "") + stl + end;
      if (capitals)
        for (char& c : text) c = static_cast<char>(std::toupper(c));
      const meshes::RawMesh raw = meshes::read_mesh_file(TemporaryFile(text, ".STL").path);
      EXPECT_EQ(raw.nodes.size(), 4u) << end;
      EXPECT_EQ(raw.triangles.size(), 4u) << end;
      EXPECT_TRUE(raw.notes.empty()) << joined(raw.notes);
    }
  EXPECT_TRUE(contains(import_error(replaced(stl, "facet", "colour red facet"), ".stl"), "colour"));
  EXPECT_TRUE(contains(import_error(stl, ".stl"), "it ends before 'endsolid'"));
}

TEST(Stl, MayLeaveItsNumberOfTrianglesOpen) {
  for (const char* number : {"\xff\xff\xff\xff", "\0\0\0\0"}) {
    std::string stl = "solid of a stream" + std::string(63, ' ') + std::string(number, 4);
    for (const float x : {0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
      stl.append(reinterpret_cast<const char*>(&x), sizeof x);
    EXPECT_EQ(meshes::read_mesh_file(TemporaryFile(stl + std::string(2, '\0'), ".stl").path).triangles.size(), 1u);
  }
}

TEST(Surfaces, OfFacesWithVerticesOfTheirOwnAreWelded) {
  const double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string obj, points, polygons;
  for (int f = 0; f < 4; ++f) {
    for (const int i : faces[f]) {
      const std::string place = std::to_string(x[i][0]) + " " + std::to_string(x[i][1]) + " " + std::to_string(x[i][2]);
      obj += "v " + place + "\r\n";
      points += place + "\n";
    }
    obj += "f -3 -2 \\\r\n -1\r\n";
    polygons += "3 " + std::to_string(3 * f) + " " + std::to_string(3 * f + 1) + " " + std::to_string(3 * f + 2) + "\n";
  }
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\n"
      "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
  const std::map<const char*, std::string> files = {
      {".obj", obj}, {".ply", ply + points + polygons}, {".off", "OFF\n12 4 0\n" + points + polygons}};
  for (const auto& [extension, bytes] : files) {
    SCOPED_TRACE(extension);
    const meshes::RawMesh raw = meshes::read_mesh_file(TemporaryFile(bytes, extension).path);
    EXPECT_EQ(raw.nodes.size(), 4u);
    EXPECT_EQ(raw.triangles, (std::vector<meshes::Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {2, 1, 3}}));
    EXPECT_TRUE(contains(joined(raw.notes), "merged 8 nodes")) << joined(raw.notes);
    const std::string cut = bytes.substr(0, bytes.find_last_of("0123456789") + 1);
    EXPECT_TRUE(contains(joined(meshes::read_mesh_file(TemporaryFile(cut, extension).path).notes), "line break"));
  }
}

/// n^3 cells of eight corners over the unit cube without one corner, with nodes in the order of their coordinates.
std::string voxels(int n, const std::string& format, bool own_points = false) {
  const int m = n + 1;
  std::string nodes, cells;
  int n_nodes = 0, n_cells = 0;
  const auto node = [&](int i, int j, int k) {
    const std::string number = format == "msh" ? std::to_string(n_nodes + 1) + " " : "";
    const std::string separator = format == "inp" ? ", " : " ";
    nodes += (format == "inp" ? std::to_string(n_nodes + 1) + ", " : number) + std::to_string(i * 1.0 / n) + separator +
             std::to_string(j * 1.0 / n) + separator + std::to_string(k * 1.0 / n) + "\n";
    return n_nodes++;
  };
  if (!own_points)
    for (int p = 0; p < m * m * m; ++p) node(p % m, p / m % m, p / m / m);
  const int voxel[8] = {0, 1, 2, 3, 4, 5, 6, 7}, hexahedron[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  for (int c = 0; c + 1 < n * n * n; ++c) {
    const int i = c % n, j = c / n % n, k = c / n / n;
    std::string corners;
    for (const int corner : format == "11" ? voxel : hexahedron) {
      const int a = i + corner % 2, b = j + corner / 2 % 2, d = k + corner / 4;
      const int number = own_points ? node(a, b, d) : a + m * (b + m * d);
      corners += (format == "inp" ? ", " : " ") + std::to_string(number + (format == "inp" || format == "msh"));
    }
    ++n_cells;
    cells += (format == "inp"   ? std::to_string(n_cells)
              : format == "msh" ? std::to_string(n_cells) + " 5 2 0 1"
                                : "8") +
             corners + "\n";
  }
  const auto count = [](int i) { return std::to_string(i); };
  if (format == "inp") return "*NODE\n" + nodes + "*ELEMENT, TYPE=C3D8R\n" + cells;
  if (format == "msh") return msh_2(cells, n_cells, nodes, n_nodes);
  std::string types;
  for (int c = 0; c < n_cells; ++c) types += format + "\n";
  return "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " + count(n_nodes) + " float\n" +
         nodes + "CELLS " + count(n_cells) + " " + count(9 * n_cells) + "\n" + cells + "CELL_TYPES " + count(n_cells) +
         "\n" + types;
}

TEST(Voxels, AreSplitAlongOneDiagonalInEveryFormat) {
  const MeshResult first = import_bytes(voxels(4, "11"), ".vtk");
  EXPECT_EQ(first.mesh.n_cells(), 6 * 63);
  EXPECT_NEAR(first.quality.volume_m3, 63.0 / 64, 1e-12);
  EXPECT_NEAR(first.quality.max_edge_m, std::sqrt(3) / 4, 1e-12);
  EXPECT_TRUE(contains(joined(first.notes), "split 63 cells")) << joined(first.notes);
  EXPECT_TRUE(first.warnings.empty()) << joined(first.warnings);
  EXPECT_EQ(hash_of(voxels(4, "12"), ".vtk"), mesh_hash(first.mesh));
  EXPECT_EQ(hash_of(voxels(4, "inp"), ".inp"), mesh_hash(first.mesh));
  EXPECT_EQ(hash_of(voxels(4, "msh"), ".msh"), mesh_hash(first.mesh));
  const MeshResult own = import_bytes(voxels(4, "12", true), ".vtk");
  EXPECT_EQ(own.mesh.n_nodes(), first.mesh.n_nodes());
  EXPECT_NEAR(own.quality.volume_m3, first.quality.volume_m3, 1e-12);
}

// A wedge and a pyramid on two faces of a hexahedron: 6, 3 and 2 tetrahedra, whose common faces agree.
TEST(Voxels, MayHaveWedgesAndPyramidsBesideThem) {
  const std::string nodes =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
      "9,2,0,0\n10,2,1,0\n11,.5,.5,2\n";
  const MeshResult result = import_bytes(nodes +
                                             "*ELEMENT, TYPE=C3D8\n1, 1,2,3,4,5,6,7,8\n*ELEMENT, TYPE=C3D6\n"
                                             "2, 2,9,6,3,10,7\n*ELEMENT, TYPE=C3D5\n3, 5,6,7,8,11\n",
                                         ".inp");
  EXPECT_EQ(result.mesh.n_cells(), 11);
  EXPECT_NEAR(result.quality.volume_m3, 1 + 0.5 + 1.0 / 3, 1e-12);
}

TEST(Msh, MayHaveElementDataWithoutALineBreakBehindThem) {
  const std::string mesh = small_msh_2_binary(false);
  const std::string data = "$ElementData\n1\n\"x\"\n1\n0\n3\n0\n1\n2\n" + std::string(24, '\n') + "$EndElementData\n";
  EXPECT_EQ(hash_of(mesh + data, ".msh"), hash_of(mesh, ".msh"));
  EXPECT_TRUE(contains(import_error(mesh + data.substr(0, 30), ".msh"), "$EndElementData"));
}

}  // namespace
}  // namespace phynness::test
