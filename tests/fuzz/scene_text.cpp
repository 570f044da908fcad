// Arbitrary bytes as a scene are read or result in an Error. The physics of a scene has one hash. Changed texts repeat
// parts of themselves, so that keys, headers and brackets can be nested as deeply as the input is long.
#include <phynness/formats/error.hpp>
#include <phynness/formats/scene.hpp>

#include "../bad_input/good_scene.hpp"
#include "texts.hpp"

namespace phynness::fuzz {
namespace {

const std::vector<std::string_view> words = {"0",
                                             "1",
                                             "-1",
                                             "2",
                                             "26",
                                             "98",
                                             "1e30",
                                             "-1e300",
                                             "1e-320",
                                             "nan",
                                             "inf",
                                             "-inf",
                                             "9223372036854775807",
                                             "0.5",
                                             "true",
                                             "false",
                                             "[]",
                                             "{}",
                                             "\"\"",
                                             "[0, 0, 0]",
                                             "[1, 1, 1]",
                                             "\"block\"",
                                             "\"liver\"",
                                             "\"cylinder\"",
                                             "\"tube\"",
                                             "\"linear\"",
                                             "\"neo-hookean\"",
                                             "\"mooney-rivlin\"",
                                             "\"st-venant-kirchhoff\"",
                                             "\"P1\"",
                                             "\"p1-p1\"",
                                             "\"taylor-hood\"",
                                             "\"surface\"",
                                             "\"free-surface\"",
                                             "\"all\"",
                                             "\"x\"",
                                             "[mesh]",
                                             "[material]",
                                             "[solver]",
                                             "[nodes]",
                                             "[probe]",
                                             "[training]",
                                             "[validation]",
                                             "[database]",
                                             "shape",
                                             "file",
                                             "law",
                                             "young_modulus_Pa",
                                             "poisson_ratio",
                                             "shear_modulus_Pa",
                                             "bulk_modulus_Pa",
                                             "c10_Pa",
                                             "c01_Pa",
                                             "element",
                                             "fixed",
                                             "active",
                                             "output",
                                             "box",
                                             "sphere",
                                             "plane",
                                             "half_space",
                                             "nearest",
                                             "nodes",
                                             "group",
                                             "min_fraction",
                                             "max_fraction",
                                             "min_m",
                                             "max_m",
                                             "center_m",
                                             "radius_m",
                                             "normal",
                                             "point_m",
                                             "directions",
                                             "increments",
                                             "max_displacement_m",
                                             "symmetry",
                                             "family",
                                             "\"modal\"",
                                             "\"rbfn\"",
                                             "fields",
                                             "[\"von-mises-stress\"]",
                                             "target_nodes",
                                             "target_size_m",
                                             "size_m",
                                             "seed",
                                             "a.a.a",
                                             "[a.a]",
                                             "[[a.a]]",
                                             "{a.a=",
                                             "\"a.\".",
                                             "#",
                                             "'''",
                                             "\"\"\""};

/// `head`, a piece n times, `tail`, behind a scene.
void append_deep(std::vector<Input>& all, std::size_t n, std::string_view head, std::string_view piece,
                 std::string_view tail) {
  Input& input = all.emplace_back();
  append_text(input, phynness::test::good_scene);
  append_text(input, head);
  for (std::size_t i = 0; i < n; ++i) append_text(input, piece);
  append_text(input, tail);
}

/// A piece of the text, doubled as often as a random number says: what is nested in it is nested deeper.
std::string with_repeated_piece(std::string text, Random& random, std::size_t max_size) {
  if (text.empty()) return text;
  const std::size_t at = random.below(text.size()), n = std::min(text.size() - at, random.below(12) + 1);
  std::string piece = text.substr(at, n);
  for (std::size_t k = random.below(15); k > 0 && 2 * piece.size() + text.size() < max_size; --k) piece += piece;
  return text.insert(at, piece);
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> all;
  append_text(all.emplace_back(), phynness::test::good_scene);
  append_text(all.emplace_back(), R"(title = "all kinds"
[mesh]
file = "nowhere.stl"
scale_to_m = 0.001
target_size_m = 0.01
symmetry = { normal = [1, 0, 0], point_fraction = [0.5, 0.5, 0.5] }
[material]
law = "mooney-rivlin"
c10_Pa = 300.0
c01_Pa = 100.0
bulk_modulus_Pa = 1e5
[solver]
element = "p1-p1"
relative_tolerance = 1e-8
[nodes]
fixed = [{ sphere = { center_m = [0, 0, 0], radius_m = 0.02 } }, { nodes = [1, 2, 3] }, { group = "hilum" }]
active = { nearest = { point_m = [0, 0, 0.1] } }
output = "surface"
[probe]
kind = "patch"
tool_radius_m = 0.01
directions = 98
increments = 3
max_displacement_m = 0.02
[database]
fields = ["von-mises-stress", "energy-density"]
[training]
family = "modal"
modes = 8
seed = 3
[validation]
probes = 10
)");
  for (const std::size_t n : {std::size_t{5}, std::size_t{60}, std::size_t{20000}}) {
    append_deep(all, n, "[x]\n", "a.", "a = 1\n");
    append_deep(all, n, "[", "a.", "a]\nb = 1\n");
    append_deep(all, n, "[[", "a.", "a]]\nb = 1\n");
    append_deep(all, n, "['b.\"'.", "a.", "a]\n");
    append_deep(all, n, "x = { ", "a.", "a = 1 }\n");
    append_deep(all, n, "x = ", "[", "1\n");
    append_deep(all, n / 4, "x = ", "{a.b=[", "1\n");
    append_deep(all, n, "title = \"\"\"\"", "a.[{", "\"\"\"\"\"\n# ...\n");
  }
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  Random random(seed);
  if (random.below(6) == 0) {
    const std::string text = with_repeated_piece(std::string(data, data + size), random, max_size);
    size = std::min(text.size(), max_size);
    std::copy_n(text.begin(), size, data);
    return size;
  }
  return change_text(data, size, max_size, seed, 0, words);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  try {
    const Scene scene = parse_scene(text, "scene.toml", "/", MeshFile::may_be_absent);
    require(physics_hash(scene).size() == 16 && physics_hash(scene) == physics_hash(scene), "one hash");
    scene_warnings(scene);
    const Scene again = parse_scene(scene.text, scene.source_name, "/", MeshFile::may_be_absent);
    require(physics_summary(again) == physics_summary(scene), "the text that a scene keeps is that scene");
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() > 10, "an error in words");
  }
  return 0;
}
