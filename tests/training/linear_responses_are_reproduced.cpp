#include <gtest/gtest.h>

#include <phynness/formats/error.hpp>
#include <phynness/training/training.hpp>
#include <random>

#include "../messages.hpp"
#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// A linear body made up: at every active node a symmetric stiffness and unit responses, the node's own the identity.
LinearResponse made_up(const DatabaseHeader& header, std::int32_t active) {
  std::mt19937_64 random(static_cast<std::uint64_t>(active) + 1);
  const auto number = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  LinearResponse linear;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) linear.stiffness(i, j) = linear.stiffness(j, i) = (i == j ? 60 : 0) + 20 * number();
  linear.unit_responses.resize(n_nodes, 9);
  for (Eigen::Index o = 0; o < n_nodes; ++o)
    for (int i = 0; i < 9; ++i) linear.unit_responses(o, i) = 0.5 * number();
  auto own = linear.unit_responses.row(header.sets.active[active]);
  own.setZero();
  own[0] = own[4] = own[8] = 1;
  return linear;
}

Eigen::Vector3d displacement(const LinearResponse& linear, Eigen::Index o, const Eigen::Vector3d& d) {
  return Eigen::Map<const Eigen::Matrix3d>(linear.unit_responses.row(o).data()) * d;
}

/// What a database of that body holds; `bend` adds the square of the displacement, as a nonlinear body would.
std::vector<Ray> linear_rays(const DatabaseHeader& header, std::int32_t active, double bend = 0) {
  const LinearResponse linear = made_up(header, active);
  std::vector<Ray> rays;
  for (std::size_t k = 0; k < header.directions.size(); ++k) {
    Ray ray;
    ray.active = active;
    ray.direction = static_cast<std::int32_t>(k);
    ray.status.assign(header.magnitudes_m.size(), Status::converged);
    for (const double magnitude : header.magnitudes_m) {
      const Vec3& e = header.directions[k];
      const Eigen::Vector3d d(magnitude * e[0], magnitude * e[1], magnitude * e[2]);
      const double more = 1 + bend * d.norm();
      const Eigen::Vector3d force = more * (linear.stiffness * d);
      ray.force.insert(ray.force.end(), force.begin(), force.end());
      ray.energy.push_back((0.5 + bend * d.norm() / 3) * d.dot(linear.stiffness * d));
      for (Eigen::Index o = 0; o < n_nodes; ++o)
        for (const double u : displacement(linear, o, d))
          ray.displacement.push_back(header.float64 ? u : static_cast<double>(static_cast<float>(u)));
    }
    rays.push_back(std::move(ray));
  }
  return rays;
}

DatabaseHeader linear_header(bool float64) {
  DatabaseHeader header = small_header();
  header.float64 = float64;
  return header;
}

Model train_linear(const DatabaseHeader& header, const std::function<std::vector<Ray>(std::int32_t)>& rays,
                   TrainingReport& report, int threads = 1) {
  TrainingSpec spec;
  spec.family = Family::linear;
  return train({&header, rays, {}, "linear"}, spec, report, {}, threads);
}

std::string refusal(const DatabaseHeader& header, const std::function<std::vector<Ray>(std::int32_t)>& rays) {
  TrainingReport report;
  return error_of([&] { train_linear(header, rays, report); });
}

// Claim: responses at random displacements, ten times the trained depth, come back: to 1e-12 of |d| from
// float64 data (rounding of 104 increments, a condition number of about 1), to 1e-6 from float32 data (6e-8
// of each component, twice). Forces are float64 in either.
TEST(LinearTraining, ResponsesAreReproducedTenTimesDeeper) {
  for (const bool float64 : {true, false}) {
    const DatabaseHeader header = linear_header(float64);
    TrainingReport report;
    const Model model = train_linear(
        header, [&](std::int32_t active) { return linear_rays(header, active); }, report);
    ASSERT_EQ(model.family, Family::linear);
    ASSERT_EQ(model.nodes.size(), header.sets.active.size());
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> uniform(-10, 10);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const LinearResponse truth = made_up(header, static_cast<std::int32_t>(i));
      const LinearResponse& found = model.nodes[i].linear;
      EXPECT_EQ(found.stiffness, found.stiffness.transpose());
      for (int probe = 0; probe < 20; ++probe) {
        Eigen::Vector3d d(uniform(random), uniform(random), uniform(random));
        d *= header.magnitudes_m.back();
        EXPECT_LT(((found.stiffness - truth.stiffness) * d).norm(), 1e-12 * (truth.stiffness * d).norm());
        for (Eigen::Index o = 0; o < n_nodes; ++o)
          EXPECT_LT((displacement(found, o, d) - displacement(truth, o, d)).norm(),
                    (float64 ? 1e-12 : 1e-6) * d.norm());
        EXPECT_EQ(displacement(found, model.nodes[i].node, d), d) << "the touched node follows exactly";
      }
      EXPECT_EQ(model.nodes[i].trained_depth_m, std::vector<double>(26, header.magnitudes_m.back()));
    }
    EXPECT_LT(report.linear.displacement_residual, float64 ? 1e-13 : 2e-7);
    EXPECT_LT(report.linear.force_residual, 1e-13);
    EXPECT_LT(report.linear.energy_residual, 1e-13);
    EXPECT_LT(report.linear.asymmetry, 1e-13);
  }
}

// Claim: a patch's own nodes move by their weights, whatever rounding the database has.
TEST(LinearTraining, PrescribedNodesMoveByTheirWeight) {
  const DatabaseHeader header = linear_header(false);
  const TrainingTables tables = training_tables(header);
  const LinearTraining trained = train_linear_node(tables, 3, {0, 0, 0}, {{2, 3}, {0.3, 1.0}}, linear_rays(header, 1));
  const Eigen::Vector3d d(0.1, -0.2, 0.3);
  EXPECT_EQ(displacement(trained.model.linear, 2, d), 0.3 * d);
  EXPECT_EQ(displacement(trained.model.linear, 3, d), d);
}

// Claim: what is not linear is refused with node, size and remedy: a body 1 % stiffer at full depth (forces),
// one whose displacements alone bend, and one probed by a single increment along three axes, where any
// response fits and energy or symmetry tell.
TEST(LinearTraining, NonlinearDataIsRefused) {
  const DatabaseHeader header = linear_header(true);
  const std::string stiffer =
      refusal(header, [&](std::int32_t active) { return linear_rays(header, active, 0.01 / 0.012); });
  expect_names(stiffer, {"node 0", "forces", "0.01 %", "rbfn"});

  const auto bent = [&](std::int32_t active) {
    std::vector<Ray> rays = linear_rays(header, active);
    for (double& u : rays[3].displacement) u *= 1.001;
    return rays;
  };
  EXPECT_NE(refusal(header, bent).find("displacements"), std::string::npos) << refusal(header, bent);

  DatabaseHeader three = linear_header(true);
  three.directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  three.magnitudes_m = {0.012};
  const auto single = [&](double bend) {
    return refusal(three, [&, bend](std::int32_t active) { return linear_rays(three, active, bend); });
  };
  EXPECT_EQ(single(0), "");
  EXPECT_NE(single(0.01 / 0.012).find("energies differ"), std::string::npos) << single(0.01 / 0.012);
  const auto skewed = [&](std::int32_t active) {
    std::vector<Ray> rays = linear_rays(three, active);
    rays[0].force[1] += 1e-3 * rays[0].force[0];
    return rays;
  };
  EXPECT_NE(refusal(three, skewed).find("transpose"), std::string::npos) << refusal(three, skewed);
}

// Claim: a departure within the tolerance is accepted and reported at its size: the refusal is no hair trigger.
TEST(LinearTraining, SmallResidualsAreAcceptedAndReported) {
  const DatabaseHeader header = linear_header(true);
  TrainingReport report;
  train_linear(
      header, [&](std::int32_t active) { return linear_rays(header, active, 2e-5 / 0.012); }, report);
  EXPECT_GT(report.linear.force_residual, 1e-6);
  EXPECT_LT(report.linear.force_residual, linear_tolerance);
}

// Claim: fewer than three independent directions are refused, naming the node: two directions, and three in a
// plane. Directions that failed count as missing; failed increments never enter.
TEST(LinearTraining, TooFewDirectionsAreRefused) {
  DatabaseHeader header = linear_header(true);
  const auto only = [&](std::vector<std::size_t> kept) {
    return [&header, kept](std::int32_t active) {
      std::vector<Ray> rays = linear_rays(header, active);
      for (std::size_t k = 0; k < rays.size(); ++k) {
        if (active != 2 || std::find(kept.begin(), kept.end(), k) != kept.end()) continue;
        rays[k].status.assign(n_increments, Status::diverged);
        std::fill(rays[k].force.begin(), rays[k].force.end(), std::nan(""));
      }
      return rays;
    };
  };
  const std::string node = "node " + std::to_string(header.sets.active[2]);
  const std::size_t n = header.directions.size();
  for (const std::vector<std::size_t>& kept : {std::vector<std::size_t>{0, 5}, {0, n - 1}, {7}})
    expect_names(refusal(header, only(kept)), {"three independent directions", node, "remedy"});
  header.directions = {{1, 0, 0}, {0, 1, 0}, {0.6, 0.8, 0}, {0.6, -0.8, 0}};
  EXPECT_NE(refusal(header, only({0, 1, 2, 3})).find("three independent directions"), std::string::npos);
  header.directions = {{1, 0, 0}, {0, 1, 0}, {0.6, 0, 0.8}, {0.6, -0.8, 0}};
  EXPECT_EQ(refusal(header, only({0, 1, 2})), "") << "three independent ones suffice";
}

// Claim: a value that is not finite in a converged increment is a damaged database.
TEST(LinearTraining, ValuesThatAreNotFiniteAreRefused) {
  const DatabaseHeader header = linear_header(true);
  const auto rays = [&](std::int32_t active) {
    std::vector<Ray> all = linear_rays(header, active);
    all[4].displacement[17] = std::numeric_limits<double>::infinity();
    return all;
  };
  EXPECT_NE(refusal(header, rays).find("not finite"), std::string::npos) << refusal(header, rays);
}

}  // namespace
