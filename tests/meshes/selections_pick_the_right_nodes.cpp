// Claim: each selector selects the nodes of its definition, including those exactly on its boundary. Impossible
// selections are refused with file and line.
#include <algorithm>
#include <phynness/meshes/patch_warnings.hpp>

#include "../block_mesh.hpp"
#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

using Nodes = std::vector<std::int32_t>;
constexpr std::int32_t center = 13;

/// [nodes] with these selections, of which each stands on a line of its own: 4, 5 and 6.
Scene scene_with(const std::string& output, const std::string& active = "\"free-surface\"") {
  return parse_scene(
      "mesh.shape = \"block\"\nmaterial = { law = \"linear\", shear_modulus_Pa = 1, bulk_modulus_Pa = 1 }\n"
      "[nodes]\nfixed = { box = { min_m = [0, 0, 0], max_m = [2, 2, 0] } }\nactive = " +
          active + "\noutput = " + output + "\n[probe]\nmax_displacement_m = 0.1\n",
      "scene.toml", ".");
}

Nodes selected(const std::string& output) { return resolve_selections(scene_with(output), grid()).output; }

TEST(Selections, BoxTakesItsFacesIn) {
  EXPECT_EQ(selected("{ box = { min_m = [1, 1, 1], max_m = [2, 2, 1] } }"), (Nodes{13, 14, 16, 17}));
}

TEST(Selections, NodesAFewRoundingErrorsOffTheFaceCountIn) {
  EXPECT_EQ(selected("{ box = { min_m = [1.000000000001, 1, 1], max_m = [2, 2, 1] } }").size(), 4u);
  EXPECT_EQ(selected("{ box = { min_m = [1.000001, 1, 1], max_m = [2, 2, 1] } }").size(), 2u);
}

TEST(Selections, FractionsAreOfTheBoundingBox) {
  EXPECT_EQ(selected("{ box = { min_fraction = [0.5, 0.5, 0.5], max_fraction = [1, 1, 0.5] } }"),
            (Nodes{13, 14, 16, 17}));
}

TEST(Selections, Sphere) {
  EXPECT_EQ(selected("{ sphere = { center_m = [1, 1, 1], radius_m = 1 } }"), (Nodes{4, 10, 12, 13, 14, 16, 22}));
}

TEST(Selections, PlaneTakesBothSidesWithinItsTolerance) {
  EXPECT_EQ(selected("{ plane = { point_m = [0, 0, 1.5], normal = [0, 0, 2], tolerance_m = 0.5 } }").size(), 18u);
  EXPECT_EQ(selected("{ plane = { point_m = [0, 0, 1], normal = [0, 0, -3] } }").size(), 9u);
}

TEST(Selections, HalfSpaceLiesBehindItsNormal) {
  EXPECT_EQ(selected("{ half_space = { point_m = [1, 0, 0], normal = [5, 0, 0] } }").size(), 18u);
  EXPECT_EQ(selected("{ half_space = { point_m = [1.5, 0, 0], normal = [-1, 0, 0] } }").size(), 9u);
}

TEST(Selections, NearestIsOneNode) {
  EXPECT_EQ(selected("{ nearest = { point_m = [1.2, 1.1, 0.9] } }"), (Nodes{center}));
  // The middle of the face at x = 2.
  EXPECT_EQ(selected("{ nearest = { point_m = [1.2, 1.1, 0.9] }, surface_only = true }"), (Nodes{14}));
}

TEST(Selections, GroupsAndNodeLists) {
  EXPECT_EQ(selected("{ group = \"corners\" }"), (Nodes{0, 2, 6, 8}));
  EXPECT_EQ(selected("{ nodes = [5, 3, 5] }"), (Nodes{3, 5}));
  EXPECT_EQ(selected("{ nodes = [5, 13], surface_only = true }"), (Nodes{5}));
}

TEST(Selections, SurfaceFreeAndAll) {
  EXPECT_EQ(selected("\"surface\"").size(), 26u);
  EXPECT_EQ(selected("\"free-surface\"").size(), 17u);
  EXPECT_EQ(selected("\"free\"").size(), 18u);
  EXPECT_EQ(selected("\"all\"").size(), 27u);
}

TEST(Selections, AListIsTheUnionOfItsSelectors) {
  EXPECT_EQ(selected("[{ nodes = [1, 2] }, { nodes = [2, 3] }]"), (Nodes{1, 2, 3}));
}

TEST(Selections, IntersectionIsWhatAllHave) {
  EXPECT_EQ(selected("{ intersection = [{ sphere = { center_m = [2, 1, 0], radius_m = 1 } }, \"free-surface\"] }"),
            (Nodes{14}));
  EXPECT_EQ(selected("{ intersection = [{ nodes = [5, 13, 14, 22] }, \"free\", \"surface\"] }"), (Nodes{14, 22}));
  EXPECT_EQ(selected("{ intersection = [[{ nodes = [5] }, { nodes = [14] }], { nodes = [14, 20] }] }"), (Nodes{14}));
}

TEST(Selections, DifferenceIsTheFirstWithoutTheOthers) {
  EXPECT_EQ(selected("{ difference = [{ nodes = [0, 5, 13, 14, 22] }, \"fixed\", { nodes = [22] }] }"),
            (Nodes{13, 14}));
  EXPECT_EQ(selected("{ difference = [\"all\", \"surface\"] }"), (Nodes{center}));
}

TEST(Selections, NotIsEveryOtherNode) {
  EXPECT_EQ(selected("{ not = \"surface\" }"), (Nodes{center}));
  EXPECT_EQ(selected("{ not = [\"free\", { group = \"corners\" }] }"), (Nodes{1, 3, 4, 5, 7}));
  EXPECT_EQ(selected("{ not = { nodes = [26] }, surface_only = true }").size(), 25u);
}

TEST(Selections, NearReachesToItsDistance) {
  EXPECT_EQ(selected("{ near = { to = { nodes = [13] }, distance_m = 1 } }"), (Nodes{4, 10, 12, 13, 14, 16, 22}));
  EXPECT_EQ(selected("{ near = { to = { nodes = [13] }, distance_m = 0.99 } }"), (Nodes{center}));
  EXPECT_EQ(selected("{ difference = [\"free-surface\", { near = { to = \"fixed\", distance_m = 1 } }] }"),
            (Nodes{18, 19, 20, 21, 22, 23, 24, 25, 26}));
  for (const char* distance : {"0.5", "1", "1.2", "1.42", "1.7", "2", "2.9"}) {
    const auto ball = [&](int x, int y, int z) {
      return "{ sphere = { center_m = [" + std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z) +
             "], radius_m = " + distance + " } }";
    };
    EXPECT_EQ(selected(std::string("{ near = { to = { nodes = [0, 5, 21] }, distance_m = ") + distance + " } }"),
              selected("[" + ball(0, 0, 0) + ", " + ball(2, 1, 0) + ", " + ball(0, 1, 2) + "]"))
        << distance;
  }
}

/// With a round tool of this radius; 0: node probes.
Scene spread(const std::string& active, double radius = 3) {
  Scene scene = scene_with("\"free-surface\"", active);
  if (radius > 0) scene.probe.kind = ProbeKind::patch;
  scene.probe.tool_radius_m = radius;
  return scene;
}

TEST(Selections, SpreadPointsLieWithinAPartAndFarFromFixedNodes) {
  const auto free = selected("\"free-surface\"");
  const auto five = selected("{ count = 5 }");
  EXPECT_EQ(five.size(), 5u);
  EXPECT_TRUE(std::includes(free.begin(), free.end(), five.begin(), five.end()));
  EXPECT_EQ(selected("{ count = 3, within = { group = \"corners\" } }").size(), 3u);
  EXPECT_EQ(selected("{ spacing_m = 0.5, from_fixed_m = 2 }"), (Nodes{18, 19, 20, 21, 22, 23, 24, 25, 26}));
  EXPECT_EQ(selected("{ intersection = [{ spacing_m = 0.5 }, { nodes = [13, 14, 22] }] }"), (Nodes{14, 22}));
  // A third of the radius: the edges, of which every second node is farther than 3/4.
  EXPECT_EQ(resolve_selections(spread("{ spacing = \"auto\" }"), grid()).active, free);
  EXPECT_LT(resolve_selections(spread("{ spacing = \"auto\" }", 6), grid()).active.size(), free.size());
}

TEST(Selections, ThatCannotBeSpreadAreRefused) {
  const auto message = [](const std::string& active, double radius = 3) {
    return error_of([&] { resolve_selections(spread(active, radius), grid()); });
  };
  auto text = message("{ count = 18 }");
  EXPECT_TRUE(contains(text, "scene.toml:5") && contains(text, "18 of 17")) << text;
  text = message("{ spacing_m = 50 }");
  EXPECT_TRUE(contains(text, "scene.toml:5") && contains(text, "50 m") && contains(text, "count = 1")) << text;
  text = message("{ spacing = \"auto\" }", 0);
  EXPECT_TRUE(contains(text, "scene.toml:5") && contains(text, "tool_radius_m")) << text;
  text = message("{ spacing_m = 0.5, within = { nodes = [22] } }");
  expect_names(text, {"of 1 nodes 0 chosen", "three nodes of the surface", "without a spacing"});
  text = message("{ spacing_m = 1, from_fixed_m = 3 }");
  expect_names(text, {"scene.toml:5", "from_fixed_m = 3", "from_fixed_m smaller than 2 m"});
  text = message("{ spacing_m = 1, from_fixed_m = 1, within = { nodes = [" + std::to_string(center) + "] } }");
  expect_names(text, {"give a part of the surface"});
}

TEST(Selections, ThatAreSpreadButNotCoveredGetAWarning) {
  const auto warning = [](const std::string& active, double radius) {
    const Scene scene = spread(active, radius);
    const auto sets = resolve_selections(scene, grid());
    const auto choice = choice_note(scene, grid(), sets);
    const auto all = patch_warnings(scene, grid(), sets);
    return !choice.empty() ? choice : all.empty() ? "" : all.front();
  };
  auto text = warning("{ spacing_m = 0.5 }", 3);
  EXPECT_TRUE(contains(text, "scene.toml:5") && contains(text, "17 of the 17 nodes")) << text;
  text = warning("{ spacing_m = 1, within = { spacing = \"auto\" } }", 6);
  EXPECT_TRUE(contains(text, "5 of the 5 nodes")) << text;
  text = warning("{ count = 9 }", 0);
  EXPECT_TRUE(contains(text, "scene.toml:5") && contains(text, "only at the 9 points")) << text;
  text = warning("{ count = 2 }", 3);
  EXPECT_TRUE(contains(text, "no triangle between the 2 points") && contains(text, "\"auto\"")) << text;
  text = warning("{ count = 9 }", 1.5);
  EXPECT_TRUE(contains(text, "triangles between the points, such as at node ") &&
              contains(text, ", have edges longer than the radius"))
      << text;
  EXPECT_TRUE(contains(text, "spacing = \"auto\" covers the part")) << text;
}

// Claim: spacing = "auto" that probes every node is named where many are probed, and with a spacing that follows the
// tool already, triangles that are too long ask for a finer mesh.
TEST(Selections, ThatAreSpreadByTheToolAskForWhatHelps) {
  const auto warnings = [](const Mesh& mesh, double radius, const char* active = "{ spacing = \"auto\" }") {
    const Scene scene = spread(active, radius);
    const auto sets = resolve_selections(scene, mesh);
    std::string all = choice_note(scene, mesh, sets) + "\n";
    for (const auto& one : patch_warnings(scene, mesh, sets)) all += one + "\n";
    return all;
  };
  EXPECT_FALSE(contains(warnings(grid(), 3), "are probed"));  // 17 of 17
  // Edges of 2 m: of 125 nodes 27 are inside and 4 are fixed.
  const auto text = warnings(block_mesh({4, 4, 4}, {8, 8, 8}), 6);
  EXPECT_TRUE(contains(text, "chose 2e+03 mm between points, a third of the radius") &&
              contains(text, "94 of the 94 nodes of the part are probed"))
      << text;
  const auto gaps = warnings(grid(), 1.2);  // the diagonals have 1.41 m
  EXPECT_TRUE(contains(gaps, "edges of at most the radius, tool_radius_m = 1.2") &&
              contains(gaps, "smaller target_size_m"))
      << gaps;
  EXPECT_FALSE(contains(gaps, "covers the part")) << gaps;
  EXPECT_EQ(warnings(grid(), 1.2, "{ difference = [{ spacing = \"auto\" }, \"fixed\"] }"), gaps);
}

TEST(Selections, OfNoNodeNameTheNearestOfTheSurfaceAndItsDistance) {
  const auto message = [](const std::string& output) { return error_of([&] { selected(output); }); };
  auto text = message("{ sphere = { center_m = [2, 2, 4], radius_m = 0.5 } }");
  EXPECT_TRUE(contains(text, "26 at (2, 2, 2) m, 1.5 m")) << text;
  EXPECT_TRUE(contains(text, "the body measures (2, 2, 2) m") && contains(text, "scale_to_m in [mesh]")) << text;
  text = message("{ box = { min_fraction = [1.5, 2.5, 0], max_fraction = [3, 3, 0] } }");
  EXPECT_TRUE(contains(text, "8 at (1, 1, 0)") && contains(text, "3.16228 m")) << text;
  text = message("{ plane = { point_m = [-3, 0, 0], normal = [1, 0, 0], tolerance_m = 0.5 } }");
  EXPECT_TRUE(contains(text, "0 at (0, 0, 0) m, 2.5 m")) << text;
  text = message("{ half_space = { point_m = [0, -2, 0], normal = [0, 1, 0] } }");
  EXPECT_TRUE(contains(text, "0 at (0, 0, 0) m, 2 m")) << text;
  text = message("{ nodes = [13], surface_only = true }");
  EXPECT_TRUE(contains(text, "scene.toml:6") && contains(text, "surface_only for the 1 node")) << text;
  text = message("{ intersection = [{ nodes = [0, 1] }, { group = \"corners\" }, \"free\"] }");
  EXPECT_TRUE(contains(text, "(2 nodes)") && contains(text, "(4 nodes)") && contains(text, "(18 nodes)")) << text;
  text = message("{ difference = [{ nodes = [0, 1] }, \"fixed\"] }");
  EXPECT_TRUE(contains(text, "(2 nodes)") && contains(text, "(9 nodes)")) << text;
  text = message("{ not = \"all\" }");
  EXPECT_TRUE(contains(text, "scene.toml:6") && contains(text, "selects no node")) << text;
  EXPECT_FALSE(contains(text, "scale_to_m")) << text;
  text = message("{ difference = [\"all\", { sphere = { center_m = [2, 2, 4], radius_m = 0.5 } }] }");
  EXPECT_TRUE(contains(text, "scene.toml:6") && contains(text, "26 at (2, 2, 2) m, 1.5 m")) << text;
}

TEST(Selections, AfterAnErrorHoldWhatWasSelectedBefore) {
  NodeSets sets;
  EXPECT_THROW(resolve_selections(scene_with("{ sphere = { center_m = [9, 9, 9], radius_m = 0.1 } }"), grid(), sets),
               Error);
  EXPECT_EQ(sets.fixed.size(), 9u);
  EXPECT_EQ(sets.active.size(), 17u);
  EXPECT_TRUE(sets.output.empty());
}

TEST(Selections, OutputMayHoldFixedNodes) { EXPECT_EQ(selected("\"all\"").front(), 0); }

TEST(Selections, MistakesAreNamedWithTheirLine) {
  const auto message = [](const Scene& scene) { return error_of([&] { resolve_selections(scene, grid()); }); };
  const Scene good = scene_with("\"all\"");
  EXPECT_EQ(message(good), "");

  auto text = message(scene_with("{ sphere = { center_m = [9, 9, 9], radius_m = 0.1 } }"));
  EXPECT_TRUE(contains(text, "scene.toml:6: ") && contains(text, "output")) << text;
  EXPECT_TRUE(contains(text, "sphere at (9, 9, 9) m, radius 0.1 m") && contains(text, "(2, 2, 2) m")) << text;

  text = message(scene_with("\"all\"", "\"surface\""));
  EXPECT_TRUE(contains(text, "scene.toml:5: ") && contains(text, "active") && contains(text, "9 nodes: 0")) << text;

  // "auto" belongs to another key.
  text = error_of([] { scene_with("\"all\"", "{ spacing_m = \"auto\" }"); });
  EXPECT_TRUE(contains(text, "scene.toml:5: ") && contains(text, "spacing = \"auto\"")) << text;

  // Remedies that leave something to touch.
  text = message(scene_with("\"all\"", "{ nodes = [0, 1] }"));
  EXPECT_TRUE(contains(text, "2 nodes: 0") && !contains(text, "difference") && contains(text, "free-surface")) << text;
  text = message(scene_with("\"all\"", "{ nodes = [13] }"));
  EXPECT_TRUE(contains(text, "inside") && !contains(text, "surface_only") && contains(text, "free-surface")) << text;

  text = message(scene_with("{ group = \"hilum\" }"));
  EXPECT_TRUE(contains(text, "scene.toml:6: ") && contains(text, "hilum") && contains(text, "'corners'")) << text;

  text = message(scene_with("{ nodes = [3, 27] }"));
  EXPECT_TRUE(contains(text, "output") && contains(text, "27") && contains(text, "0 to 26")) << text;

  Scene scene = good;
  scene.fixed.clear();
  text = message(scene);
  EXPECT_TRUE(contains(text, "scene.toml:4: ") && contains(text, "fixed")) << text;
}

}  // namespace
}  // namespace phynness::test
