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

/// With edges of half the length on the surface of the scene, and not on that of its mesh. Without nodes where these
/// surfaces are the same, as of a block and of a file's tetrahedra.
VariantBody body_of_true_shape(const VariantBody& own) {
  VariantBody finer{own.scene, {}, {}};
  auto& spec = finer.scene.mesh;
  if (spec.shape == Shape::block || !(spec.target_nodes || spec.target_size_m)) return finer;
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
  return std::numeric_limits<double>::infinity();  // another system
}

double factor_bytes(double unknowns) { return 350 * std::pow(unknowns, 4.0 / 3); }

std::string why_no_memory(double unknowns, const DiscretizationOptions& options) {
  constexpr double at_start = 1.5e8;
  const double needed = at_start + factor_bytes(unknowns), available = options.available_bytes();
  if (needed <= available) return "";
  return fmt::format("{:.2f} GB of memory are needed, {:.2f} GB are available", needed / 1e9, available / 1e9);
}

ComparisonAtRest compare_at_rest(const VariantBody& own, Variant reference, std::vector<PlaceAtRest> places,
                                 const DiscretizationOptions& options, const std::function<double()>& left_s,
                                 const ShouldStop& stop) {
  ComparisonAtRest result{std::move(places), ""};
  std::vector<Eigen::Matrix3d> first, base, last;
  double last_s = 0, last_unknowns = 1;
  const auto step = [&](const char* what, const VariantBody& body, double PlaceAtRest::*part) {
    const double unknowns =
        unknowns_of(body.scene.solver.element, body.mesh.n_nodes(), static_cast<double>(mesh_edges(body.mesh).size()));
    const double expected_s = last_s * std::pow(unknowns / last_unknowns, cost_exponent);
    auto why_not = why_no_memory(unknowns, options);
    // The exponent is that of large bodies, so that the time may be some times too long.
    if (why_not.empty() && expected_s > 5 * left_s()) why_not = fmt::format("up to {:.0f} s are needed", expected_s);
    std::vector<Eigen::Matrix3d> next;
    if (why_not.empty()) try {
        const std::clock_t before = std::clock();
        ProbeSolver solver(body.scene, body.mesh, {body.sets.fixed, {}, {}});
        solver.set_stop([&] { return (stop && stop()) || !(left_s() > 0); }, 0);
        for (const auto& place : result.places) try {
            const Eigen::RowVector3d x = own.mesh.nodes.row(place.node);
            const auto point = nearest_on_surface(body.mesh.nodes, body.mesh.surface, {x[0], x[1], x[2]});
            next.emplace_back(solver.alone_at_rest(point).stiffness_N_per_m);
          } catch (const Error&) {  // it cannot be touched on this mesh
            solver.recover();
            next.push_back(Eigen::Matrix3d::Constant(undefined));
          }
        last_s = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
        last_unknowns = unknowns;
      } catch (const Interrupted&) {
        why_not = "the time is over";
      }
    if (!why_not.empty()) {
      result.why_not = fmt::format("{}: {}", what, why_not);
      return false;
    }
    for (std::size_t i = 0; part != nullptr && i < next.size(); ++i)
      result.places[i].*part = (last[i] - next[i]).norm() / next[i].norm();
    last = std::move(next);
    return true;
  };
  if (!step("the scene", own, nullptr)) return result;
  first = last;
  VariantBody finer = own;
  if (reference == Variant::taylor_hood) {
    finer = variant_body(reference, finer);
    if (!step("taylor-hood elements", finer, &PlaceAtRest::element)) return result;
    base = last;
  }
  if (!step("cells of half the size", variant_body(Variant::half_size, finer), &PlaceAtRest::cells)) return result;
  if (base.empty()) base = last;
  try {
    const auto true_shape = body_of_true_shape(finer);
    if (true_shape.mesh.n_nodes() > 0) step("shape", true_shape, &PlaceAtRest::shape);
  } catch (const Error& error) {
    result.why_not = fmt::format("shape: {}", error.what());
  }
  for (std::size_t i = 0; i < base.size(); ++i) {
    result.places[i].all = (first[i] - last[i]).norm() / last[i].norm();
    result.places[i].finest_over_reference = last[i] * base[i].inverse();
  }
  return result;
}

}  // namespace phynness
