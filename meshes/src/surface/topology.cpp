#include "topology.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "read/raw_mesh.hpp"

namespace phynness::meshes {
namespace {

/// Disjoint sets with path halving.
class Sets {
 public:
  explicit Sets(std::size_t n) : _parent(n) { std::iota(_parent.begin(), _parent.end(), 0); }
  std::int32_t find(std::int32_t i) {
    while (_parent[i] != i) i = _parent[i] = _parent[_parent[i]];
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = find(a), b = find(b);
    if (a != b) _parent[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> _parent;
};

/// Numbers by first appearance. @param set  of each of n_elements elements, below n_sets
template <class SetOf>
Components components_of(std::size_t n_elements, std::size_t n_sets, const SetOf& set) {
  Components found;
  std::vector<std::int32_t> number(n_sets, -1);
  for (std::size_t e = 0; e < n_elements; ++e) {
    auto& n = number[set(e)];
    if (n < 0) {
      n = static_cast<std::int32_t>(found.component_sizes.size());
      found.component_sizes.push_back(0);
    }
    found.component.push_back(n);
    ++found.component_sizes[n];
  }
  return found;
}

struct HalfEdge {
  Edge key;
  std::int32_t triangle;
  bool forward;  // from the smaller to the larger node
};

std::vector<HalfEdge> half_edges(const Triangles& triangles) {
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(triangles.rows()) * 3);
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      edges.push_back({edge_of(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& p, const HalfEdge& q) {
    return std::tie(p.key, p.triangle) < std::tie(q.key, q.triangle);
  });
  return edges;
}

/// Calls visit(first, last) for every run of half edges on the same edge, or of cells' faces of the same nodes.
template <class Item, class Visit>
void for_each_run(const std::vector<Item>& items, Visit visit) {
  for (std::size_t i = 0, j = 0; i < items.size(); i = j) {
    j = i + 1;
    while (j < items.size() && items[j].key == items[i].key) ++j;
    visit(i, j);
  }
}

/// Nodes whose triangles are not all connected by shared edges.
std::vector<std::int32_t> pinched(const Triangles& triangles, const std::vector<HalfEdge>& edges) {
  Sets corners(static_cast<std::size_t>(triangles.rows()) * 3);
  const auto corner = [&](std::int32_t t, std::int32_t node) {
    int k = 0;
    while (triangles(t, k) != node) ++k;
    return 3 * t + k;
  };
  for_each_run(edges, [&](std::size_t i, std::size_t j) {
    for (std::size_t e = i + 1; e < j; ++e)
      for (const std::int32_t node : edges[i].key)
        corners.join(corner(edges[i].triangle, node), corner(edges[e].triangle, node));
  });
  std::vector<std::array<std::int32_t, 2>> fans;  // node, fan
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) fans.push_back({triangles(t, k), corners.find(3 * t + k)});
  std::sort(fans.begin(), fans.end());
  fans.erase(std::unique(fans.begin(), fans.end()), fans.end());
  std::vector<std::int32_t> nodes;
  for (std::size_t i = 1; i < fans.size(); ++i)
    if (fans[i][0] == fans[i - 1][0] && (nodes.empty() || nodes.back() != fans[i][0])) nodes.push_back(fans[i][0]);
  return nodes;
}

/// The first items as text, separated by commas.
template <class Item, class Text>
std::string few(const std::vector<Item>& items, std::size_t how_many, const Text& text_of) {
  std::string text;
  for (std::size_t i = 0; i < std::min(items.size(), how_many); ++i) text += (i ? ", " : "") + text_of(items[i]);
  return text + (items.size() > how_many ? ", ..." : "");
}

}  // namespace

Triangles to_matrix(const std::vector<std::array<std::int32_t, 3>>& list) {
  return Eigen::Map<const Triangles>(reinterpret_cast<const std::int32_t*>(list.data()), std::ssize(list), 3);
}

SurfaceTopology surface_topology(const Triangles& triangles) {
  SurfaceTopology topology;
  const std::vector<HalfEdge> edges = half_edges(triangles);
  for_each_run(edges, [&](std::size_t i, std::size_t j) {
    if (j - i == 1) topology.open_edges.push_back(edges[i].key);
    if (j - i > 2) topology.non_manifold_edges.push_back(edges[i].key);
    if (j - i == 2 && edges[i].forward == edges[i + 1].forward) topology.inconsistent_edges.push_back(edges[i].key);
  });
  topology.pinched_nodes = pinched(triangles, edges);
  const auto n_nodes = static_cast<std::size_t>(triangles.rows() == 0 ? 0 : triangles.maxCoeff() + 1);
  Sets sets(n_nodes);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 1; k < 3; ++k) sets.join(triangles(t, 0), triangles(t, k));
  static_cast<Components&>(topology) =
      components_of(static_cast<std::size_t>(triangles.rows()), n_nodes,
                    [&](std::size_t t) { return sets.find(triangles(static_cast<Eigen::Index>(t), 0)); });
  return topology;
}

std::int32_t orient_consistently(Triangles& triangles, const SurfaceTopology& topology) {
  if (topology.inconsistent_edges.empty()) return 0;
  struct Neighbour {
    std::int32_t triangle;
    bool same_way;
  };
  std::vector<std::vector<Neighbour>> neighbours(static_cast<std::size_t>(triangles.rows()));
  const std::vector<HalfEdge> edges = half_edges(triangles);
  for_each_run(edges, [&](std::size_t i, std::size_t j) {
    if (j - i != 2) return;
    const bool same = edges[i].forward == edges[i + 1].forward;
    neighbours[edges[i].triangle].push_back({edges[i + 1].triangle, same});
    neighbours[edges[i + 1].triangle].push_back({edges[i].triangle, same});
  });
  enum : signed char { unseen, keep, turn };
  std::vector<signed char> state(neighbours.size(), unseen);
  std::int32_t turned = 0;
  std::vector<std::int32_t> queue;
  for (std::int32_t seed = 0; seed < triangles.rows(); ++seed) {
    if (state[seed] != unseen) continue;
    state[seed] = keep;
    queue.assign(1, seed);
    while (!queue.empty()) {
      const std::int32_t t = queue.back();
      queue.pop_back();
      for (const auto& [other, same] : neighbours[t]) {
        const signed char wanted = (state[t] == turn) != same ? turn : keep;
        if (state[other] == unseen) {
          state[other] = wanted;
          queue.push_back(other);
        } else if (state[other] != wanted) {
          return -1;
        }
      }
    }
  }
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    if (state[t] == turn) {
      std::swap(triangles(t, 1), triangles(t, 2));
      ++turned;
    }
  return turned;
}

CellTopology cell_topology(const std::vector<std::array<std::int32_t, 4>>& cells) {
  constexpr int faces_of[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  struct Face {
    std::array<std::int32_t, 3> key;
    std::int32_t cell;
    bool even;  // the face's nodes are an even permutation of the sorted ones
  };
  CellTopology topology;
  Sets sets(cells.size());
  std::vector<Face> faces;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& cell = cells[c];
    for (const auto& f : faces_of) {
      std::array<std::int32_t, 3> key{cell[f[0]], cell[f[1]], cell[f[2]]};
      const bool even = (key[0] < key[1]) ^ (key[1] < key[2]) ^ (key[0] < key[2]);
      std::sort(key.begin(), key.end());
      faces.push_back({key, static_cast<std::int32_t>(c), even});
    }
  }
  std::sort(faces.begin(), faces.end(),
            [](const Face& p, const Face& q) { return std::tie(p.key, p.cell) < std::tie(q.key, q.cell); });
  for_each_run(faces, [&](std::size_t i, std::size_t j) {
    auto& defects = j - i > 2 ? topology.crowded_cells : topology.folded_cells;
    if (j - i > 2 || (j - i == 2 && faces[i].even == faces[i + 1].even))
      for (std::size_t f = i; f < j; ++f) defects.push_back(faces[f].cell);
    for (std::size_t f = i + 1; f < j; ++f) sets.join(faces[i].cell, faces[f].cell);
  });
  static_cast<Components&>(topology) =
      components_of(cells.size(), cells.size(), [&](std::size_t c) { return sets.find(static_cast<std::int32_t>(c)); });
  for (auto* list : {&topology.folded_cells, &topology.crowded_cells}) sort_unique(*list);
  return topology;
}

std::string counted(std::size_t n, const char* singular, const char* plural) {
  return std::to_string(n) + ' ' + (n == 1 ? singular : plural);
}

std::string first_few(const std::vector<std::int32_t>& numbers, std::size_t how_many) {
  return few(numbers, how_many, [](std::int32_t number) { return std::to_string(number); });
}

std::string describe_components(const std::vector<std::size_t>& sizes, const char* things) {
  std::vector<std::size_t> sorted = sizes;
  std::sort(sorted.rbegin(), sorted.rend());
  std::string text = counted(sizes.size(), "component", "components") + " of ";
  const std::size_t shown = std::min<std::size_t>(sorted.size(), 6);
  for (std::size_t i = 0; i < shown; ++i)
    text += (i == 0 ? "" : i + 1 == sorted.size() ? " and " : ", ") + std::to_string(sorted[i]);
  return text + (sorted.size() > shown ? ", ... " : " ") + things;
}

std::string describe_defects(const SurfaceTopology& topology, bool with_components,
                             const std::vector<std::int32_t>& numbers) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  const auto name = [&](std::int32_t node) { return std::to_string(numbers.empty() ? node : numbers[node]); };
  const auto edges = [&](const std::vector<Edge>& list) {
    return " (nodes " + few(list, 4, [&](const Edge& e) { return name(e[0]) + "-" + name(e[1]); }) + ")";
  };
  if (!topology.open_edges.empty())
    add(counted(topology.open_edges.size(), "open edge", "open edges") + edges(topology.open_edges));
  if (!topology.non_manifold_edges.empty())
    add(counted(topology.non_manifold_edges.size(), "non-manifold edge", "non-manifold edges") +
        edges(topology.non_manifold_edges));
  if (!topology.pinched_nodes.empty())
    add(counted(topology.pinched_nodes.size(), "pinched vertex", "pinched vertices") + " (node " +
        few(topology.pinched_nodes, 8, name) + ")");
  if (with_components && topology.component_sizes.size() > 1)
    add(describe_components(topology.component_sizes, "triangles"));
  return text;
}

}  // namespace phynness::meshes
