#include <gtest/gtest.h>

#include <phynness/validation/named_organ.hpp>

#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

const std::vector<std::int32_t> tools = {3, 8, 15};
const std::vector<Vec3> displacements = {{0.004, 0.001, 0}, {0, -0.006, 0.002}, {0.003, 0.003, -0.001}};

NamedOrgan organ_of(const Model& model) {
  Mesh mesh;
  mesh.cells.resize(0, 4);
  mesh.nodes = Points::Zero(model.n_mesh_nodes, 3);
  for (const auto& node : model.nodes) mesh.nodes.row(node.node) = to_eigen(node.point).transpose();
  return NamedOrgan(model, mesh, "model");
}

// Claim: away from the touched nodes the field is sum Theta_I U_I with Theta_I of (16), here computed as
// printed; U_I is the field of tool I alone. 1e-13 relative is rounding of a weighted sum.
TEST(SeveralTools, FieldIsTheWeightedSum) {
  const Model model = small_model();
  const NamedOrgan organ = organ_of(model);
  const Points u = organ.blend(tools, displacements).displacement_m;
  for (Eigen::Index o = 0; o < u.rows(); ++o) {
    Eigen::RowVector3d expected(0, 0, 0);
    double sum = 0;
    bool touched = false;
    for (std::size_t t = 0; t < 3; ++t) {
      const ActiveNodeModel& node = model.nodes[t == 0 ? 0 : t + 1];
      const double distance = (model.output_points.row(o) - to_eigen(node.point).transpose()).norm();
      touched = touched || distance == 0;
      sum += 1 / distance;
      expected += 1 / distance * organ.blend({tools[t]}, {displacements[t]}).displacement_m.row(o);
    }
    if (!touched) {
      EXPECT_LT((u.row(o) - expected / sum).norm(), 1e-13 * u.norm());
    }
  }
}

// Claim: where (16) is singular, at a touched node, that node takes exactly its own displacement.
TEST(SeveralTools, TouchedNodesFollowExactly) {
  const Points u = organ_of(small_model()).blend(tools, displacements).displacement_m;
  EXPECT_EQ(u.row(3 - 2), to_eigen(displacements[0]).transpose());
  EXPECT_EQ(u.row(8 - 2), to_eigen(displacements[1]).transpose());
}

// Claim: two tools at one node act as one with their mean displacement there. Rounding of a mean: 1e-15.
TEST(SeveralTools, AtOneNodeActAsTheirMean) {
  const Points u = organ_of(small_model()).blend({3, 3}, {displacements[0], displacements[1]}).displacement_m;
  EXPECT_LT((u.row(3 - 2).transpose() - (to_eigen(displacements[0]) + to_eigen(displacements[1])) / 2).norm(), 1e-15);
}

// Claim: two nodes at one place (the lips of a slit) share the weight there instead of dividing by zero.
TEST(SeveralTools, CoincidentNodesAreDefined) {
  Model model = small_model(0, 0);
  model.nodes[1].point = model.nodes[0].point;
  model.output_points.row(3) = model.output_points.row(1);
  EXPECT_TRUE(organ_of(model).blend({3, 5}, {displacements[0], displacements[1]}).displacement_m.allFinite());
}

}  // namespace
