// A scene from its text: the sections in turn, then what only shows across sections.
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/scene.hpp>

#include "scene_depth.hpp"
#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness {
namespace sd = scene_detail;
namespace {

/// Refuses a law that has no form, or here none that is good enough, whose stress across the wall vanishes.
void require_shell(const Material& m, const sd::SceneTable& table) {
  std::vector<std::string_view> always;
  for (const auto& law : laws())
    if (law.has_shell && law.shell_from == 0) always.push_back(law.name);
  const std::string remedy = "use law = " + sd::listed(always) + ", or a solid without thickness_m";
  if (!m.law->has_shell) table.reject("law", "is not condensed to the plane stress of a shell", remedy);
  if (m.bulk_to_shear() < m.law->shell_from)
    table.reject("law",
                 "condenses the stress across a shell in a few steps of Newton's method, good enough from K/mu = " +
                     sd::shortest(m.law->shell_from) + " on; here K/mu is " + sd::shortest(m.bulk_to_shear()),
                 remedy);
}

}  // namespace

Scene read_scene(const std::filesystem::path& file) {
  constexpr std::uint64_t most_bytes = 16 << 20;  // lists of two million nodes
  const auto text = read_input_file(file, {"the scene file", "give the path of a TOML file", most_bytes, true});
  return parse_scene(text, file.string(), std::filesystem::absolute(file).parent_path());
}

Scene parse_scene(const std::string& text, const std::string& source_name, const std::filesystem::path& folder,
                  MeshFile mesh_file, Element solid_element) {
  if (const auto line = sd::too_deep_at(text))
    sd::refuse({source_name, *line}, "keys, tables or arrays are nested too deeply",
               "more than " + std::to_string(sd::largest_depth) + " levels",
               "shorten the dotted key or close the brackets; no key of a scene lies deeper than five levels");
  toml::table root;
  try {
    root = toml::parse(std::string_view(text), source_name);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    const std::string reason(error.description());
    throw input_error(
        source_name + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": the file is not valid TOML",
        reason, "mend the syntax at this line and column (https://toml.io)");
  }

  const sd::SceneTable top(root, "", source_name);
  const auto section = [&](const char* name) {
    const auto* node = top.find(name);
    if (!node) return sd::SceneTable(name, source_name);
    const auto* table = node->as_table();
    if (!table) top.reject(name, "must be a section", "write [" + std::string(name) + "] on a line of its own");
    return sd::SceneTable(*table, name, source_name);
  };
  // Every section is opened before any is parsed: a misspelt key says more than the missing one it leaves
  // behind.
  const auto mesh = section("mesh"), material = section("material"), solver = section("solver");
  const auto nodes = section("nodes"), probe = section("probe"), database = section("database");
  const auto training = section("training"), validation = section("validation");

  Scene scene;
  scene.text = text;
  scene.source_name = source_name;
  scene.title = top.text("title").value_or("");
  scene.mesh = sd::parse_mesh(mesh, folder, mesh_file);
  scene.material = sd::parse_material(material);
  scene.solver = sd::parse_solver(solver, scene.material, scene.mesh, solid_element);
  sd::parse_nodes(nodes, scene);
  scene.probe = sd::parse_probe(probe);
  scene.database = sd::parse_database(database);
  scene.training = sd::parse_training(training, scene.material);
  scene.validation = sd::parse_validation(validation);
  if (scene.mesh.thickness_m > 0 && !scene.database.fields.empty())
    database.reject("fields", "are computed in solids, but [mesh] is the middle surface of a shell", "remove fields");
  if (scene.mesh.thickness_m > 0) require_shell(scene.material, material);
  return scene;
}

std::vector<std::string> scene_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const Material& m = scene.material;
  const Element element = scene.solver.element;
  if (m.bulk_to_shear() > element->locks_above)
    warnings.push_back(m.where.str() + ": K/mu = " + sd::shortest(m.bulk_to_shear()) + ": " + name(element) +
                       " tetrahedra lock at this ratio, so that the body feels " +
                       (element->locks_severely ? "several times" : "noticeably") +
                       " too stiff; elements p1-p1 and taylor-hood do not");
  const ProbeSpec& probe = scene.probe;
  if (m.law->linear && (probe.directions != Directions::three || probe.increments != 1)) {
    const auto asked = exploratory_directions(probe.directions).size() * static_cast<std::size_t>(probe.increments);
    warnings.push_back(probe.where.str() +
                       ": the law is linear, so that three solves say all about a node: " + std::to_string(asked) +
                       " are asked for; directions = 3, increments = 1 and family = \"linear\" give an exact model");
  }
  return warnings;
}

std::vector<std::string> scene_notes(const Scene& scene) {
  if (scene.probe.kind_given) return {};
  return {scene.probe.where.str() +
          ": the scene names no kind of probe, so that single nodes are displaced: the force at a node has no limit "
          "under mesh refinement; kind = \"patch\" with tool_radius_m has one"};
}

}  // namespace phynness
