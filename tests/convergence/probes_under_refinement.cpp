// Claim: under refinement the force of a patch converges for every element, and that of a node does not. The
// displacement of a point under a point force is infinite, so that the force of a node decreases with the mesh size.
//
// The body is 10 x 8 x 6 cm with K/mu = 10, divided into 4 x 4 x 3 boxes (h), and into 2 and 4 times as many per edge.
// A patch prescribes only its nodes, so that its boundary is determined up to an element, and its force converges
// unevenly with an order of about 1.
#include <gtest/gtest.h>

#include <phynness/meshes/tool_weights.hpp>
#include <set>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

ProbeBlock refined(Element element, ProbeKind kind, double bulk_to_shear, int times) {
  auto block = probe_block({law_named("neo-hookean"), element}, bulk_to_shear, {4 * times, 4 * times, 3 * times});
  block.scene.probe.kind = kind;
  if (kind == ProbeKind::patch) block.scene.probe.tool_radius_m = 0.04;
  return block;
}

double force_at_5_mm(Element element, ProbeKind kind, int times) {
  const auto response = refined(element, kind, 10, times).touched().solve({{0, 0, -0.005}}, 2);
  EXPECT_EQ(response.status, Status::converged);
  const double force = -response.force_N[0][2];
  std::printf("%s, %s, h/%d: %.4f N\n", name(element), name(kind), times, force);
  return force;
}

TEST(ForceOfAPatch, ConvergesUnderRefinement) {
  // Differences shrink to less than half each time: order above 1.
  const double at_h = force_at_5_mm(element_named("p1-p1"), ProbeKind::patch, 1),
               at_half = force_at_5_mm(element_named("p1-p1"), ProbeKind::patch, 2),
               at_quarter = force_at_5_mm(element_named("p1-p1"), ProbeKind::patch, 4);
  EXPECT_LT(std::abs(at_quarter - at_half), 0.5 * std::abs(at_half - at_h));
  EXPECT_NEAR(at_quarter, at_half, 0.06 * at_quarter);
  // What is left to go is about the last difference; quadratic elements, half way down, agree within that.
  EXPECT_NEAR(force_at_5_mm(element_named("P2"), ProbeKind::patch, 2), at_quarter, 0.06 * at_quarter);
}

// Claim: beside fixed nodes the stiffness of es-p1-p1 at rest is within a tenth of that of Taylor-Hood on an eighth of
// the cells, in the mean over places within a radius, at nodes and in triangles with fixed corners. Held is a quarter
// of the block; a tool has 2.5 edges. Measured: see the printed lines.
TEST(ForceOfAPatch, IsThatOfAFineBodyBesideFixedNodes) {
  const auto held = [](Element element, int times) {
    auto block = probe_block({law_named("neo-hookean"), element}, 50, {6 * times, 5 * times, 4 * times});
    block.scene.probe.kind = ProbeKind::patch;
    block.scene.probe.tool_radius_m = 0.042;
    block.sets.fixed.clear();
    const std::set<std::int32_t> surface(block.mesh.surface.data(),
                                         block.mesh.surface.data() + block.mesh.surface.size());
    for (const auto i : surface)
      if (block.mesh.nodes(i, 0) < 0.34 * block_size_m[0]) block.sets.fixed.push_back(i);
    return block;
  };
  const auto coarse = held(element_named("es-p1-p1"), 1), fine = held(element_named("taylor-hood"), 2);
  auto of_coarse = coarse.solver(), of_fine = fine.solver();
  const auto mean_error = [&](std::initializer_list<double> all_x) {
    double sum = 0;
    int n = 0;
    for (const double x : all_x)
      for (const double y : {0.016, 0.032}) {
        const auto stiffness = [&](ProbeSolver& solver, const Mesh& mesh) {
          return solver.single_tool_at_rest(nearest_on_surface(mesh.nodes, mesh.surface, {x, y, block_size_m[2]}))
              .stiffness_N_per_m;
        };
        const auto K = stiffness(of_coarse, coarse.mesh), expected = stiffness(of_fine, fine.mesh);
        const double off = (K - expected).norm() / expected.norm();
        std::printf("at %g, %g: off by %.3f, %.3f of it\n", x, y, off, K.norm() / expected.norm());
        sum += off, ++n;
      }
    return sum / n;
  };
  EXPECT_LT(mean_error({0.05, 0.0667}), 0.1);
  EXPECT_LT(mean_error({0.038, 0.042, 0.046}), 0.1);
}

class ForceOfANode : public ::testing::TestWithParam<Element> {};

TEST_P(ForceOfANode, FallsWithoutEndUnderRefinement) {
  // As 1/h in the limit, so to about a half each time; 0.6 leaves room for the coarsest mesh.
  const double at_h = force_at_5_mm(GetParam(), ProbeKind::node, 1),
               at_half = force_at_5_mm(GetParam(), ProbeKind::node, 2),
               at_quarter = force_at_5_mm(GetParam(), ProbeKind::node, 4);
  EXPECT_LT(at_half, 0.6 * at_h);
  EXPECT_LT(at_quarter, 0.6 * at_half);
}

INSTANTIATE_TEST_SUITE_P(Elements, ForceOfANode,
                         ::testing::Values(element_named("P1"), element_named("p1-p1"), element_named("es-p1-p1")),
                         element_name);

TEST(StiffnessAtANode, ShowsP1LockedAtTheLiversIncompressibility) {
  // K/mu = 200, on one mesh: P1 is at least three times as stiff as any other element, which differ by no
  // more than a factor of two among themselves, in the order p1-p1, P2, Taylor-Hood.
  std::map<Element, double> k;
  for (const auto element : every_element) {
    k[element] = refined(element, ProbeKind::node, 200, 2).touched().rest().stiffness_N_per_m(2, 2);
    std::printf("K/mu 200, %s: %.2f N/m\n", name(element), k[element]);
  }
  EXPECT_GT(k[element_named("P1")], 3 * k[element_named("p1-p1")]);
  EXPECT_GT(k[element_named("p1-p1")], k[element_named("P2")]);
  EXPECT_GT(k[element_named("P2")], k[element_named("taylor-hood")]);
  EXPECT_LT(k[element_named("p1-p1")], 2 * k[element_named("taylor-hood")]);
}

}  // namespace
}  // namespace phynness::test
