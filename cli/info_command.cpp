#include <algorithm>
#include <cstring>
#include <fstream>
#include <phynness/formats/body.hpp>
#include <phynness/formats/image.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/training/families.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/named_organ.hpp>
#include <set>
#include <sstream>

#include "commands.hpp"

namespace phynness::cli::info_command {
namespace {

struct Options {
  std::filesystem::path what;
  OptionalPath json_file;
  bool failed = false;
};

void print_mesh(const Mesh& mesh, const NodeSets& sets) {
  if (mesh.cells.cols() == 3)
    print_result("mesh      {}: {} nodes, {} triangles of a shell\n", mesh_hash(mesh), mesh.n_nodes(), mesh.n_cells());
  else
    print_result("mesh      {}: {} nodes, {} tetrahedra, {} surface triangles\n", mesh_hash(mesh), mesh.n_nodes(),
                 mesh.n_cells(), mesh.surface.rows());
  print_result("nodes     {} fixed, {} active, {} output{}\n", sets.fixed.size(), sets.active.size(),
               sets.output.size(),
               sets.linear.empty() ? "" : fmt::format(", {} elsewhere with the linear response", sets.linear.size()));
}

/// Prints how spread points are distributed. @param covered  ascending
void print_points(const Mesh& mesh, const std::vector<std::int32_t>& active, const std::vector<std::int32_t>& fixed,
                  const std::vector<std::int32_t>& covered) {
  const auto spread = probe_spread(mesh.nodes, mesh.surface, active, fixed, covered);
  print_result(
      "points    {} spread over the surface, {:.3g} mm from their nearest neighbours in the median, {:.3g} mm at most; "
      "a tool is between them on {:.3g} % of the area that can move\n",
      active.size(), 1e3 * spread.median_m, 1e3 * spread.largest_m, 100 * spread.covered);
}

/// A ray that ended before the full depth.
struct ShortRay {
  std::int32_t node = 0;
  std::size_t direction = 0;
  Vec3 vector{};
  double reached_m = 0, failed_at_m = 0;
  std::string reason;
  PHYNNESS_FIGURES(node, direction, vector, reached_m, failed_at_m, reason)
};

/// Rays that the solver could not follow. @param with_ends  also those that end early, for example at a crushed cell
std::vector<ShortRay> failed_rays(const Database& database, bool with_ends) {
  const auto& h = database.header();
  const auto statuses = database.statuses();
  const std::size_t n = h.magnitudes_m.size(), n_directions = h.directions.size();
  std::vector<ShortRay> rays;
  for (std::size_t ray = 0; ray * n < statuses.size(); ++ray) {
    const auto first = statuses.begin() + static_cast<std::ptrdiff_t>(ray * n),
               last = first + static_cast<std::ptrdiff_t>(n);
    const auto failed = std::find_if(
        first, last, [&](Status s) { return static_cast<int>(s) < 0 || (with_ends && s == Status::after_end); });
    if (failed == last) continue;
    const auto i = static_cast<std::size_t>(failed - first), direction = ray % n_directions;
    rays.push_back({h.sets.active[ray / n_directions], direction, h.directions[direction],
                    i > 0 ? h.magnitudes_m[i - 1] : 0.0, h.magnitudes_m[i], name(*failed)});
  }
  return rays;
}

/// Prints how many rays failed, and which with `all`.
void print_failed_rays(const std::vector<ShortRay>& failed, std::size_t n_active, bool all) {
  if (failed.empty()) {
    if (all) print_result("failed    no ray stops short\n");
    return;
  }
  std::set<std::int32_t> nodes;
  for (const auto& ray : failed) nodes.insert(ray.node);
  print_result("failed    {} rays stop short, at {} of {} active nodes{}\n", failed.size(), nodes.size(), n_active,
               all ? ":" : "; --failed lists them");
  if (!all) return;
  print_result("  {:>8} {:>9}  {:<22} {:>11} {:>13}  {}\n", "node", "direction", "", "reached, mm", "failed at, mm",
               "reason");
  for (const auto& ray : failed)
    print_result("  {:>8} {:>9}  {:<22} {:>11.4g} {:>13.4g}  {}\n", ray.node, ray.direction,
                 fmt::format("{:.3f} {:.3f} {:.3f}", ray.vector[0], ray.vector[1], ray.vector[2]), 1e3 * ray.reached_m,
                 1e3 * ray.failed_at_m, ray.reason);
}

/// Prints the shares of rays and of the probe volume that end early, with reasons and nodes. @return the figures
json print_ends(const DatabaseHeader& header, const EndSummary& ends) {
  constexpr std::size_t most_listed = 8;
  json reasons = json::object();
  std::string reasons_text, nodes_text;
  for (const auto& [reason, count] : ends.reasons) {
    const auto untrained = ends.volume.find(reason);
    reasons[name(reason)] =
        record("rays", count, "share_of_volume", untrained == ends.volume.end() ? 0.0 : untrained->second);
    if (RayEnd{reason}.is_early())
      reasons_text += fmt::format("  {:<16} {:<9} {}\n", name(reason), count, meaning(reason));
  }
  std::vector<std::size_t> nodes;  // sorted by ascending probe volume
  for (std::size_t a = 0; a < ends.early.size(); ++a)
    if (ends.early[a] > 0) nodes.push_back(a);
  std::ranges::stable_sort(nodes, {}, [&](std::size_t a) { return ends.reached[a]; });
  for (std::size_t i = 0; i < nodes.size() && i < most_listed; ++i)
    nodes_text +=
        fmt::format("{}{} ({:.0f} %)", i ? ", " : "", header.sets.active[nodes[i]], 100 * ends.reached[nodes[i]]);
  if (!nodes.empty())
    print_result(
        "ends      {:.1f} % of {} rays end early, {:.1f} % of the probe volume is not trained\n{}"
        "  at {} of {} nodes; volume that is trained: {}{}\n",
        100 * ends.share_of_rays(), ends.rays, 100 * ends.share_of_volume(), reasons_text, nodes.size(),
        ends.early.size(), nodes_text, nodes.size() > most_listed ? ", ..." : "");
  if (ends.folds > 0)
    print_result("folds     on {} rays; the largest energy lost at once is {:.3g} J\n", ends.folds,
                 ends.largest_loss_J);
  return record("share_of_rays", ends.share_of_rays(), "share_of_volume", ends.share_of_volume(), "reasons", reasons,
                "folds", ends.folds, "largest_energy_lost_J", ends.largest_loss_J);
}

/// Prints the parts of a body of several materials.
json print_regions(const Scene& scene, const Mesh& mesh) {
  const auto regions = region_figures(scene, mesh);
  for (const auto& region : regions) print_result("  {}\n", region.str());
  return figures(regions);
}

/// Prints the relaxation of a body. @return null for an elastic body
json print_relaxation(const Relaxation& relaxation) {
  if (relaxation.empty()) return nullptr;
  json terms = json::array();
  for (const auto& term : relaxation.terms.rowwise()) terms.push_back(record("g", term[0], "tau_s", term[1]));
  print_result("relaxes   {} of the force after a sudden displacement\n", relaxation.sentence());
  return terms;
}

json print_relaxation(const phn_relaxation& from) {
  Relaxation relaxation;
  relaxation.terms.resize(from.n_terms, 2);
  for (Eigen::Index i = 0; i < from.n_terms; ++i) relaxation.terms.row(i) << from.g[i], from.tau_s[i];
  return print_relaxation(relaxation);
}

json about_database(const std::filesystem::path& file, bool failed) {
  const auto progress = database_progress(file);
  print_log_damage(progress.damage);
  if (!progress.complete) {
    if (failed)
      throw input_error("only a finished database lists its failed rays", "--failed with " + file.string(),
                        "finish it, or omit --failed");
    print_result("unfinished database: {} of {} rays; continue with phynness precompute SCENE -o {} --resume\n",
                 progress.rays_logged, progress.rays_total, file.string());
    return record("kind", "database", "complete", false, "rays_logged", progress.rays_logged, "rays_total",
                  progress.rays_total);
  }
  const auto database = Database::open(file);
  const auto& h = database.header();
  const auto summary = summarize(database);
  print_result("database  {} ({}), {}\n", file.string(), bytes(std::filesystem::file_size(file)), h.software_version);
  print_result("scene     {}, physics {}\n", h.scene_name, h.physics_hash);
  print_mesh(h.mesh, h.sets);
  print_patch_warnings(stored_scene(h), h.mesh, h.sets);
  const json regions = h.mesh.regions.empty() ? json::array() : print_regions(stored_scene(h), h.mesh);
  const json relaxation = print_relaxation(h.scene_text.empty() ? Relaxation{} : stored_scene(h).relaxation);
  print_result("probes    {} directions, {} increments to {:.4g} m{}{}\n", h.directions.size(), h.magnitudes_m.size(),
               h.magnitudes_m.back(), h.tangents ? ", with 3x3 tangents" : "",
               h.imported ? ", imported from another program" : "");
  json fields = json::array();
  for (const auto field : h.fields) fields.push_back(name(field));
  if (!h.fields.empty()) {
    std::string names;
    for (const auto field : h.fields) names += fmt::format(" {} [{}]", name(field), unit(field));
    print_result("fields   {}\n", names);
  }
  json states = json::object();
  for (const auto& [status, count] : summary.states) {
    print_result("  {:<16} {:<9} {}\n", name(status), count, meaning(status));
    states[name(status)] = count;
  }
  const auto rays = failed_rays(database, failed);
  print_failed_rays(rays, h.sets.active.size(), failed);
  const json ends = print_ends(h, summarize_ends(database));
  if (!h.imported) {
    print_result("unstable  {} converged states with negative pivots; smallest J {:.3g}\n", summary.unstable_states,
                 summary.min_jacobian);
    print_result("cost      {} Newton iterations, {} of solving\n", summary.newton_iterations,
                 duration(summary.seconds));
  }
  return record("kind", "database", "complete", true, "mesh_hash", h.mesh_hash, "physics_hash", h.physics_hash, "nodes",
                h.mesh.n_nodes(), "active", h.sets.active, "linear", h.sets.linear, "fields", fields, "states", states,
                "regions", regions, "relaxation", relaxation, "failed_rays", rays, "ends", ends, "newton_iterations",
                summary.newton_iterations, "unstable_states", summary.unstable_states);
}

/// Prints the element, the material and the distance to a finer solution.
json print_provenance(const phn_provenance& p, const FinerDistance* whole = nullptr) {
  const auto text_or_null = [](const char* text) { return *text != 0 ? json(text) : json(nullptr); };
  const auto positive_or_null = [](auto value) { return value > 0 ? json(value) : json(nullptr); };
  const FinerDistance finer{.is_measured = *p.reference != 0,
                            .element = p.element,
                            .reference = p.reference,
                            .probes = p.finer_probes,
                            .tool_radius_m = p.finer_tool_radius_m,
                            .mean = p.finer_mean,
                            .p95 = p.finer_p95};
  print_result("elements  {}; shear modulus at rest {}\n", *p.element != 0 ? p.element : "not recorded",
               p.shear_modulus_Pa > 0 ? fmt::format("{:.6g} Pa", p.shear_modulus_Pa) : "not recorded");
  print_result("distance  from a finer solution: {}{}\n",
               finer.is_measured ? (whole != nullptr ? *whole : finer).sentence() : "not recorded",
               p.finer_nodes > 0 ? fmt::format(". Its mesh has {} nodes", p.finer_nodes) : "");
  return record("mesh_hash", text_or_null(p.mesh_hash), "physics_hash", text_or_null(p.physics_hash), "element",
                text_or_null(p.element), "shear_modulus_Pa", positive_or_null(p.shear_modulus_Pa), "reference",
                text_or_null(p.reference), "finer_nodes", positive_or_null(p.finer_nodes), "finer_probes",
                finer.is_measured ? json(p.finer_probes) : json(nullptr), "finer_tool_radius_m",
                positive_or_null(p.finer_tool_radius_m), "finer_mean",
                finer.probes > 0 ? json(p.finer_mean) : json(nullptr), "finer_p95",
                finer.probes > 0 ? json(p.finer_p95) : json(nullptr), "bound_reference",
                positive_or_null(p.bound_reference));
}

json about_image(const std::filesystem::path& file) {
  const std::string text =
      read_input_file(file, {"the image", "give a NAME.bin of phynness export", 1ULL << 31, false});
  std::vector<std::uint64_t> words((text.size() + 7) / 8);
  std::memcpy(words.data(), text.data(), text.size());
  const auto image = read_image(words, text.size(), file.string());
  const auto& p = image.provenance;
  const auto or_not_recorded = [](const char* hash) { return *hash != 0 ? hash : "not recorded"; };
  print_result("image     {} ({}): {} active nodes, {}, {}\n", file.string(), bytes(static_cast<double>(text.size())),
               image.n_active,
               image.n_output > 0 ? fmt::format("{} output nodes", image.n_output) : std::string("forces only"),
               image.floats ? "float" : "double");
  print_result("mesh      {}, physics {}\n", or_not_recorded(p.mesh_hash), or_not_recorded(p.physics_hash));
  const json provenance = print_provenance(p), relaxation = print_relaxation(image.relaxation);
  return record("kind", "image", "relaxation", relaxation, "image_bytes", text.size(), "real_bytes",
                image.floats ? 4 : 8, "active", image.n_active, "output", image.n_output, "provenance", provenance);
}

/// Median over the database's displacements of all active nodes.
double median_bound_N(const Model& model, std::size_t bound) {
  std::vector<double> all;
  for (const auto& node : model.nodes) {
    const Eigen::MatrixXd values = node.bounds[bound].values();
    all.insert(all.end(), values.data(), values.data() + values.size());
  }
  if (all.empty()) return 0;
  const auto median = all.begin() + std::ssize(all) / 2;
  std::ranges::nth_element(all, median);
  return *median;
}

json about_model(const std::filesystem::path& dir) {
  const NamedOrgan model(dir);
  const auto& m = model.model();
  std::vector<std::int32_t> active;
  for (const auto& node : m.nodes) active.push_back(node.node);
  const auto sizes = sizes_of(m);
  print_result("model     {}: family {}, {}\n", dir.string(), name(m.family), m.software_version);
  print_result("scene     {}, physics {}\n", m.title, m.physics_hash);
  print_mesh(model.mesh(), {m.fixed, active, m.output});
  print_result("responses {}\n", operations(m.family).describe(m));
  json fields = json::array();
  for (const auto& field : m.fields) {
    print_result("field     {} [{}], {} shared modes, up to {:.4g} in training\n", field.name, field.unit,
                 field.modes.cols(), field.scale);
    fields.push_back(field.name);
  }
  if (const auto n = model.info().n_levels; n > 1)
    print_result("levels    {}; phynness bench shows their sizes, errors and times\n", n);
  const auto area = touched_area(m, model.mesh());
  if (m.covered.rows() > 0) print_points(model.mesh(), active, m.fixed, probed_nodes(m));
  if (!m.linear_points.empty())
    print_result("elsewhere {} points answer as the body at rest: {:.3g} % of the area is linear\n",
                 m.linear_points.size(), 100 * area.linear);
  const json surface =
      record("nonlinear", area.nonlinear, "linear", area.linear, "linear_points", m.linear_points.size());
  json bounds = json::array();
  for (const auto& bound : m.bounds) {
    const double median_N = median_bound_N(m, bounds.size());
    const ForceUnit unit = force_unit(median_N);
    print_result(
        "bounds    of the force's error{}, for {:g} % of random displacements, {:.3g} {} in the median over the "
        "database's displacements of all nodes; from {} rays at {} nodes\n",
        bound.from(), 100 * bound.coverage, unit.per_N * median_N, unit.name, bound.n_rays, bound.n_nodes);
    bounds.push_back(record("coverage", bound.coverage, "median_N", median_N, "rays", bound.n_rays, "nodes",
                            bound.n_nodes, "reference", reference_names.at(static_cast<std::size_t>(bound.reference))));
  }
  const json provenance = print_provenance(model.info().provenance, &m.finer),
             relaxation = print_relaxation(model.info().relaxation);
  print_result("size      model.txt {}, mesh.txt {}, {} in the runtime's memory\n", bytes(model.text().size()),
               bytes(model.mesh_text_bytes()), bytes(model.organ().constant_bytes()));
  return record("kind", "model", "relaxation", relaxation, "family", name(m.family), "model_hash", model.hash(),
                "mesh_hash", m.mesh_hash, "physics_hash", m.physics_hash, "active", active, "deformation_neurons",
                sizes.deformation_neurons, "force_neurons", sizes.force_neurons, "force_centers", sizes.force_centers,
                "modes", sizes.modes, "levels", model.info().n_levels, "fields", fields, "bounds", bounds, "surface",
                surface, "provenance", provenance, "model_text_bytes", model.text().size(), "memory_bytes",
                model.organ().constant_bytes());
}

/// Whether the file begins with the first word of a body.
bool is_body(const std::filesystem::path& file) {
  const std::string_view expected_bytes(schema::body_first_line, sizeof "phynness-body " - 1);
  std::string first_bytes(expected_bytes.size(), '\0');
  return std::filesystem::is_regular_file(file) &&
         std::ifstream(file, std::ios::binary).read(first_bytes.data(), std::ssize(first_bytes)) &&
         first_bytes == expected_bytes;
}

json about_body(const std::filesystem::path& file) {
  const auto body = NamedOrgan::body(file);
  const auto& info = body.body_info();
  const auto text = read_body_text(body.text(), file.string());
  const bool has_tables = text.cells_at_rest.entries.size() > 0;
  std::size_t state_bytes = 0;
  phn_body_state_size(body.organ().body(), 2, &state_bytes);
  print_result("body      {}: law {}, {} modes, {} cells, {} pressures{}{}\n", file.string(), info.law, info.n_modes,
               info.n_cells, info.n_pressures,
               text.regions.rows() > 0 ? fmt::format(", regions: {}", text.regions.rows()) : "",
               has_tables ? "" : ", without tables at rest");
  print_result("mesh      {}, physics {}: {} nodes and {} triangles of the surface\n", info.mesh_hash,
               info.physics_hash, info.n_nodes, info.n_triangles);
  print_result("tools     {}, to {:.4g} m in training{}\n",
               info.tool_radius_m > 0 ? fmt::format("of {:.4g} m radius", info.tool_radius_m) : "at points",
               info.max_displacement_m,
               text.lacking.rows() > 0 ? "; elsewhere corrected by the stiffness at rest" : "");
  if (body.has_bounds())
    print_result("bounds    of the force's error, for {:g} % of random displacements; from {} rays\n",
                 100 * text.coverage, text.n_rays);
  else
    print_result("bounds    none; phynness calibrate --body adds them\n");
  print_result("size      {}, {} in the runtime's memory, {} for a state of 2 tools\n", bytes(body.text().size()),
               bytes(body.organ().constant_bytes()), bytes(state_bytes));
  const json relaxation = print_relaxation(info.relaxation);
  const json bounds = body.has_bounds() ? record("coverage", text.coverage, "rays", text.n_rays) : json(nullptr);
  return record("kind", "body", "relaxation", relaxation, "mesh_hash", info.mesh_hash, "physics_hash",
                info.physics_hash, "law", info.law, "nodes", info.n_nodes, "triangles", info.n_triangles, "modes",
                info.n_modes, "cells", info.n_cells, "pressures", info.n_pressures, "has_tables_at_rest", has_tables,
                "regions", text.regions.rows(), "tool_radius_m", info.tool_radius_m, "max_displacement_m",
                info.max_displacement_m, "bounds", bounds, "body_bytes", body.text().size(), "memory_bytes",
                body.organ().constant_bytes(), "state_bytes", state_bytes);
}

/// The lines of settings that a scene without any has not.
std::string changed_lines(const std::string& settings, const std::string& defaults) {
  std::string changed;
  std::istringstream lines(settings);
  for (std::string line; std::getline(lines, line);)
    if (("\n" + defaults).find("\n" + line + "\n") == std::string::npos) changed += "  " + line + "\n";
  return changed;
}

json about_scene(const std::filesystem::path& file) {
  const auto loaded = load_scene(file);
  print_choice_note(loaded);
  print_result("scene     {}: {}\n", file.string(), loaded.scene.title);
  print_mesh(loaded.mesh, loaded.sets);
  const json worst = print_worst_cells(loaded.mesh, loaded.sets.fixed);
  if (spreads(loaded.scene.active)) {
    const auto& sets = loaded.sets;
    // The covered part is that of the trained model.
    const bool is_round = loaded.scene.probe.kind == ProbeKind::patch;
    std::vector<std::int32_t> touched;
    if (is_round)
      touched = probed_nodes(touched_surface(loaded.mesh, sets, loaded.scene.probe.tool_radius_m));
    else
      std::ranges::set_union(sets.active, sets.fixed, std::back_inserter(touched));
    print_points(loaded.mesh, sets.active, sets.fixed, touched);
  }
  const Material& m = loaded.scene.material;
  print_result("at rest   E {:.4g} Pa, nu {:.4g}, mu {:.4g} Pa, K {:.4g} Pa, K/mu {:.4g}\n", m.youngs_modulus_Pa(),
               m.poisson_ratio(), m.shear_modulus_Pa, m.bulk_modulus_Pa, m.bulk_to_shear());
  // The notes of the mesh have printed the regions.
  const json regions = figures(region_figures(loaded.scene, loaded.mesh));
  print_result("physics   {}, of these keys and of those that have their defaults\n{}", physics_hash(loaded.scene),
               changed_lines(physics_summary(loaded.scene), physics_summary(Scene())));
  print_result("others    that do not change a solve\n{}",
               changed_lines(other_settings(loaded.scene), other_settings(Scene())));
  return record("kind", "scene", "mesh_hash", mesh_hash(loaded.mesh), "physics_hash", physics_hash(loaded.scene),
                "youngs_modulus_Pa", m.youngs_modulus_Pa(), "poisson_ratio", m.poisson_ratio(), "bulk_to_shear",
                m.bulk_to_shear(), "regions", regions, "nodes", loaded.mesh.n_nodes(), "worst_cells", worst, "active",
                loaded.sets.active, "linear", loaded.sets.linear);
}

/// Reads a mesh file as in a scene without selections. An open surface is the midsurface of a shell, with a note.
MeshResult mesh_of_file(const std::filesystem::path& file, bool shell) {
  Scene scene;
  scene.mesh.file = file;
  try {
    return make_mesh(scene, true);
  } catch (const Error& no_body) {
    scene.mesh.repair = true;
    try {
      MeshResult result = shell ? make_shell(file) : make_mesh(scene, true);
      message("{}: {}\n{}", shell ? "note" : "warning", no_body.what(),
              shell ? "" : "note: what follows is of the file with repair = true in [mesh] of a scene\n");
      return result;
    } catch (const Error&) {
      throw Error(no_body);
    }
  }
}

json about_mesh(const std::filesystem::path& file) {
  const auto absolute = std::filesystem::absolute(file);
  const bool shell = holds_open_surface(absolute);
  const auto result = mesh_of_file(absolute, shell);
  for (const auto& note : result.notes) message("note: {}\n", note);
  for (const auto& warning : result.warnings) message("warning: {}\n", warning);
  const auto& q = result.quality;
  if (shell)
    print_result("mesh      {} {}: {} nodes, {} triangles of an open surface\n", file.string(), mesh_hash(result.mesh),
                 q.n_nodes, q.n_cells);
  else
    print_result("mesh      {} {}: {} nodes ({} on the surface), {} tetrahedra\n", file.string(),
                 mesh_hash(result.mesh), q.n_nodes, q.n_surface_nodes, q.n_cells);
  print_result("box       {:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g} (file units)\n", q.min_m[0], q.min_m[1],
               q.min_m[2], q.max_m[0], q.max_m[1], q.max_m[2]);
  const auto surface = measure_quality({result.mesh.nodes, result.mesh.surface, result.mesh.surface, {}});
  print_result("size      {}area {:.4g}; edges of the surface {:.3g} to {:.3g}, mean {:.3g} (file units)\n",
               shell ? "" : fmt::format("volume {:.4g}, ", q.volume_m3), surface.area_m2, surface.min_edge_m,
               surface.max_edge_m, surface.mean_edge_m);
  print_result("quality   worst {:.3f}, {} slivers\n", q.min_quality, q.n_slivers);
  const auto worst = worst_cells(result.mesh, {});
  if (!worst.empty()) print_result("worst cells\n");
  for (const auto& cell : worst) print_result("  {}\n", cell.str(1, " (file units)"));
  return record("kind", "mesh", "mesh_hash", mesh_hash(result.mesh), "nodes", q.n_nodes, "tetrahedra",
                shell ? 0 : q.n_cells, "shell_triangles", shell ? q.n_cells : 0, "box", json::array({q.min_m, q.max_m}),
                "volume", q.volume_m3, "area", surface.area_m2, "surface_edge", surface.mean_edge_m, "worst_cells",
                worst);
}

void run(const Options& options) {
  const auto& what = options.what;
  if (std::error_code code; !std::filesystem::exists(what, code))
    throw input_error("there is no such file or directory", what.string() + (code ? ": " + code.message() : ""),
                      "give a scene, a mesh, a database, a model directory, an image or a body");
  json out;
  const auto extension = what.extension();
  if (options.failed && extension != ".h5" && extension != ".hdf5")
    throw input_error("only a database has rays that failed", "--failed with " + what.string(),
                      "give database.h5, or omit --failed");
  if (std::filesystem::is_directory(what))
    out = about_model(what);
  else if (extension == ".toml")
    out = about_scene(what);
  else if (extension == ".h5" || extension == ".hdf5")
    out = about_database(what, options.failed);
  else if (extension == ".bin")
    out = about_image(what);
  else if (is_body(what))
    out = about_body(what);
  else
    out = about_mesh(what);
  write_json(options.json_file, out);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "info", "Print the contents of a scene, mesh, database, model directory, image or body", run);
  add_path(command, "FILE_OR_DIR", options.what, PathKind::input,
           "scene.toml, mesh file, database.h5, MODEL_DIR, NAME.bin of export, or body.txt")
      ->required();
  command.set_version_flag("--keys", scene_key_tables, "print the tables of a scene's keys in Markdown and exit");
  command.add_flag("--failed", options.failed, "of a database: list every ray that failed, with depth and reason");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::info_command
