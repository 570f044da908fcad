#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "loaded_model.hpp"
#include "small_model.hpp"
#include "tools/surface_turn.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

/// Node 0 with a closed rim of n nodes around it that goes up and down; triangles of all sizes.
Model fan(int n) {
  Model model = small_linear_model();
  model.n_mesh_nodes = n + 2;
  model.fixed = {n + 1};
  model.fixed_points.resize(1, 3);
  model.fixed_points << 0, 0, -0.1;
  model.output.clear();
  model.output_points = Points::Zero(n + 1, 3);
  model.surface.resize(n, 3);
  for (int i = 0; i <= n; ++i) {
    model.output.push_back(i);
    const double angle = 2 * M_PI * std::pow(i / (n + 1.0), 1.3);
    if (i > 0)
      model.output_points.row(i) << 0.03 * std::cos(angle), 0.02 * std::sin(angle), 0.004 * std::cos(3 * angle);
    if (i > 0) model.surface.row(i - 1) << 0, i, i % n + 1;
  }
  model.nodes.resize(3);
  for (int i = 0; i < 3; ++i) {
    ActiveNodeModel& node = model.nodes[static_cast<std::size_t>(i)];
    node.node = i;
    for (int k = 0; k < 3; ++k) node.point[k] = model.output_points(i, k);
    node.prescribed = {i};
    node.prescribed_weight = {1};
    node.trained_depth_m = {0.01, 0.01, 0.01, 0.01};
    node.linear.stiffness = Eigen::Matrix3d::Identity();
    node.linear.unit_responses = Eigen::MatrixXd::Zero(n + 1, 9);
    for (int k = 0; k < 3; ++k) node.linear.unit_responses(i, 4 * k) = 1;
  }
  return model;
}

struct Turned {
  Vector3d by = Vector3d::Zero();
  int parts = 0;
};

/// The rotation that displacements of the vertices make around some of them.
template <class Displacement>
Turned turn_of(const phn_model& model, const std::vector<std::int32_t>& vertices, const std::vector<double>& weights,
               const Displacement& u) {
  Turned turned;
  runtime::SurfaceTurn part = {};
  while (runtime::next_turn(model, static_cast<std::int32_t>(vertices.size()), vertices.data(), weights.data(), part)) {
    for (std::int32_t i = 0; i < part.n; ++i) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> map(part.map[i].a);
      turned.by += map * u(Vector3d(Eigen::Map<const Vector3d>(model.output_points + 3 * part.vertex[i])));
    }
    ++turned.parts;
  }
  if (part.area > 0) turned.by /= part.area;
  return turned;
}

// Claim: a rigid rotation, infinitesimal, is found, wherever its axis is and however many triangles meet; a
// translation and a swelling are none. At a node and between three.
TEST(SurfaceTurn, IsThatOfARigidBody) {
  const Vector3d w(0.3, -0.2, 0.5), center(0.1, 0.05, -0.02);
  for (const int n : {3, 6, 40, 200}) {
    const LoadedModel loaded(write_model_text(fan(n)));
    const auto rigid = [&](const Vector3d& x) { return Vector3d(w.cross(x - center)); };
    for (const auto& weights : {std::vector<double>{1, 0, 0}, {0.2, 0.5, 0.3}}) {
      const Turned turned = turn_of(*loaded.model, {0, 1, 2}, weights, rigid);
      EXPECT_LT((turned.by - w).norm(), 1e-13) << n;
      EXPECT_EQ(turned.parts > 1, n > 48) << n;
      EXPECT_LT(turn_of(*loaded.model, {0, 1, 2}, weights, [](const Vector3d&) { return Vector3d(1, 2, 3); }).by.norm(),
                1e-11);  // gradients of 1 / 3 mm
      EXPECT_LT(turn_of(*loaded.model, {0, 1, 2}, weights, [](const Vector3d& x) { return x; }).by.norm(), 1e-13);
    }
  }
}

// Claim: a surface without triangles, or with none of any area, does not turn.
TEST(SurfaceTurn, NeedsASurface) {
  Model model = fan(6);
  const auto lift = [](const Vector3d& x) { return Vector3d(0, 0, x[0]); };
  EXPECT_GT(turn_of(*LoadedModel(write_model_text(model)).model, {0}, {1}, lift).by.norm(), 0.1);
  for (int i = 1; i <= 6; ++i) model.output_points.row(i) << 0.01 * i, 0, 0;
  EXPECT_EQ(turn_of(*LoadedModel(write_model_text(model)).model, {0}, {1}, lift).by, Vector3d::Zero());
  model.surface.resize(0, 3);
  EXPECT_EQ(turn_of(*LoadedModel(write_model_text(model)).model, {0}, {1}, lift).parts, 0);
}

runtime::Vector small(const Vector3d& x) { return runtime::vector_at(x.data()); }
Vector3d eigen(const runtime::Vector& x) { return Vector3d::Map(x.x); }

// Claim: rotated is the rotation by 2 atan |v| around v and its inverse, up to half a turn where v has no
// bound; rotation_gradient is its derivative, by central differences.
TEST(Rotate, IsARotationWithADerivative) {
  Numbers numbers;
  const auto random = [&] { return numbers.vector(); };
  for (const double size : {0.0, 1e-9, 0.1, 1.0, 30.0, 1e100}) {
    const Vector3d v = size * random().normalized(), x = random(), g = random();
    const Eigen::AngleAxisd rotation(2 * std::atan(v.norm()), size > 0 ? v.normalized() : Vector3d::UnitX().eval());
    Vector3d there, back, gradient;
    there = eigen(runtime::rotated(small(v), small(x)));
    back = eigen(runtime::rotated_back(small(v), small(there)));
    EXPECT_LT((there - rotation * x).norm(), 1e-14) << size;
    EXPECT_LT((back - x).norm(), 1e-14) << size;
    if (size > 1e10) continue;
    gradient = eigen(runtime::rotation_gradient(small(v), small(g), small(x)));
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-5 * std::fmax(1, size);
      double value[2];
      for (int side = 0; side < 2; ++side) {
        const Vector3d moved = v + (side == 0 ? -h : h) * Vector3d::Unit(k);
        back = eigen(runtime::rotated_back(small(moved), small(x)));
        value[side] = g.dot(back);
      }
      EXPECT_NEAR((value[1] - value[0]) / (2 * h), gradient[k], 1e-9) << size;
    }
  }
}

}  // namespace
