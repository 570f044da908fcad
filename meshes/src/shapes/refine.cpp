#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <phynness/meshes/meshes.hpp>

#include "surface/topology.hpp"

namespace phynness {
namespace {

using meshes::Edge, meshes::edge_of;

/// Numbers of the nodes at the midpoints of edges.
class Middles {
 public:
  Middles(const std::vector<Edge>& edges, std::int32_t n_nodes) : _edges(edges), _n_nodes(n_nodes) {}
  std::int32_t operator()(std::int32_t a, std::int32_t b) const {
    const auto at = std::lower_bound(_edges.begin(), _edges.end(), edge_of(a, b));
    return _n_nodes + static_cast<std::int32_t>(at - _edges.begin());
  }

 private:
  const std::vector<Edge>& _edges;
  std::int32_t _n_nodes;
};

std::array<std::array<std::int32_t, 3>, 4> children_of(const std::array<std::int32_t, 3>& t, const Middles& middle) {
  const auto a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
  return {{{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}}};
}

template <class Matrix>
void split_triangles(const Matrix& triangles, const Middles& middle, Matrix& children) {
  children.resize(4 * triangles.rows(), 3);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto four = children_of({triangles(t, 0), triangles(t, 1), triangles(t, 2)}, middle);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k)
        children(4 * t + i, k) = four[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  }
}

/// Four tetrahedra at the corners, and the octahedron between them divided along its shortest diagonal.
void split_tetrahedra(const Cells& cells, const Points& nodes, const Middles& middle, Cells& children) {
  children.resize(8 * cells.rows(), 4);
  Eigen::Index at = 0;
  const auto add = [&](const std::array<std::int32_t, 4>& cell) {
    for (int k = 0; k < 4; ++k) children(at, k) = cell[static_cast<std::size_t>(k)];
    const auto x = [&](int k) { return Eigen::Vector3d(nodes.row(children(at, k)).transpose()); };
    Eigen::Matrix3d sides;
    sides << x(1) - x(0), x(2) - x(0), x(3) - x(0);
    if (sides.determinant() < 0) std::swap(children(at, 2), children(at, 3));
    ++at;
  };
  for (Eigen::Index c = 0; c < cells.rows(); ++c) {
    std::int32_t m[4][4] = {};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (i != j) m[i][j] = middle(cells(c, i), cells(c, j));
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 1) % 4, k = (i + 2) % 4, l = (i + 3) % 4;
      add({cells(c, i), m[i][j], m[i][k], m[i][l]});
    }
    int shortest = 1;
    double least = std::numeric_limits<double>::infinity();
    for (int j = 1; j < 4; ++j) {
      const int k = j % 3 + 1, l = k % 3 + 1;
      const double length = (nodes.row(m[0][j]) - nodes.row(m[k][l])).norm();
      if (length < least) least = length, shortest = j;
    }
    // The diagonal connects the midpoints of 0-j and k-l; the other four midpoints surround it.
    const int j = shortest, k = j % 3 + 1, l = k % 3 + 1;
    const std::array<std::int32_t, 4> around{m[0][k], m[j][k], m[j][l], m[0][l]};
    for (std::size_t i = 0; i < 4; ++i) add({m[0][j], m[k][l], around[i], around[(i + 1) % 4]});
  }
}

}  // namespace

std::vector<std::array<std::int32_t, 2>> mesh_edges(const Mesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(static_cast<std::size_t>(mesh.cells.rows() * (mesh.cells.cols() == 4 ? 6 : 3)));
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c)
    for (Eigen::Index i = 0; i < mesh.cells.cols(); ++i)
      for (Eigen::Index j = i + 1; j < mesh.cells.cols(); ++j)
        edges.push_back(edge_of(mesh.cells(c, i), mesh.cells(c, j)));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Mesh refined(const Mesh& mesh) {
  const auto edges = mesh_edges(mesh);
  const Middles middle(edges, mesh.n_nodes());
  Mesh fine;
  fine.nodes.resize(mesh.n_nodes() + static_cast<Eigen::Index>(edges.size()), 3);
  fine.nodes.topRows(mesh.n_nodes()) = mesh.nodes;
  for (std::size_t e = 0; e < edges.size(); ++e)
    fine.nodes.row(mesh.n_nodes() + static_cast<Eigen::Index>(e)) =
        0.5 * (mesh.nodes.row(edges[e][0]) + mesh.nodes.row(edges[e][1]));
  if (mesh.cells.cols() == 4)
    split_tetrahedra(mesh.cells, fine.nodes, middle, fine.cells);
  else
    split_triangles(mesh.cells, middle, fine.cells);
  split_triangles(mesh.surface, middle, fine.surface);
  fine.groups = mesh.groups;
  for (auto& [name, nodes] : fine.groups) nodes = refined(nodes, edges, mesh.n_nodes());
  constexpr std::int32_t parts = 8;  // of each tetrahedron, one after the other
  for (const auto& [name, cells] : mesh.cell_groups)
    for (const auto cell : cells)
      for (std::int32_t k = 0; k < parts; ++k) fine.cell_groups[name].push_back(parts * cell + k);
  for (const auto region : mesh.regions) fine.regions.insert(fine.regions.end(), parts, region);
  return fine;
}

std::vector<std::int32_t> refined(const std::vector<std::int32_t>& nodes,
                                  const std::vector<std::array<std::int32_t, 2>>& edges, std::int32_t n_nodes) {
  std::vector<char> inside(static_cast<std::size_t>(n_nodes), 0);
  for (const auto node : nodes) inside[static_cast<std::size_t>(node)] = 1;
  auto all = nodes;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (inside[static_cast<std::size_t>(edges[e][0])] && inside[static_cast<std::size_t>(edges[e][1])])
      all.push_back(n_nodes + static_cast<std::int32_t>(e));
  return all;
}

}  // namespace phynness
