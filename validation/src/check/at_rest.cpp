#include <fmt/core.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/patch_warnings.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/precompute/probe_solver.hpp>

#include "compared_scene.hpp"

namespace phynness {
namespace {

/// Whether the mesh has the surface of the scene: of a block, of tetrahedra from a file, of the triangles of a file.
bool has_true_shape(const MeshSpec& spec) {
  return spec.shape == Shape::block || !(spec.target_nodes || spec.target_size_m);
}

/// A mesh with edges of half the length on the surface of the scene instead of the surface of its mesh. It is empty if
/// the scene's file has the tetrahedra of the mesh.
VariantBody body_of_true_shape(const VariantBody& own) {
  VariantBody finer{own.scene, {}, {}};
  auto& spec = finer.scene.mesh;
  const auto edges = surface_edges_at(surface_nodes(own.mesh.surface), own.mesh);
  spec.target_size_m = std::accumulate(edges.begin(), edges.end(), 0.0) / (2 * static_cast<double>(edges.size()));
  spec.target_nodes.reset();
  auto made = make_mesh(finer.scene);
  if (!made.made_here) return finer;
  finer.sets.fixed = resolve_fixed(finer.scene, made.mesh);
  finer.mesh = std::move(made.mesh);
  return finer;
}

}  // namespace

double available_memory_bytes() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  for (double kB = 0; file >> key >> kB; std::getline(file, unit))
    if (key == "MemAvailable:") return 1024 * kB;
  return std::numeric_limits<double>::infinity();
}

double factor_bytes(double unknowns) { return 350 * std::pow(unknowns, 4.0 / 3); }

constexpr double startup_bytes = 1.5e8;

double check_memory_bytes(const Scene& scene, const Mesh& mesh) {
  // Rays on the refined mesh took 1.6 times the memory of its stiffness at rest (taylor-hood, 320 nodes).
  const bool of_rays = finer_reference(scene) == Variant::half_size;
  const Element element = of_rays ? scene.solver.element : element_named("taylor-hood");
  return startup_bytes + (of_rays ? 1.6 : 1) * factor_bytes(variant_unknowns(Variant::half_size, element, mesh));
}

std::string memory_shortage(double unknowns, const DiscretizationOptions& options) {
  const double needed = startup_bytes + factor_bytes(unknowns), available = options.available_bytes();
  if (needed <= available) return "";
  return fmt::format("{:.2f} GB of memory are needed, {:.2f} GB are available", needed / 1e9, available / 1e9);
}

ComparisonAtRest compare_at_rest(const VariantBody& own, Variant reference, std::vector<PlaceAtRest> places,
                                 const DiscretizationOptions& options, const std::function<double()>& elapsed_s,
                                 const ShouldStop& stop) {
  const auto remaining_s = [&] { return part_of_time_at_rest * options.seconds - elapsed_s(); };
  ComparisonAtRest result{std::move(places), "", 0};
  const bool is_true_shape = has_true_shape(own.scene.mesh);
  for (auto& place : result.places)
    if (is_true_shape) place.shape = 0;
  std::vector<Eigen::Matrix3d> scene_stiffness, reference_stiffness, finest_stiffness;
  // What is still to be compared, with the unknowns of its body; the true shape has about those of the smaller cells.
  std::vector<std::pair<std::string, double>> missing;
  const Element element = own.scene.solver.element;
  if (reference == Variant::taylor_hood)
    missing.emplace_back("the element", variant_unknowns(reference, element, own.mesh));
  const double most_unknowns = variant_unknowns(
      Variant::half_size, reference == Variant::taylor_hood ? element_named("taylor-hood") : element, own.mesh);
  missing.emplace_back("the size of the cells", most_unknowns);
  if (!is_true_shape) missing.emplace_back("the shape of the surface", most_unknowns);
  double previous_s = 0, previous_unknowns = 1;
  const auto compare_body = [&](const char* what, const VariantBody& body, double PlaceAtRest::*part) {
    const double unknowns =
        unknowns_of(body.scene.solver.element, body.mesh.n_nodes(), static_cast<double>(mesh_edges(body.mesh).size()));
    const double expected_s = previous_s * std::pow(unknowns / previous_unknowns, cost_exponent);
    auto skipped_reason = memory_shortage(unknowns, options);
    // The exponent holds for large bodies, so that the prediction may be several times too long.
    bool is_late = skipped_reason.empty() && expected_s > 5 * remaining_s();
    if (is_late) skipped_reason = fmt::format("up to {:.0f} s are needed", expected_s);
    std::vector<Eigen::Matrix3d> stiffness;
    const std::clock_t before = std::clock();
    const auto spent_s = [&] { return static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC; };
    if (skipped_reason.empty()) try {
        previous_unknowns = unknowns;
        ProbeSolver solver(body.scene, body.mesh, {body.sets.fixed, {}, {}});
        solver.set_stop([&] { return (stop && stop()) || !(remaining_s() > 0); }, 0);
        for (const auto& place : result.places) try {
            const Eigen::RowVector3d x = own.mesh.nodes.row(place.node);
            const auto point = nearest_on_surface(body.mesh.nodes, body.mesh.surface, {x[0], x[1], x[2]});
            stiffness.emplace_back(solver.single_tool_at_rest(point).stiffness_N_per_m);
          } catch (const Error&) {  // the place cannot be touched on this mesh
            solver.recover();
            stiffness.push_back(Eigen::Matrix3d::Constant(undefined));
          }
        previous_s = spent_s();
      } catch (const Interrupted&) {
        skipped_reason = "the time is over";
        is_late = true;
        previous_s = 2 * spent_s();
      }
    if (!skipped_reason.empty()) {
      std::string parts;
      double needed_s = elapsed_s();
      for (const auto& [name_of_part, its_unknowns] : missing) {
        parts += (parts.empty() ? "" : ", ") + name_of_part;
        needed_s += previous_s * std::pow(its_unknowns / previous_unknowns, cost_exponent);
      }
      result.skipped_reason = fmt::format("{} ({}: {})", parts, what, skipped_reason);
      if (is_late) result.sufficient_s = needed_s / part_of_time_at_rest;
      return false;
    }
    if (part != nullptr) missing.erase(missing.begin());
    for (std::size_t i = 0; part != nullptr && i < stiffness.size(); ++i)
      result.places[i].*part = (finest_stiffness[i] - stiffness[i]).norm() / stiffness[i].norm();
    finest_stiffness = std::move(stiffness);
    return true;
  };
  if (!compare_body("the scene", own, nullptr)) return result;
  scene_stiffness = finest_stiffness;
  VariantBody finer = own;
  if (reference == Variant::taylor_hood) {
    finer = variant_body(reference, finer);
    if (!compare_body("taylor-hood elements", finer, &PlaceAtRest::element)) return result;
    reference_stiffness = finest_stiffness;
  }
  if (!compare_body("cells of half the size", variant_body(Variant::half_size, finer), &PlaceAtRest::cells))
    return result;
  if (reference_stiffness.empty()) reference_stiffness = finest_stiffness;
  if (!is_true_shape) try {
      const auto true_shape = body_of_true_shape(finer);
      if (true_shape.mesh.n_nodes() > 0) compare_body("shape", true_shape, &PlaceAtRest::shape);
    } catch (const Error& error) {
      result.skipped_reason = fmt::format("shape: {}", error.what());
    }
  for (std::size_t i = 0; i < reference_stiffness.size(); ++i) {
    result.places[i].all = (scene_stiffness[i] - finest_stiffness[i]).norm() / finest_stiffness[i].norm();
    result.places[i].finest_over_reference = finest_stiffness[i] * reference_stiffness[i].inverse();
  }
  return result;
}

}  // namespace phynness
