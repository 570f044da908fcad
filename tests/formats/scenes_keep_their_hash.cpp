// Claim: the text of a selector and of a law in the physics summary, and with it the hash in databases, does not
// change; neither do hash and values of the scenes of the distribution if defaults change. A changed hash makes all
// databases of such a scene unusable: change these numbers only together with a note in the changelog.
#include <filesystem>

#include "../bad_input/scene_under_test.hpp"

namespace phynness::test {
namespace {

std::string summary_line(const Scene& scene, const std::string& key) {
  const auto summary = physics_summary(scene);
  const auto begin = summary.find(key + " = ");
  return summary.substr(begin, summary.find('\n', begin) - begin);
}

TEST(PhysicsHash, spells_every_selector_as_ever) {
  const Scene scene = parsed(with(good_scene, "active = \"free-surface\"", R"(active = [
  { box = { min_m = [0, 1e-3, -0.25], max_m = [1, 0.1, 0.5] }, surface_only = false },
  { sphere = { center_fraction = [0.5, 0.5, 1], radius_m = 0.01 }, surface_only = true },
  { plane = { point_m = [0, 0, 1], normal = [0, 0, 2] } },
  { plane = { point_fraction = [0, 0, 1], normal = [1, 1, 0], tolerance_m = 0.001 } },
  { half_space = { point_m = [0, 0, 1], normal = [0, 3, 4] } },
  { group = "lobe" }, { nodes = [0, 7, 5] },
  { nearest = { point_fraction = [1, 1, 0.3] } }, "surface", "free-surface", "free", "all" ])"));
  EXPECT_EQ(summary_line(scene, "nodes.fixed"),
            "nodes.fixed = box { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] }");
  EXPECT_EQ(summary_line(scene, "nodes.active"),
            "nodes.active = box { min_m = [0, 0.001, -0.25], max_m = [1, 0.1, 0.5] } + sphere { center_fraction = "
            "[0.5, 0.5, 1], radius_m = 0.01 } surface_only + plane { point_m = [0, 0, 1], normal = [0, 0, 1], "
            "tolerance_m = 1e-06 } + plane { point_fraction = [0, 0, 1], normal = [0.7071067811865475, "
            "0.7071067811865475, 0], tolerance_m = 0.001 } + half_space { point_m = [0, 0, 1], normal = [0, 0.6, "
            "0.8] "
            "} + group \"lobe\" + nodes [0, 7, 5] + nearest { point_fraction = [1, 1, 0.3] } + surface + "
            "free-surface "
            "+ free + all");
  EXPECT_EQ(summary_line(scene, "nodes.output"), "nodes.output = free-surface");
  EXPECT_EQ(physics_hash(scene), "73402a485f98187b");
}

TEST(PhysicsHash, spells_every_combination_of_selectors_as_ever) {
  const Scene scene = parsed(with(good_scene, "active = \"free-surface\"", R"(active = [
  { intersection = [[{ group = "a" }, { group = "b" }], "free-surface"], surface_only = true },
  { difference = [{ nodes = [0, 7] }, "fixed", { not = "surface", surface_only = true }] },
  { near = { to = [{ group = "a" }, "fixed"], distance_m = 0.015 } }, { spacing_m = 0.012 }, { spacing = "auto" },
  { count = 16, within = { group = "a" }, from_fixed_m = 0.01 },
  { ellipsoid = { center_m = [0, 0.5, 1], radii_m = [0.01, 2e-2, 3] } } ])"));
  EXPECT_EQ(summary_line(scene, "nodes.active"),
            "nodes.active = intersection { group \"a\" + group \"b\", free-surface } surface_only + difference { nodes "
            "[0, 7], fixed, not { surface } surface_only } + near { to = group \"a\" + fixed, distance_m = 0.015 } + "
            "spread { spacing_m = 0.012, within = free-surface } + spread { spacing = auto, within = free-surface } + "
            "spread { count = 16, within = group \"a\", from_fixed_m = 0.01 } + "
            "ellipsoid { center_m = [0, 0.5, 1], radii_m = [0.01, 0.02, 3] }");
}

TEST(PhysicsHash, does_not_contain_the_relaxation) {
  const Scene relaxing = parsed(with(good_scene, "law = \"neo-hookean\"",
                                     "law = \"neo-hookean\"\nrelaxation = { g = [0.3, 0.2], tau_s = [2, 20.5] }"));
  EXPECT_EQ(physics_hash(relaxing), physics_hash(parsed(good_scene)));
  EXPECT_NE(other_settings(relaxing).find("material.relaxation = 30 % in 2 s, 20 % in 20.5 s\n"), std::string::npos);
  EXPECT_TRUE(parsed(good_scene).relaxation.empty());
}

TEST(ShippedScenes, keep_hash_element_and_family) {
  struct Shipped {
    const char *file, *hash, *element, *family;
  };
  for (const auto& [file, hash, element, family] : {
           Shipped{"../examples/model/scene.toml", "1833d2b29663bfb6", "p1-p1", "modal"},
           Shipped{"demo.toml", "0ff7f2ec86362d50", "es-p1-p1", "modal"},
           Shipped{"liver_relaxing.toml", "4d8892e404d66eb9", "es-p1-p1", "modal"},
           Shipped{"liver_case1.toml", "49294041b950946e", "P1", "linear"},
           Shipped{"liver_case2.toml", "377e6cc4e6fd3f68", "P1", "rbfn"},
           Shipped{"liver_case3.toml", "55603a113c26bb8e", "P1", "rbfn"},
           Shipped{"liver_nodule.toml", "ffd328fcdf03dfc1", "es-p1-p1", "modal"},
           Shipped{"penrose_case4.toml", "7fc0c8a253bf11dd", "shell", "rbfn"},
       }) {
    const Scene scene = read_scene(std::filesystem::path(PHYNNESS_SOURCE_DIR "/scenes") / file);
    EXPECT_EQ(physics_hash(scene), hash) << file;
    EXPECT_STREQ(name(scene.solver.element), element) << file;
    EXPECT_STREQ(name(scene.training.family), family) << file;
  }
}

/// A law as it was described in its first databases.
struct Pinned {
  std::string name, law_and_moduli, lines, hash;
};

class PhysicsHashOfALaw : public testing::TestWithParam<Pinned> {};

TEST_P(PhysicsHashOfALaw, IsThatOfItsFirstDatabases) {
  const auto& [name, law_and_moduli, lines, hash] = GetParam();
  // Every choice is written out, so that no default has a part in the hash.
  const auto scene =
      parsed("[mesh]\nshape = \"block\"\ntarget_nodes = 60\nsize_m = [0.1, 0.1, 0.1]\n[material]\n" + law_and_moduli +
             "\n[solver]\nelement = \"P1\"\nrelative_tolerance = 1e-8\nmax_iterations = 40\n"
             "max_cutbacks = 6\n[nodes]\nfixed = { group = \"base\" }\nactive = \"free-surface\"\n"
             "output = \"free-surface\"\n[probe]\nkind = \"node\"\ndirections = 26\nincrements = 4\n"
             "max_displacement_m = 0.02\n");
  const auto summary = physics_summary(scene);
  const auto from = summary.find("material."), to = summary.find("solver.");
  EXPECT_EQ(summary.substr(from, to - from), lines);
  EXPECT_EQ(physics_hash(scene), hash) << summary;
}

INSTANTIATE_TEST_SUITE_P(
    Laws, PhysicsHashOfALaw,
    testing::Values(Pinned{"linear", "law = \"linear\"\nyoungs_modulus_Pa = 1500.0\npoisson_ratio = 0.45",
                           "material.law = linear\nmaterial.shear_modulus_Pa = "
                           "517.2413793103449\nmaterial.lame_lambda_Pa = 4655.172413793105\n",
                           "0e9b4e5a39e0582b"},
                    Pinned{"st_venant_kirchhoff",
                           "law = \"st-venant-kirchhoff\"\nshear_modulus_Pa = 500.0\nlame_lambda_Pa = 1234.5",
                           "material.law = st-venant-kirchhoff\nmaterial.shear_modulus_Pa = "
                           "500\nmaterial.lame_lambda_Pa = 1234.5\n",
                           "427c5741694f3019"},
                    Pinned{"neo_hookean", "law = \"neo-hookean\"\nc10_Pa = 250.0\nd1_per_Pa = 1e-5",
                           "material.law = neo-hookean\nmaterial.shear_modulus_Pa = "
                           "500\nmaterial.lame_lambda_Pa = 99666.66666666666\n",
                           "4989c0d143d16ee7"},
                    Pinned{"neo_hookean_by_youngs_modulus",
                           "law = \"neo-hookean\"\nyoungs_modulus_Pa = 1500.0\nbulk_modulus_Pa = 5e4",
                           "material.law = neo-hookean\nmaterial.shear_modulus_Pa = "
                           "501.67224080267556\nmaterial.lame_lambda_Pa = 49665.55183946488\n",
                           "e7926360f79d589f"},
                    Pinned{"mooney_rivlin", "law = \"mooney-rivlin\"\nc10_Pa = 2.0\nc01_Pa = 0.2\nd1_per_Pa = 1e-5",
                           "material.law = mooney-rivlin\nmaterial.c10_Pa = 2\nmaterial.c01_Pa = "
                           "0.2\nmaterial.bulk_modulus_Pa = 99999.99999999999\n",
                           "e1941fc003b49de4"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace phynness::test
