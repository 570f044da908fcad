// Reading and writing of mesh.txt by one grammar (formats/mesh.md).
#include <phynness/formats/mesh.hpp>

#include "text/text_lines_reader.hpp"
#include "text/text_lines_writer.hpp"

namespace phynness {
namespace {

constexpr char first_line[] = "phynness-mesh 1\n";
static_assert(std::string_view(first_line).starts_with(mesh_text_magic));

class MeshWriter : public TextLinesWriter {
 public:
  MeshWriter() : TextLinesWriter(first_line) {}
  void text(const std::string& group) {
    if (group.empty() || group.find_first_of("\r\n") != std::string::npos)
      throw input_error("the name of a physical group is empty or contains a line break", group, "rename the group");
    put(group);
    end();
  }
};

template <class IO, class Store>
void rows_of_nodes(IO& io, const char* what, Store& store, std::int32_t n, std::int32_t columns, const Mesh& mesh) {
  io.shape(what, store, n, columns);
  for (std::int32_t i = 0; i < n; ++i) {
    for (std::int32_t k = 0; k < columns; ++k) schema::integer(io, what, store, i, k, 0, mesh.n_nodes() - 1);
    io.end();
  }
}

template <class IO, class Name, class Nodes>
void group_lines(IO& io, Name& name, Nodes& nodes, const Mesh& mesh) {
  auto n = static_cast<std::int32_t>(nodes.size());
  io.keyword("group");
  io.count("nodes of a group", n, 0);
  io.text(name);
  io.require(!name.empty(), "a group has no name");
  rows_of_nodes(io, "node of a group", nodes, n, 1, mesh);
}
void groups(MeshWriter& io, const Mesh& mesh) {
  for (const auto& [name, nodes] : mesh.groups) group_lines(io, name, nodes, mesh);
}
void groups(TextLinesReader& io, Mesh& mesh) {
  while (io.optional("group", false)) {
    std::string name;
    std::vector<std::int32_t> nodes;
    group_lines(io, name, nodes, mesh);
    mesh.groups[name] = std::move(nodes);
  }
}

/// Meshes without regions have no such lines.
template <class IO>
void region_lines(IO& io, std::vector<std::int32_t>& regions, std::int32_t n_cells) {
  if (!io.optional("regions", !regions.empty())) return;
  io.keyword("regions");
  io.end();
  io.shape("regions", regions, n_cells, 1);
  for (std::int32_t cell = 0; cell < n_cells; ++cell) {
    schema::integer(io, "region of a cell", regions, cell, 0, 0, 255);
    io.end();
  }
}

/// @param hash  of the mesh
template <class IO, class AnyMesh>
void mesh_lines(IO& io, AnyMesh& mesh, std::string& hash, std::vector<std::int32_t>& regions) {
  io.keyword("hash");
  io.word("hash", hash);
  io.end();
  const auto n_nodes = schema::count_line(io, "nodes", mesh.nodes.rows());
  schema::rows_of_numbers(io, "coordinate", mesh.nodes, n_nodes, 3, schema::any_number);
  std::int32_t n_cells = mesh.n_cells();
  auto n_corners = static_cast<std::int32_t>(mesh.cells.cols());
  io.keyword("cells");
  io.count("cells", n_cells, 0);
  io.integer("number of corners", n_corners, 3, 4);
  io.end();
  rows_of_nodes(io, "corner of a cell", mesh.cells, n_cells, n_corners, mesh);
  const auto n_triangles = schema::count_line(io, "surface", mesh.surface.rows());
  rows_of_nodes(io, "corner of the surface", mesh.surface, n_triangles, 3, mesh);
  std::vector<std::int32_t> fixed;  // there are none in files of this program
  const auto n_fixed = schema::count_line(io, "fixed", 0);
  rows_of_nodes(io, "fixed node", fixed, n_fixed, 1, mesh);
  groups(io, mesh);
  region_lines(io, regions, n_cells);
}

}  // namespace

std::string write_mesh_text(const Mesh& mesh) {
  MeshWriter writer;
  std::string hash = mesh_hash(mesh);
  std::vector<std::int32_t> regions(mesh.regions.begin(), mesh.regions.end());
  mesh_lines(writer, mesh, hash, regions);
  return writer.finished();
}

Mesh read_mesh_text(const std::string& text, const std::string& source_name) {
  TextLinesReader reader(checked_lines(first_line, text, source_name, "mesh"), source_name,
                         "write the file again with this software; it cannot be edited by hand");
  Mesh mesh;
  std::string hash;
  std::vector<std::int32_t> regions;
  mesh_lines(reader, mesh, hash, regions);
  mesh.regions.assign(regions.begin(), regions.end());
  reader.require_end();
  if (const std::string actual = mesh_hash(mesh); actual != hash)
    throw input_error(source_name + ": the mesh does not have the stored hash",
                      "hash " + hash + " instead of " + actual, "write the file again");
  return mesh;
}

}  // namespace phynness
