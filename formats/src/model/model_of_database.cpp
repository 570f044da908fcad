// The scene and the model of a database's header, and what a model says about its surface.
#include <cmath>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/version.hpp>
#include <set>

namespace phynness {
namespace {

/// The triangles whose corners are all fixed or output nodes, so that the model gives their displacement.
Triangles known_triangles(const Mesh& mesh, const Model& model) {
  std::vector<char> known(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto* nodes : {&model.fixed, &model.output})
    for (const auto node : *nodes) known[static_cast<std::size_t>(node)] = 1;
  Triangles kept(mesh.surface.rows(), 3);
  Eigen::Index n = 0;
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t) {
    bool all = true;
    for (int k = 0; k < 3; ++k) all = all && known[static_cast<std::size_t>(mesh.surface(t, k))];
    if (all) kept.row(n++) = mesh.surface.row(t);
  }
  return kept.topRows(n);
}

/// Of imported responses: none.
Relaxation relaxation_of(const DatabaseHeader& header) {
  return header.scene_text.empty() ? Relaxation{} : carried_relaxation(stored_scene(header));
}

/// Nothing is recorded of imported responses, and of a header without a scene.
SolvedBody solved_body(const DatabaseHeader& header) {
  if (header.imported || header.scene_text.empty()) return {};
  const Scene scene = stored_scene(header);
  return {true, name(scene.solver.element), scene.material.shear_modulus_Pa};
}

std::string fixed(double value, int decimals) { return number_text(value, std::chars_format::fixed, decimals); }

std::string in_words(const std::string& reference, const std::string& element) {
  return reference == reference_names[2] ? element + " elements of half the size"
                                         : reference + " elements on the same mesh";
}

}  // namespace

Model model_of_database(const DatabaseHeader& header, Family family, const std::string& title) {
  Model model;
  model.family = family;
  model.title = title;
  model.mesh_hash = header.mesh_hash;
  model.physics_hash = header.physics_hash;
  model.software_version = header.software_version;
  model.solved = solved_body(header);
  model.relaxation = relaxation_of(header);
  model.directions = header.directions;
  model.max_displacement_m = header.magnitudes_m.back();
  model.n_mesh_nodes = header.mesh.n_nodes();
  model.fixed = header.sets.fixed;
  model.output = header.sets.output;
  model.fixed_points = header.mesh.nodes(model.fixed, Eigen::all);
  model.output_points = header.mesh.nodes(model.output, Eigen::all);
  model.surface = known_triangles(header.mesh, model);
  return model;
}

Relaxation carried_relaxation(const Scene& scene) {
  Relaxation relaxation = scene.relaxation;
  if (!relaxation.empty()) relaxation.length_m = scene.probe.tool_radius_m;
  return relaxation;
}

std::vector<std::int32_t> probed_nodes(const Model& model) {
  const auto n_active = static_cast<std::int32_t>(model.nodes.size());
  const auto n_inner = static_cast<std::int32_t>(model.probe_triangles.rows());
  std::set<std::int32_t> nodes;
  for (const auto& node : model.nodes) nodes.insert(node.node);
  for (const auto& row : model.covered.rowwise()) {
    const bool is_inner = row[1] < n_inner;
    const auto corner =
        (is_inner ? model.probe_triangles : model.outer_triangles).row(is_inner ? row[1] : row[1] - n_inner);
    const std::int32_t first = row[2], second = row[3], rest = schema::whole_weight - first;
    const bool counts[] = {first > 0, rest > 0 && second > 0, rest > 0 && second < schema::whole_weight};
    bool probed = true;
    for (int k = 0; k < 3; ++k) probed = probed && !(counts[k] && corner[k] >= n_active);
    if (probed) nodes.insert(row[0]);
  }
  return {nodes.begin(), nodes.end()};
}

std::string ModelBound::from() const {
  return reference == 0 ? "" : " from " + in_words(reference_names.at(static_cast<std::size_t>(reference)), "the same");
}

std::string FinerDistance::sentence() const {
  const auto percent = [](double error) { return fixed(100 * error, error < 0.0995 ? 1 : 0) + " %"; };
  std::string finer = in_words(reference, element), corrected;
  if (probes == 0)
    return "nothing to compare with, because no probe has a finer solution (" + finer +
           ") in the time of the check (phynness check SCENE, with more --seconds) or at all";
  if (cells_at_rest.places > 0 && reference != reference_names[2]) corrected = "cells of half the size";
  const bool has_shape_step = shape_at_rest.places > 0 && shape_at_rest.mean > 0;
  if (has_shape_step) corrected += (corrected.empty() ? "" : " and ") + std::string("the shape of the surface");
  if (!corrected.empty())
    finer += "; its force is multiplied by the factor by which " + corrected + " change the stiffness at rest";
  constexpr int fewest_for_p95 = 20;
  std::string parts, left_out;
  for (const auto& [what, part] : {std::pair{"the element", &element_at_rest},
                                   {"the size of the cells", &cells_at_rest},
                                   {"the shape of the surface and its fixed part", &shape_at_rest}})
    if (part->places > 0 && (part != &shape_at_rest || has_shape_step))
      parts += (parts.empty() ? ". At rest " : ", ") + std::string(what) +
               (parts.empty() ? " alone changes the stiffness by " : " by ") + percent(part->mean);
    else if (part->places == 0 && has_parts && element != "shell" && part != &element_at_rest &&
             !(part == &cells_at_rest && reference == reference_names[2]))  // shells are not compared at rest
      left_out += (left_out.empty() ? "" : " and ") + std::string(what);
  const double bias = force_ratio > 0 ? force_ratio - 1 : 0;
  constexpr double least_bias = 5e-4;  // a smaller one is printed as 0.0 %
  const std::string size = percent(std::abs(bias));
  const std::string sign = size == percent(mean) ? " (forces too " : " (forces " + size + " too ";
  std::string text = (left_out.empty() ? "" : "without " + left_out + " ") + percent(mean) + " on average" +
                     (std::abs(bias) < least_bias ? "" : sign + (bias < 0 ? "small" : "large") + ")") + ", " +
                     (probes < fewest_for_p95 ? "at most " + percent(p95) : "below " + percent(p95) + " in 95 %") +
                     ", at " + std::to_string(probes) + (probes == 1 ? " probe" : " probes") + " of a round tool of " +
                     fixed(1e3 * tool_radius_m, 1) + " mm radius";
  constexpr int fewest_for_mean = 4;  // with which a check may end (is_known)
  if (probes < fewest_for_mean) text += " (fewer than " + std::to_string(fewest_for_mean) + " are too few for a mean)";
  const auto at = [&](const DistancePart& part) { return percent(part.mean) + " at " + std::to_string(part.places); };
  if (has_parts) {
    if (near_fixed.places == 0)
      text += ", none of them within this radius of fixed nodes";
    else if (elsewhere.places == 0)
      text += ", all of them within this radius of fixed nodes";
    else
      text += ": " + at(near_fixed) + " within this radius of fixed nodes, " + at(elsewhere) + " elsewhere";
  }
  // An image does not record what its finer solution has.
  if (has_parts) text += ". The finer solution has " + finer;
  text += parts;
  if (cells_at_rest.places > 0 && !parts.empty())
    text += std::string("; smaller cells usually reduce the last") + (has_shape_step ? " two" : "");
  if (!left_out.empty())
    text += ". Not compared: " + left_out + " (phynness check SCENE, with more --seconds, does it)";
  if (of_reference.places > 0 && of_reference.mean < mean) {
    // Taylor-Hood elements have no reduced bodies. Times were measured on four bodies of 265 to 355 nodes: 5.5 to 24.
    text += ". With " + in_words(reference, element) +
            (reference == reference_names[1] ? ", which answer one tool only," : "") + " the error would be " +
            percent(of_reference.mean) + ", at " + fixed(unknowns_factor, unknowns_factor < 9.95 ? 1 : 0) +
            " times the unknowns" + (element == "es-p1-p1" ? " and 5 to 25 times the time" : "");
  }
  return text;
}

Points prescribed_displacements(const DatabaseHeader& header) {
  Points all(static_cast<Eigen::Index>(header.directions.size() * header.magnitudes_m.size()), 3);
  Eigen::Index row = 0;
  for (const Vec3& e : header.directions)
    for (const double magnitude : header.magnitudes_m) all.row(row++) = magnitude * to_eigen(e).transpose();
  return all;
}

void require_scene(const DatabaseHeader& header) {
  if (!header.imported) return;
  throw input_error("the responses of this database were imported, and there is no scene to be solved",
                    header.scene_name,
                    "solve in the program from which they are; train, info, show, view and eval work as with others");
}

Scene stored_scene(const DatabaseHeader& header) {
  if (header.imported) return parse_imported_scene(header.scene_text, header.scene_name);
  return parse_scene(header.scene_text, header.scene_name, header.scene_folder, MeshFile::may_be_absent);
}

DatabaseHeader database_header(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  DatabaseHeader header;
  header.mesh = mesh;
  header.sets = sets;
  header.directions = exploratory_directions(scene.probe.directions);
  for (int i = 1; i <= scene.probe.increments; ++i)
    header.magnitudes_m.push_back(scene.probe.max_displacement_m * i / scene.probe.increments);
  header.tangents = scene.database.tangents;
  header.float64 = scene.database.float64;
  if (const double tolerance = scene.database.field_tolerance; tolerance > 0)
    header.field_bits = static_cast<int>(std::ceil(-std::log2(2 * tolerance)));
  header.fields = scene.database.fields;
  header.scene_text = scene.text;
  header.scene_name = scene.source_name;
  header.scene_folder = scene.mesh.file.parent_path().string();
  header.physics_hash = physics_hash(scene);
  header.mesh_hash = mesh_hash(mesh);
  header.software_version = software_version();
  return header;
}

}  // namespace phynness
