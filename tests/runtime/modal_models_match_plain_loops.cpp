#include <gtest/gtest.h>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// The formulas of formats/model.md as printed there, term by term, from the host's model.
Matrix3d phi(const Vector3d& y, double s) { return q(y, s) * Matrix3d::Identity() + y * y.transpose() / q(y, s); }
Vector3d g(const Vector3d& y, double s) { return q(y, s) * y; }
Matrix3d h(const Vector3d& y, const Vector3d& b, double s) {
  return (b * y.transpose() + y * b.transpose() +
          y.dot(b) * (Matrix3d::Identity() - y * y.transpose() / std::pow(q(y, s), 2))) /
         q(y, s);
}

struct Response {
  Vector3d force;
  double energy;
  Matrix3d stiffness;
  Points u;
  double force_terms, energy_terms,
      stiffness_terms;  ///< sums of the sizes of the terms: what rounding is measured by
  double u_terms;
};

Response plain(const Model& model, const ActiveNodeModel& node, const Vector3d& d) {
  const double R = model.max_displacement_m;
  const auto center = [&](std::int32_t row) { return Vector3d(model.displacements.row(row).transpose() / R); };
  const Vector3d x = d / R, zero(0, 0, 0);
  const ConservativeNetwork& net = node.conservative;
  const double s = net.shape;
  Response r{net.stiffness * d, d.dot(net.stiffness * d) / 2, net.stiffness, {}, 0, 0, 0, 0};
  r.force_terms = r.force.norm();
  r.energy_terms = r.energy;
  r.stiffness_terms = net.stiffness.norm();
  for (std::size_t i = 0; i < net.centers.size(); ++i) {
    const Vector3d c = center(net.centers[i]), b = net.coefficients.row(static_cast<Eigen::Index>(i));
    r.force += (phi(x - c, s) - phi(x, s) - phi(c, s) + phi(zero, s)) * b;
    r.energy += R * (g(x - c, s) - g(x, s) + g(c, s) - (phi(c, s) - phi(zero, s)) * x).dot(b);
    r.stiffness += (h(x - c, b, s) - h(x, b, s)) / R;
    const double size = q(x, s) + q(c, s);
    r.force_terms += 4 * size * b.norm();
    r.energy_terms += 4 * R * size * size * b.norm();
    r.stiffness_terms += 8 / R * b.norm();
  }
  const phynness::SharedModes& shared = model.shared;
  Eigen::VectorXd basis(static_cast<Eigen::Index>(shared.centers.size()) + 3);
  for (std::size_t i = 0; i < shared.centers.size(); ++i) {
    const Vector3d c = center(shared.centers[i]);
    basis[static_cast<Eigen::Index>(i)] =
        q(x - c, shared.shape) - q(x, shared.shape) - q(c, shared.shape) + q(zero, shared.shape);
  }
  basis.tail(3) = x;
  const Eigen::VectorXd a = node.modal.weights.values().transpose() * basis;
  const Eigen::VectorXd amounts = node.modal.mixing.values() * a;
  const Eigen::VectorXd all = shared.modes.values() * amounts, near = node.modal.near_modes.values() * a;
  r.u_terms = (shared.modes.values().cwiseAbs() * amounts.cwiseAbs()).maxCoeff() +
              (node.modal.near_modes.values().cwiseAbs() * a.cwiseAbs()).sum();
  r.u.resize(model.output_points.rows(), 3);
  for (Eigen::Index o = 0; o < r.u.rows(); ++o) r.u.row(o) = all.segment<3>(3 * o).transpose();
  for (std::size_t i = 0; i < node.modal.near.size(); ++i)
    r.u.row(node.modal.near[i]) = near.segment<3>(3 * static_cast<Eigen::Index>(i)).transpose();
  for (std::size_t i = 0; i < node.prescribed.size(); ++i)
    for (std::size_t o = 0; o < model.output.size(); ++o)
      if (model.output[o] == node.prescribed[i])
        r.u.row(static_cast<Eigen::Index>(o)) = node.prescribed_weight[i] * d.transpose();
  return r;
}

const Vector3d probes[] = {{0, 0, 0},  {0.004, -0.002, 0.001}, {0.01, 0, 0}, {-0.02, 0.03, 0.01},
                           {1, 1, -1}, {0, 0.005, 0},          {1e-9, 0, 0}, {0.0099, -0.0001, 0.0005}};

/// Models of every shape: no centers, no shared modes, one more than a pass takes, more output than a piece holds.
std::vector<Model> models() {
  std::vector<Model> all = {small_modal_model(), small_modal_model(1, 0, 1, 0), small_modal_model(2, 3, 0, 1),
                            small_modal_model(7, 30, 13, 8)};
  Model& large = all.emplace_back(small_modal_model(4, 5, 5, 4));
  Numbers numbers;
  large.n_mesh_nodes = 1000;
  large.output.clear();
  for (int i = 0; i < 400; ++i) large.output.push_back(i + 2);
  large.output_points = Points::Random(400, 3);
  large.shared.modes = random_table(1200, 5, 0.5, numbers);
  return all;
}

// Claim: force, energy and stiffness are the formulas of formats/model.md, to rounding: 1e-14 of the sizes of the
// terms, which the runtime sums in another order; 1e-12 of the force itself, whose terms may be a hundred times larger.
TEST(ModalRuntime, ForceEnergyAndStiffnessAreTheFormulas) {
  for (const Model& model : models()) {
    const LoadedModel loaded(write_model_text(model));
    for (const ActiveNodeModel& node : model.nodes)
      for (const Vector3d& d : probes) {
        const Response expected = plain(model, node, d);
        Vector3d force;
        Matrix3d stiffness;
        double energy = 0;
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force.data(), nullptr, nullptr), 0);
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), nullptr, &energy, nullptr), 0);
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), nullptr, nullptr, stiffness.data()),
                  0);
        EXPECT_LE((force - expected.force).norm(), 1e-14 * expected.force_terms);
        EXPECT_LE(std::abs(energy - expected.energy), 1e-14 * expected.energy_terms);
        EXPECT_LE((stiffness - expected.stiffness).norm(), 1e-14 * expected.stiffness_terms);
        if (d.norm() > 1e-3) {
          EXPECT_LT((force - expected.force).norm(), 1e-12 * expected.force.norm());
        }
        EXPECT_EQ(stiffness, stiffness.transpose());
      }
  }
}

// Claim: deformation is the sum of modes, with near nodes and the nodes of the probe replaced. Shared modes
// are summed as floats: 1e-6 of the sizes of the terms is 16 roundings of 6e-8, of which up to 13 modes make,
// 1e-5 of the largest displacement. The other nodes are sums in double, 1e-14.
TEST(ModalRuntime, DeformationIsTheSumOfModes) {
  for (const Model& model : models()) {
    const LoadedModel loaded(write_model_text(model));
    for (const ActiveNodeModel& node : model.nodes) {
      for (const Vector3d& d : probes) {
        if (d.isZero(0)) continue;  // the printed formula rounds there; see NothingHappensAtRest
        const Response expected = plain(model, node, d);
        Points u(model.output_points.rows(), 3);
        ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d.data()), u.data()), 0);
        EXPECT_LE((u - expected.u).cwiseAbs().maxCoeff(), 1e-6 * expected.u_terms);
        EXPECT_LE((u - expected.u).cwiseAbs().maxCoeff(), 1e-5 * expected.u.cwiseAbs().maxCoeff());
        for (const std::int32_t near : node.modal.near)
          EXPECT_LE((u.row(near) - expected.u.row(near)).norm(), 1e-14 * (1 + 100 * d.norm()));
        for (std::size_t o = 0; o < model.output.size(); ++o)
          for (std::size_t i = 0; i < node.prescribed.size(); ++i)
            if (node.prescribed[i] == model.output[o]) {
              EXPECT_EQ(u.row(static_cast<Eigen::Index>(o)), node.prescribed_weight[i] * d.transpose());
            }
      }
    }
  }
}

// Claim: the state of rest is one, exactly: no force, no energy, no displacement, for either sign of zero.
TEST(ModalRuntime, NothingHappensAtRest) {
  for (const Model& model : models()) {
    const LoadedModel loaded(write_model_text(model));
    for (const ActiveNodeModel& node : model.nodes)
      for (const double zero : {0.0, -0.0}) {
        const double d[] = {zero, 0, zero};
        Vector3d force(1, 1, 1);
        double energy = 1;
        Points u = Points::Ones(model.output_points.rows(), 3);
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d), force.data(), nullptr, nullptr), 0);
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d), nullptr, &energy, nullptr), 0);
        ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d), u.data()), 0);
        EXPECT_EQ(force.cwiseAbs().maxCoeff(), 0);
        EXPECT_EQ(energy, 0);
        EXPECT_EQ(u.cwiseAbs().maxCoeff(), 0);
      }
  }
}

}  // namespace
