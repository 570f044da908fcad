#include "file_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "surface/geometry.hpp"

namespace phynness::meshes {
namespace {

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

void drop_useless_triangles(RawMesh& raw) {
  const auto n =
      std::erase_if(raw.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[0] == t[2]; });
  if (n > 0) raw.notes.push_back("dropped " + counted(n, "triangle", "triangles") + " with two equal corners");
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
  raw.renumber_groups([&](std::int32_t& node) { node = node < 0 ? node : position[node]; });
  for (auto& [name, nodes] : raw.groups) {
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

std::string describe_sizes(std::vector<double> sizes, std::ptrdiff_t kept, const char* unit) {
  std::ostringstream text;
  text.precision(3);
  text << sizes[kept] << ' ' << unit << "; dropped";
  sizes.erase(sizes.begin() + kept);
  std::sort(sizes.rbegin(), sizes.rend());
  for (std::size_t i = 0; i < std::min<std::size_t>(sizes.size(), 4); ++i) text << (i ? ", " : " ") << sizes[i];
  text << (sizes.size() > 4 ? ", ... " : " ") << unit;
  return text.str();
}

std::string join_near_nodes(RawMesh& raw, bool repair) {
  const Points x = to_points(raw.nodes);
  std::vector<double> near(raw.nodes.size(), std::numeric_limits<double>::infinity());  // of each node
  const auto look = [&](const auto& element) {
    for (const auto i : element)
      for (const auto j : element)
        if (const double length = (x.row(i) - x.row(j)).norm(); length > 0) near[i] = std::min(near[i], 0.01 * length);
  };
  std::for_each(raw.tetrahedra.begin(), raw.tetrahedra.end(), look);
  std::for_each(raw.triangles.begin(), raw.triangles.end(), look);
  // Along a direction in which the nodes of a grid differ.
  const Eigen::VectorXd along = x * Eigen::Vector3d(0.5371, 0.3719, 0.7571);
  std::vector<std::int32_t> order, first(raw.nodes.size()), twins;
  std::iota(first.begin(), first.end(), 0);
  for (const auto i : first)
    if (std::isfinite(near[i]) && std::isfinite(along(i))) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](auto p, auto q) { return std::pair(along(p), p) < std::pair(along(q), q); });
  double farthest = 0;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size() && along(order[j]) - along(order[i]) <= near[order[i]]; ++j)
      if (const double distance = (x.row(order[i]) - x.row(order[j])).norm();
          distance <= std::min(near[order[i]], near[order[j]])) {
        const auto [low, high] = std::minmax(order[i], order[j]);
        first[high] = std::min(first[high], first[low]);
        farthest = std::max(farthest, distance);
      }
  for (std::int32_t i = 0; i < std::ssize(first); ++i)
    if (first[i] != i) twins.push_back(file_number(raw, i));
  if (twins.empty()) return "";
  std::ostringstream text;
  text << counted(twins.size(), "node is", "nodes are") << " within " << farthest << " m of another one ("
       << first_few(twins) << ")";
  if (!repair) return text.str() + ", which mesh.repair = true merges: nearer than a hundredth of the edges there";
  raw.notes.push_back("repair: merged nodes nearer than a hundredth of the edges there: " + text.str());
  const auto merge = [&](std::int32_t& node) {
    while (node >= 0 && first[node] != node) node = first[node];
  };
  raw.for_each_corner(merge);
  raw.renumber_groups(merge);
  drop_unused_nodes(raw);
  return "";
}

void warn_of_shape(MeshResult& result, const char* cell) {
  const QualityReport& quality = result.quality;
  if (quality.n_slivers == 0) return;
  std::ostringstream slivers;
  slivers.precision(2);
  slivers << counted(static_cast<std::size_t>(quality.n_slivers), "sliver", "slivers") << ", worst quality "
          << quality.min_quality << " in " << cell << " " << quality.worst_cell;
  result.warnings.push_back(slivers.str());
}

void warn_of_size(MeshResult& result, double scale_to_m) {
  const double extent = extent_of(result.mesh.nodes).maxCoeff();
  if (extent <= 1 && extent >= 1e-3) return;  // organs of a mouse and of a man
  std::ostringstream size;
  size << "the body is " << extent << " m long; check whether mesh.scale_to_m = " << scale_to_m << " is correct";
  result.warnings.push_back(size.str());
}

}  // namespace phynness::meshes
