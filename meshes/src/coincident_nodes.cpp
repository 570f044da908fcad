#include "coincident_nodes.hpp"

#include <algorithm>
#include <numeric>
#include <sstream>

namespace phynness::meshes {
namespace {

// Relative to the bounding box; closer nodes are coincident.
constexpr double coincident = 1e-9;

}  // namespace

std::vector<std::int32_t> coincident_nodes(const Points& nodes) {
  if (nodes.rows() == 0) return {};
  const double tolerance = coincident * (nodes.colwise().maxCoeff() - nodes.colwise().minCoeff()).norm();
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

std::vector<std::int32_t> repeated(const std::vector<std::int32_t>& first) {
  std::vector<std::int32_t> list;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (first[i] != static_cast<std::int32_t>(i)) list.push_back(static_cast<std::int32_t>(i));
  return list;
}

void warn_of_size(MeshResult& result, double scale_to_m) {
  const Points& nodes = result.mesh.nodes;
  const double extent = (nodes.colwise().maxCoeff() - nodes.colwise().minCoeff()).maxCoeff();
  if (extent <= 1 && extent >= 1e-3) return;  // organs of a mouse and of a man
  std::ostringstream text;
  text << "the body is " << extent << " m long; check whether mesh.scale_to_m = " << scale_to_m << " is correct";
  result.warnings.push_back(text.str());
}

}  // namespace phynness::meshes
