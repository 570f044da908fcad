// Nodes within a distance of other nodes, by a k-d tree that is stored as an order: the middle of a range divides it.
#include "near_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace phynness::scene_detail {
namespace {

class NodeTree {
 public:
  NodeTree(const Points& nodes, NodeList order) : _nodes(nodes), _order(std::move(order)) { sort(0, _order.size(), 0); }

  bool has_within(const Eigen::RowVector3d& x, double distance) const {
    return has_within({x, distance}, Eigen::RowVector3d::Zero(), 0, _order.size(), 0);
  }

 private:
  void sort(std::size_t first, std::size_t last, int axis) {
    if (last - first < 2) return;
    const std::size_t middle = first + (last - first) / 2;
    const auto begin = _order.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                     begin + static_cast<std::ptrdiff_t>(last), [&](std::int32_t a, std::int32_t b) {
                       return std::pair(_nodes(a, axis), a) < std::pair(_nodes(b, axis), b);
                     });
    sort(first, middle, (axis + 1) % 3);
    sort(middle + 1, last, (axis + 1) % 3);
  }

  struct Query {
    const Eigen::RowVector3d& x;
    double distance;
  };

  /// @param outside  how far x lies outside of the range's box along each axis
  bool has_within(const Query& query, const Eigen::RowVector3d& outside, std::size_t first, std::size_t last,
                  int axis) const {
    if (first >= last || outside.norm() > query.distance) return false;
    const std::size_t middle = first + (last - first) / 2;
    const auto at = _nodes.row(_order[middle]);
    if ((at - query.x).norm() <= query.distance) return true;
    const double beyond = query.x(axis) - at(axis);
    Eigen::RowVector3d below = outside, above = outside;
    (beyond > 0 ? below : above)(axis) = std::abs(beyond);
    const int next = (axis + 1) % 3;
    return has_within(query, below, first, middle, next) || has_within(query, above, middle + 1, last, next);
  }

  const Points& _nodes;
  NodeList _order;
};

}  // namespace

NodeList near_nodes(const Points& nodes, const NodeList& candidates, NodeList targets, double distance) {
  const NodeTree tree(nodes, std::move(targets));
  NodeList near;
  for (const std::int32_t i : candidates)
    if (tree.has_within(nodes.row(i), distance)) near.push_back(i);
  return near;
}

}  // namespace phynness::scene_detail
