// Arbitrary bytes as a mesh (mesh.txt, .msh, .vtk, .stl, .obj, .vtu, .ply, .off, .inp) are read or result in an
// Error. Input: a byte (bits 0 to 3: the reader; 8: mesh.txt with its right checksum; bits 4 to 6: repair, millimetres,
// half a body), then the file. The contents are checked as a body, as a surface and as a shell, which gives a valid
// mesh or an Error.
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>

#include "../meshes/small_files.hpp"
#include "read/file_mesh.hpp"
#include "read/flat_cells.hpp"
#include "read/raw_mesh.hpp"
#include "surface/surface.hpp"
#include "texts.hpp"

namespace phynness::fuzz {
namespace {

const std::vector<std::string_view> words = words_of(
    "0|1|2|3|4|5|10|-1|2147483647|2147483648|4294967295|9223372036854775807|1e30|1e308|nan|inf|1p+0|1p+1023|0p+0|"
    "1p-1074|phynness-mesh|hash|nodes|cells|surface|fixed|group|checksum|$MeshFormat|$EndMeshFormat|$Nodes|"
    "$EndNodes|$Elements|$EndElements|$Entities|$EndEntities|$PhysicalNames|$EndPhysicalNames|2.2|4.1|ASCII|"
    "BINARY|DATASET|POINTS|CELLS|CELL_TYPES|OFFSETS|CONNECTIVITY|vtktypeint64|double|float|solid|facet|vertex|"
    "endfacet|v|f|f 1/2/3 2//3 -1|g|ascii|binary|appended|base64|raw|UInt64|BigEndian|"
    "compressor=\"vtkZLibDataCompressor\"|AQAAAACAAAAQAAAA|property|element|list|*NODE|*NSET,NSET=a|GENERATE|");

using Read = meshes::RawMesh (*)(const std::string&, const std::string&);
/// By the low four bits of the first byte; 0 and 8 are mesh.txt.
constexpr Read readers[16] = {nullptr,          meshes::read_msh, meshes::read_vtk, meshes::read_stl, meshes::read_obj,
                              meshes::read_vtu, meshes::read_off, meshes::read_ply, nullptr,          meshes::read_inp};

/// An XML file of VTK with one tetrahedron, in ASCII or with arrays in base64 or appended.
std::string small_vtk_xml(const std::string& cells, const std::string& rest) {
  return "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><UnstructuredGrid>"
         "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" "
         "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>" +
         cells + "</Piece></UnstructuredGrid>" + rest + "</VTKFile>\n";
}

std::string small_cells(const std::string& place) {
  return "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=" + place +
         "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray>"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>";
}

Mesh small_mesh() {
  Mesh mesh;
  mesh.nodes.resize(5, 3);
  mesh.nodes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  mesh.cells.resize(2, 4);
  mesh.cells << 0, 1, 2, 3, 1, 4, 2, 3;
  mesh.surface = boundary_triangles(mesh.cells);
  mesh.groups["hilum"] = {0, 2};
  return mesh;
}

void require_sound(const Mesh& mesh) {
  require(mesh.nodes.allFinite() && mesh.n_cells() > 0 && mesh.surface.rows() > 0, "a mesh of finite cells");
  require(mesh.cells.minCoeff() >= 0 && mesh.cells.maxCoeff() < mesh.n_nodes(), "corners are nodes");
}

/// Everything that is done to a file's mesh before gmsh or the solver sees it.
void check_mesh(meshes::RawMesh raw, std::uint8_t how) {
  const bool repair = (how & 16) != 0;
  const double scale_to_m = (how & 32) != 0 ? 0.001 : 1;
  const auto refused_or = [](const auto& work) {
    try {
      work();
    } catch (const Error& error) {
      require(std::string_view(error.what()).size() > 10, "an error in words");
    }
  };
  refused_or([&] {
    MeshResult body = meshes::checked_body(raw, scale_to_m, repair, "file");
    require_sound(body.mesh);
    meshes::peel_slivers(raw);
  });
  refused_or([&] {
    std::vector<std::string> notes;
    meshes::Surface surface = meshes::checked_surface(raw, scale_to_m, repair, "file", notes);
    require(surface.nodes.allFinite() && surface.triangles.rows() > 0, "a surface of finite triangles");
    if (surface.triangles.rows() < 100) meshes::untangle(surface, notes);
  });
  refused_or([&] {
    MeshResult shell = meshes::checked_shell(raw, scale_to_m, repair, "file");
    require_sound(shell.mesh);
    meshes::check_wall(shell, 0.001, "file");
  });
}

}  // namespace

std::vector<Input> seeds() {
  using namespace phynness::test;
  std::vector<Input> all;
  const auto add = [&](int reader, const std::string& text) {
    Input& input = all.emplace_back();
    input.push_back(static_cast<std::uint8_t>(reader));
    append_text(input, text);
  };
  add(8, write_mesh_text(small_mesh()));
  add(0, write_mesh_text(small_mesh()));
  for (const auto& text : {small_msh_1, small_msh_2, small_msh_4, small_msh_2_binary(false), small_msh_2_binary(true),
                           small_msh_4_binary(false), small_msh_4_binary(true)})
    add(1, text);
  for (const auto& text : {small_vtk_4, small_vtk_5, small_vtk_binary()}) add(2, text);
  add(3,
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid s\n");
  std::string binary(80, ' ');
  binary += bytes_of(std::uint32_t{2});
  for (int i = 0; i < 24; ++i) {
    binary += bytes_of(static_cast<float>(i % 5));
    if (i % 12 == 11) binary += std::string(2, '\0');
  }
  add(3, binary);
  add(4, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/3\nf 2//1 3//1 4//1\nf -4 -1 -2\n");
  const std::string four = "EAAAAAAAAAABAAAAAgAAAAMAAAA=";  // 16 bytes: 0 1 2 3
  add(5, small_vtk_xml(small_cells("\"ascii\">0 1 2 3"), ""));
  add(5, small_vtk_xml(small_cells("\"binary\">" + four), ""));
  add(5, small_vtk_xml(small_cells("\"appended\" offset=\"0\">"),
                       "<AppendedData encoding=\"base64\">_" + four + "</AppendedData>"));
  add(7,
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  add(6, "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n4 0 1 2 3 1 0 0\n");
  add(9,
      "*NODE, NSET=all\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=b\n1, 1, 2,\n3, 4\n"
      "*NSET, NSET=a, GENERATE\n1, 3, 2\n*NSET, NSET=c\na, 2\n");
  // Triangles and cells that are points or lines, repeated, far away, or of nodes that lie on one another.
  for (const int how : {0, 16, 32, 64, 112}) {
    add(4 + how, "v 0 0 0\nf 1 1 1\n");
    add(4 + how, "v 0 0 0\nv 1 0 0\nf 1 2 1\nf 2 2 1\n");
    add(4 + how, "v 0 0 0\nv 0 0 0\nv 0 0 0\nv 9 9 9\nf 1 2 3\nf 1 2 3\n");
    add(4 + how, "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    add(4 + how, "v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nv 0 0 1e300\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    add(3 + how,
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\n"
        "endfacet\nendsolid s\n");
    add(2 + how, small_vtk_4);
    add(1 + how, small_msh_2);
  }
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return change_text(data, size, max_size, seed, 1, words);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script script(data, size);
  const std::uint8_t how = script.byte();
  const Input rest = script.rest();
  std::string text(rest.begin(), rest.end());
  const auto reader = how & 15;
  if (reader == 8) text = sealed(text);
  try {
    if (reader == 0 || reader == 8) {
      const std::string written = write_mesh_text(read_mesh_text(text, "mesh.txt"));
      require(write_mesh_text(read_mesh_text(written, "mesh.txt")) == written, "a round trip");
      return 0;
    }
    const Read read = readers[reader] ? readers[reader] : meshes::read_obj;
    const meshes::RawMesh raw = read(text, "file");
    const auto n = static_cast<std::int32_t>(raw.nodes.size());
    for (const auto& cell : raw.tetrahedra)
      for (const std::int32_t node : cell) require(node >= 0 && node < n, "corners are nodes");
    for (const auto& triangle : raw.triangles)
      for (const std::int32_t node : triangle) require(node >= 0 && node < n, "corners are nodes");
    for (const auto& [name, nodes] : raw.groups)
      for (const std::int32_t node : nodes) require(node >= 0 && node < n, "groups are of nodes");
    check_mesh(raw, how);
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() > 10, "an error in words");
  }
  return 0;
}
