// Any bytes as a mesh: mesh.txt, .msh, .vtk, .stl, .obj. Read, or an Error in words. Input: a byte (which
// reader; bit 3: put the right checksum, of mesh.txt), the file.
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>

#include "../meshes/small_files.hpp"
#include "raw_mesh.hpp"
#include "texts.hpp"

namespace phynness::fuzz {
namespace {

const std::vector<std::string_view> words = {"0",
                                             "1",
                                             "2",
                                             "3",
                                             "4",
                                             "5",
                                             "10",
                                             "-1",
                                             "2147483647",
                                             "2147483648",
                                             "4294967295",
                                             "9223372036854775807",
                                             "1e30",
                                             "1e308",
                                             "nan",
                                             "inf",
                                             "1p+0",
                                             "1p+1023",
                                             "0p+0",
                                             "1p-1074",
                                             "phynness-mesh",
                                             "hash",
                                             "nodes",
                                             "cells",
                                             "surface",
                                             "fixed",
                                             "group",
                                             "checksum",
                                             "$MeshFormat",
                                             "$EndMeshFormat",
                                             "$Nodes",
                                             "$EndNodes",
                                             "$Elements",
                                             "$EndElements",
                                             "$Entities",
                                             "$EndEntities",
                                             "$PhysicalNames",
                                             "$EndPhysicalNames",
                                             "2.2",
                                             "4.1",
                                             "ASCII",
                                             "BINARY",
                                             "DATASET",
                                             "POINTS",
                                             "CELLS",
                                             "CELL_TYPES",
                                             "OFFSETS",
                                             "CONNECTIVITY",
                                             "vtktypeint64",
                                             "double",
                                             "float",
                                             "solid",
                                             "facet",
                                             "vertex",
                                             "endfacet",
                                             "v",
                                             "f",
                                             "f 1/2/3 2//3 -1",
                                             "g",
                                             ""};

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

}  // namespace

std::vector<Input> seeds() {
  using namespace phynness::test;
  std::vector<Input> all;
  const auto add = [&](int reader, const std::string& text) {
    Input& input = all.emplace_back();
    input.push_back(static_cast<std::uint8_t>(reader));
    append_text(input, text);
  };
  add(8, write_mesh_text(small_mesh(), {0, 1}));
  add(0, write_mesh_text(small_mesh()));
  for (const auto& text : {small_msh_1, small_msh_2, small_msh_4, small_msh_2_binary(false),
                           small_msh_2_binary(true), small_msh_4_binary(false), small_msh_4_binary(true)})
    add(1, text);
  for (const auto& text : {small_vtk_4, small_vtk_5}) add(2, text);
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
  if (how & 8) text = sealed(text);
  try {
    const auto reader = how & 7;
    if (reader == 0) {
      std::vector<std::int32_t> fixed;
      const Mesh mesh = read_mesh_text(text, "mesh.txt", &fixed);
      const std::string written = write_mesh_text(mesh, fixed);
      require(write_mesh_text(read_mesh_text(written, "mesh.txt", &fixed), fixed) == written, "a round trip");
      return 0;
    }
    const auto read = reader == 1   ? meshes::read_msh
                      : reader == 2 ? meshes::read_vtk
                      : reader == 3 ? meshes::read_stl
                                    : meshes::read_obj;
    const meshes::RawMesh raw = read(text, "file");
    const auto n = static_cast<std::int32_t>(raw.nodes.size());
    for (const auto& cell : raw.tetrahedra)
      for (const std::int32_t node : cell) require(node >= 0 && node < n, "corners are nodes");
    for (const auto& triangle : raw.triangles)
      for (const std::int32_t node : triangle) require(node >= 0 && node < n, "corners are nodes");
    for (const auto& [name, nodes] : raw.groups)
      for (const std::int32_t node : nodes) require(node >= 0 && node < n, "groups are of nodes");
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() > 10, "an error in words");
  }
  return 0;
}
