// Claims about probed nodes that are spread over a surface, and about the coordinates of the nodes between them, on a
// sphere of radius 1 with 642 or 2,562 nodes, on a flat grid and on a thin plate.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <phynness/formats/model.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/meshes/tool_weights.hpp>

namespace {

using namespace phynness;

/// The icosahedron, with each triangle divided into four again and again; symmetric about the coordinate planes.
Mesh sphere(int n_divisions) {
  const double p = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::RowVector3d> x;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-p, p})
      for (const auto& v : {Eigen::RowVector3d(0, a, b), Eigen::RowVector3d(a, b, 0), Eigen::RowVector3d(b, 0, a)})
        x.push_back(v.normalized());
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < 12; ++i)
    for (int j = i + 1; j < 12; ++j)
      for (int k = j + 1; k < 12; ++k) {
        const double longest = std::max({(x[i] - x[j]).norm(), (x[j] - x[k]).norm(), (x[k] - x[i]).norm()});
        const bool outward = (x[j] - x[i]).cross(x[k] - x[i]).dot(x[i]) > 0;
        if (longest < 1.1) triangles.push_back(outward ? std::array{i, j, k} : std::array{i, k, j});
      }
  for (int n = 0; n < n_divisions; ++n) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, is_new] = middles.emplace(std::minmax(a, b), static_cast<int>(x.size()));
      if (is_new) x.emplace_back((x[a] + x[b]).normalized());
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int d = middle(a, b), e = middle(b, c), f = middle(c, a);
      for (const auto& t : {std::array{a, d, f}, std::array{d, b, e}, std::array{f, e, c}, std::array{d, e, f}})
        finer.push_back(t);
    }
    triangles = finer;
  }
  Mesh mesh;
  mesh.nodes.resize(std::ssize(x), 3);
  for (std::size_t i = 0; i < x.size(); ++i) mesh.nodes.row(static_cast<Eigen::Index>(i)) = x[i];
  mesh.surface.resize(std::ssize(triangles), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    mesh.surface.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
  return mesh;
}

/// Squares of edge 1 with alternating diagonals.
Mesh grid(int n) {
  Mesh mesh;
  mesh.nodes.resize((n + 1) * (n + 1), 3);
  mesh.surface.resize(2 * n * n, 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.nodes.row(j * (n + 1) + i) << i, j, 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1, t = 2 * (j * n + i);
      const bool even = (i + j) % 2 == 0;
      mesh.surface.row(t) << a, b, (even ? c : d);
      mesh.surface.row(t + 1) << (even ? a : b), c, d;
    }
  return mesh;
}

NodeList where(const Mesh& mesh, bool (*inside)(const Eigen::RowVector3d&)) {
  NodeList nodes;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (inside(mesh.nodes.row(i))) nodes.push_back(i);
  return nodes;
}
bool everywhere(const Eigen::RowVector3d&) { return true; }
bool above(const Eigen::RowVector3d& x) { return x[2] > -0.3; }

double along(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b) {
  return 2 * std::asin(std::min(1.0, (a - b).norm() / 2));
}

/// A model of round tools at the given nodes of a mesh whose other nodes are free.
Model model_of(const Mesh& mesh, const NodeList& probed) {
  Model model;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) model.output.push_back(i);
  model.surface = mesh.surface;
  for (const auto node : probed) {
    model.nodes.emplace_back().node = node;
    model.nodes.back().moves_mean = true;
  }
  return model;
}

// Claim: no node of the part is farther from a chosen one than 3/4 of the spacing, and no two chosen ones are nearer
// than this, on the border of the part half of the spacing. Ways along edges are longer than the sphere's great circles
// by at most 6 % here.
TEST(SpreadNodes, HonourTheSpacing) {
  const Mesh mesh = sphere(4);
  for (const auto& part : {where(mesh, everywhere), where(mesh, above)}) {
    const bool whole = part.size() == static_cast<std::size_t>(mesh.n_nodes());
    for (const double spacing : {0.15, 0.25, 0.4}) {
      const auto chosen = spread_nodes(mesh.nodes, mesh.surface, part, spacing, 0);
      EXPECT_EQ(chosen, spread_nodes(mesh.nodes, mesh.surface, part, spacing, 0));
      EXPECT_TRUE(std::includes(part.begin(), part.end(), chosen.begin(), chosen.end()));
      for (const auto i : part) {
        double nearest = 10;
        for (const auto c : chosen) nearest = std::min(nearest, along(mesh.nodes.row(i), mesh.nodes.row(c)));
        EXPECT_LE(nearest, 0.75 * spacing);
      }
      for (const auto a : chosen)
        for (const auto b : chosen) {
          if (a == b) continue;
          EXPECT_GE(along(mesh.nodes.row(a), mesh.nodes.row(b)), (whole ? 0.75 : 0.5) * spacing / 1.06);
        }
    }
  }
}

// Claim: a count is met, more points are denser, and a spacing below the edges, which are longer than 0.06, takes all.
TEST(SpreadNodes, AreAsManyAsWanted) {
  const Mesh mesh = sphere(4);
  const auto part = where(mesh, above);
  for (const std::size_t count : {1, 2, 16, 333})
    EXPECT_EQ(spread_nodes(mesh.nodes, mesh.surface, part, 0, count).size(), count);
  EXPECT_EQ(spread_nodes(mesh.nodes, mesh.surface, part, 0.06, 0), part);
  EXPECT_EQ(spread_nodes(mesh.nodes, mesh.surface, part, 0, part.size()), part);
}

// Claim: nodes that are there are kept; those that are added keep their distance from them and fill the part.
TEST(SpreadNodes, KeepWhatIsThere) {
  const Mesh mesh = sphere(4);
  const auto part = where(mesh, above), all = where(mesh, everywhere);
  const auto kept = spread_nodes(mesh.nodes, mesh.surface, part, 0.4, 0);
  const auto is_kept = [&](std::int32_t i) { return std::binary_search(kept.begin(), kept.end(), i); };
  for (const double spacing : {0.25, 0.4}) {
    const auto chosen = spread_nodes(mesh.nodes, mesh.surface, all, spacing, 0, kept);
    EXPECT_TRUE(std::includes(chosen.begin(), chosen.end(), kept.begin(), kept.end()));
    EXPECT_EQ(chosen, spread_nodes(mesh.nodes, mesh.surface, all, spacing, 0, chosen));
    for (const auto i : all) {
      double nearest = 10;
      for (const auto c : chosen) nearest = std::min(nearest, along(mesh.nodes.row(i), mesh.nodes.row(c)));
      EXPECT_LE(nearest, 0.75 * spacing);
    }
    for (const auto a : chosen)
      for (const auto b : chosen)
        if (a != b && !(is_kept(a) && is_kept(b))) {
          EXPECT_GE(along(mesh.nodes.row(a), mesh.nodes.row(b)), 0.75 * spacing / 1.06);
        }
  }
  EXPECT_EQ(spread_nodes(mesh.nodes, mesh.surface, part, 0, kept.size() + 5, kept).size(), kept.size() + 5);
}

// Claim: on a closed surface the triangles between the probed nodes close, too (Euler: 2 n - 4 of them), every node is
// covered, the weights are at least 0 and have the sum 1, a probed node has its own weight only, and the coordinates
// give the place of a node up to what the triangle lies below the sphere: at most L^2 / 2 for a longest edge L.
TEST(ProbeCoordinates, CoverTheSurface) {
  const Mesh mesh = sphere(3);
  const auto all = where(mesh, everywhere);
  for (const double spacing : {0.15, 0.25, 0.4}) {
    const auto probed = spread_nodes(mesh.nodes, mesh.surface, all, spacing, 0);
    const auto made = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 3 * spacing);
    EXPECT_EQ(made.triangles.rows(), 2 * std::ssize(probed) - 4);
    ASSERT_EQ(made.covered, all);
    double longest = 0;
    for (Eigen::Index t = 0; t < made.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        longest = std::max(
            longest, (mesh.nodes.row(made.triangles(t, k)) - mesh.nodes.row(made.triangles(t, (k + 1) % 3))).norm());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto w = made.weights.row(static_cast<Eigen::Index>(i));
      EXPECT_GE(w.minCoeff(), 0);
      EXPECT_NEAR(w.sum(), 1, 1e-12);
      Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 3; ++k) x += w[k] * mesh.nodes.row(made.triangles(made.triangle[i], k));
      EXPECT_LE((x - mesh.nodes.row(all[i])).norm(), longest * longest / 2);
      if (!std::binary_search(probed.begin(), probed.end(), all[i])) continue;
      EXPECT_EQ(w.maxCoeff(), 1);
      EXPECT_LT((x - mesh.nodes.row(all[i])).norm(), 1e-15);
    }
    EXPECT_EQ(probe_spread(mesh.nodes, mesh.surface, probed, {}, made.covered).covered, 1);
  }
}

// Claim: where a part of one face of a thin body is probed, nodes around its rim, on the other face, or more than a
// spacing beyond the part have no coordinates, however long triangles may be.
TEST(ProbeCoordinates, EndAtTheProbedPart) {
  Mesh mesh = sphere(4);
  mesh.nodes.col(2) *= 0.2;
  const auto within = [](const Eigen::RowVector3d& x) { return x[2] > 0 && x.head<2>().norm() < 0.65; };
  const auto part = where(mesh, within);
  for (const double spacing : {0.02, 0.15, 0.3}) {  // 0.02: every node
    const auto probed = spread_nodes(mesh.nodes, mesh.surface, part, spacing, 0);
    const auto made = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 0.8);
    std::size_t inside = 0;
    for (const auto node : made.covered) {
      const Eigen::RowVector3d x = mesh.nodes.row(node);
      EXPECT_GT(x[2], 0);
      EXPECT_LT(x.head<2>().norm(), 0.65 + std::max(spacing, 0.08));  // edges are at most 0.08
      inside += within(x);
    }
    EXPECT_GE(static_cast<double>(inside), 0.97 * static_cast<double>(part.size()));
  }
}

// Claim: in the plane the coordinates of nodes between the probed ones give their place exactly; nearly all nodes lie
// between them, and beside the border and its corners hardly any is not covered. No triangle reaches across fixed
// nodes, which have no coordinates. Longer edges than allowed leave nothing.
TEST(ProbeCoordinates, AreExactInThePlaneAndEndAtFixedNodes) {
  const Mesh mesh = grid(24);
  const auto fixed = where(mesh, [](const Eigen::RowVector3d& x) { return x[0] == 12; });
  const auto free = where(mesh, [](const Eigen::RowVector3d& x) { return x[0] != 12; });
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, free, 4, 0);
  const auto made = probe_coordinates(mesh.nodes, mesh.surface, probed, fixed, 20);
  for (Eigen::Index t = 0; t < made.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_GT((mesh.nodes(made.triangles(t, 0), 0) - 12) * (mesh.nodes(made.triangles(t, k), 0) - 12), 0);
  std::ptrdiff_t exact = 0;
  for (std::size_t i = 0; i < made.covered.size(); ++i) {
    const auto w = made.weights.row(static_cast<Eigen::Index>(i));
    Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) x += w[k] * mesh.nodes.row(made.triangles(made.triangle[i], k));
    const double off = (x - mesh.nodes.row(made.covered[i])).norm();
    exact += off < 1e-12;
    EXPECT_TRUE(off < 1e-12 || w.minCoeff() == 0);
  }
  EXPECT_GT(exact, 0.96 * static_cast<double>(free.size()));
  EXPECT_GE(static_cast<double>(made.covered.size()), 0.99 * static_cast<double>(free.size()));
  for (const auto node : made.covered) EXPECT_FALSE(std::binary_search(fixed.begin(), fixed.end(), node));
  EXPECT_EQ(probe_coordinates(mesh.nodes, mesh.surface, probed, fixed, 1).triangles.rows(), 0);
  // Round tools in triangles with a fixed node have a warning.
  Model model = model_of(mesh, probed);
  model.fixed = fixed;
  cover_surface(model, mesh, 8);
  const double share_without_fixed_nodes = 22.0 / 24, answered = touched_area(model, mesh).nonlinear;
  EXPECT_LE(answered, share_without_fixed_nodes);
  EXPECT_GT(answered, 0.9 * share_without_fixed_nodes) << "only corners and folds of the sheet are not covered";
}

// Claim: a part of the surface that lies over the probed part and faces the same way, but is far from it along the
// surface, has no coordinates between probed nodes. The sheet is folded into three layers, of which the lowest is
// probed; the third one has the same normals.
TEST(ProbeCoordinates, EndWhereTheSurfaceIsFar) {
  Mesh mesh = grid(24);
  for (auto x : mesh.nodes.rowwise()) {
    const double u = x[0];
    x = Eigen::RowVector3d(u > 16 ? u - 16 : u > 8 ? 16 - u : u, x[1], u > 16 ? 8 : u > 8 ? 4 : 0);
  }
  const auto lowest = where(mesh, [](const Eigen::RowVector3d&x) { return x[2] == 0; }),
             others = where(mesh, [](const Eigen::RowVector3d&x) { return x[2] > 0; });
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, lowest, 3, 0);
  const auto own = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 20);
  // Tools at the edge of the fold, x = 8, and at up to two nodes beside it touch two layers.
  EXPECT_TRUE(std::ranges::includes(own.covered,
                                    where(mesh, [](const Eigen::RowVector3d& x) { return x[2] == 0 && x[0] < 6; })));
  const auto joined = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 20, others);
  for (const auto* made : {&own, &joined})
    for (std::size_t i = 0; i < made->covered.size(); ++i)
      if (made->triangle[i] < own.triangles.rows()) {
        EXPECT_LT(mesh.nodes(made->covered[i], 2), 8);
      }
}

// Claim: nothing on one side of a sharp fold is answered by probed nodes on the other, unless all are beside it. At a
// gentle bend it is.
TEST(ProbeCoordinates, EndInFolds) {
  for (const double degrees : {20, 90}) {
    Mesh mesh = grid(24);
    const auto along_x = mesh.nodes.col(0).eval();
    for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i) {
      const double past = std::max(along_x[i] - 12, 0.0), angle = degrees * std::numbers::pi / 180;
      mesh.nodes.row(i) << std::min(along_x[i], 12.0) + past * std::cos(angle), mesh.nodes(i, 1),
          past * std::sin(angle);
    }
    const auto all = where(mesh, [](const Eigen::RowVector3d&) { return true; });
    const auto probed = spread_nodes(mesh.nodes, mesh.surface, all, 4, 0);
    const auto made = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 20);
    std::ptrdiff_t over = 0;
    for (std::size_t i = 0; i < made.covered.size(); ++i) {
      const double of_node = along_x[made.covered[i]] - 12;
      for (int k = 0; k < 3; ++k) {
        const double of_corner = along_x[made.triangles(made.triangle[i], k)] - 12;
        over += made.weights(static_cast<Eigen::Index>(i), k) > 0 && of_node * of_corner < 0 &&
                std::max(std::abs(of_node), std::abs(of_corner)) > 2;
      }
    }
    EXPECT_EQ(over > 0, degrees < 45) << over;
    // In the fold up to three rows of nodes on each side, of 24, are not covered.
    EXPECT_GE(std::ssize(made.covered), degrees < 45 ? std::ssize(all) * 95 / 100 : std::ssize(all) * 3 / 4);
  }
}

// Claim: there are no holes between probed nodes that are spread unevenly.
TEST(ProbeCoordinates, HaveNoHolesBetweenUnevenNodes) {
  const Mesh mesh = grid(24);
  const auto probed = where(mesh, [](const Eigen::RowVector3d& x) {
    const int i = static_cast<int>(x[0]), j = static_cast<int>(x[1]);
    return (i <= 4 && i % 2 == 0 && j % 2 == 0) || (i >= 12 && i % 8 == 4 && j % 8 == 0);
  });
  const auto made = probe_coordinates(mesh.nodes, mesh.surface, probed, {}, 20);
  std::vector<char> is_covered(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto node : made.covered) is_covered[static_cast<std::size_t>(node)] = 1;
  for (Eigen::Index t = 0; t < made.triangles.rows(); ++t) {
    const Eigen::RowVector3d middle = (mesh.nodes.row(made.triangles(t, 0)) + mesh.nodes.row(made.triangles(t, 1)) +
                                       mesh.nodes.row(made.triangles(t, 2))) /
                                      3;
    Eigen::Index nearest = 0;
    (mesh.nodes.rowwise() - middle).rowwise().squaredNorm().minCoeff(&nearest);
    EXPECT_TRUE(is_covered[static_cast<std::size_t>(nearest)]) << mesh.nodes.row(nearest);
  }
}

// Claim: models of which every node of the touched part is probed, as older ones, have no coordinates; others have
// weights of at least 0, at probed nodes 1 in one corner.
TEST(ProbeCoordinates, AreInAModelOnlyWhereNeeded) {
  const Mesh mesh = sphere(3);
  Model dense = model_of(mesh, where(mesh, everywhere));
  cover_surface(dense, mesh, 1);
  EXPECT_EQ(dense.covered.rows() + dense.probe_triangles.rows(), 0);
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, where(mesh, above), 0.4, 0);
  Model sparse = model_of(mesh, probed);
  cover_surface(sparse, mesh, 1);
  ASSERT_GT(sparse.covered.rows(), std::ssize(probed));
  for (Eigen::Index i = 0; i < sparse.covered.rows(); ++i) {
    const auto row = sparse.covered.row(i);
    const double first = row[2], second = row[3], whole = schema::whole_weight;
    const double parts[3] = {first / whole, (1 - first / whole) * (second / whole),
                             (1 - first / whole) * (1 - second / whole)};
    const auto own = std::lower_bound(probed.begin(), probed.end(), row[0]);
    if (own == probed.end() || *own != row[0]) continue;
    for (int k = 0; k < 3; ++k) EXPECT_EQ(parts[k] == 1, sparse.probe_triangles(row[1], k) == own - probed.begin());
  }
}

/// Claim: points beside the probed part join it to all of the surface. Triangles and coordinates of the part remain; no
/// other node has them of probed nodes alone, but at the edges of the part. Coordinates are continuous: neighbours on
/// the surface have coordinates of points that are near.
TEST(ProbeCoordinates, JoinPointsBesideThePart) {
  const Mesh mesh = sphere(4);
  const auto part = where(mesh, above), all = where(mesh, everywhere);
  const auto fixed = where(mesh, [](const Eigen::RowVector3d& x) { return x[0] < -0.9; });
  NodeList free, within, linear;
  std::ranges::set_difference(all, fixed, std::back_inserter(free));
  std::ranges::set_difference(part, fixed, std::back_inserter(within));
  const double spacing = 0.25;
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, within, spacing, 0);
  const auto points = spread_nodes(mesh.nodes, mesh.surface, free, spacing, 0, probed);
  std::ranges::set_difference(points, probed, std::back_inserter(linear));
  ASSERT_GT(linear.size(), 20U);
  const auto own = probe_coordinates(mesh.nodes, mesh.surface, probed, fixed, 2 * spacing);
  const auto joined = probe_coordinates(mesh.nodes, mesh.surface, probed, fixed, 2 * spacing, linear);
  EXPECT_EQ(joined.triangles.topRows(own.triangles.rows()), own.triangles);
  EXPECT_EQ(joined.covered, free);
  std::size_t n_beyond = 0;
  for (std::size_t i = 0; i < own.covered.size(); ++i) {
    const auto at = std::ranges::lower_bound(joined.covered, own.covered[i]) - joined.covered.begin();
    const auto j = static_cast<std::size_t>(at);
    n_beyond += own.is_beyond[i] != 0;
    if (own.is_beyond[i]) continue;
    EXPECT_EQ(joined.triangle[j], own.triangle[i]);
    EXPECT_EQ(joined.weights.row(at), own.weights.row(static_cast<Eigen::Index>(i)));
  }
  EXPECT_GT(n_beyond, 10U);
  // The place of the coordinates is that of the node: between flat triangles and the sphere, and beyond the points at
  // the fixed part, which are up to half a spacing from it.
  Points place(std::ssize(joined.covered), 3);
  for (Eigen::Index i = 0; i < place.rows(); ++i) {
    const auto corners = joined.triangles.row(joined.triangle[static_cast<std::size_t>(i)]);
    place.row(i) = joined.weights.row(i) * mesh.nodes({corners[0], corners[1], corners[2]}, Eigen::all);
    EXPECT_NEAR(joined.weights.row(i).sum(), 1, 1e-12);
    const double away = (place.row(i) - mesh.nodes.row(joined.covered[static_cast<std::size_t>(i)])).norm();
    EXPECT_LT(away, joined.is_beyond[static_cast<std::size_t>(i)] ? 0.5 * spacing : 0.1 * spacing);
  }
}

// Claim: with linear points all free nodes have coordinates. The rows of nodes in triangles of probed nodes, and these
// triangles, are those of the model without; beyond these triangles linear points have a part. Fixed nodes have none.
TEST(ProbeCoordinates, CoverTheFreeSurfaceWithLinearPoints) {
  const Mesh mesh = sphere(3);
  const auto fixed = where(mesh, [](const Eigen::RowVector3d& x) { return x[0] < -0.8; });
  NodeList free = where(mesh, [](const Eigen::RowVector3d& x) { return x[0] >= -0.8; });
  const auto part = where(mesh, [](const Eigen::RowVector3d& x) { return above(x) && x[0] >= -0.8; });
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, part, 0.4, 0);
  const auto all = spread_nodes(mesh.nodes, mesh.surface, free, 0.4, 0, probed);
  for (const bool spread : {true, false}) {
    Model without = model_of(mesh, probed);
    without.fixed = fixed;
    Model with = without;
    for (const auto node : all)
      if (!std::ranges::binary_search(probed, node)) with.linear_points.emplace_back().node = node;
    if (spread) cover_surface(without, mesh, 1);
    cover_surface(with, mesh, 1, spread);
    EXPECT_EQ(with.probe_triangles, without.probe_triangles);
    ASSERT_EQ(with.covered.rows(), std::ssize(free));
    const auto answered = probed_nodes(with);
    EXPECT_TRUE(std::ranges::includes(answered, probed));
    EXPECT_LT(answered.size(), free.size());
    for (Eigen::Index i = 0; i < with.covered.rows(); ++i) {
      const auto row = with.covered.row(i);
      EXPECT_EQ(row[0], free[static_cast<std::size_t>(i)]);
      ASSERT_LT(row[1], with.probe_triangles.rows() + with.outer_triangles.rows());
      const auto nodes = without.covered.col(0);
      const auto same = std::lower_bound(nodes.begin(), nodes.end(), row[0]) - nodes.begin();
      if (same == nodes.size() || nodes[same] != row[0] || !std::ranges::binary_search(answered, row[0])) continue;
      EXPECT_EQ(without.covered.row(same), row);
    }
  }
}

/// The surface of n x n cubes of edge 1, flattened to a plate with side faces of two rows.
Mesh plate(int n) {
  std::map<std::array<int, 3>, int> numbers;
  std::vector<Eigen::RowVector3i> triangles;
  const auto add_square = [&](const std::array<std::array<int, 3>, 4>& corners) {
    std::array<int, 4> c{};
    for (std::size_t k = 0; k < 4; ++k)
      c[k] = numbers.emplace(corners[k], static_cast<int>(numbers.size())).first->second;
    triangles.emplace_back(c[0], c[1], c[2]);
    triangles.emplace_back(c[0], c[2], c[3]);
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      add_square({{{i, j, 2}, {i + 1, j, 2}, {i + 1, j + 1, 2}, {i, j + 1, 2}}});
      add_square({{{i, j, 0}, {i, j + 1, 0}, {i + 1, j + 1, 0}, {i + 1, j, 0}}});
      if (j > 1) continue;
      add_square({{{i, 0, j}, {i + 1, 0, j}, {i + 1, 0, j + 1}, {i, 0, j + 1}}});
      add_square({{{i, n, j}, {i, n, j + 1}, {i + 1, n, j + 1}, {i + 1, n, j}}});
      add_square({{{0, i, j}, {0, i, j + 1}, {0, i + 1, j + 1}, {0, i + 1, j}}});
      add_square({{{n, i, j}, {n, i + 1, j}, {n, i + 1, j + 1}, {n, i, j + 1}}});
    }
  Mesh mesh;
  mesh.nodes.resize(std::ssize(numbers), 3);
  for (const auto& [x, i] : numbers) mesh.nodes.row(i) << x[0], x[1], 0.25 * x[2];
  mesh.surface.resize(std::ssize(triangles), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.surface.row(static_cast<Eigen::Index>(t)) = triangles[t];
  return mesh;
}

// Claim: of a thin plate whose upper face is probed, probed nodes alone answer on this face only, although side faces
// and the lower face are nearer to them than they are to each other.
TEST(ProbeCoordinates, EndAtTheEdgesOfAThinPlate) {
  const Mesh mesh = plate(30);
  const auto upper = where(mesh, [](const Eigen::RowVector3d& x) { return x[2] == 0.5; });
  const auto all = where(mesh, everywhere);
  for (const double spacing : {3, 10}) {
    const auto probed = spread_nodes(mesh.nodes, mesh.surface, upper, spacing, 0);
    Model model = model_of(mesh, probed);
    for (const auto node : spread_nodes(mesh.nodes, mesh.surface, all, spacing, 0, probed))
      if (!std::ranges::binary_search(probed, node)) model.linear_points.emplace_back().node = node;
    cover_surface(model, mesh, 2 * spacing);
    const auto answered = probed_nodes(model);
    EXPECT_TRUE(std::ranges::includes(upper, answered)) << spacing;
    EXPECT_GE(std::ssize(answered), std::ssize(upper) - 40) << spacing;
  }
}

// Claim: points that answer as the body at rest are chosen once, also where the tool is as wide as the probed part.
TEST(ProbeCoordinates, LinearPointsAreDistinct) {
  const Mesh mesh = plate(20);
  NodeSets sets;
  sets.active = where(mesh, [](const Eigen::RowVector3d& x) {
    return x[2] == 0.5 && x.head<2>().minCoeff() > 5 && x.head<2>().maxCoeff() < 15;
  });
  Scene scene;
  scene.active = {Selector{.kind = SelectorKind::spread}};
  scene.probe.kind = ProbeKind::patch;
  for (const double radius : {3, 5, 8, 12, 20}) {
    scene.probe.tool_radius_m = radius;
    select_elsewhere(scene, mesh, sets);
    EXPECT_EQ(std::ranges::adjacent_find(sets.linear), sets.linear.end()) << radius;
    EXPECT_FALSE(sets.linear.empty());
  }
}

// Claim: where the whole surface of a thin plate is probed, a node that probed points alone answer has a tool of which
// three fifths are those of the points around it: nodes in the middle of side faces are answered by linear points, and
// nodes of the upper and lower face that are farther than a radius from the edges by probed ones.
TEST(ProbeCoordinates, EndWhereToolsHaveLittleInCommon) {
  const Mesh mesh = plate(30);
  const auto all = where(mesh, everywhere),
             sides = where(mesh, [](const Eigen::RowVector3d&x) { return x[2] == 0.25; }),
             inside = where(mesh, [](const Eigen::RowVector3d&x) {
               return x.head<2>().minCoeff() > 10 && x.head<2>().maxCoeff() < 20;
             });
  const double spacing = 5, radius = 2 * spacing, whole = schema::whole_weight;
  const auto probed = spread_nodes(mesh.nodes, mesh.surface, all, spacing, 0);
  Model model = model_of(mesh, probed);
  for (const auto node : sides)
    if (!std::ranges::binary_search(probed, node)) model.linear_points.emplace_back().node = node;
  cover_surface(model, mesh, radius);
  const auto answered = probed_nodes(model);
  const auto is_answered = [&](std::int32_t node) { return std::ranges::binary_search(answered, node); };
  EXPECT_TRUE(std::ranges::includes(answered, inside));
  EXPECT_LE(4 * std::ranges::count_if(sides, is_answered), std::ssize(sides));
  const auto tools = tools_of(mesh, {}, all, radius);
  const auto weights_at = [&](std::int32_t node) {
    const TouchedNodes& tool = tools[static_cast<std::size_t>(node)];
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(mesh.n_nodes());
    for (std::size_t i = 0; i < tool.nodes.size(); ++i) weights[tool.nodes[i]] = tool.weights[i];
    return weights;
  };
  for (const auto& row : model.covered.rowwise()) {
    if (row[1] >= model.probe_triangles.rows()) continue;
    const double first = row[2] / whole, second = (1 - first) * (row[3] / whole);
    const double parts[] = {first, second, 1 - first - second};
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(mesh.n_nodes());
    for (int k = 0; k < 3; ++k)
      mean += parts[k] * weights_at(probed[static_cast<std::size_t>(model.probe_triangles(row[1], k))]);
    EXPECT_GE(weights_at(row[0]).cwiseMin(mean).sum(), 0.6 - 1e-4);  // Weights in the model have 16 bits.
  }
}

}  // namespace
