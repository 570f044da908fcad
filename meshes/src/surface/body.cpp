#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "read/file_mesh.hpp"

namespace phynness::meshes {
namespace {

// Relative to the cube of the longest edge. Coordinates that were stored as float give a flat cell a volume of about
// 1e-7, and no solver can use a cell as flat as this.
constexpr double zero_volume = 1e-9;

std::string cell_nodes(const RawMesh& raw, const Tetrahedron& cell) {
  std::string text = "nodes";
  for (const auto node : cell) text += ' ' + std::to_string(raw.file_number[node]);
  return text;
}

void orient_cells(RawMesh& raw, const std::string& source) {
  std::vector<std::int32_t> negative;
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c) {
    Tetrahedron& cell = raw.tetrahedra[c];
    for (const auto node : cell)
      require_coordinates(raw.nodes[node], source + ": a node of cell " + std::to_string(c), raw.file_number[node]);
    const auto x = [&](int k) { return Eigen::Map<const Eigen::RowVector3d>(raw.nodes[cell[k]].data()); };
    const Eigen::RowVector3d u = x(1) - x(0), v = x(2) - x(0), w = x(3) - x(0);
    const double longest2 = std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm(), (u - v).squaredNorm(),
                                      (v - w).squaredNorm(), (w - u).squaredNorm()});
    const double six_volumes = u.dot(v.cross(w));
    if (!(std::abs(six_volumes) > zero_volume * longest2 * std::sqrt(longest2))) {
      std::ostringstream value;
      value << cell_nodes(raw, cell) << ", volume " << six_volumes / 6 << " m^3";
      throw input_error(source + ": cell " + std::to_string(c) + " has no volume", value.str(),
                        "mesh the body again without flat tetrahedra");
    }
    if (six_volumes >= 0) continue;
    negative.push_back(static_cast<std::int32_t>(c));
    std::swap(cell[2], cell[3]);
  }
  const std::string all = std::to_string(raw.tetrahedra.size());
  if (negative.size() == raw.tetrahedra.size())
    raw.notes.push_back("flipped all " + all + " cells: the file numbers their nodes in the opposite order");
  else if (!negative.empty())
    raw.notes.push_back("flipped " + counted(negative.size(), "cell", "cells") + " of " + all +
                        " whose nodes were numbered in the opposite order: " + first_few(negative));
}

/// After the merge of nodes, a cell may be smaller than the tolerance for coincident nodes.
void require_corners(const RawMesh& raw, const std::string& source) {
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c) {
    Tetrahedron cell = raw.tetrahedra[c];
    std::sort(cell.begin(), cell.end());
    if (std::adjacent_find(cell.begin(), cell.end()) != cell.end())
      throw input_error(source + ": a cell is so small that the merge of coincident nodes makes it a point or a line",
                        "cell " + std::to_string(c), "remove the cell, or merge the nodes and export again");
  }
}

/// @return a warning about coincident nodes, if there is one
std::string require_one_component(RawMesh& raw, bool repair, const std::string& source) {
  const auto topology_of = [&raw] { return cell_topology(raw.tetrahedra, raw.nodes.size()); };
  CellTopology topology = topology_of();
  const std::vector<std::int32_t> first = coincident_nodes(to_points(raw.nodes));
  const std::string twins = describe_twins(raw, first);
  const bool one_piece = topology.component_sizes.size() == 1;
  if (!one_piece && repair && !twins.empty()) {
    merge_nodes(raw, first);
    require_corners(raw, source);
    drop_unused_nodes(raw);
    topology = topology_of();
  }
  const auto list = [](const std::vector<std::int32_t>& cells) {
    return counted(cells.size(), "cell", "cells") + ": " + first_few(cells);
  };
  if (!topology.crowded_cells.empty())
    throw input_error(source + ": more than two cells share a face", list(topology.crowded_cells),
                      "remove repeated or overlapping cells");
  if (!topology.folded_cells.empty())
    throw input_error(source + ": cells are inverted: they lie on the same side of a face as their neighbour",
                      list(topology.folded_cells), "mesh the body again; overlapping cells cannot be solved");
  if (topology.component_sizes.size() < 2)
    return one_piece && !twins.empty() ? twins + ": the body has a slit there, unless the nodes should be merged" : "";
  if (!repair)
    throw input_error(source + ": the body is not in one piece",
                      describe_components(topology.component_sizes, "cells") + (twins.empty() ? "" : "; " + twins),
                      twins.empty()
                          ? "keep one piece, or set mesh.repair = true to keep the largest"
                          : "merge coincident nodes and export again, or set mesh.repair = true to merge them here");
  keep_largest(raw.tetrahedra, topology.component, topology.component_sizes, "cells", raw.notes);
  drop_unused_nodes(raw);
  return "";
}

}  // namespace

MeshResult checked_body(RawMesh raw, double scale_to_m, bool repair, const std::string& source) {
  if (raw.tetrahedra.empty())
    throw input_error(source + ": holds no tetrahedra", counted(raw.nodes.size(), "node", "nodes"),
                      "mesh the body and export it again");
  raw.triangles.clear();
  scale(raw, scale_to_m);
  drop_unreferenced_nodes(raw);
  orient_cells(raw, source);
  MeshResult result;
  if (const std::string slit = require_one_component(raw, repair, source); !slit.empty())
    result.warnings.push_back(slit);
  Mesh& mesh = result.mesh;
  mesh.nodes = to_points(raw.nodes);
  mesh.cells = Eigen::Map<const Cells>(raw.tetrahedra.front().data(), std::ssize(raw.tetrahedra), 4);
  mesh.surface = boundary_triangles(mesh.cells);
  mesh.groups = std::move(raw.groups);
  result.notes = std::move(raw.notes);
  SurfaceTopology surface = surface_topology(mesh.surface);
  for (auto& node : surface.pinched_nodes) node = raw.file_number[node];
  for (auto* edges : {&surface.open_edges, &surface.non_manifold_edges})
    for (auto& edge : *edges)
      for (auto& node : edge) node = raw.file_number[node];
  if (const std::string defects = describe_defects(surface, false); !defects.empty())
    throw input_error(
        source + ": the body's surface is not a closed manifold", defects,
        "the body touches itself along an edge or at a node: thicken or separate it there and mesh it again");
  result.quality = measure_quality(mesh);
  warn_of_shape_and_size(result, "cell", scale_to_m);
  return result;
}

}  // namespace phynness::meshes
