#include <charconv>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/meshes/meshes.hpp>

namespace phynness {
namespace {

using Groups = std::map<std::string, std::vector<std::int32_t>>;

/// Physical groups of all triangles and of all tetrahedra. meshio reads a file only if every block has a physical tag
/// or none has one.
constexpr const char *surface_group = "phynness_surface", *body_group = "phynness_body";

template <class Number>
void append(std::string& text, Number value) {
  char buffer[40];
  // Without a format argument to_chars writes the shortest decimal from which the same double is read.
  const char* end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, static_cast<std::size_t>(end - buffer));
}

/// Writes numbers separated by spaces, then a line break.
template <class... Numbers>
void line(std::string& text, Numbers... numbers) {
  bool first = true;
  ((first ? void() : void(text += ' '), first = false, append(text, numbers)), ...);
  text += '\n';
}

bool is_solid(const Mesh& mesh) { return mesh.cells.cols() == 4; }
/// Volumes of a mesh: the body and its regions; none of a shell.
int n_volumes(const Mesh& mesh) {
  if (!is_solid(mesh)) return 0;
  return mesh.regions.empty() ? 1 : 1 + *std::max_element(mesh.regions.begin(), mesh.regions.end());
}
int volume_of(const Mesh& mesh, Eigen::Index c) {
  return mesh.regions.empty() ? 1 : 1 + mesh.regions[static_cast<std::size_t>(c)];
}

void append_names(std::string& text, const Mesh& mesh, const Groups& groups) {
  text += "$PhysicalNames\n";
  line(text, groups.size() + 1 + static_cast<std::size_t>(n_volumes(mesh)));
  int tag = 0;
  for (const auto& [name, nodes] : groups) {
    if (name.find_first_of("\"\r\n") != std::string::npos)
      throw input_error("a physical group's name holds a quote or a line break", name, "rename the group");
    text += "0 " + std::to_string(++tag) + " \"" + name + "\"\n";
  }
  text += "2 " + std::to_string(++tag) + " \"" + surface_group + "\"\n";
  for (int v = 0; v < n_volumes(mesh); ++v)
    text += "3 " + std::to_string(++tag) + " \"" + (v == 0 ? body_group : region_group(static_cast<std::size_t>(v))) +
            "\"\n";
  text += "$EndPhysicalNames\n";
}

/// One point entity for each group, one surface, and the volumes of a solid.
void append_entities(std::string& text, const Mesh& mesh, const Groups& groups) {
  const Eigen::RowVector3d low = mesh.nodes.colwise().minCoeff(), high = mesh.nodes.colwise().maxCoeff();
  text += "$Entities\n";
  line(text, groups.size(), 0, 1, n_volumes(mesh));
  int tag = 0;
  for (const auto& [name, nodes] : groups) {
    const Eigen::RowVector3d x = mesh.nodes.row(nodes.empty() ? 0 : nodes.front());
    ++tag;
    line(text, tag, x(0), x(1), x(2), 1, tag);
  }
  line(text, 1, low(0), low(1), low(2), high(0), high(1), high(2), 1, ++tag, 0);
  for (int v = 1; v <= n_volumes(mesh); ++v)
    line(text, v, low(0), low(1), low(2), high(0), high(1), high(2), 1, ++tag, 1, 1);
  text += "$EndEntities\n";
}

void append_nodes(std::string& text, const Mesh& mesh) {
  const Eigen::Index n = mesh.nodes.rows();
  text += "$Nodes\n";
  line(text, 1, n, 1, n);
  line(text, is_solid(mesh) ? 3 : 2, 1, 0, n);  // all in one block, which keeps the order of the mesh
  for (Eigen::Index i = 1; i <= n; ++i) line(text, i);
  for (Eigen::Index i = 0; i < n; ++i) line(text, mesh.nodes(i, 0), mesh.nodes(i, 1), mesh.nodes(i, 2));
  text += "$EndNodes\n";
}

void append_elements(std::string& text, const Mesh& mesh, const Groups& groups) {
  std::size_t n_points = 0;
  for (const auto& [name, nodes] : groups) n_points += nodes.size();
  const auto n = n_points + static_cast<std::size_t>(mesh.surface.rows() + (is_solid(mesh) ? mesh.cells.rows() : 0));
  std::size_t tag = 0;
  text += "$Elements\n";
  // Blocks of successive cells of a volume, which keep the order of the mesh.
  std::vector<Eigen::Index> blocks;
  for (Eigen::Index c = 0; is_solid(mesh) && c < mesh.cells.rows(); ++c)
    if (c == 0 || volume_of(mesh, c) != volume_of(mesh, c - 1)) blocks.push_back(c);
  line(text, groups.size() + 1 + blocks.size(), n, 1, n);
  blocks.push_back(mesh.cells.rows());
  int group = 0;
  for (const auto& [name, nodes] : groups) {
    line(text, 0, ++group, 15, nodes.size());
    for (const std::int32_t node : nodes) line(text, ++tag, node + 1);
  }
  line(text, 2, 1, 2, mesh.surface.rows());
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t)
    line(text, ++tag, mesh.surface(t, 0) + 1, mesh.surface(t, 1) + 1, mesh.surface(t, 2) + 1);
  for (std::size_t b = 0; b + 1 < blocks.size(); ++b) {
    line(text, 3, volume_of(mesh, blocks[b]), 4, blocks[b + 1] - blocks[b]);
    for (Eigen::Index c = blocks[b]; c < blocks[b + 1]; ++c)
      line(text, ++tag, mesh.cells(c, 0) + 1, mesh.cells(c, 1) + 1, mesh.cells(c, 2) + 1, mesh.cells(c, 3) + 1);
  }
  text += "$EndElements\n";
}

}  // namespace

void write_msh(const Mesh& mesh, const NodeSets* sets, const std::filesystem::path& file) {
  if ((mesh.cells.cols() != 4 && mesh.cells.cols() != 3) || mesh.cells.rows() == 0)
    throw input_error("cannot write the mesh: it has neither tetrahedra nor triangles", file.string(),
                      "give a mesh of 4-node or 3-node cells");
  Groups groups = mesh.groups;
  if (sets) {
    groups["phynness_fixed"] = sets->fixed;
    groups["phynness_active"] = sets->active;
    groups["phynness_output"] = sets->output;
  }
  std::erase_if(groups, [](const auto& group) {
    return group.second.empty() || group.first == surface_group || group.first == body_group ||
           group.first.starts_with(region_group_prefix);
  });
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  append_names(text, mesh, groups);
  append_entities(text, mesh, groups);
  append_nodes(text, mesh);
  append_elements(text, mesh, groups);

  write_text_file(file, text);
}

}  // namespace phynness
