// The checks of sections across keys, and [database] fields.
#include "scene_sections.hpp"

#include <algorithm>
#include <phynness/formats/mesh_files.hpp>
#include <phynness/formats/printable.hpp>

#include "scene_keys.hpp"
#include "selectors.hpp"

namespace phynness {

namespace {

double or_standard(double given, double standard) { return given > 0 ? given : standard; }

}  // namespace

MeshSpec with_standard_sizes(MeshSpec spec) {
  if (spec.shape == Shape::none) return spec;
  const ShapeRow& shape = row(spec.shape);
  if (!spec.target_nodes && !spec.target_size_m) spec.target_nodes = shape.target_nodes;
  for (std::size_t k = 0; k < 3; ++k) spec.size_m[k] = or_standard(spec.size_m[k], shape.size_m[k]);
  spec.radius_m = or_standard(spec.radius_m, shape.radius_m);
  spec.inner_radius_m = or_standard(spec.inner_radius_m, shape.wall * spec.radius_m);
  spec.length_m = or_standard(spec.length_m, shape.length_m);
  spec.slit_length_m = or_standard(spec.slit_length_m, shape.slit * spec.length_m);
  spec.slit_width_m = or_standard(spec.slit_width_m, std::min(shape.slit_width_m, spec.radius_m / 2));
  spec.thickness_m = or_standard(spec.thickness_m, shape.thickness_m);
  return spec;
}

namespace scene_detail {
namespace {

constexpr double most_slender = 1000;

/// Refuses selections by what new tetrahedra do not have of the file.
void refuse_nodes_of_file(const SceneTable& nodes, const toml::node& selection) {
  if (const auto* list = selection.as_array())
    for (const auto& item : *list) refuse_nodes_of_file(nodes, item);
  if (const auto* table = selection.as_table())
    for (const auto& [key, value] : *table) {
      if (key == "group" || key == "nodes")
        refuse(nodes.where(value),
               nodes.label("") + "selects by " + std::string(key.str()) + ", but [mesh] remesh = true " +
                   "replaces the nodes and cells of the file",
               shown(value), "select by places (box, sphere, plane, nearest), or remove remesh");
      refuse_nodes_of_file(nodes, value);
    }
}

void refuse_keys(const SceneTable& table, std::initializer_list<std::string_view> keys, const std::string& what) {
  for (const auto key : keys)
    if (table.has(key)) table.reject(key, what, "remove it");
}

void check_file(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file, MeshSpec& spec) {
  const std::string extension = lower(spec.file.extension().string());
  spec.file = std::filesystem::absolute(folder / spec.file).lexically_normal();
  if (std::ranges::find(mesh_file_extensions, extension) == std::end(mesh_file_extensions))
    table.reject("file", "has an unknown format", mesh_file_kinds());
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
              "belongs to a built-in shape, but the mesh comes from a file");
  if (spec.remesh)
    refuse_keys(table, {"thickness_m"}, "cannot be combined with remesh = true, whose tetrahedra are not a shell");
}

void refuse_keys_of_other_shapes(const SceneTable& table, Shape shape) {
  const auto own = shape_keys(shape);
  for (const auto& other : shapes())
    for (const auto key : shape_keys(other.shape))
      if (table.has(key) && std::find(own.begin(), own.end(), key) == own.end())
        table.reject(key, "does not apply to shape " + std::string(name(shape)),
                     "give " + listed(own, " and ") + ", or write shape = \"" + other.name + '"');
}

void check_shape(const SceneTable& table, MeshSpec& spec) {
  refuse_keys(table, {"scale_to_m", "repair", "remesh"}, "belongs to a mesh file, but the mesh is a built-in shape");
  refuse_keys_of_other_shapes(table, spec.shape);
  const MeshSpec whole = with_standard_sizes(spec);
  const auto [least, most] = std::minmax_element(whole.size_m.begin(), whole.size_m.end());
  if (*most > most_slender * *least)
    table.reject("size_m", "has a largest edge of more than 1000 times the smallest edge",
                 "give a thicker body; tetrahedra cannot fill this one");
  if (whole.inner_radius_m > 0 && whole.inner_radius_m >= whole.radius_m)
    table.reject("inner_radius_m", "must be less than radius_m, which is " + length_text(whole.radius_m),
                 "reduce inner_radius_m or increase radius_m");
  const auto refuse_long = [&](const char* key, double value, double most, const char* what) {
    if (value > most)
      table.reject(key, "must be at most " + length_text(most) + ", " + what, "reduce " + std::string(key));
  };
  refuse_long("slit_length_m", whole.slit_length_m, 0.9 * whole.length_m, "nine tenths of length_m");
  refuse_long("slit_width_m", whole.slit_width_m, whole.radius_m, "which is radius_m");
  refuse_long("slit_width_m", whole.slit_width_m, whole.slit_length_m, "which is slit_length_m");
  spec.target_nodes = whole.target_nodes;
  spec.thickness_m = whole.thickness_m;
}

}  // namespace

void check_mesh(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file, MeshSpec& spec) {
  spec.where = table.where();
  if (table.has("shape") && table.has("file"))
    table.reject("file", "cannot be combined with shape", "keep either the built-in shape or the file");
  if (!table.has("shape") && !table.has("file"))
    table.missing("shape", ", and so is file",
                  "add shape = \"liver\", \"block\", \"cylinder\", \"tube\" or \"drain\", or file = \"body.msh\"");
  if (table.has("target_nodes") && table.has("target_size_m"))
    table.reject("target_size_m", "cannot be combined with target_nodes, which also determines the size",
                 "keep one of the two");
  if (table.has("file"))
    check_file(table, folder, mesh_file, spec);
  else
    check_shape(table, spec);
}

void check_solver(const SceneTable& table, Scene& scene) {
  SolverSpec& spec = scene.solver;
  const bool shell = scene.mesh.thickness_m > 0;
  if (!table.has("element")) {
    const bool patch = scene.probe.kind == ProbeKind::patch;
    spec.element = shell ? &elements().back() : element_named(patch ? "es-p1-p1" : "p1-p1");
  }
  if (shell && !spec.element->is_shell)
    table.reject("element", "is made of tetrahedra, but [mesh] is the midsurface of a shell",
                 "write element = \"shell\", or remove mesh.thickness_m");
  if (!shell && spec.element->is_shell)
    table.reject("element", "is an element for shells, but [mesh] has no thickness_m", "add thickness_m to [mesh]");
  for (const Material* material : materials(scene))
    if (spec.element->mixed && !(material->lame_lambda_Pa > 0))
      refuse(
          table.where("element"),
          std::string("element ") + phynness::name(spec.element) + " needs a positive Lame parameter lambda",
          "lambda = K - 2 mu / 3 = " + shortest(material->lame_lambda_Pa) + " Pa of the material at line " +
              std::to_string(material->where.line),
          "check the moduli, of which a region has the body's where it gives none; for so compressible a material use "
          "element = \"P1\" or \"P2\", which do not lock there");
}

void check_region(const SceneTable& table, const Scene& scene) {
  const Region& region = scene.regions.back();
  if (scene.mesh.remesh && table.has("cells")) refuse_nodes_of_file(table, *table.find("cells"));
  for (const char* key : {"name", "cells"})
    if (!table.has(key))
      table.missing(key, "", "add name = \"nodule\" and cells = { sphere = { center_m = [...], radius_m = ... } }");
  if (region.name.empty() || region.name.find_first_of("\r\n") != std::string::npos)
    table.reject("name", "is empty or has several lines", "give a name, such as \"nodule\"");
  for (const Region& other : scene.regions)
    if (&other != &region && other.name == region.name)
      table.reject("name", "is that of another region, at line " + std::to_string(other.where.line),
                   "give each region a name of its own");
  if (scene.regions.size() > 255)
    table.reject("name", "is that of region 256, and a scene has at most 255", "select several parts in one region");
  if (scene.mesh.thickness_m > 0)
    refuse(table.where(), "regions are only available for solids, but [mesh] is the midsurface of a shell",
           "[[region]] " + region.name, "remove the region");
}

void check_nodes(const SceneTable& table, Scene& scene) {
  if (!table.has("fixed"))
    table.missing("fixed", ": without fixed nodes the body can move freely and its system is singular",
                  "add fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } } or another "
                  "selection");
  const auto locate = [&](const char* key, Selection& selection, SourceLocation& where) {
    if (scene.mesh.remesh && table.has(key)) refuse_nodes_of_file(table, *table.find(key));
    where = table.where(key);
    if (!table.has(key)) selection.front().where = where;
  };
  locate("fixed", scene.fixed, scene.fixed_where);
  locate("active", scene.active, scene.active_where);
  locate("output", scene.output, scene.output_where);
}

void check_probe(const SceneTable& table, ProbeSpec& spec) {
  spec.where = table.where();
  spec.kind_given = table.has("kind");
  if (spec.kind == ProbeKind::node && table.has("tool_radius_m"))
    table.reject("tool_radius_m", "is only used by patch probes, but kind is \"node\"",
                 "remove it, or write kind = \"patch\"");
  if (spec.kind == ProbeKind::node && table.has("elsewhere") && spec.elsewhere == Elsewhere::linear)
    table.reject("elsewhere", "is only used by patch probes, but kind is \"node\"",
                 "remove it, or write kind = \"patch\"");
  if (spec.kind == ProbeKind::patch && !table.has("tool_radius_m"))
    table.missing("tool_radius_m", ", which a patch probe needs", "add tool_radius_m in metres, such as 0.01");
  if (!table.has("max_displacement_m"))
    table.missing("max_displacement_m", "", "add max_displacement_m in metres, such as 0.028 for 28 mm");
}

void check_tools(const SceneTable& table, const Scene& scene) {
  if (scene.probe.tools < 2) return;
  if (scene.probe.kind == ProbeKind::node)
    table.reject("tools", "needs round tools, but kind is \"node\"", "write kind = \"patch\", or remove tools");
  if (!has_bodies(*scene.solver.element))
    table.reject("tools",
                 std::string("needs an element that has reduced bodies, but [solver] element is ") +
                     phynness::name(scene.solver.element),
                 "write element = \"es-p1-p1\" or \"p1-p1\", or remove tools");
}

std::vector<Field> parse_fields(const SceneTable& database) {
  std::vector<Field> fields;
  std::vector<std::string_view> known;
  for (const auto field : every_field) known.push_back(phynness::name(field));
  const auto* array = database.find("fields")->as_array();
  if (!array)
    database.reject("fields", "must be an array of names", "write fields = [\"" + std::string(known[0]) + "\"]");
  for (const auto& entry : *array) {
    const auto* word = entry.as_string();
    const auto field = word ? field_named(word->get()) : std::nullopt;
    if (!field) {
      const auto near = word ? nearest(word->get(), known) : std::string_view{};
      refuse(database.where(entry), database.label("fields") + " contains an unknown name", shown(entry),
             "write " + listed(known, " or ") + " between quotes" +
                 (near.empty() ? "" : "; did you mean \"" + std::string(near) + "\"?"));
    }
    if (std::find(fields.begin(), fields.end(), *field) != fields.end())
      refuse(database.where(entry), database.label("fields") + " contains a field twice", shown(entry),
             "name each field once");
    fields.push_back(*field);
  }
  std::sort(fields.begin(), fields.end());
  return fields;
}

void check_database(const SceneTable& table, const Scene& scene) {
  if (scene.mesh.thickness_m > 0 && !scene.database.fields.empty())
    table.reject("fields", "are only available for solids, but [mesh] is the midsurface of a shell", "remove fields");
}

void check_training(const SceneTable& table, const Scene& scene) {
  // Imported responses have no material; their numbers tell whether they are linear.
  const bool has_material = !scene.material.parameters.empty();
  if (has_material && schema::traits(scene.training.family).proportional && !scene.material.law->linear)
    table.reject(
        "family",
        std::string("needs the linear law, but [material] law is \"") + phynness::name(scene.material.law) + "\"",
        "write family = \"modal\" or \"rbfn\", or law = \"linear\"");
}

}  // namespace scene_detail
}  // namespace phynness
