// Claims about points of a database that have a response at rest only: each is in the model with its stiffness and
// fields, in every family, and the model of the same database without them is otherwise the same.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Round tools; the node behind each active one has a response at rest.
DatabaseHeader header_with_points() {
  DatabaseHeader header = small_header(8);
  header.mesh.surface.resize(n_nodes - 2, 3);
  for (int i = 0; i + 2 < n_nodes; ++i) header.mesh.surface.row(i) << i, i + 1, i + 2;
  for (auto& tool : header.sets.tools) tool.mean = true;
  for (const auto node : header.sets.active)
    if (node + 1 < n_nodes) header.sets.linear.push_back(node + 1);
  header.sets.linear_tools = single_nodes(header.sets.linear);
  return header;
}

/// Largest near the point, and as smooth elsewhere as those of a body.
AtRest response_of(const DatabaseHeader& header, std::int32_t i) {
  AtRest response;
  const Eigen::RowVector3d touched = header.mesh.nodes.row(header.sets.linear[static_cast<std::size_t>(i)]);
  for (int k = 0; k < 9; ++k) response.stiffness_N_per_m[static_cast<std::size_t>(k)] = k % 4 == 0 ? 40 + i + k : 2;
  for (int axis = 0; axis < 3; ++axis)
    for (const auto o : header.sets.output) {
      const Eigen::RowVector3d x = header.mesh.nodes.row(o) - touched, d = Eigen::RowVector3d::Unit(axis);
      const double r2 = x.squaredNorm() + 1e-3;
      const Eigen::RowVector3d u = 0.03 / std::sqrt(r2) * (d + x * (x.dot(d) / r2));
      response.displacement.insert(response.displacement.end(), u.begin(), u.end());
    }
  return response;
}

TEST(LinearPoints, AreThoseAtRest) {
  const DatabaseHeader header = header_with_points();
  DatabaseHeader bare = header;
  bare.sets.linear.clear();
  for (const Family family : {Family::rbfn, Family::modal}) {
    const auto source_with = [&](const DatabaseHeader& of) {
      ResponseSource source = source_of(of);
      source.probe.kind = ProbeKind::patch;
      source.probe.tool_radius_m = 0.2;
      source.at_rest = [&of](std::int32_t i) { return response_of(of, i); };
      return source;
    };
    const TrainingSpec spec = family == Family::modal ? modal_spec() : small_spec();
    TrainingReport report;
    Model model = train(source_with(header), spec, report);
    ASSERT_EQ(model.linear_points.size(), header.sets.linear.size());
    for (std::size_t i = 0; i < model.linear_points.size(); ++i) {
      const LinearPoint& point = model.linear_points[i];
      const AtRest wanted = response_of(header, static_cast<std::int32_t>(i));
      EXPECT_EQ(point.node, header.sets.linear[i]);
      for (int k = 0; k < 9; ++k)
        EXPECT_EQ(point.stiffness.data()[k], wanted.stiffness_N_per_m[static_cast<std::size_t>(k)]);
      Eigen::MatrixXd unit = model.rest_modes.values() * point.mixing.values();
      const Eigen::MatrixXd near = point.near_modes.values();
      for (std::size_t n = 0; n < point.near.size(); ++n)
        unit.middleRows<3>(3 * point.near[n]) = near.middleRows<3>(3 * static_cast<Eigen::Index>(n));
      // 32 of 39 independent fields are shared, and the nodes with the largest errors have their own values.
      const Eigen::Map<const Eigen::MatrixXd> expected(wanted.displacement.data(), 3 * n_nodes, 3);
      EXPECT_LT((unit - expected).norm(), 0.02 * expected.norm()) << i;
    }
    EXPECT_EQ(model.covered.rows(), n_nodes);
    const std::string text = write_model_text(model);
    EXPECT_EQ(write_model_text(read_model_text(text, "model.txt")), text);
    model.linear_points.clear();
    model.rest_modes = {};
    model.outer_triangles.resize(0, 3);
    model.covered.resize(0, 4);
    model.probe_triangles.resize(0, 3);
    EXPECT_EQ(write_model_text(model), write_model_text(train(source_with(bare), spec, report)));
  }
}

}  // namespace
