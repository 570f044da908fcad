// Claim: the numbers of points that a plan gives for other spacings are those that a scene with these spacings selects,
// however its active nodes are selected now; without a round tool it plans none.
#include <gtest/gtest.h>

#include <phynness/planning/planning.hpp>

#include "../block_mesh.hpp"

namespace phynness::test {
namespace {

struct Selected {
  Scene scene;
  NodeSets sets;
};

Selected selected(const Mesh& mesh, const std::string& active, const std::string& probe) {
  Selected result;
  result.scene = parse_scene(
      "[mesh]\nshape = \"block\"\n[material]\nlaw = \"linear\"\nyoungs_modulus_Pa = 1e3\npoisson_ratio = 0.45\n"
      "[nodes]\nfixed = { plane = { point_m = [0, 0, 0], normal = [1, 0, 0], tolerance_m = 1e-6 } }\nactive = " +
          active + "\n[probe]\nmax_displacement_m = 0.01\n" + probe,
      "body.toml", ".");
  SelectableBody body(mesh);
  body.fixed = result.sets.fixed = select_nodes(result.scene.fixed, body, "fixed", {});
  body.tool_radius_m = result.scene.probe.tool_radius_m;
  result.sets.active = select_nodes(result.scene.active, body, "active", {});
  return result;
}

TEST(Spacings, CountThePointsThatAScenePicks) {
  const Mesh mesh = block_mesh({12, 12, 2}, {0.12, 0.12, 0.02});
  const std::string tool = "kind = \"patch\"\ntool_radius_m = 0.066\n";
  for (const std::string within : {"",
                                   "within = { box = { min_fraction = [0.2, 0, 1], max_fraction = [1, 1, 1] } }, "
                                   "from_fixed_m = 0.03"}) {
    const auto active = [&](const std::string& size) {
      return "{ " + size + (within.empty() ? "" : ", ") + within + " }";
    };
    for (const std::string size : {"spacing = \"auto\"", "count = 5", "spacing_m = 0.025"}) {
      const auto now = selected(mesh, active(size), tool);
      const auto plans = plan_spacings(now.scene, mesh, now.sets, 0.0114);
      ASSERT_EQ(plans.size(), 3u);
      for (std::size_t i = 0; i < 3; ++i) {
        const double spacing_m = std::array{0.022, 0.011, 0.044}[i];
        EXPECT_NEAR(plans[i].spacing_m, spacing_m, 1e-15);
        const auto then = selected(mesh, active("spacing_m = " + std::to_string(spacing_m)), tool);
        EXPECT_EQ(plans[i].points, std::ssize(then.sets.active)) << size << ", " << spacing_m << within;
      }
      // Edges have 10 mm, and of the diagonals 14: 11.4 mm in the mean.
      EXPECT_EQ(plans[0].every_node || plans[2].every_node, false);
      EXPECT_TRUE(plans[1].every_node && !plans[1].mean) << "finer than anything that was measured";
      EXPECT_TRUE(plans[0].mean && plans[0].p95 && !plans[2].mean);
      EXPECT_GT(plans[1].points, plans[0].points);
      EXPECT_GT(plans[0].points, plans[2].points);
    }
  }
  const auto every_node = selected(mesh, "\"free-surface\"", tool);
  EXPECT_EQ(plan_spacings(every_node.scene, mesh, every_node.sets, 0)[0].points,
            std::ssize(selected(mesh, "{ spacing = \"auto\" }", tool).sets.active));
  const auto node = selected(mesh, "{ count = 5 }", "");
  EXPECT_TRUE(plan_spacings(node.scene, mesh, node.sets, 0).empty());
}

}  // namespace
}  // namespace phynness::test
