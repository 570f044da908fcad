// Claims: the meaning of a scene does not depend on the pair of moduli with which it is written. Its hash depends on
// the physics only. All scenes of the distribution are valid. The locale of the process has no influence.
#include <clocale>
#include <cmath>
#include <filesystem>
#include <locale>
#include <sstream>

#include <phynness/validation/locking.hpp>

#include "../bad_input/scene_under_test.hpp"

namespace phynness::test {
namespace {

const std::string moduli = "shear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0";
const std::string law_and_moduli = "law = \"neo-hookean\"\n" + moduli;

// mu = 500 Pa and K = 5000 Pa in every pair; the conversions are a few operations, so rounding stays near 1e-15.
TEST(Material, is_the_same_in_every_pair_of_moduli) {
  const double mu = 500, bulk = 5000, lambda = bulk - 2 * mu / 3;
  const double young = 9 * bulk * mu / (3 * bulk + mu), poisson = (3 * bulk - 2 * mu) / (2 * (3 * bulk + mu));
  const auto text = [](double x) {
    std::ostringstream stream;
    stream.precision(17);
    stream << x;
    return stream.str();
  };
  for (const std::string& pair :
       {"youngs_modulus_Pa = " + text(young) + "\npoisson_ratio = " + text(poisson),
        "shear_modulus_Pa = 500\nlame_lambda_Pa = " + text(lambda),
        std::string("shear_modulus_Pa = 500\nbulk_modulus_Pa = 5000"),
        std::string("shear_modulus_Pa = 500\nd1_per_Pa = 2e-4"),
        "youngs_modulus_Pa = " + text(young) + "\nbulk_modulus_Pa = 5000",
        "youngs_modulus_Pa = " + text(young) + "\nd1_per_Pa = 2e-4",
        std::string("c10_Pa = 250\nbulk_modulus_Pa = 5000"), std::string("c10_Pa = 250\nd1_per_Pa = 2e-4")}) {
    const Material m = parsed(with(good_scene, moduli, pair)).material;
    EXPECT_NEAR(m.shear_modulus_Pa, mu, 1e-12 * mu) << pair;
    EXPECT_NEAR(m.lame_lambda_Pa, lambda, 1e-12 * lambda) << pair;
    EXPECT_NEAR(m.bulk_modulus_Pa, bulk, 1e-12 * bulk) << pair;
  }
}

TEST(Material, of_the_papers_cases_three_and_four) {
  const Material three = parsed(with(good_scene, moduli, "c10_Pa = 250\nd1_per_Pa = 1e-5")).material;
  EXPECT_DOUBLE_EQ(three.shear_modulus_Pa, 500);
  EXPECT_NEAR(three.lame_lambda_Pa, 99'666.67, 0.01);
  EXPECT_NEAR(three.bulk_to_shear(), 200, 1e-9);
  const Material four = parsed(with(good_scene, law_and_moduli,
                                    "law = \"mooney-rivlin\"\nc10_Pa = 2\nc01_Pa = 0.2\nbulk_modulus_Pa = 1e5"))
                            .material;
  EXPECT_DOUBLE_EQ(four.shear_modulus_Pa, 4.4);
  EXPECT_EQ(four.parameters, (std::vector<double>{2, 0.2, 1e5}));
}

TEST(Material, may_be_auxetic_and_mooney_rivlin_may_lack_its_second_term) {
  EXPECT_LT(parsed(with(good_scene, moduli, "youngs_modulus_Pa = 1e4\npoisson_ratio = -0.3")).material.lame_lambda_Pa,
            0);
  EXPECT_EQ(
      parsed(with(good_scene, law_and_moduli, "law = \"mooney-rivlin\"\nc10_Pa = 2\nc01_Pa = 0\nbulk_modulus_Pa = 1e5"))
          .material.parameters[1],
      0);
}

TEST(Warnings, tell_of_locking_by_the_measured_ratio_and_of_nothing_else) {
  const std::string stiff = with(good_scene, "bulk_modulus_Pa = 5000.0", "bulk_modulus_Pa = 10e3");
  const auto warnings = scene_warnings(parsed(stiff));
  ASSERT_EQ(warnings.size(), 1u);
  expect_names(warnings[0],
               {std::string("body.toml:4"), std::string("K/mu = 20"), std::string("lock"), std::string("p1-p1"),
                std::string("taylor-hood"), std::string("check"), ratio_in_words(expected_force_ratio(parsed(stiff)))});
  for (const char* element : {"\"p1-p1\"", "\"taylor-hood\""})
    for (const char* modulus : {"bulk_modulus_Pa = 500.0", "bulk_modulus_Pa = 100e3"})
      EXPECT_TRUE(scene_warnings(parsed(with(with(good_scene, "bulk_modulus_Pa = 5000.0", modulus), "\"P1\"", element)))
                      .empty());
  auto patch = parsed(stiff);
  patch.probe.kind = ProbeKind::patch;
  expect_names(scene_warnings(patch)[0], {std::string("use es-p1-p1 or taylor-hood")});
  // Below the table nothing is claimed: at K/mu = 0.29 the force was measured to be right within 3 %.
  const std::string softest = with(good_scene, "bulk_modulus_Pa = 5000.0", "bulk_modulus_Pa = 145.0");
  EXPECT_TRUE(scene_warnings(parsed(softest)).empty());
  EXPECT_EQ(expected_force_ratio(parsed(softest)), 1);
  // P2 locks later than P1.
  const std::string soft =
      with(with(good_scene, "bulk_modulus_Pa = 5000.0", "bulk_modulus_Pa = 1000.0"), "\"P1\"", "\"P2\"");
  EXPECT_TRUE(scene_warnings(parsed(soft)).empty());
  EXPECT_EQ(scene_warnings(parsed(with(stiff, "\"P1\"", "\"P2\""))).size(), 1u);
  // A region may lock where the rest of the body does not.
  const auto of_region = scene_warnings(parsed(
      with(softest, "[solver]", "[[region]]\nname = \"part\"\ncells = \"all\"\nbulk_modulus_Pa = 10e3\n[solver]")));
  ASSERT_EQ(of_region.size(), 1u);
  expect_names(of_region[0], {std::string("K/mu = 20"), std::string("lock")});
}

// Forces of patches over those of Taylor-Hood on the same mesh of a kidney of 300 nodes, to a seventh of an edge and to
// an edge. The table is a mean over four bodies and both depths, from which the kidney differs by up to a quarter.
TEST(Warnings, expect_the_forces_that_were_measured) {
  const std::tuple<double, double, double> P1[] = {
      {2, 1.26, 1.26}, {10, 1.44, 1.41}, {50, 1.97, 1.91}, {200, 3.16, 3.00}};
  const auto expected = [](const char* element, double K_mu) {
    auto scene = parsed(with(good_scene, "\"P1\"", element));
    scene.material.bulk_modulus_Pa = K_mu * scene.material.shear_modulus_Pa;
    scene.probe.kind = ProbeKind::patch;
    return expected_force_ratio(scene);
  };
  for (const auto& [K_mu, shallow, deep] : P1)
    for (const double ratio : {shallow, deep}) EXPECT_NEAR(expected("\"P1\"", K_mu) / ratio, 1, 0.25) << K_mu;
  // It grows with K/mu, beyond what was measured, and less with quadratic elements.
  EXPECT_GT(expected("\"P1\"", 2000), 1.5 * expected("\"P1\"", 200));
  EXPECT_LT(expected("\"P2\"", 200), 0.5 * expected("\"P1\"", 200));
  EXPECT_EQ(expected("\"p1-p1\"", 200), 1);
}

TEST(Warnings, are_absent_from_the_demo) {
  EXPECT_TRUE(scene_warnings(read_scene(std::filesystem::path(PHYNNESS_SOURCE_DIR) / "scenes/demo.toml")).empty());
}

TEST(Warnings, say_ratios_in_words) {
  for (const auto& [ratio, words] : {std::pair{4.51, "4.5 times too large"}, std::pair{27.2, "27 times too large"},
                                     std::pair{1.12, "12 % too large"}, std::pair{1.02, "within 5 %"},
                                     std::pair{0.8, "20 % too small"}, std::pair{1.97, "97 % too large"}})
    EXPECT_EQ(ratio_in_words(ratio), words);
}

TEST(Warnings, tell_when_a_linear_body_is_probed_more_than_it_requires) {
  const auto linear = with(with(good_scene, "\"P1\"", "\"p1-p1\""), "\"neo-hookean\"", "\"linear\"");
  const auto warnings = scene_warnings(parsed(linear));
  ASSERT_EQ(warnings.size(), 1u);
  expect_names(warnings[0], {"body.toml:13", "linear", "104", "directions = 3"});
  const std::string all = "directions = 26\nincrements = 4";
  EXPECT_EQ(scene_warnings(parsed(with(linear, all, "directions = 26\nincrements = 1"))).size(), 1u);
  EXPECT_TRUE(scene_warnings(parsed(with(linear, all, "directions = 3\nincrements = 1"))).empty());
}

// What each selector holds shows in its text: scenes_keep_their_hash.cpp.
TEST(Selection, keeps_every_selector_with_its_line) {
  const Scene scene = parsed(with(good_scene, "active = \"free-surface\"", R"(active = [
  "surface",
  { sphere = { center_fraction = [0.5, 0.5, 1], radius_m = 0.01 }, surface_only = true },
  { group = "lobe" },
])"));
  ASSERT_EQ(scene.active.size(), 3u);
  EXPECT_EQ(scene.active[0].text, "surface");
  EXPECT_FALSE(scene.active[0].surface_only);
  EXPECT_TRUE(scene.active[1].surface_only);
  EXPECT_EQ(scene.active[1].where.line, 14);
  EXPECT_EQ(scene.active[2].description, "group 'lobe'");
  ASSERT_EQ(scene.output.size(), 1u);
  EXPECT_EQ(scene.output[0].text, "free-surface");
}

TEST(Directions, may_be_written_as_number_or_text) {
  EXPECT_EQ(parsed(with(good_scene, "directions = 26", "directions = 3")).probe.directions, Directions::three);
  EXPECT_EQ(parsed(with(good_scene, "directions = 26", "directions = \"26\"")).probe.directions,
            Directions::twenty_six);
  EXPECT_EQ(parsed(with(good_scene, "directions = 26", "directions = \"hemisphere\"")).probe.directions,
            Directions::hemisphere);
  EXPECT_EQ(parsed(with(good_scene, "directions = 26", "directions = 14")).probe.directions, Directions::fourteen);
  EXPECT_EQ(parsed(with(good_scene, "directions = 26", "directions = 98")).probe.directions, Directions::ninety_eight);
}

TEST(Directions, are_distinct_unit_vectors_closed_under_sign) {
  const std::pair<Directions, std::size_t> kinds[] = {
      {Directions::fourteen, 14}, {Directions::twenty_six, 26}, {Directions::ninety_eight, 98}};
  for (const auto& [kind, count] : kinds) {
    const auto all = exploratory_directions(kind);
    ASSERT_EQ(all.size(), count);
    EXPECT_EQ(all[0], (Vec3{-1, 0, 0}));
    EXPECT_EQ(all[5], (Vec3{1, 0, 0}));
    for (const auto& d : all) {
      EXPECT_NEAR(std::hypot(d[0], d[1], d[2]), 1, 1e-15);
      EXPECT_EQ(std::count(all.begin(), all.end(), d), 1);
      EXPECT_EQ(std::count(all.begin(), all.end(), Vec3{-d[0], -d[1], -d[2]}), 1);
    }
  }
  EXPECT_EQ(exploratory_directions(Directions::hemisphere), exploratory_directions(Directions::twenty_six));
  EXPECT_EQ(exploratory_directions(Directions::three), (std::vector<Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
}

TEST(Directions, finer_ones_hold_the_coarser_ones) {
  const auto all = exploratory_directions(Directions::ninety_eight);
  const auto some = exploratory_directions(Directions::twenty_six);
  EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin()));
  for (const auto& d : exploratory_directions(Directions::fourteen))
    EXPECT_EQ(std::count(some.begin(), some.end(), d), 1);
}

TEST(Directions, leave_no_gap) {
  // Farthest point of the sphere from the nearest direction, in degrees: the middle of a triangle of three, from its
  // plane's normal. 14: axis, two corners. 26: axis, edge, corner. 98: the widest of the quarters of that.
  const std::pair<Directions, double> kinds[] = {
      {Directions::fourteen, 36.2}, {Directions::twenty_six, 27.6}, {Directions::ninety_eight, 14.3}};
  for (const auto& [kind, gap] : kinds) {
    const auto all = exploratory_directions(kind);
    double widest = 0;
    const int n = 200;  // along each edge of a face of the cube: half a degree, so at most 0.4 beside the middle
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const double y = 2.0 * i / n - 1, z = 2.0 * j / n - 1, norm = std::sqrt(1 + y * y + z * z);
        double nearest = -1;
        for (const auto& d : all) nearest = std::max(nearest, (d[0] + y * d[1] + z * d[2]) / norm);
        widest = std::max(widest, std::acos(nearest) * 180 / 3.14159265358979);
      }
    EXPECT_NEAR(widest, gap, 0.4) << phynness::name(kind);
  }
}

TEST(PhysicsHash, ignores_what_does_not_decide_a_solve) {
  const auto hash = physics_hash(parsed(good_scene));
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(physics_hash(parsed("# a comment\n" + good_scene)), hash);
  EXPECT_EQ(physics_hash(parsed(with(good_scene, "samples = 1000", "samples = 9\nseed = 5"))), hash);
  EXPECT_EQ(physics_hash(parsed(with(good_scene, "title = \"test\"", "title = \"other\""))), hash);
  EXPECT_EQ(physics_hash(parsed(with(good_scene, "500.0", "5e2"))), hash);
  EXPECT_EQ(physics_hash(parsed(good_scene + "[validation]\nprobes = 3\n[database]\ntangents = true\n")), hash);
  EXPECT_EQ(physics_hash(parsed(good_scene + "[database]\nfields = [\"energy-density\"]\n")), hash);
}

TEST(SceneFields, are_none_by_default_and_in_one_order) {
  EXPECT_TRUE(parsed(good_scene).database.fields.empty());
  EXPECT_TRUE(parsed(good_scene + "[database]\nfields = []\n").database.fields.empty());
  const auto both = parsed(good_scene + "[database]\nfields = [\"energy-density\", \"von-mises-stress\"]\n");
  EXPECT_EQ(both.database.fields, (std::vector<Field>{Field::von_mises_stress, Field::energy_density}));
}

TEST(PhysicsHash, follows_everything_that_decides_a_solve) {
  const auto hash = physics_hash(parsed(good_scene));
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"shape = \"block\"", "shape = \"liver\""},
      {"shape = \"block\"", "shape = \"block\"\ntarget_nodes = 100"},
      {"500.0", "501.0"},
      {"law = \"neo-hookean\"", "law = \"linear\""},
      {"element = \"P1\"", "element = \"P2\""},
      {"element = \"P1\"", "relative_tolerance = 1e-6"},
      {"[0.2, 1, 1]", "[0.3, 1, 1]"},
      {"_fraction = [0.2, 1, 1] }", "_fraction = [0.2, 1, 1] }, surface_only = true"},
      {"active = \"free-surface\"", "active = \"free\""},
      {"directions = 26", "directions = 3"},
      {"increments = 4", "increments = 5"},
      {"0.02", "0.021"},
      {"increments = 4", "increments = 4\nkind = \"patch\"\ntool_radius_m = 0.01"}};
  for (const auto& [part, replacement] : changes)
    EXPECT_NE(physics_hash(parsed(with(good_scene, part, replacement))), hash) << replacement;
}

TEST(Locale, with_decimal_commas_changes_nothing) {
  const auto hash = physics_hash(parsed(good_scene));
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const char* c_locale = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // where installed
  const Scene scene = parsed(with(good_scene, "increments = 4", "increments = 1000"));
  const auto again = physics_hash(parsed(good_scene));
  const auto message = refusal(with(good_scene, "max_displacement_m = 0.02", "max_displacement_m = -1234.5"));
  std::locale::global(before);
  if (c_locale) std::setlocale(LC_NUMERIC, "C");
  EXPECT_EQ(scene.probe.max_displacement_m, 0.02);
  EXPECT_EQ(again, hash);
  EXPECT_NE(message.find("-1234.5"), std::string::npos) << message;
}

TEST(Defaults, are_what_is_recommended) {
  const std::string plain = with(with(good_scene, "element = \"P1\"\n", ""), "family = \"rbfn\"\n", "");
  const Scene solid = parsed(plain), shell = parsed(with(plain, "shape = \"block\"", "shape = \"drain\""));
  EXPECT_EQ(solid.solver.element, element_named("p1-p1"));
  EXPECT_EQ(shell.solver.element, element_named("shell"));
  const std::string patch = "increments = 4\nkind = \"patch\"\ntool_radius_m = 0.01";
  EXPECT_EQ(parsed(with(plain, "increments = 4", patch)).solver.element, element_named("es-p1-p1"));
  EXPECT_EQ(solid.training.family, Family::modal);
  EXPECT_EQ(solid.probe.kind, ProbeKind::node);
  EXPECT_TRUE(scene_warnings(parsed(with(plain, "bulk_modulus_Pa = 5000.0", "bulk_modulus_Pa = 100e3"))).empty());
}

TEST(Notes, tell_that_a_node_has_no_limit_unless_the_scene_asks_for_one) {
  const auto notes = scene_notes(parsed(good_scene));
  ASSERT_EQ(notes.size(), 1u);
  expect_names(notes[0], {"body.toml:13", "mesh refinement", "patch", "tool_radius_m"});
  const std::string key = "increments = 4";
  EXPECT_TRUE(scene_notes(parsed(with(good_scene, key, key + "\nkind = \"node\""))).empty());
  EXPECT_TRUE(scene_notes(parsed(with(good_scene, key, key + "\nkind = \"patch\"\ntool_radius_m = 0.02"))).empty());
}

TEST(Notes, name_a_depth_beyond_the_radius_of_the_tool) {
  const std::string key = "increments = 4";
  const auto notes = scene_notes(parsed(with(good_scene, key, key + "\nkind = \"patch\"\ntool_radius_m = 0.0199")));
  ASSERT_EQ(notes.size(), 1u);
  expect_names(notes[0], {"body.toml:13", "max_displacement_m = 0.02 ", "tool_radius_m = 0.0199", "crushed"});
}

TEST(Notes, ask_about_moduli_that_are_often_meant_otherwise) {
  const std::string known = with(good_scene, "increments = 4", "increments = 4\nkind = \"node\"");
  EXPECT_TRUE(scene_notes(parsed(known)).empty());
  const auto exchanged = scene_notes(parsed(with(known, moduli, "shear_modulus_Pa = 5000.0\nbulk_modulus_Pa = 500.0")));
  ASSERT_EQ(exchanged.size(), 1u);
  expect_names(exchanged[0], {"body.toml:4", "K/mu = 0.1", "nu = -0.65", "exchanged"});
  const auto kilopascals = scene_notes(parsed(with(known, moduli, "shear_modulus_Pa = 0.5\nbulk_modulus_Pa = 25e3")));
  ASSERT_EQ(kilopascals.size(), 1u);
  expect_names(kilopascals[0], {"body.toml:4", "K/mu = 5e+04", "in Pa"});
  const auto both = scene_notes(parsed(with(known, moduli, "shear_modulus_Pa = 3\nbulk_modulus_Pa = 300")));
  ASSERT_EQ(both.size(), 1u);
  expect_names(both[0], {"body.toml:4", "mu = 3 Pa", "kPa"});
  const auto d1 = scene_notes(parsed(with(known, moduli, "shear_modulus_Pa = 500\nd1_per_Pa = 2e-4")));
  ASSERT_EQ(d1.size(), 1u);
  expect_names(d1[0], {"K = 1/D1", "2/D1", "Abaqus", "bulk_modulus_Pa"});
  const Material m = parsed(known).material;
  EXPECT_NEAR(m.youngs_modulus_Pa(), 9 * 5000.0 * 500 / (3 * 5000 + 500), 1e-9);
  EXPECT_NEAR(m.poisson_ratio(), (3 * 5000.0 - 1000) / (2 * (3 * 5000 + 500)), 1e-14);
}

TEST(Material, refuses_with_a_remedy_what_people_expect_of_one) {
  expect_names(refusal(with(good_scene, moduli, "shear_modulus_Pa = 500\nd1_per_Pa = 0")),
               {"d1_per_Pa", "greater than 0", "bulk_modulus_Pa = 100 to 1,000 times mu"});
  for (const std::string key : {"regions = { brain = 1 }", "density = 1000", "prony = [1, 2]", "skull.E = 1e9"})
    expect_names(refusal(with(good_scene, moduli, moduli + "\n" + key)),
                 {"body.toml:8", "materials are elastic", "[[region]]"});
  expect_names(refusal("regions = [1]\n" + good_scene), {"body.toml:1", "did you mean region?"});
}

TEST(Defaults, of_a_shape_are_those_of_its_row) {
  for (const ShapeRow& shape : shapes()) {
    const std::string plain = with(good_scene, "element = \"P1\"\n", "");
    const MeshSpec spec = parsed(with(plain, "\"block\"", '"' + std::string(shape.name) + '"')).mesh;
    EXPECT_EQ(spec.target_nodes, shape.target_nodes) << shape.name;
    EXPECT_EQ(spec.thickness_m, shape.thickness_m) << shape.name;
    const MeshSpec whole = with_standard_sizes(spec);
    EXPECT_EQ(whole.size_m, shape.size_m) << shape.name;
    EXPECT_EQ(whole.radius_m, shape.radius_m) << shape.name;
    EXPECT_EQ(whole.length_m, shape.length_m) << shape.name;
  }
  EXPECT_EQ(row(Shape::liver).target_nodes, 739) << "the paper's liver";
  EXPECT_EQ(row(Shape::drain).target_nodes, 239) << "the paper's drain";
}

TEST(ShippedScenes, are_all_valid) {
  int scenes = 0;
  for (const auto& item : std::filesystem::directory_iterator(PHYNNESS_SOURCE_DIR "/scenes")) {
    if (item.path().extension() != ".toml") continue;
    ++scenes;
    EXPECT_FALSE(read_scene(item.path()).title.empty()) << item.path();
  }
  EXPECT_GE(scenes, 4);
}

TEST(MeshFile, is_found_from_the_scene_folder_and_may_be_absent_only_on_request) {
  const std::string text = with(good_scene, "shape = \"block\"", "file = \"sub/body.msh\"\nscale_to_m = 0.001");
  const Scene scene = parse_scene(text, "body.toml", "/nowhere", MeshFile::may_be_absent);
  EXPECT_EQ(scene.mesh.file, "/nowhere/sub/body.msh");
  EXPECT_EQ(scene.mesh.shape, Shape::none);
  EXPECT_EQ(physics_hash(scene), physics_hash(parse_scene(text, "body.toml", "/elsewhere", MeshFile::may_be_absent)));
  EXPECT_THROW(parse_scene(text, "body.toml", "/nowhere"), Error);
}

}  // namespace
}  // namespace phynness::test
