// Claim: every error in a scene is refused with file and line, the wrong value, and a remedy.
#include <algorithm>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include "scene_under_test.hpp"

namespace phynness::test {
namespace {

/// `replacement` takes the place of `part` in the good scene; `at` is the text whose line must be named
/// (`replacement` itself if empty).
struct Mistake {
  std::string name, part, replacement, at;
  std::vector<std::string> said;  ///< key, value and keys or values of the remedy
};

void PrintTo(const Mistake& mistake, std::ostream* stream) { *stream << mistake.name; }

const char* const fixed_line = "fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } }";
const char* const active_line = "active = \"free-surface\"";
const char* const shear = "shear_modulus_Pa = 500.0";
const char* const moduli = "shear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0";
const char* const law_and_moduli = "law = \"neo-hookean\"\nshear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0";
const char* const shape = "shape = \"block\"";
const char* const depth = "max_displacement_m = 0.02";
const char* const increments = "increments = 4";

const std::string region = "[[region]]\nname = \"a\"\ncells = { group = \"a\" }\nshear_modulus_Pa = 8.0\n";

const std::map<std::string, std::string> parts{
    {"fixed_line", fixed_line}, {"active_line", active_line},       {"shear", shear},
    {"moduli", moduli},         {"law_and_moduli", law_and_moduli}, {"shape", shape},
    {"depth", depth},           {"increments", increments}};

std::vector<std::string> fields(const std::string& row, char between) {
  std::vector<std::string> found;
  std::istringstream stream(row);
  for (std::string field; std::getline(stream, field, between);) {
    const auto first = field.find_first_not_of(' '), last = field.find_last_not_of(' ');
    found.push_back(first == field.npos ? "" : field.substr(first, last - first + 1));
  }
  return found;
}

/// A row: name | part, or its name in `parts` | replacement, with \\n for the ends of lines | at | said ; said. A row
/// may go on in a line that begins with blanks.
std::vector<Mistake> mistakes(std::string table) {
  table = std::regex_replace(std::regex_replace(table, std::regex("\n +"), " "), std::regex("\\\\n"), "\t");
  std::vector<Mistake> found;
  for (const auto& row : fields(table, '\n')) {
    if (row.empty()) continue;
    auto field = fields(row, '|');
    for (auto& text : field) std::replace(text.begin(), text.end(), '\t', '\n');
    const auto known = parts.find(field.at(1));
    found.push_back({field[0], known == parts.end() ? field[1] : known->second, field.at(2), field.at(3),
                     fields(field.at(4), ';')});
  }
  return found;
}

TEST(RegionsOfAScene, RefuseWhatIsWrong) {
  const std::string good = with(good_scene, "[solver]", region + "[solver]");
  EXPECT_EQ(parsed(good).regions.at(0).material.shear_modulus_Pa, 8);
  EXPECT_EQ(parsed(good).regions.at(0).material.bulk_modulus_Pa, 5000);
  const auto refused = [&](const std::string& part, const std::string& replacement, const std::string& at,
                           const std::vector<std::string>& said) {
    const std::string text = with(good, part, replacement), message = refusal(text);
    EXPECT_EQ(message.find("body.toml:" + std::to_string(line_of(text, at)) + ":"), 0u) << message;
    expect_error(message, said);
  };
  refused("name = \"a\"", "", "[[region]]", {"[region] name is missing", "nodule"});
  refused("name = \"a\"", "name = \"\"", "name", {"[region] name is empty"});
  refused("cells = { group = \"a\" }", "", "[[region]]", {"[region] cells is missing", "sphere"});
  refused("[solver]", region + "[solver]", "name = \"a\"\ncells = { group = \"a\" }\nshear_modulus_Pa = 8.0\n[sol",
          {"name is that of another region", "line 8"});
  refused("shear_modulus_Pa = 8.0", "", "[[region]]",
          {"shear_modulus_Pa is missing, and so is every other parameter of law neo-hookean", "bulk_modulus_Pa"});
  refused("shear_modulus_Pa = 8.0", "poisson_ratio = 0.4", "poisson_ratio",
          {"do not determine", "poisson_ratio = 0.4"});
  refused("shear_modulus_Pa = 8.0", "shear_modulus_Pa = -8", "shear_modulus_Pa = -8", {"greater than 0", "-8"});
  refused("shear_modulus_Pa = 8.0", "law = \"linear\"", "law = \"linear\"", {"unknown key in [region]", "[material]"});
  refused("cells = { group = \"a\" }", "cells = { nodes = [3] }", "cells",
          {"selects nodes, but a region is made of cells", "near", "distance_m"});
  refused("cells = { group = \"a\" }", "cells = { not = \"surface\" }", "cells", {"selects nodes", "\"surface\""});
  refused("[[region]]", "[region]", "[region]", {"region must be an array of tables", "[[region]]"});
  refused("shape = \"block\"", "shape = \"drain\"\n#", "[[region]]",
          {"only available for solids", "remove the region"});
  EXPECT_EQ(physics_summary(parsed(good)).substr(physics_summary(parsed(good_scene)).size()),
            "region 1.cells = group \"a\"\nregion 1.order = 0\nregion 1.shear_modulus_Pa = 8\n"
            "region 1.lame_lambda_Pa = 4994.666666666667\n");
}

TEST(RegionsOfAScene, AreSolvedByAnElementThatServesEachOfThem) {
  const auto text = with(with(good_scene, "element = \"P1\"", "element = \"p1-p1\""), "[solver]", region + "[solver]");
  const auto message = refusal(with(text, "shear_modulus_Pa = 8.0", "shear_modulus_Pa = 9000.0"));
  expect_error(message, {"p1-p1 needs a positive Lame parameter", "2 mu / 3 = -1000 Pa", "line 8", "P1"});
  EXPECT_TRUE(scene_notes(parsed(text)).size() < 2);
  const auto notes = scene_notes(parsed(with(text, "shear_modulus_Pa = 8.0", "shear_modulus_Pa = 0.4")));
  ASSERT_FALSE(notes.empty());
  expect_names(notes.back(), {"body.toml:8", "factor of 1.25e+03", "1e+03", "check"});
}

class SceneMistake : public testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, is_refused_with_line_value_and_remedy) {
  const Mistake& mistake = GetParam();
  const std::string text = with(good_scene, mistake.part, mistake.replacement);
  const std::string message = refusal(text);
  const std::string at = mistake.at.empty() ? mistake.replacement : mistake.at;
  EXPECT_EQ(message.find("body.toml:" + std::to_string(line_of(text, at)) + ":"), 0u) << message;
  expect_error(message, mistake.said);
}

TEST(ShellScene, RefusesWhatShellsDoNotHave) {
  const auto shell = with(with(good_scene, shape, "shape = \"drain\""), "element = \"P1\"", "");
  EXPECT_EQ(parsed(shell).solver.element, element_named("shell"));
  const auto fields = refusal(shell + "[database]\nfields = [\"von-mises-stress\"]\n");
  expect_error(fields, {"[database] fields", "von-mises-stress"});
  // Condensed by Newton steps that are good near incompressibility.
  const auto soft = refusal(with(shell, moduli, "shear_modulus_Pa = 500.0\nbulk_modulus_Pa = 400.0"));
  expect_error(soft, {"[material] law", "0.8", "st-venant-kirchhoff"});
  const auto mooney = refusal(
      with(shell, law_and_moduli, "law = \"mooney-rivlin\"\nc10_Pa = 200.0\nc01_Pa = 50.0\nbulk_modulus_Pa = 900.0"));
  expect_error(mooney, {"[material] law", "1.8"});
  parsed(with(shell, law_and_moduli, "law = \"linear\"\nshear_modulus_Pa = 500.0\nbulk_modulus_Pa = 400.0"));
}

INSTANTIATE_TEST_SUITE_P(all, SceneMistake, testing::ValuesIn(mistakes(R"(
misspelt_key | increments | incremnets = 4 | | unknown key in [probe] ; incremnets = 4 ; did you mean increments?
end_of_a_key | increments | increments = 4\nradius_m = 0.05 | radius_m = 0.05 | radius_m = 0.05 ; did you mean tool_radius_m?
misspelt_section | [training] | [trainning] | | unknown key ; did you mean training?
key_of_another_section | increments | increments = 4\nsamples = 5 | samples = 5 | samples = 5 ; [training]
far_from_any_key | increments | zzzzzz = 4 | | zzzzzz = 4 ; [probe] ; max_displacement_m
unit_forgotten | shear | youngs_modulus = 20e3 | | youngs_modulus = 20000 ; youngs_modulus_Pa ; in Pa
unit_forgotten_length | depth | max_displacement = 0.02 | | max_displacement = 0.02 ; max_displacement_m
other_unit | depth | max_displacement_mm = 20 | | max_displacement_mm = 20 ; max_displacement_m ; SI
selector_key | fixed_line | fixed = { bix = { min_m = [0,0,0] } } | | bix ; did you mean box?
selector_inner_key | fixed_line | fixed = { sphere = { center_m = [0,0,0], radius = 1 } } | | radius = 1 ; radius_m
text_for_number | depth | max_displacement_m = "28 mm" | | max_displacement_m ; number ; 28 mm
float_for_integer | increments | increments = 4.0 | | increments ; integer ; 4
number_for_text | law = "neo-hookean" | law = 3 | | law ; text ; 3
text_for_boolean | [training] | [database]\ntangents = "yes"\n[training] | tangents = "yes" | true or false ; yes
text_for_fields | [training] | [database]\nfields = "von-mises-stress"\n[training] | fields =
    | [database] fields ; array ; ["von-mises-stress"]
number_for_a_field | [training] | [database]\nfields = [3]\n[training] | fields =
    | [database] fields ; 3 ; von-mises-stress or energy-density
misspelt_field | [training] | [database]\nfields = [\n  "energy-density",\n  "von-mises"]\n[training] | "von-mises"
    | [database] fields ; 'von-mises' ; von-mises-stress or energy-density
energy_densitty | [training] | [database]\nfields = ["energy-densitty"]\n[training] | energy-densitty
    | did you mean "energy-density"?
a_field_twice | [training] | [database]\nfields = ["energy-density",\n "energy-density"]\n[training] | "energy-density"]
    | [database] fields ; twice ; energy-density
two_numbers_for_three | shape | shape = "block"\nsize_m = [0.1, 0.2] | size_m | size_m ; [0.1, 0.2]
not_a_number | depth | max_displacement_m = nan | | max_displacement_m ; finite ; nan
infinite | shear | shear_modulus_Pa = inf | | shear_modulus_Pa ; finite ; inf
selection_of_number | fixed_line | fixed = 3 | | [nodes] fixed ; 3 ; selector
node_numbers_as_floats | fixed_line | fixed = { nodes = [0, 1.5] } | | nodes ; 1.5
negative_modulus | shear | shear_modulus_Pa = -500.0 | | shear_modulus_Pa ; greater than 0 ; -500
poisson_half | moduli | youngs_modulus_Pa = 2e4\npoisson_ratio = 0.5 | poisson_ratio | less than 0.5 ; 0.5
poisson_minus_one | moduli | youngs_modulus_Pa = 2e4\npoisson_ratio = -1 | poisson_ratio | greater than -1 ; -1
lambda_too_negative | moduli | shear_modulus_Pa = 3.0\nlame_lambda_Pa = -2.5 | lame_lambda_Pa | -2.5 ; greater than -2
young_above_nine_bulk | moduli | youngs_modulus_Pa = 90.0\nbulk_modulus_Pa = 10.0 | youngs_modulus_Pa | 90 ; less than 90
c10_zero | moduli | c10_Pa = 0\nbulk_modulus_Pa = 10.0 | c10_Pa | c10_Pa ; greater than 0
relaxation_of_a_number | shear | shear_modulus_Pa = 500.0\nrelaxation = 0.5 | relaxation | table of g and tau_s ; 0.5
relaxation_without_times | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.3] } | relaxation | array tau_s
relaxation_key | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.3], tau = [1.0] } | relaxation | unknown key ; tau
relaxation_of_two_lengths | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.3, 0.1], tau_s = [1.0] } | relaxation
    | as many numbers in g as in tau_s
relaxation_of_all | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.6, 0.4], tau_s = [1.0, 2.0] } | relaxation
    | sum of g ; not below 1
relaxation_of_no_time | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.6], tau_s = [0.0] } | relaxation
    | tau_s ; 0 ; seconds
relaxation_of_nine | shear
    | shear_modulus_Pa = 500.0\nrelaxation = { g = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1], tau_s = [1, 2, 3, 4, 5, 6, 7, 8, 9] }
    | relaxation | 1 to 8
relaxation_negative | shear | shear_modulus_Pa = 500.0\nrelaxation = { g = [-0.1], tau_s = [1.0] } | relaxation | g ; -0.1
c01_negative | law_and_moduli | law = "mooney-rivlin"\nc10_Pa = 2\nc01_Pa = -0.2\nbulk_modulus_Pa = 1e5 | c01_Pa
    | at least 0 ; -0.2
no_increment | increments | increments = 0 | | increments ; 0 ; between 1 and 1000
insane_increments | increments | increments = 5000 | | 5000 ; between 1 and 1000
no_depth | depth | max_displacement_m = 0 | | greater than 0 ; remedy
depth_in_millimetres | depth | max_displacement_m = 28 | | 28 ; not in mm
insane_nodes | shape | shape = "block"\ntarget_nodes = 6000000 | target_nodes | 6000000 ; 5000000
tool_radius_zero | increments | increments = 4\nkind = "patch"\ntool_radius_m = 0 | tool_radius_m | at least 1e-09 ; 0
unknown_law | law = "neo-hookean" | law = "neohookean" | | "neohookean" ; did you mean "neo-hookean"?
unknown_element | element = "P1" | element = "P3" | | "P3" ; taylor-hood
unknown_directions | directions = 26 | directions = 27 | | 27 ; hemisphere
unknown_word | active = "free-surface" | active = "freesurface" | | "freesurface" ; did you mean "free-surface"?
spread_word | samples = 1000 | force_spread = "find" | | find ; search
normal_zero | fixed_line | fixed = { plane = { point_m = [0,0,0], normal = [0,0,0] } } | | normal ; [0, 0, 0]
box_upside_down | fixed_line | fixed = { box = { min_m = [1,0,0], max_m = [0,1,1] } } | | min_m ; max_m ; [1, 0, 0]
negative_node | fixed_line | fixed = { nodes = [-1] } | | nodes ; -1
under_determined | moduli | shear_modulus_Pa = 500.0 | shear_modulus_Pa
    | do not determine ; shear_modulus_Pa = 500 ; bulk_modulus_Pa
no_parameters | moduli | | [material] | do not determine ; youngs_modulus_Pa and poisson_ratio
over_determined | moduli | shear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0\nyoungs_modulus_Pa = 3 | bulk_modulus_Pa
    | over-determined ; youngs_modulus_Pa = 3 ; keep exactly one
bulk_modulus_twice | moduli | shear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0\nd1_per_Pa = 1e-5 | d1_per_Pa
    | over-determined ; d1_per_Pa = 1e-05
c10_in_linear_law | law_and_moduli | law = "linear"\nc10_Pa = 250.0\nbulk_modulus_Pa = 1e5 | bulk_modulus_Pa
    | linear ; c10_Pa = 250 ; exactly one
mooney_without_c01 | law_and_moduli | law = "mooney-rivlin"\nc10_Pa = 2.0\nbulk_modulus_Pa = 1e5 | bulk_modulus_Pa
    | mooney-rivlin ; c01_Pa
no_law | law = "neo-hookean" | | [material] | law is missing ; neo-hookean
shape_and_file | shape | shape = "block"\nfile = "a.msh" | file | [mesh] file ; shape ; a.msh
neither_shape_nor_file | shape | | [mesh] | shape is missing ; file
file_not_there | shape | file = "no/such/mesh.msh" | | [mesh] file ; no/such/mesh.msh
file_of_unknown_kind | shape | file = "body.step" | | body.step ; .msh
nodes_and_size | shape | shape = "block"\ntarget_nodes = 100\ntarget_size_m = 0.01 | target_size_m
    | target_nodes ; target_size_m ; 0.01
scale_of_a_shape | shape | shape = "block"\nscale_to_m = 0.001 | scale_to_m | scale_to_m ; 0.001
remesh_of_a_shape | shape | shape = "block"\nremesh = true | remesh | [mesh] remesh ; mesh file
radius_of_a_block | shape | shape = "block"\nradius_m = 0.1 | radius_m | block ; size_m
wall_without_thickness | shape | shape = "tube"\nradius_m = 0.01\ninner_radius_m = 0.01 | inner_radius_m
    | inner_radius_m ; radius_m ; 0.01
wall_outside_of_the_default_radius | shape | shape = "tube"\ninner_radius_m = 0.02 | inner_radius_m
    | [mesh] inner_radius_m ; 0.02 ; 0.01 m
slit_as_long_as_the_drain | shape | shape = "drain"\nslit_length_m = 0.038 | slit_length_m
    | [mesh] slit_length_m ; 0.038 ; 0.0342 m
slit_wider_than_the_drain | shape | shape = "drain"\nslit_width_m = 0.007 | slit_width_m
    | [mesh] slit_width_m ; 0.007 ; 0.00635 m
slit_wider_than_long | shape | shape = "drain"\nslit_length_m = 0.001\nslit_width_m = 0.002 | slit_width_m
    | [mesh] slit_width_m ; 0.002 ; 0.001 m
size_of_no_length | shape | shape = "tube"\ntarget_size_m = -1 | target_size_m | at least 1e-09 ; -1
thickness_of_a_solid | shape | shape = "block"\nthickness_m = 0.001 | thickness_m | block ; 0.001 ; drain
thickness_of_nothing | shape | shape = "drain"\nthickness_m = 0 | thickness_m | thickness_m ; greater than 0
slit_of_a_tube | shape | shape = "tube"\nslit_width_m = 0.001 | slit_width_m | tube ; 0.001 ; drain
inner_radius_of_a_drain | shape | shape = "drain"\ninner_radius_m = 0.001 | inner_radius_m | drain ; 0.001 ; thickness_m
tetrahedra_of_a_shell | shape | shape = "drain" | element = "P1" | tetrahedra ; P1 ; element = "shell"
shell_of_a_solid | element = "P1" | element = "shell" | | [solver] element ; thickness_m
nothing_fixed | fixed_line | | [nodes] | fixed is missing ; singular ; box
empty_selection | fixed_line | fixed = [] | | [nodes] fixed ; empty ; []
empty_active | active_line | active = [] | | [nodes] active ; empty ; []
empty_node_list | fixed_line | fixed = { nodes = [] } | | nodes ; empty
fixed_by_what_is_free | fixed_line | fixed = "free" | | [nodes] fixed ; "free" ; box
everything_fixed | fixed_line | fixed = "all" | | [nodes] fixed ; "all"
two_shapes_in_a_selector | fixed_line | fixed = { group = "a", nodes = [1] } | | [nodes] fixed ; two selectors
fixed_by_what_is_free_inside | fixed_line | fixed = { difference = ["surface",\n { near = { to = "free", distance_m = 1 } }] }
    | fixed = | [nodes] fixed ; depends on the fixed nodes
fixed_by_itself | fixed_line | fixed = { not = "fixed" } | | [nodes] fixed ; depends on the fixed nodes
intersection_of_one | fixed_line | fixed = { intersection = ["surface"] } | | intersection ; two
intersection_of_nothing | fixed_line | fixed = { intersection = ["surface", []] } | | intersection ; empty list
difference_of_a_table | fixed_line | fixed = { difference = { box = {} } } | | difference ; array
not_a_selection | fixed_line | fixed = { not = 3 } | | not ; 3
near_nothing | fixed_line | fixed = { near = { distance_m = 1 } } | | [selector.near] to ; missing
near_without_distance | fixed_line | fixed = { near = { to = { group = "a" } } } | | [selector.near] distance_m ; missing
a_sphere_in_an_intersection | fixed_line
    | fixed = { intersection = ["surface",\n { sphere = { center_m = [0, 0, 0], radius = 1 } }] } | { sphere | radius_m
spread_without_distance | active_line | active = { spacing_m = 0 } | | spacing_m ; greater than 0 ; 0
spread_backwards | active_line | active = { spacing_m = -0.01 } | | spacing_m ; greater than 0 ; -0.01
spread_by_nan | active_line | active = { spacing_m = nan } | | spacing_m ; nan
spread_by_a_number | active_line | active = { spacing = 0.015 } | | spacing ; auto ; spacing_m = 0.01
spread_by_a_word | active_line | active = { spacing = "dense" } | | spacing ; dense ; auto
spread_over_no_points | active_line | active = { count = 0 } | | count ; 0
spread_twice | active_line | active = { spacing_m = 0.01, count = 9 } | | two selectors ; count
within_without_spread | active_line | active = { nodes = [1], within = "free" } | | within ; spacing_m
fixed_by_spread | fixed_line | fixed = { count = 9 } | | [nodes] fixed ; depends on the fixed nodes
selector_without_shape | fixed_line | fixed = { surface_only = true } | | [nodes] fixed ; sphere
half_a_box | fixed_line | fixed = { box = { min_m = [0,0,0] } } | | max_m is missing
box_in_two_measures | fixed_line | fixed = { box = { min_m = [0,0,0], max_fraction = [1,1,1] } } | | metres ; fractions
sphere_without_radius | fixed_line | fixed = { sphere = { center_m = [0,0,0] } } | | radius_m is missing
patch_without_radius | increments | increments = 4\nkind = "patch" | [probe] | tool_radius_m is missing ; 0.01
nine_tools | increments | increments = 4\nkind = "patch"\ntool_radius_m = 0.01\ntools = 9 | tools = 9 | 8 ; 9
tools_of_nodes | increments | increments = 4\ntools = 2 | tools = 2 | round tools ; kind = "patch"
tools_of_an_element_without_bodies | increments | increments = 4\nkind = "patch"\ntool_radius_m = 0.01\ntools = 2 | tools = 2
    | [solver] element is P1 ; element = "es-p1-p1"
node_elsewhere | increments | increments = 4\nelsewhere = "linear" | elsewhere | patch ; remove it
node_with_radius | increments | increments = 4\ntool_radius_m = 0.01 | tool_radius_m | 0.01 ; patch
unknown_family | family = "rbfn" | family = "fourier" | | [training] family ; "fourier" ; modal
too_many_modes | samples = 1000 | modes = 2000 | | 2000 ; 1024
linear_family_of_a_nonlinear_law | family = "rbfn" | family = "linear"
    | | [training] family ; 'linear' ; law is "neo-hookean" ; family = "modal" or "rbfn", or law = "linear"
no_depth_given | depth | | [probe] | max_displacement_m is missing ; 0.028
mixed_without_lambda | law = "neo-hookean"\nshear_modulus_Pa = 500.0\nbulk_modulus_Pa = 5000.0\n[solver]\nelement = "P1"
    | law = "linear"\nyoungs_modulus_Pa = 2e4\npoisson_ratio = 0\n[solver]\nelement = "p1-p1" | element
    | 2 mu / 3 = 0 Pa ; P1 ; P2
)")),
                         [](const auto& info) { return info.param.name; });

// Claim: of the families that can be trained, each is accepted where it applies.
TEST(SceneFamily, linear_goes_with_the_linear_law_and_networks_with_every_law) {
  const std::string linear = with(good_scene, "\"neo-hookean\"", "\"linear\"");
  EXPECT_EQ(parsed(with(linear, "\"rbfn\"", "\"linear\"")).training.family, Family::linear);
  EXPECT_EQ(parsed(linear).training.family, Family::rbfn);
  EXPECT_EQ(parsed(good_scene).training.family, Family::rbfn);
}

TEST(SceneSyntax, error_names_line_and_column) {
  const std::string message = refusal("title = \"a\"\n[mesh\nshape = 1\n");
  EXPECT_EQ(message.find("body.toml:2:"), 0u) << message;
  expect_names(message, {"not valid TOML", "remedy"});
}

// Found by fuzzing: toml++ asserts and assumes here, see toml_implementation.cpp.
TEST(SceneSyntax, headers_without_a_name_and_letters_beyond_ascii_are_refused) {
  for (const char* line : {"[#]", "[=]", "[m\u00e4sh]", "m\u00e4sh = 1", "a = \u00e4", "a\u00e9 = 1", "\u0416 = 1"}) {
    const std::string message = refusal("title = \"a\"\n" + std::string(line) + "\n");
    EXPECT_EQ(message.find("body.toml:2:"), 0u) << message;
    EXPECT_NE(message.find("not valid TOML"), std::string::npos) << message;
  }
}

TEST(SceneSyntax, key_given_twice_is_refused) {
  const std::string message = refusal(with(good_scene, "increments = 4", "increments = 4\nincrements = 5"));
  EXPECT_EQ(message.find("body.toml:16:"), 0u) << message;
}

TEST(SceneSyntax, missing_section_is_refused_at_the_first_line) {
  const std::string message = refusal(
      "title = \"a\"\n[mesh]\nshape = \"block\"\n[material]\nlaw = \"linear\"\n"
      "youngs_modulus_Pa = 1.0\npoisson_ratio = 0.3\n[probe]\nmax_displacement_m = 0.1\n");
  EXPECT_EQ(message.find("body.toml:1: [nodes] fixed is missing"), 0u) << message;
}

TEST(SceneSyntax, section_that_is_no_table_is_refused) {
  const std::string message = refusal("title = \"a\"\nmesh = 3\n");
  EXPECT_EQ(message.find("body.toml:2: mesh must be a section: 3"), 0u) << message;
}

TEST(SceneFile, that_is_not_there_or_a_folder_is_refused) {
  for (const char* path : {"/no/such/scene.toml", "/"})
    expect_names(message_of([&] { read_scene(path); }), {path, "remedy"});
}

}  // namespace
}  // namespace phynness::test
