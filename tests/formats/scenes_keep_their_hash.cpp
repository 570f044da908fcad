// Claim: the text of a selector in the physics summary, and with it the hash in databases, does not change; neither do
// hash and values of the scenes of the distribution if defaults change. A changed hash makes all databases of such a
// scene unusable: change these numbers only together with a note in the changelog.
#include <filesystem>
#include <phynness/formats/database.hpp>

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
  EXPECT_EQ(physics_hash(scene), "12377ff066aeb629");
}

TEST(PhysicsHash, spells_every_combination_of_selectors_as_ever) {
  const Scene scene = parsed(with(good_scene, "active = \"free-surface\"", R"(active = [
  { intersection = [[{ group = "a" }, { group = "b" }], "free-surface"], surface_only = true },
  { difference = [{ nodes = [0, 7] }, "fixed", { not = "surface", surface_only = true }] },
  { near = { to = [{ group = "a" }, "fixed"], distance_m = 0.015 } }, { spacing_m = 0.012 }, { spacing = "auto" },
  { count = 16, within = { group = "a" }, from_fixed_m = 0.01 } ])"));
  EXPECT_EQ(summary_line(scene, "nodes.active"),
            "nodes.active = intersection { group \"a\" + group \"b\", free-surface } surface_only + difference { nodes "
            "[0, 7], fixed, not { surface } surface_only } + near { to = group \"a\" + fixed, distance_m = 0.015 } + "
            "spread { spacing_m = 0.012, within = free-surface } + spread { spacing = auto, within = free-surface } + "
            "spread { count = 16, within = group \"a\", from_fixed_m = 0.01 }");
}

TEST(ShippedScenes, keep_hash_element_and_family) {
  struct Shipped {
    const char *file, *hash, *element, *family;
  };
  for (const auto& [file, hash, element, family] : {
           Shipped{"../examples/model/scene.toml", "0f3331c3b41eb150", "p1-p1", "modal"},
           Shipped{"demo.toml", "aef167f904c96b4b", "es-p1-p1", "modal"},
           Shipped{"liver_case1.toml", "927ff5561329b5f6", "P1", "linear"},
           Shipped{"liver_case2.toml", "271f3d186b4b743c", "P1", "rbfn"},
           Shipped{"liver_case3.toml", "9ae035b8de2bea0c", "P1", "rbfn"},
           Shipped{"penrose_case4.toml", "933076b81ae47b2d", "shell", "rbfn"},
       }) {
    const Scene scene = read_scene(std::filesystem::path(PHYNNESS_SOURCE_DIR "/scenes") / file);
    EXPECT_EQ(physics_hash(scene), hash) << file;
    EXPECT_STREQ(name(scene.solver.element), element) << file;
    EXPECT_STREQ(name(scene.training.family), family) << file;
  }
}

// Databases made before p1-p1 became the default, or es-p1-p1 that of patches: such a scene still means the element
// that it was solved with.
TEST(StoredScene, means_the_element_that_it_was_solved_with) {
  const std::string plain = with(with(good_scene, "element = \"P1\"\n", ""), "family = \"rbfn\"\n", "");
  DatabaseHeader header;
  header.scene_text = plain;
  header.scene_name = "body.toml";
  EXPECT_EQ(stored_scene(header).solver.element, element_named("p1-p1")) << "a database that is about to be made";
  header.physics_hash = physics_hash(parsed(plain));
  EXPECT_EQ(stored_scene(header).solver.element, element_named("p1-p1"));
  header.physics_hash = physics_hash(parsed(with(plain, "[solver]", "[solver]\nelement = \"P1\"")));
  EXPECT_EQ(stored_scene(header).solver.element, element_named("P1"));
  EXPECT_EQ(physics_hash(stored_scene(header)), header.physics_hash);
  const std::string patch = with(plain, "increments = 4", "increments = 4\nkind = \"patch\"\ntool_radius_m = 0.01");
  header.scene_text = patch;
  for (const char* element : {"P1", "p1-p1", "es-p1-p1"}) {
    header.physics_hash =
        physics_hash(parsed(with(patch, "[solver]", "[solver]\nelement = \"" + std::string(element) + '"')));
    EXPECT_EQ(stored_scene(header).solver.element, element_named(element));
  }
  // Written out, nothing is left to guess.
  header.scene_text = with(good_scene, "family = \"rbfn\"\n", "");
  header.physics_hash = physics_hash(parsed(header.scene_text));
  EXPECT_EQ(stored_scene(header).solver.element, element_named("P1"));
}

// es-p1-p1 got other equations with laws that have a bulk modulus: such a scene has another hash since, and a database
// of before is read as what it is. Everything else keeps its hash.
TEST(StoredScene, has_the_equations_that_it_was_solved_with) {
  struct Pinned {
    const char *element, *law, *numbers, *earlier, *now;
  };
  for (const auto& [element, law, numbers, earlier, now] : {
           Pinned{"es-p1-p1", "mooney-rivlin", "c10_Pa = 200.0\nc01_Pa = 50.0", "ef6f6215bdb6b3fc", "73baa0db6d059ced"},
           Pinned{"es-p1-p1", "yeoh", "c10_Pa = 250.0\nc20_Pa = 10.0\nc30_Pa = 1.0", "547ffde194e6dcea",
                  "452bf1e28d407873"},
           Pinned{"es-p1-p1", "gent", "shear_modulus_Pa = 500.0\nj_m = 50.0", "d392ed3217148890", "d0bf69e4eac2d1c1"},
           Pinned{"es-p1-p1", "neo-hookean", "shear_modulus_Pa = 500.0", "eea97db4fa6799be", "eea97db4fa6799be"},
           Pinned{"p1-p1", "mooney-rivlin", "c10_Pa = 200.0\nc01_Pa = 50.0", "6eea03544f56ecc3", "6eea03544f56ecc3"},
       }) {
    DatabaseHeader header;
    header.scene_text = with(good_scene, "law = \"neo-hookean\"\nshear_modulus_Pa = 500.0",
                             "law = \"" + std::string(law) + "\"\n" + numbers);
    header.scene_text = with(header.scene_text, "element = \"P1\"", "element = \"" + std::string(element) + "\"");
    const Scene today = parsed(header.scene_text);
    EXPECT_EQ(physics_hash(today), now) << element << ", " << law;
    for (const std::string hash : {now, earlier}) {
      header.physics_hash = hash;
      const Scene stored = stored_scene(header);
      EXPECT_EQ(physics_hash(stored), hash) << element << ", " << law;
      EXPECT_EQ(stored.solver.earlier_revision.has_value(), hash != now) << element << ", " << law;
    }
  }
}

// A material whose lambda is not positive cannot be solved with p1-p1, so that its old scene is refused
// today.
TEST(StoredScene, is_read_where_it_would_be_refused_today) {
  const std::string plain =
      with(with(good_scene, "element = \"P1\"\n", ""), "bulk_modulus_Pa = 5000.0", "bulk_modulus_Pa = 300.0");
  EXPECT_THROW(parsed(plain), Error);
  DatabaseHeader header;
  header.scene_text = plain;
  header.physics_hash = physics_hash(parsed(with(plain, "[solver]", "[solver]\nelement = \"P1\"")));
  EXPECT_EQ(stored_scene(header).solver.element, element_named("P1"));
}

}  // namespace
}  // namespace phynness::test
