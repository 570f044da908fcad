// Reads a scene: the keys of each section and the checks across them; warnings and notes.
#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/scene.hpp>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness {
namespace sd = scene_detail;

Scene read_scene(const std::filesystem::path& file) {
  constexpr std::uint64_t most_bytes = 16 << 20;  // lists of two million nodes
  const auto text = read_input_file(
      file, {"the scene file", "give the path of a TOML file, whose [mesh] names the mesh", most_bytes, true});
  return parse_scene(text, file.string(), std::filesystem::absolute(file).parent_path());
}

namespace {

/// Above this K/mu moduli are probably given in different units: from 1,000 on forces hardly change (docs/extremes.md).
constexpr double largest_usual_bulk_to_shear = 1e4;
/// The shear modulus of organs is above this one, and their number of kPa below.
constexpr double softest_usual_Pa = 20;

sd::SceneTable section_of(const sd::SceneTable& top, const char* name, const std::string& source_name) {
  const auto* node = top.find(name);
  if (!node) return {name, source_name};
  const auto* table = node->as_table();
  if (!table) top.reject(name, "must be a section", "write [" + std::string(name) + "] on a separate line");
  return {*table, name, source_name};
}

/// The tables of [[region]].
std::vector<sd::SceneTable> regions_of(const sd::SceneTable& top, const std::string& source_name) {
  std::vector<sd::SceneTable> tables;
  const auto* node = top.find("region");
  const auto* list = node ? node->as_array() : nullptr;
  if (node && !list) top.reject("region", "must be an array of tables", "write [[region]] on a separate line");
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    const auto* table = (*list)[i].as_table();
    if (!table) top.reject("region", "must be an array of tables", "write [[region]] on a separate line");
    tables.emplace_back(*table, "region", source_name);
  }
  return tables;
}

}  // namespace

std::vector<const Material*> materials(const Scene& scene) {
  std::vector<const Material*> all{&scene.material};
  for (const Region& region : scene.regions) all.push_back(&region.material);
  return all;
}

Scene parse_scene(const std::string& text, const std::string& source_name, const std::filesystem::path& folder,
                  MeshFile mesh_file) {
  const toml::table root = sd::parse_toml(text, source_name);
  const sd::SceneTable top(root, "", source_name);
  const auto section = [&](const char* name) { return section_of(top, name, source_name); };
  // All sections are opened, which checks their keys, before any is read: the error about a misspelt key is more
  // useful than the error about the missing key that it causes.
  const auto mesh = section("mesh"), material = section("material"), solver = section("solver");
  const auto nodes = section("nodes"), probe = section("probe"), database = section("database");
  const auto training = section("training"), validation = section("validation");
  const auto regions = regions_of(top, source_name);

  Scene scene;
  scene.text = text;
  scene.source_name = source_name;
  top.read_into(scene);
  mesh.read_into(scene);
  sd::check_mesh(mesh, folder, mesh_file, scene.mesh);
  material.read_into(scene);
  sd::check_material(material, scene);
  for (const auto& region : regions) {
    scene.regions.emplace_back();
    region.read_into(scene);
    sd::check_region(region, scene);
    scene.regions.back().material = sd::parse_material(region, material, scene.material.law);
    scene.regions.back().where = region.where();
  }
  solver.read_into(scene);
  nodes.read_into(scene);
  sd::check_nodes(nodes, scene);
  probe.read_into(scene);
  sd::check_probe(probe, scene.probe);
  sd::check_solver(solver, scene);
  sd::check_tools(probe, scene);
  database.read_into(scene);
  sd::check_database(database, scene);
  training.read_into(scene);
  sd::check_training(training, scene);
  validation.read_into(scene);
  return scene;
}

Scene parse_imported_scene(const std::string& text, const std::string& source_name) {
  const toml::table root = sd::parse_toml(text, source_name);
  const sd::SceneTable top(root, "", source_name);
  const auto probe = section_of(top, "probe", source_name), training = section_of(top, "training", source_name);
  Scene scene;
  scene.text = text;
  scene.source_name = source_name;
  top.read_into(scene);
  probe.read_into(scene);
  sd::check_probe(probe, scene.probe);
  if (probe.has("tools"))
    probe.reject("tools", "needs the elements of a body, but the responses are imported", "remove it");
  if (probe.has("elsewhere")) probe.reject("elsewhere", "needs a solver, but the responses are imported", "remove it");
  training.read_into(scene);
  return scene;
}

TrainingSpec changed_training(Scene scene, const std::string& keys, const std::string& source_name) {
  const toml::table section = sd::parse_toml(keys, source_name);
  const sd::SceneTable training(section, "training", source_name);
  training.read_into(scene);
  sd::check_training(training, scene);
  return scene.training;
}

std::vector<std::string> scene_notes(const Scene& scene) {
  std::vector<std::string> notes;
  if (!scene.probe.kind_given)
    notes.push_back(scene.probe.where.str() +
                    ": the scene does not name a kind of probe, so that single nodes are displaced. The force at a "
                    "single node does "
                    "not converge under mesh refinement; with kind = \"patch\" and tool_radius_m it does");
  const auto short_text = [](double value) { return number_text(value, std::chars_format::general, 3); };
  if (scene.probe.kind == ProbeKind::patch && scene.probe.max_displacement_m > scene.probe.tool_radius_m)
    notes.push_back(
        scene.probe.where.str() + ": max_displacement_m = " + short_text(scene.probe.max_displacement_m) +
        " is more than the radius of the tool, tool_radius_m = " + short_text(scene.probe.tool_radius_m) +
        ". Deeper than half of the radius the surface under the tool is crushed on thin bodies: give a smaller "
        "depth or a larger radius");
  if (scene.probe.directions == Directions::three && scene.material.law != law_named("linear"))
    notes.push_back(scene.probe.where.str() +
                    ": directions = 3 solves +x, +y and +z only. Forces in all other directions are extrapolated, and "
                    "no bound covers that; 26 directions cover all");
  for (const Material* m : materials(scene)) {
    if (m->d1_given)
      notes.push_back(m->where.str() +
                      ": K = 1/D1 here, and 2/D1 in Abaqus and CalculiX: halve their D1, or give bulk_modulus_Pa");
    if (m->bulk_modulus_Pa < m->shear_modulus_Pa)
      notes.push_back(m->where.str() + ": K/mu = " + short_text(m->bulk_to_shear()) + " is below 1, nu = " +
                      number_text(m->poisson_ratio(), std::chars_format::fixed, 2) + ": are K and mu exchanged?");
    if (m->bulk_to_shear() > largest_usual_bulk_to_shear)
      notes.push_back(m->where.str() + ": K/mu = " + short_text(m->bulk_to_shear()) +
                      ", but from 1,000 on forces hardly depend on K: are both moduli in Pa?");
    else if (m == &scene.material && m->shear_modulus_Pa < softest_usual_Pa)
      notes.push_back(m->where.str() + ": mu = " + short_text(m->shear_modulus_Pa) +
                      " Pa is softer than organs: are the moduli in Pa, not in kPa?");
  }
  const auto all = materials(scene);
  for (const auto& [what, modulus] :
       {std::pair{"shear moduli", &Material::shear_modulus_Pa}, {"bulk moduli", &Material::bulk_modulus_Pa}}) {
    const auto [softest, stiffest] = std::ranges::minmax(all, {}, [of = modulus](const Material* m) { return m->*of; });
    if (const double ratio = stiffest->*modulus / softest->*modulus; ratio > largest_measured_ratio)
      notes.push_back(scene.regions.front().where.str() + ": " + what + " of regions differ by a factor of " +
                      short_text(ratio) + ", and elements were measured up to " + short_text(largest_measured_ratio) +
                      ": compare with `phynness check` before forces are believed");
  }
  return notes;
}

}  // namespace phynness
