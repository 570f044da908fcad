// [mesh], [solver], [probe], [database], [training] and [validation].
#include "scene_sections.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <phynness/formats/mesh_files.hpp>

#include "scene_keys.hpp"

namespace phynness::scene_detail {
namespace {

constexpr double most_slender = 1000;
constexpr int default_target_nodes = 739, default_drain_nodes = 239;  // the paper's liver and drain
constexpr double default_drain_thickness_m = 0.0005;
constexpr std::int64_t most_nodes = 5'000'000;

void refuse_keys(const SceneTable& table, std::initializer_list<const char*> keys, const std::string& why,
                 const std::string& remedy) {
  for (const char* key : keys)
    if (table.has(key)) table.reject(key, why, remedy);
}

void parse_mesh_file(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file, MeshSpec& spec) {
  const std::filesystem::path given = *table.text("file");
  spec.file = std::filesystem::absolute(given.is_absolute() ? given : folder / given).lexically_normal();
  std::string extension = given.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(mesh_file_extensions.begin(), mesh_file_extensions.end(), extension) == mesh_file_extensions.end())
    table.reject("file", "has an unknown format", "give a " + listed(mesh_file_extensions) + " file");
  std::error_code code;
  if (mesh_file == MeshFile::must_exist && std::filesystem::exists(spec.file, code) &&
      !std::filesystem::is_regular_file(spec.file, code))
    table.reject("file",
                 "names something that is not a file, but a folder, a pipe or a device (" + spec.file.string() + ")",
                 "name the file of a mesh");
  if (mesh_file == MeshFile::must_exist && !std::filesystem::is_regular_file(spec.file, code))
    table.reject("file", "does not exist (as " + spec.file.string() + ")",
                 "correct the path; a relative path starts at the folder of the scene file");
  refuse_keys(table, {"size_m", "radius_m", "inner_radius_m", "length_m", "slit_length_m", "slit_width_m"},
              "belongs to a built-in shape, but the mesh comes from a file", "remove it");
  spec.scale_to_m = table.number_or("scale_to_m", 1.0, {0, 1e6, true, false});
}

void parse_built_in_shape(const SceneTable& table, MeshSpec& spec) {
  refuse_keys(table, {"scale_to_m", "repair"}, "belongs to a mesh file, but the mesh is a built-in shape", "remove it");
  const bool drain = spec.shape == Shape::drain;
  const bool round = spec.shape == Shape::cylinder || spec.shape == Shape::tube || drain;
  const std::string shape = phynness::name(spec.shape);
  if (round)
    refuse_keys(table, {"size_m"}, "does not apply to shape " + shape, "give radius_m and length_m");
  else
    refuse_keys(table, {"radius_m", "inner_radius_m", "length_m"}, "does not apply to shape " + shape,
                "give size_m = [x, y, z]");
  if (spec.shape == Shape::cylinder)
    refuse_keys(table, {"inner_radius_m"}, "does not apply to a cylinder", "use shape = \"tube\"");
  if (drain)
    refuse_keys(table, {"inner_radius_m"}, "does not apply to a drain, which is a shell",
                "give radius_m of its midsurface, and thickness_m");
  else
    refuse_keys(table, {"slit_length_m", "slit_width_m", "thickness_m"}, "does not apply to shape " + shape,
                "use shape = \"drain\", or the file of a shell's midsurface");

  if (const auto size = table.vector("size_m", shape_length)) {
    spec.size_m = *size;
    const auto [least, most] = std::minmax_element(size->begin(), size->end());
    if (*most > most_slender * *least)
      table.reject("size_m", "has a largest edge of more than 1000 times the smallest edge",
                   "give a thicker body; tetrahedra cannot fill this one");
  }
  spec.radius_m = table.number_or("radius_m", 0, shape_length);
  spec.inner_radius_m = table.number_or("inner_radius_m", 0, shape_length);
  spec.length_m = table.number_or("length_m", 0, shape_length);
  spec.slit_length_m = table.number_or("slit_length_m", 0, shape_length);
  spec.slit_width_m = table.number_or("slit_width_m", 0, shape_length);
  if (drain && spec.thickness_m == 0) spec.thickness_m = default_drain_thickness_m;
  if (table.has("inner_radius_m") && table.has("radius_m") && spec.inner_radius_m >= spec.radius_m)
    table.reject("inner_radius_m", "must be less than radius_m", "reduce inner_radius_m or increase radius_m");

  if (!spec.target_nodes && !spec.target_size_m) spec.target_nodes = drain ? default_drain_nodes : default_target_nodes;
}

Directions parse_directions(const SceneTable& table) {
  const auto* node = table.find("directions");
  if (!node) return Directions::twenty_six;
  std::string word;
  if (const auto* number = node->as_integer())
    word = std::to_string(number->get());
  else if (const auto* text = node->as_string())
    word = text->get();
  for (auto kind : {Directions::three, Directions::fourteen, Directions::twenty_six, Directions::ninety_eight,
                    Directions::hemisphere})
    if (word == phynness::name(kind)) return kind;
  table.reject("directions", "is not a known set of directions", "write 14, 26, 98, 3 or \"hemisphere\"");
}

/// A spread; <= 0 means "search".
double parse_spread(const SceneTable& table, std::string_view key, double otherwise) {
  const auto* node = table.find(key);
  if (!node) return otherwise;
  if (const auto* word = node->as_string()) {
    if (word->get() == "search") return 0;
    table.reject(key, "is neither a number nor \"search\"", "write \"search\" or a number greater than 0");
  }
  // Inputs are scaled to [-1, 1]. Far smaller spreads separate all points, far larger ones separate none.
  return *table.number(key, {1e-3, 1e3});
}

}  // namespace

MeshSpec parse_mesh(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file) {
  MeshSpec spec;
  spec.where = table.where();
  if (table.has("shape") && table.has("file"))
    table.reject("file", "cannot be combined with shape", "keep either the built-in shape or the file");
  if (!table.has("shape") && !table.has("file"))
    table.missing("shape", ", and so is file",
                  "add shape = \"liver\", \"block\", \"cylinder\", \"tube\" or \"drain\", or file = \"body.msh\"");
  if (table.has("target_nodes") && table.has("target_size_m"))
    table.reject("target_size_m", "cannot be combined with target_nodes, which also determines the size",
                 "keep one of the two");
  if (const auto nodes = table.integer("target_nodes", 8, most_nodes)) spec.target_nodes = static_cast<int>(*nodes);
  if (const auto size = table.number("target_size_m", shape_length)) spec.target_size_m = *size;
  spec.repair = table.flag_or("repair", false);
  spec.thickness_m = table.number_or("thickness_m", 0, length);
  spec.symmetry = parse_symmetry(table);
  if (table.has("file")) {
    parse_mesh_file(table, folder, mesh_file, spec);
  } else {
    spec.shape = *table.choice<Shape>("shape", {{"liver", Shape::liver},
                                                {"block", Shape::block},
                                                {"cylinder", Shape::cylinder},
                                                {"tube", Shape::tube},
                                                {"drain", Shape::drain}});
    parse_built_in_shape(table, spec);
  }
  return spec;
}

SolverSpec parse_solver(const SceneTable& table, const Material& material, const MeshSpec& mesh,
                        Element solid_element) {
  SolverSpec spec;
  const bool shell = mesh.thickness_m > 0;
  spec.element_given = table.has("element");
  spec.element = shell ? &elements().back() : solid_element;
  spec.element = table.choice<Element>("element", choices(elements())).value_or(spec.element);
  if (shell && !spec.element->is_shell)
    table.reject("element", "is made of tetrahedra, but [mesh] is the midsurface of a shell",
                 "write element = \"shell\", or remove mesh.thickness_m");
  if (!shell && spec.element->is_shell)
    table.reject("element", "is an element for shells, but [mesh] has no thickness_m", "add thickness_m to [mesh]");
  spec.relative_tolerance = table.number_or("relative_tolerance", spec.relative_tolerance, {1e-14, 1e-2});
  spec.max_iterations = static_cast<int>(table.integer_or("max_iterations", spec.max_iterations, 1, 1000));
  spec.max_cutbacks = static_cast<int>(table.integer_or("max_cutbacks", spec.max_cutbacks, 0, 30));
  if (spec.element->mixed && !(material.lame_lambda_Pa > 0))
    refuse(table.where("element"),
           std::string("element ") + phynness::name(spec.element) + " needs a positive Lame parameter lambda",
           "lambda = " + shortest(material.lame_lambda_Pa) + " Pa",
           "use element = \"P1\" or \"P2\", which do not lock with such a compressible material");
  return spec;
}

ProbeSpec parse_probe(const SceneTable& table) {
  ProbeSpec spec;
  spec.where = table.where();
  spec.kind_given = table.has("kind");
  spec.kind =
      table.choice<ProbeKind>("kind", {{"node", ProbeKind::node}, {"patch", ProbeKind::patch}}).value_or(spec.kind);
  const auto radius = table.number("tool_radius_m", shape_length);
  if (spec.kind == ProbeKind::node && radius)
    table.reject("tool_radius_m", "is only used by patch probes, but kind is \"node\"",
                 "remove it, or write kind = \"patch\"");
  if (spec.kind == ProbeKind::patch && !radius)
    table.missing("tool_radius_m", ", which a patch probe needs", "add tool_radius_m in metres, such as 0.01");
  spec.tool_radius_m = radius.value_or(0);
  spec.directions = parse_directions(table);
  spec.increments = static_cast<int>(table.integer_or("increments", spec.increments, 1, 1000));
  const auto depth = table.number("max_displacement_m", {0, 10, true, false});
  if (!depth) table.missing("max_displacement_m", "", "add max_displacement_m in metres, such as 0.028 for 28 mm");
  spec.max_displacement_m = *depth;
  spec.max_force_N = table.number_or("max_force_N", spec.max_force_N, {0, 1e9, true, false});
  spec.min_jacobian = table.number_or("min_jacobian", spec.min_jacobian, {0, 0.9});
  spec.stop_at_fold = table.flag_or("stop_at_fold", spec.stop_at_fold);
  return spec;
}

DatabaseSpec parse_database(const SceneTable& table) {
  DatabaseSpec spec;
  spec.tangents = table.flag_or("tangents", spec.tangents);
  spec.float64 =
      table.choice<bool>("displacement_precision", {{"float32", false}, {"float64", true}}).value_or(spec.float64);
  spec.fields = parse_fields(table);
  return spec;
}

/// All families with their names.
std::vector<std::pair<std::string_view, Family>> every_family() {
  std::vector<std::pair<std::string_view, Family>> all;
  for (std::uint32_t f = 0; f < schema::n_families; ++f)
    all.emplace_back(schema::family_words[f], static_cast<Family>(f));
  return all;
}

TrainingSpec parse_training(const SceneTable& table, const Material& material) {
  TrainingSpec spec;
  spec.family = table.choice("family", every_family()).value_or(spec.family);
  if (schema::traits(spec.family).proportional && !material.law->linear)
    table.reject("family",
                 std::string("needs the linear law, but [material] law is \"") + phynness::name(material.law) + "\"",
                 "write family = \"modal\" or \"rbfn\", or law = \"linear\"");
  spec.deformation_neurons =
      static_cast<int>(table.integer_or("deformation_neurons", spec.deformation_neurons, 1, 100'000));
  spec.force_neurons = static_cast<int>(table.integer_or("force_neurons", spec.force_neurons, 1, 100'000));
  spec.deformation_spread = parse_spread(table, "deformation_spread", spec.deformation_spread);
  spec.force_spread = parse_spread(table, "force_spread", spec.force_spread);
  spec.samples = static_cast<int>(table.integer_or("samples", spec.samples, 1, 10'000'000));
  spec.target_mse = table.number_or("target_mse", spec.target_mse, {0, 1});
  spec.force_centers = static_cast<int>(table.integer_or("force_centers", spec.force_centers, 1, 100'000));
  spec.amplitude_centers = static_cast<int>(table.integer_or("amplitude_centers", spec.amplitude_centers, 0, 100'000));
  spec.modes = static_cast<int>(table.integer_or("modes", spec.modes, 0, 1024));
  spec.shared_modes = static_cast<int>(table.integer_or("shared_modes", spec.shared_modes, 0, 1024));
  spec.near_nodes = static_cast<int>(table.integer_or("near_nodes", spec.near_nodes, 0, 1'000'000));
  spec.levels = static_cast<int>(table.integer_or("levels", spec.levels, 1, 8));
  spec.seed = static_cast<std::uint64_t>(
      table.integer_or("seed", static_cast<std::int64_t>(spec.seed), 0, std::numeric_limits<std::int64_t>::max()));
  return spec;
}

ValidationSpec parse_validation(const SceneTable& table) {
  ValidationSpec spec;
  spec.probes = static_cast<int>(table.integer_or("probes", spec.probes, 1, 1'000'000));
  spec.seed = static_cast<std::uint64_t>(
      table.integer_or("seed", static_cast<std::int64_t>(spec.seed), 0, std::numeric_limits<std::int64_t>::max()));
  return spec;
}

}  // namespace phynness::scene_detail
