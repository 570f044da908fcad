// Claim: probes up to R have the same directions and depths whatever the model trained, uniform in the sphere of
// directions and in (0, R]; probes inside the trained range do not depend on that. Both are compared bit for bit. Means
// of 4000 uniform numbers differ from 1/2 by less than 0.03, which is six standard deviations.
#include <gtest/gtest.h>

#include <cmath>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/validation.hpp>

#include "linear_body.hpp"

namespace phynness::test {
namespace {

constexpr double R = 0.01;

/// A linear body of three nodes with the given trained depths in its four directions.
NamedOrgan body(const std::vector<double>& depths) {
  Model model = LinearBody(3).model;
  for (auto& node : model.nodes) node.trained_depth_m = depths;
  Mesh mesh;
  mesh.nodes.resize(4, 3);
  mesh.nodes.topRows(3) = model.output_points;
  mesh.nodes.row(3) = model.fixed_points.row(0);
  mesh.cells.resize(1, 4);
  mesh.cells << 0, 1, 2, 3;
  return {std::move(model), std::move(mesh), "body"};
}

struct RangeProbes {
  std::vector<std::array<double, 5>> drawn;   ///< node, displacement, beyond
  std::vector<std::array<double, 4>> inside;  ///< node, displacement
};

RangeProbes drawn_for(const NamedOrgan& model, double range_m, std::int64_t probes = 8000) {
  RangeProbes out;
  for (const auto& entry : plan_probes(model, Directions::twenty_six, probes, 3, 3, range_m))
    for (const auto& pair : entry.pairs) {
      const auto& e = pair.direction;
      const double node = entry.node;
      for (const double s : {pair.to_range_m, pair.beyond_range_m})
        if (s > 0) out.drawn.push_back({node, s * e[0], s * e[1], s * e[2], s == pair.beyond_range_m ? 1.0 : 0.0});
      if (pair.inside_m > 0)
        out.inside.push_back({node, pair.inside_m * e[0], pair.inside_m * e[1], pair.inside_m * e[2]});
    }
  return out;
}

TEST(ShortenedRays, HideNoProbe) {
  const auto whole = drawn_for(body({R, R, R, R}), R), shortened = drawn_for(body({R, 0.4 * R, 0.7 * R, R}), R);
  EXPECT_EQ(whole.drawn, shortened.drawn);
  EXPECT_NE(whole.inside, shortened.inside);
}

TEST(UntrainedDirections, HideNoProbe) {
  const auto untrained = drawn_for(body({R, 0, 0, R}), R);
  std::vector<double> depth;
  double z = 0, half = 0;
  for (const auto& p : untrained.drawn) {
    const double s = std::hypot(p[1], p[2], p[3]);
    if (p[4] > 0) {
      EXPECT_GT(s, R * (1 - 1e-12));
      EXPECT_LE(s, outside_factor * R * (1 + 1e-12));
      continue;
    }
    EXPECT_LE(s, R * (1 + 1e-12));
    depth.push_back(s);
    half += s / R / 4000;
    z += p[3] / s / 4000;
  }
  EXPECT_EQ(depth.size(), 4000U);
  EXPECT_NEAR(half, 0.5, 0.03);
  EXPECT_NEAR(z, 0, 0.06);  // uniform in (-1, 1)
  EXPECT_EQ(untrained.inside.size(), 4000U);
}

TEST(ProbesInside, AreWhatTheyWere) {
  for (const auto& depths : {std::vector{R, R, R, R}, std::vector{R, 0.4 * R, 0.0, R}}) {
    const auto model = body(depths);
    EXPECT_EQ(drawn_for(model, R).inside, drawn_for(model, 0).inside);
    EXPECT_TRUE(drawn_for(model, 0).drawn.empty());
  }
}

}  // namespace
}  // namespace phynness::test
