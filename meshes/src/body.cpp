#include "body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "coincident_nodes.hpp"
#include "coordinates.hpp"
#include "topology.hpp"

namespace phynness::meshes {
namespace {

// Relative to the cube of the longest edge. Coordinates that were stored as float give a flat cell a volume of about
// 1e-7, and no solver can use a cell as flat as this.
constexpr double zero_volume = 1e-9;

/// Tested cells, with a method that drops cells and the nodes that only these use.
struct Body {
  const std::string& source;
  MeshResult result;
  std::vector<std::int32_t> file_number;  // of each node: position in the node list of the file

  Mesh& mesh() { return result.mesh; }
  void note(const std::string& text) { result.notes.push_back(text); }

  /// Keeps the cells for which `keep` returns true, in their order, and the nodes that they use.
  template <class Keep>
  std::vector<std::int32_t> reduce(Keep keep) {
    Cells cells(mesh().cells.rows(), 4);
    Eigen::Index n_cells = 0;
    for (Eigen::Index c = 0; c < mesh().cells.rows(); ++c)
      if (keep(c)) cells.row(n_cells++) = mesh().cells.row(c);
    cells.conservativeResize(n_cells, 4);
    std::vector<std::int32_t> position(static_cast<std::size_t>(mesh().nodes.rows()), -1), dropped;
    for (Eigen::Index i = 0; i < cells.size(); ++i) position[cells.data()[i]] = 0;
    std::int32_t n = 0;
    for (std::int32_t i = 0; i < mesh().nodes.rows(); ++i) {
      if (position[i] < 0) {
        dropped.push_back(file_number[i]);
        continue;
      }
      mesh().nodes.row(n) = mesh().nodes.row(i);
      file_number[n] = file_number[i];
      position[i] = n++;
    }
    mesh().nodes.conservativeResize(n, 3);
    file_number.resize(static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < cells.size(); ++i) cells.data()[i] = position[cells.data()[i]];
    mesh().cells = std::move(cells);
    for (auto group = mesh().groups.begin(); group != mesh().groups.end();) {
      auto& nodes = group->second;
      for (auto& node : nodes) node = position[node];
      std::erase(nodes, -1);
      if (nodes.empty()) note("group '" + group->first + "' is empty after unused nodes were dropped");
      group = nodes.empty() ? mesh().groups.erase(group) : std::next(group);
    }
    return dropped;
  }
};

std::string cell_nodes(const Body& body, Eigen::Index c) {
  std::string text = "nodes";
  for (int k = 0; k < 4; ++k) text += ' ' + std::to_string(body.file_number[body.result.mesh.cells(c, k)]);
  return text;
}

void orient_cells(Body& body) {
  std::vector<std::int32_t> negative;
  Mesh& mesh = body.mesh();
  for (std::int32_t c = 0; c < mesh.n_cells(); ++c) {
    const auto cell = mesh.cells.row(c);
    const Eigen::RowVector3d a = mesh.nodes.row(cell(0)), u = mesh.nodes.row(cell(1)) - a,
                             v = mesh.nodes.row(cell(2)) - a, w = mesh.nodes.row(cell(3)) - a;
    for (int k = 0; k < 4; ++k)
      require_coordinates(mesh.nodes.row(cell(k)), body.source + ": a node of cell " + std::to_string(c),
                          body.file_number[cell(k)]);
    const double longest2 = std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm(), (u - v).squaredNorm(),
                                      (v - w).squaredNorm(), (w - u).squaredNorm()});
    const double six_volumes = u.dot(v.cross(w));
    if (!(std::abs(six_volumes) > zero_volume * longest2 * std::sqrt(longest2))) {
      std::ostringstream value;
      value << cell_nodes(body, c) << ", volume " << six_volumes / 6 << " m^3";
      throw input_error(body.source + ": cell " + std::to_string(c) + " has no volume", value.str(),
                        "mesh the body again without flat tetrahedra");
    }
    if (six_volumes < 0) negative.push_back(c);
  }
  for (const std::int32_t c : negative) std::swap(mesh.cells(c, 2), mesh.cells(c, 3));
  if (negative.empty()) return;
  if (static_cast<std::int32_t>(negative.size()) == mesh.n_cells())
    body.note("flipped all " + std::to_string(mesh.n_cells()) +
              " cells: the file numbers their nodes in the opposite order");
  else
    body.note("flipped " + counted(negative.size(), "cell", "cells") + " of " + std::to_string(mesh.n_cells()) +
              " whose nodes were numbered in the opposite order: " + first_few(negative));
}

/// After the merge of nodes, a cell may be smaller than the tolerance for coincident nodes.
void require_corners(const Body& body) {
  const Cells& cells = body.result.mesh.cells;
  for (Eigen::Index c = 0; c < cells.rows(); ++c)
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < i; ++k)
        if (cells(c, i) == cells(c, k))
          throw input_error(
              body.source + ": a cell is so small that the merge of coincident nodes makes it a point or a line",
              "cell " + std::to_string(c), "remove the cell, or merge the nodes and export again");
}

void require_one_component(Body& body, bool repair) {
  Mesh& mesh = body.mesh();
  CellTopology topology = cell_topology(mesh.cells, mesh.nodes.rows());
  const std::vector<std::int32_t> first = coincident_nodes(mesh.nodes);
  std::vector<std::int32_t> twins = repeated(first);
  for (auto& node : twins) node = body.file_number[node];
  const std::string twins_text =
      counted(twins.size(), "node lies", "nodes lie") + " exactly on another node (" + first_few(twins) + ")";
  if (topology.component_sizes.size() > 1 && repair && !twins.empty()) {
    for (Eigen::Index i = 0; i < mesh.cells.size(); ++i) mesh.cells.data()[i] = first[mesh.cells.data()[i]];
    for (auto& [name, nodes] : mesh.groups) {
      for (auto& node : nodes) node = first[node];
      std::sort(nodes.begin(), nodes.end());
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    }
    require_corners(body);
    body.reduce([](Eigen::Index) { return true; });
    body.note("repair: merged coincident nodes: " + twins_text);
    topology = cell_topology(mesh.cells, mesh.nodes.rows());
  } else if (!twins.empty() && topology.component_sizes.size() == 1) {
    body.result.warnings.push_back(twins_text + ": the body has a slit there, unless the nodes should be merged");
  }
  const auto list = [&](const std::vector<std::int32_t>& cells) { return first_few(cells); };
  if (!topology.crowded_cells.empty())
    throw input_error(body.source + ": more than two cells share a face",
                      counted(topology.crowded_cells.size(), "cell", "cells") + ": " + list(topology.crowded_cells),
                      "remove repeated or overlapping cells");
  if (!topology.folded_cells.empty())
    throw input_error(body.source + ": cells are inverted: they lie on the same side of a face as their neighbour",
                      counted(topology.folded_cells.size(), "cell", "cells") + ": " + list(topology.folded_cells),
                      "mesh the body again; overlapping cells cannot be solved");
  if (topology.component_sizes.size() < 2) return;
  const std::string components = describe_components(topology.component_sizes, "cells");
  if (!repair)
    throw input_error(
        body.source + ": the body is not in one piece", components + (twins.empty() ? "" : "; " + twins_text),
        twins.empty() ? "keep one piece, or set mesh.repair = true to keep the largest"
                      : "merge coincident nodes and export again, or set mesh.repair = true to merge them here");
  const auto largest = std::max_element(topology.component_sizes.begin(), topology.component_sizes.end());
  const auto keep = static_cast<std::int32_t>(largest - topology.component_sizes.begin());
  body.reduce([&](Eigen::Index c) { return topology.component[c] == keep; });
  body.note("repair: kept the largest of " + components);
}

}  // namespace

MeshResult checked_body(const RawMesh& raw, double scale_to_m, bool repair, const std::string& source) {
  Body body{source, {}, std::vector<std::int32_t>(raw.nodes.size())};
  Mesh& mesh = body.mesh();
  body.result.notes = raw.notes;
  std::iota(body.file_number.begin(), body.file_number.end(), 0);
  mesh.nodes.resize(static_cast<Eigen::Index>(raw.nodes.size()), 3);
  for (std::size_t i = 0; i < raw.nodes.size(); ++i)
    for (int k = 0; k < 3; ++k) mesh.nodes(static_cast<Eigen::Index>(i), k) = raw.nodes[i][k] * scale_to_m;
  mesh.cells.resize(static_cast<Eigen::Index>(raw.tetrahedra.size()), 4);
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
    for (int k = 0; k < 4; ++k) mesh.cells(static_cast<Eigen::Index>(c), k) = raw.tetrahedra[c][k];
  mesh.groups = raw.groups;
  if (raw.tetrahedra.empty())
    throw input_error(source + ": holds no tetrahedra", counted(raw.nodes.size(), "node", "nodes"),
                      "mesh the body and export it again");

  if (const auto dropped = body.reduce([](Eigen::Index) { return true; }); !dropped.empty())
    body.note("dropped " + counted(dropped.size(), "unreferenced node", "unreferenced nodes") +
              " (numbers in the file's list, from 0): " + first_few(dropped, 20));
  orient_cells(body);
  require_one_component(body, repair);
  mesh.surface = boundary_triangles(mesh.cells);
  SurfaceTopology surface = surface_topology(mesh.surface);
  for (auto& node : surface.pinched_nodes) node = body.file_number[node];
  for (auto* edges : {&surface.open_edges, &surface.non_manifold_edges})
    for (auto& edge : *edges)
      for (auto& node : edge) node = body.file_number[node];
  if (const std::string defects = describe_defects(surface, false); !defects.empty())
    throw input_error(
        source + ": the body's surface is not a closed manifold", defects,
        "the body touches itself along an edge or at a node: thicken or separate it there and mesh it again");

  body.result.quality = measure_quality(mesh);
  const QualityReport& quality = body.result.quality;
  if (quality.n_slivers > 0) {
    std::ostringstream text;
    text.precision(2);
    text << counted(static_cast<std::size_t>(quality.n_slivers), "sliver", "slivers") << ", worst quality "
         << quality.min_quality << " in cell " << quality.worst_cell;
    body.result.warnings.push_back(text.str());
  }
  warn_of_size(body.result, scale_to_m);
  return std::move(body.result);
}

}  // namespace phynness::meshes
