// Claim: an edge of the edge-smoothed element has a sixth of the volume of each of its cells, the mean gradient of
// these cells weighted by volume, and the dofs of their nodes. The shear energy is that of these gradients, except for
// the share that is that of the cells: with the linear law and zero pressure, sums of mu e : e. The edges and cells are
// found here in the mesh that went in; both sums round in a different order.
#include <set>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

constexpr double rounding_of_sums = 1e-12;

struct Sum {
  double volume = 0;
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  ///< times the volume
  std::set<std::int32_t> nodes;
};

TEST(Edges, HaveTheMeanGradientAndASixthOfTheVolumeOfTheirCells) {
  Random random(3);
  const auto mesh = irregular(block_mesh({3, 2, 2}, {1, 1.2, 0.9}), 0.08, random);
  Discretization body(mesh, form_set(unit_material(law_named("linear"), 10), element_named("es-p1-p1"), 1));
  const auto state = state_of(body, [&](const Vector3&) { return Vector3(random(), random(), random()); });

  double energy = 0;
  const auto shear = [](const Eigen::Matrix3d& H) { return ((H + H.transpose()) / 2).eval().squaredNorm(); };
  std::map<std::set<std::int32_t>, Sum> by_nodes;  // the pair of nodes of an edge
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c) {
    Eigen::Matrix3d sides, moved;
    for (int i = 0; i < 3; ++i) {
      sides.col(i) = (mesh.nodes.row(mesh.cells(c, i + 1)) - mesh.nodes.row(mesh.cells(c, 0))).transpose();
      moved.col(i) = value_at(body, state, mesh.cells(c, i + 1)) - value_at(body, state, mesh.cells(c, 0));
    }
    energy += cell_share * sides.determinant() / 6 * shear(moved * sides.inverse());
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) {
        auto& sum = by_nodes[{mesh.cells(c, i), mesh.cells(c, j)}];
        sum.volume += sides.determinant() / 36;
        sum.gradient += sides.determinant() / 36 * moved * sides.inverse();
        for (int k = 0; k < 4; ++k) sum.nodes.insert(mesh.cells(c, k));
      }
  }
  // By the dofs of the nodes around an edge; edges of one cell only have the same.
  std::multimap<std::set<std::int32_t>, Sum> by_dofs;
  for (const auto& [nodes, sum] : by_nodes) {
    std::set<std::int32_t> dofs;
    for (const auto node : sum.nodes) dofs.insert(body.dofs(node).begin(), body.dofs(node).end());
    by_dofs.emplace(dofs, sum);
    energy += (1 - cell_share) * sum.volume * shear(sum.gradient / sum.volume);
  }
  const auto& edges = body.edge_patches();
  ASSERT_EQ(edges.size(), static_cast<int>(by_dofs.size()));
  double total = 0;
  for (int i = 0; i < edges.size(); ++i) {
    const auto dofs = edges.dofs(i);
    const auto [first, last] = by_dofs.equal_range(std::set<std::int32_t>(dofs.begin(), dofs.end()));
    const auto found = std::find_if(first, last, [&](const auto& entry) {
      const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + entry.second.gradient / entry.second.volume;
      return std::abs(edges.volume(i) - entry.second.volume) < rounding_of_sums * entry.second.volume &&
             (edges.gradient(i, state) - F).norm() < rounding_of_sums * F.norm();
    });
    ASSERT_NE(found, last) << "edge " << i;
    by_dofs.erase(found);
    total += edges.volume(i);
  }
  EXPECT_NEAR(total, 1 * 1.2 * 0.9, rounding_of_sums);
  EXPECT_NEAR(body.energy(state), energy, rounding_of_sums * energy);
}

// Claim: laws with a bulk modulus, whose shape does not see changes of volume, have mu/3 (J - 1)^2 of their volumetric
// energy at the edges and not in the pressure: it is the energy of a dilation without pressure.
TEST(Edges, SeeChangesOfVolumeInEveryLaw) {
  const Vector3 size(1, 1.2, 0.9);
  for (const char* law : {"mooney-rivlin", "yeoh", "gent"}) {
    Discretization body(block_mesh({1, 1, 1}, {size[0], size[1], size[2]}),
                        form_set(unit_material(law_named(law), 10), element_named("es-p1-p1"), 1));
    const auto state = state_of(body, [](const Vector3& X) { return Vector3(0.1 * X); });
    const double g = std::pow(1.1, 3) - 1;
    EXPECT_NEAR(body.energy(state), size.prod() / 3 * g * g, rounding_of_sums) << law;
  }
}

TEST(Edges, OtherElementsHaveNone) {
  for (const auto element : every_element) {
    const Discretization body(block_mesh({1, 1, 1}, {1, 1, 1}),
                              form_set(unit_material(law_named("linear"), 10), element, 1));
    EXPECT_EQ(body.edge_patches().size() > 0, element == element_named("es-p1-p1"));
  }
}

}  // namespace
}  // namespace phynness::test
