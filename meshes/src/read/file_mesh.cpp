#include "file_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "surface/geometry.hpp"

namespace phynness::meshes {
namespace {

// Relative to the bounding box; closer nodes are coincident.
constexpr double coincident = 1e-9;

std::int32_t file_number(const RawMesh& raw, std::int32_t node) {
  return raw.file_number.empty() ? node : raw.file_number[node];
}

}  // namespace

void require_coordinates(const std::array<double, 3>& x, const std::string& where, std::int64_t node) {
  const Eigen::Map<const Eigen::RowVector3d> point(x.data());
  if (!point.allFinite())
    throw input_error(where + " has coordinates that are not finite", "node " + std::to_string(node),
                      "export the mesh again");
  if (point.cwiseAbs().maxCoeff() <= largest_coordinate_m) return;
  std::ostringstream value;
  value << "node " << node << " at (" << x[0] << ", " << x[1] << ", " << x[2] << ") m";
  throw input_error(where + " has coordinates that are too large", value.str(),
                    "export the mesh again, or check mesh.scale_to_m");
}

void scale(RawMesh& raw, double scale_to_m) {
  for (auto& x : raw.nodes)
    for (double& value : x) value *= scale_to_m;
}

Points to_points(const std::vector<std::array<double, 3>>& nodes) {
  return Eigen::Map<const Points>(reinterpret_cast<const double*>(nodes.data()), std::ssize(nodes), 3);
}

void drop_useless_triangles(RawMesh& raw, std::vector<std::string>& notes) {
  const auto n =
      std::erase_if(raw.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[0] == t[2]; });
  if (n > 0) notes.push_back("dropped " + counted(n, "triangle", "triangles") + " with two equal corners");
}

std::vector<std::int32_t> drop_unused_nodes(RawMesh& raw) {
  std::vector<std::int32_t> position(raw.nodes.size(), -1), numbers, dropped;
  raw.for_each_corner([&](std::int32_t node) { position[node] = 0; });
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(position.size()); ++i) {
    (position[i] < 0 ? dropped : numbers).push_back(file_number(raw, i));
    if (position[i] < 0) continue;
    position[i] = static_cast<std::int32_t>(numbers.size()) - 1;
    raw.nodes[position[i]] = raw.nodes[i];
  }
  raw.nodes.resize(numbers.size());
  raw.file_number = std::move(numbers);
  raw.for_each_corner([&](std::int32_t& node) { node = position[node]; });
  for (auto& [name, nodes] : raw.groups) {
    for (auto& node : nodes) node = position[node];
    std::erase(nodes, -1);
    if (nodes.empty()) raw.notes.push_back("group '" + name + "' is empty after unused nodes were dropped");
  }
  std::erase_if(raw.groups, [](const auto& group) { return group.second.empty(); });
  return dropped;
}

void drop_unreferenced_nodes(RawMesh& raw) {
  if (const auto dropped = drop_unused_nodes(raw); !dropped.empty())
    raw.notes.push_back("dropped " + counted(dropped.size(), "unreferenced node", "unreferenced nodes") +
                        " (numbers in the file's list, from 0): " + first_few(dropped, 20));
}

std::vector<std::int32_t> coincident_nodes(const Points& nodes) {
  if (nodes.rows() == 0) return {};
  const double tolerance = coincident * extent_of(nodes).norm();
  std::vector<std::int32_t> by_x(static_cast<std::size_t>(nodes.rows())), first(by_x.size());
  std::iota(by_x.begin(), by_x.end(), 0);
  std::iota(first.begin(), first.end(), 0);
  std::sort(by_x.begin(), by_x.end(),
            [&](std::int32_t p, std::int32_t q) { return std::pair(nodes(p, 0), p) < std::pair(nodes(q, 0), q); });
  for (std::size_t i = 0; i < by_x.size(); ++i)
    for (std::size_t j = i + 1; j < by_x.size() && nodes(by_x[j], 0) - nodes(by_x[i], 0) <= tolerance; ++j)
      if ((nodes.row(by_x[i]) - nodes.row(by_x[j])).norm() <= tolerance) {
        const auto [low, high] = std::minmax(by_x[i], by_x[j]);
        first[high] = std::min(first[high], first[low]);
      }
  return first;
}

std::string describe_twins(const RawMesh& raw, const std::vector<std::int32_t>& first) {
  std::vector<std::int32_t> twins;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(first.size()); ++i)
    if (first[i] != i) twins.push_back(file_number(raw, i));
  if (twins.empty()) return "";
  return counted(twins.size(), "node lies", "nodes lie") + " exactly on another node (" + first_few(twins) + ")";
}

void merge_nodes(RawMesh& raw, const std::vector<std::int32_t>& first) {
  raw.for_each_corner([&](std::int32_t& node) { node = first[node]; });
  for (auto& [name, nodes] : raw.groups) {
    for (auto& node : nodes) node = first[node];
    sort_unique(nodes);
  }
  raw.notes.push_back("repair: merged coincident nodes: " + describe_twins(raw, first));
}

void warn_of_shape_and_size(MeshResult& result, const char* cell, double scale_to_m) {
  const QualityReport& quality = result.quality;
  std::ostringstream slivers, size;
  if (quality.n_slivers > 0) {
    slivers.precision(2);
    slivers << counted(static_cast<std::size_t>(quality.n_slivers), "sliver", "slivers") << ", worst quality "
            << quality.min_quality << " in " << cell << " " << quality.worst_cell;
    result.warnings.push_back(slivers.str());
  }
  const double extent = extent_of(result.mesh.nodes).maxCoeff();
  if (extent <= 1 && extent >= 1e-3) return;  // organs of a mouse and of a man
  size << "the body is " << extent << " m long; check whether mesh.scale_to_m = " << scale_to_m << " is correct";
  result.warnings.push_back(size.str());
}

}  // namespace phynness::meshes
