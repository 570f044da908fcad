#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>
#include <set>
#include <sstream>

#include "read/file_mesh.hpp"

namespace phynness::meshes {
namespace {

// Relative to the cube of the longest edge. Coordinates that were stored as float give a flat cell a volume of about
// 1e-7, and no solver can use a cell as flat as this.
constexpr double zero_volume = 1e-9;
// Four corners of one face, which need not be plane. Cells that a mesh lacks are above 0.08.
constexpr double flat_volume = 0.01;

/// Six volumes with sign, and the longest edge.
std::pair<double, double> volume_and_edge(const RawMesh& raw, const Tetrahedron& cell) {
  const auto x = [&](int k) { return Eigen::Map<const Eigen::RowVector3d>(raw.nodes[cell[k]].data()); };
  const Eigen::RowVector3d u = x(1) - x(0), v = x(2) - x(0), w = x(3) - x(0);
  const double longest2 = std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm(), (u - v).squaredNorm(),
                                    (v - w).squaredNorm(), (w - u).squaredNorm()});
  return {u.dot(v.cross(w)), std::sqrt(longest2)};
}

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
    const auto [six_volumes, longest] = volume_and_edge(raw, cell);
    if (!(std::abs(six_volumes) > zero_volume * longest * longest * longest)) {
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

Triangles surface_of(const RawMesh& raw) {
  return boundary_triangles(Eigen::Map<const Cells>(raw.tetrahedra.front().data(), std::ssize(raw.tetrahedra), 4));
}

/// The cells of each group, which are found by their corners. Groups without any of them are left out.
std::map<std::string, std::vector<std::int32_t>> groups_of_cells(const RawMesh& raw) {
  if (raw.cell_groups.empty()) return {};
  const auto sorted = [](const auto& cell) {
    Tetrahedron corners;
    std::copy(cell.begin(), cell.end(), corners.begin());
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  std::map<Tetrahedron, std::int32_t> numbers;
  for (const auto& cell : raw.tetrahedra) numbers.emplace(sorted(cell), static_cast<std::int32_t>(numbers.size()));
  std::map<std::string, std::vector<std::int32_t>> groups;
  for (const auto& [name, cells] : raw.cell_groups)
    for (const auto& cell : cells)
      if (const auto found = numbers.find(sorted(cell)); found != numbers.end()) groups[name].push_back(found->second);
  for (auto& [name, cells] : groups) sort_unique(cells);
  return groups;
}

/// Where one neighbour divides a face with four corners along one diagonal and the other one along the other, all four
/// triangles are on the surface of a flat void.
void require_matching_faces(const RawMesh& raw, const std::string& source) {
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  std::set<Triangle> faces;
  std::map<Edge, std::vector<std::int32_t>> opposite;
  const Triangles surface = surface_of(raw);
  for (const auto& t : surface.rowwise()) {
    faces.insert(sorted({t(0), t(1), t(2)}));
    for (int k = 0; k < 3; ++k) opposite[edge_of(t(k), t((k + 1) % 3))].push_back(t((k + 2) % 3));
  }
  std::set<Tetrahedron> crossed;
  for (const auto& [edge, nodes] : opposite)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Tetrahedron quad{edge[0], edge[1], nodes[i], nodes[j]};
        const auto [six_volumes, longest] = volume_and_edge(raw, quad);
        if (!faces.contains(sorted({quad[0], quad[2], quad[3]})) ||
            !faces.contains(sorted({quad[1], quad[2], quad[3]})) ||
            std::abs(six_volumes) > flat_volume * longest * longest * longest)
          continue;
        std::sort(quad.begin(), quad.end());
        crossed.insert(quad);
      }
  if (!crossed.empty())
    throw input_error(source + ": faces of neighbouring cells do not match: they are split along different diagonals",
                      counted(crossed.size(), "place", "places") + ", first " + cell_nodes(raw, *crossed.begin()),
                      "mesh the body again, or give its hexahedra, which are split along matching diagonals here");
}

/// Pieces that have only nodes in common become one if these are not on a line. @return the nodes at which others touch
NodeList join_pieces(const RawMesh& raw, Components& pieces) {
  const Mesh mesh{to_points(raw.nodes), Cells(0, 4), {}, {}};
  std::vector<std::set<std::int32_t>> at(raw.nodes.size());
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
    for (const auto node : raw.tetrahedra[c]) at[node].insert(pieces.component[c]);
  const auto rename = [&](std::int32_t from, std::int32_t to) {
    std::replace(pieces.component.begin(), pieces.component.end(), from, to);
    for (auto& list : at)
      if (list.erase(from) > 0) list.insert(to);
  };
  while (true) {
    std::map<Edge, NodeList> common;
    for (std::int32_t node = 0; node < std::ssize(at); ++node)
      for (const auto first : at[node])
        for (const auto second : at[node])
          if (first < second) common[{first, second}].push_back(node);
    const auto held = std::find_if(common.begin(), common.end(),
                                   [&](const auto& entry) { return hold_the_body(mesh, entry.second); });
    if (held == common.end()) {
      NodeList joints;
      for (const auto& [pair, nodes] : common)
        for (const auto node : nodes) joints.push_back(raw.file_number[node]);
      sort_unique(joints);
      return joints;
    }
    auto& sizes = pieces.component_sizes;
    const auto [kept, gone] = held->first;
    sizes[kept] += sizes[gone];
    sizes[gone] = sizes.back();
    rename(gone, kept);
    rename(static_cast<std::int32_t>(sizes.size()) - 1, gone);
    sizes.pop_back();
  }
}

/// @param near  about nodes that are near to each other
void require_one_piece(RawMesh& raw, const std::string& near, bool repair, const std::string& source,
                       std::vector<std::string>& warnings) {
  CellTopology topology = cell_topology(raw.tetrahedra);
  const auto list = [](const std::vector<std::int32_t>& cells) {
    return counted(cells.size(), "cell", "cells") + ": " + first_few(cells);
  };
  if (!topology.crowded_cells.empty())
    throw input_error(source + ": more than two cells share a face", list(topology.crowded_cells),
                      "remove overlapping cells");
  if (!topology.folded_cells.empty())
    throw input_error(source + ": cells are inverted: they lie on the same side of a face as their neighbour",
                      list(topology.folded_cells), "mesh the body again; overlapping cells cannot be solved");
  require_matching_faces(raw, source);
  const NodeList joints = topology.component_sizes.size() > 1 ? join_pieces(raw, topology) : NodeList();
  if (topology.component_sizes.size() < 2) {
    if (!near.empty()) warnings.push_back("the body has a slit there, unless the nodes should be merged: " + near);
    return;
  }
  if (!repair)
    throw input_error(source + ": the body is not in one piece",
                      describe_components(topology.component_sizes, "cells") +
                          (joints.empty() ? "" : "; they turn about what they share: nodes " + first_few(joints)) +
                          (near.empty() ? "" : "; " + near),
                      near.empty() ? "join the pieces, or set mesh.repair = true to keep the largest"
                                   : "set mesh.repair = true, or merge the nodes and export again");
  std::vector<double> volumes;
  for (const auto& cell : raw.tetrahedra) volumes.push_back(volume_and_edge(raw, cell).first / 6);
  keep_largest(raw.tetrahedra, topology, "cells", volumes, "m^3", raw.notes);
  drop_unused_nodes(raw);
}

}  // namespace

MeshResult checked_body(RawMesh raw, double scale_to_m, bool repair, const std::string& source) {
  if (raw.tetrahedra.empty())
    throw input_error(source + ": holds no tetrahedra", counted(raw.nodes.size(), "node", "nodes"),
                      "mesh the body and export it again");
  raw.triangles.clear();
  scale(raw, scale_to_m);
  drop_unreferenced_nodes(raw);
  const std::string near = join_near_nodes(raw, repair);
  orient_cells(raw, source);
  MeshResult result;
  require_one_piece(raw, near, repair, source, result.warnings);
  Mesh& mesh = result.mesh;
  mesh.nodes = to_points(raw.nodes);
  mesh.cells = Eigen::Map<const Cells>(raw.tetrahedra.front().data(), std::ssize(raw.tetrahedra), 4);
  mesh.surface = surface_of(raw);
  mesh.groups = std::move(raw.groups);
  mesh.cell_groups = groups_of_cells(raw);
  result.notes = std::move(raw.notes);
  if (const std::string touching = describe_defects(surface_topology(mesh.surface), false, raw.file_number);
      !touching.empty())
    result.warnings.push_back("the body touches itself, and is joined there by these nodes alone: " + touching +
                              "; forces and stresses near them depend on the size of the cells");
  result.quality = measure_quality(mesh);
  warn_of_shape(result, "cell");
  return result;
}

}  // namespace phynness::meshes
