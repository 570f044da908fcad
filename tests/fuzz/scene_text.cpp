// Arbitrary bytes as a scene are read or result in an Error. The physics of a scene has one hash. Changed texts repeat
// parts of themselves, so that keys, headers and brackets can be nested as deeply as the input is long.
#include <phynness/formats/error.hpp>
#include <phynness/formats/scene.hpp>
#include <set>

#include "../bad_input/good_scene.hpp"
#include "texts.hpp"

namespace phynness::fuzz {
namespace {

/// What scenes are made of: values and structure, and all sections, keys, selectors, laws, elements and fields that the
/// parser knows.
const std::vector<std::string>& known_words() {
  static const std::vector<std::string> all = [] {
    const auto plain = words_of(
        "0|1|-1|2|26|98|1e30|-1e300|1e-320|nan|inf|-inf|9223372036854775807|0.5|true|false|[]|{}|\"\"|[0, 0, 0]|"
        "[1, 1, 1]|a.a.a|[a.a]|[[a.a]]|{a.a=|\"a.\".|#|'''|\"\"\"");
    std::vector<std::string> words(plain.begin(), plain.end());
    for (const char* text : {"block", "liver", "cylinder", "tube", "drain", "surface", "free-surface", "all", "node",
                             "patch", "modal", "rbfn", "linear", "x"})
      words.push_back('"' + std::string(text) + '"');
    for (const LawRow& law : laws()) words.push_back('"' + std::string(law.name) + '"');
    for (const ElementRow& element : elements()) words.push_back('"' + std::string(element.name) + '"');
    for (const Field field : every_field) words.push_back("[\"" + std::string(name(field)) + "\"]");
    std::set<std::string> parts;
    for (const std::string& key : scene_keys()) {
      const std::size_t dot = key.find('.');
      if (dot == std::string::npos) {
        parts.insert(key);
        continue;
      }
      if (key.compare(0, dot, "selector") != 0) parts.insert('[' + key.substr(0, dot) + ']');
      for (std::size_t at = dot; at != std::string::npos; at = key.find('.', at + 1))
        parts.insert(key.substr(at + 1, key.find('.', at + 1) - at - 1));
    }
    words.insert(words.end(), parts.begin(), parts.end());
    return words;
  }();
  return all;
}
const std::vector<std::string_view> words(known_words().begin(), known_words().end());

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
    const Scene again = parse_scene(scene.text, scene.source_name, "/", MeshFile::may_be_absent);
    require(physics_summary(again) == physics_summary(scene), "the text that a scene keeps is that scene");
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() > 10, "an error in words");
  }
  return 0;
}
