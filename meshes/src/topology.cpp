#include "topology.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

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

/// Numbers the sets of `members` by first appearance.
void number_sets(Sets& sets, const std::vector<std::int32_t>& members, std::vector<std::int32_t>& component,
                 std::vector<std::size_t>& sizes, std::size_t n_elements) {
  std::vector<std::int32_t> number(n_elements, -1);
  for (const std::int32_t member : members) {
    auto& n = number[sets.find(member)];
    if (n < 0) {
      n = static_cast<std::int32_t>(sizes.size());
      sizes.push_back(0);
    }
    component.push_back(n);
    ++sizes[n];
  }
}

struct HalfEdge {
  Edge edge;
  std::int32_t triangle;
  bool forward;  // from the smaller to the larger node
};

std::vector<HalfEdge> half_edges(const Triangles& triangles) {
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(triangles.rows()) * 3);
  for (std::int32_t t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      edges.push_back({{std::min(a, b), std::max(a, b)}, t, a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& p, const HalfEdge& q) {
    return std::tie(p.edge, p.triangle) < std::tie(q.edge, q.triangle);
  });
  return edges;
}

/// Calls visit(first, last) for every run of half edges on the same edge.
template <class Visit>
void for_each_edge(const std::vector<HalfEdge>& edges, Visit visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i + 1;
    while (j < edges.size() && edges[j].edge == edges[i].edge) ++j;
    visit(i, j);
    i = j;
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
  for_each_edge(edges, [&](std::size_t i, std::size_t j) {
    for (std::size_t e = i + 1; e < j; ++e)
      for (const std::int32_t node : edges[i].edge)
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

std::string first_few_edges(const std::vector<Edge>& edges) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(edges.size(), 4); ++i)
    text += (i ? ", " : "") + std::to_string(edges[i][0]) + "-" + std::to_string(edges[i][1]);
  return text + (edges.size() > 4 ? ", ..." : "");
}

}  // namespace

Triangles to_matrix(const std::vector<std::array<std::int32_t, 3>>& list) {
  Triangles triangles(static_cast<Eigen::Index>(list.size()), 3);
  for (std::size_t t = 0; t < list.size(); ++t)
    for (int k = 0; k < 3; ++k) triangles(static_cast<Eigen::Index>(t), k) = list[t][k];
  return triangles;
}

SurfaceTopology surface_topology(const Triangles& triangles) {
  SurfaceTopology topology;
  const std::vector<HalfEdge> edges = half_edges(triangles);
  for_each_edge(edges, [&](std::size_t i, std::size_t j) {
    if (j - i == 1) topology.open_edges.push_back(edges[i].edge);
    if (j - i > 2) topology.non_manifold_edges.push_back(edges[i].edge);
    if (j - i == 2 && edges[i].forward == edges[i + 1].forward) topology.inconsistent_edges.push_back(edges[i].edge);
  });
  topology.pinched_nodes = pinched(triangles, edges);
  const auto n_nodes = static_cast<std::size_t>(triangles.rows() == 0 ? 0 : triangles.maxCoeff() + 1);
  Sets sets(n_nodes);
  std::vector<std::int32_t> first_nodes;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    first_nodes.push_back(triangles(t, 0));
    sets.join(triangles(t, 0), triangles(t, 1));
    sets.join(triangles(t, 0), triangles(t, 2));
  }
  number_sets(sets, first_nodes, topology.component, topology.component_sizes, n_nodes);
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
  for_each_edge(edges, [&](std::size_t i, std::size_t j) {
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

CellTopology cell_topology(const std::vector<std::array<std::int32_t, 4>>& cells, std::size_t n_nodes) {
  constexpr int faces_of[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  struct Face {
    std::array<std::int32_t, 3> key;
    std::int32_t cell;
    bool even;  // the face's nodes are an even permutation of the sorted ones
  };
  CellTopology topology;
  Sets sets(n_nodes);
  std::vector<Face> faces;
  std::vector<std::int32_t> first_nodes;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& cell = cells[c];
    first_nodes.push_back(cell[0]);
    for (int k = 1; k < 4; ++k) sets.join(cell[0], cell[k]);
    for (const auto& f : faces_of) {
      std::array<std::int32_t, 3> key{cell[f[0]], cell[f[1]], cell[f[2]]};
      const bool even = (key[0] < key[1]) ^ (key[1] < key[2]) ^ (key[0] < key[2]);
      std::sort(key.begin(), key.end());
      faces.push_back({key, static_cast<std::int32_t>(c), even});
    }
  }
  number_sets(sets, first_nodes, topology.component, topology.component_sizes, n_nodes);
  std::sort(faces.begin(), faces.end(),
            [](const Face& p, const Face& q) { return std::tie(p.key, p.cell) < std::tie(q.key, q.cell); });
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].key == faces[i].key) ++j;
    auto& defects = j - i > 2 ? topology.crowded_cells : topology.folded_cells;
    if (j - i > 2 || (j - i == 2 && faces[i].even == faces[i + 1].even))
      for (std::size_t f = i; f < j; ++f) defects.push_back(faces[f].cell);
    i = j;
  }
  for (auto* list : {&topology.folded_cells, &topology.crowded_cells}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return topology;
}

std::string counted(std::size_t n, const char* singular, const char* plural) {
  return std::to_string(n) + ' ' + (n == 1 ? singular : plural);
}

std::string first_few(const std::vector<std::int32_t>& numbers, std::size_t how_many) {
  std::string text;
  for (std::size_t i = 0; i < std::min(numbers.size(), how_many); ++i)
    text += (i ? ", " : "") + std::to_string(numbers[i]);
  return text + (numbers.size() > how_many ? ", ..." : "");
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

std::string describe_defects(const SurfaceTopology& topology, bool with_components) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (!topology.open_edges.empty())
    add(counted(topology.open_edges.size(), "open edge", "open edges") + " (nodes " +
        first_few_edges(topology.open_edges) + ")");
  if (!topology.non_manifold_edges.empty())
    add(counted(topology.non_manifold_edges.size(), "non-manifold edge", "non-manifold edges") + " (nodes " +
        first_few_edges(topology.non_manifold_edges) + ")");
  if (!topology.pinched_nodes.empty())
    add(counted(topology.pinched_nodes.size(), "pinched vertex", "pinched vertices") + " (node " +
        first_few(topology.pinched_nodes) + ")");
  if (with_components && topology.component_sizes.size() > 1)
    add(describe_components(topology.component_sizes, "triangles"));
  return text;
}

}  // namespace phynness::meshes
