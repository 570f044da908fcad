// Any bytes as a scene: read, or an Error in words; the physics of what was read has one hash.
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
                                             "#",
                                             "'''",
                                             "\"\"\""};

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
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
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
