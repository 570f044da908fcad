#include <algorithm>
#include <cmath>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/sizes.hpp>

namespace phynness {
namespace {

/// Share of the calibration in the increments of both checks. Bounds need more states than means and quantiles.
constexpr double part_of_calibration = 0.6;

/// Increments of a probe. Two probes share a ray, which on average reaches 1.2 times the trained depth and needs about
/// 1.5 more increments for the two depths.
double increments_per_probe(int increments) { return (1.2 * increments + 1.5) / 2; }

/// The number of rays that the scene requests.
std::int64_t wanted_rays(const Scene& scene, const DatabaseHeader& header) {
  const auto flags = requested_rays(scene, header.mesh, header);
  return std::count(flags.begin(), flags.end(), char{1});
}

/// Whether the model answers tools in some triangle of the surface.
bool answers_between(const Scene& scene, const DatabaseHeader& header) {
  const auto& [mesh, sets] = std::tie(header.mesh, header.sets);
  NodeList answered = sets.active;
  if (scene.probe.kind == ProbeKind::patch && answered.size() > 2) {
    const auto covered =
        probe_coordinates(mesh.nodes, mesh.surface, sets.active, sets.fixed, scene.probe.tool_radius_m).covered;
    answered.insert(answered.end(), covered.begin(), covered.end());
    std::sort(answered.begin(), answered.end());
  }
  const auto triangles = mesh.surface.rowwise();
  return std::any_of(triangles.begin(), triangles.end(), [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](std::int32_t node) { return std::binary_search(answered.begin(), answered.end(), node); });
  });
}

std::int64_t between(double least, double value, double most) {
  return static_cast<std::int64_t>(std::floor(std::clamp(value, least, most)));
}

}  // namespace

CheckSizes sizes_of_checks(const Scene& scene, const DatabaseHeader& header, bool bounded) {
  const double budget = 0.5 * static_cast<double>(wanted_rays(scene, header)) * scene.probe.increments;
  const auto& spec = scene.validation;
  CheckSizes sizes;
  if (bounded) {
    const bool has_between = answers_between(scene, header);
    const double fixed_increments = calibration_increments(0, has_between),
                 per_ray = (calibration_increments(1000, has_between) - fixed_increments) / 1000;
    sizes.calibration_rays =
        spec.calibration_rays.value_or(between(100, (part_of_calibration * budget - fixed_increments) / per_ray, 1000));
    sizes.calibration_increments = calibration_increments(sizes.calibration_rays, has_between);
  }
  const double per_probe = increments_per_probe(scene.probe.increments);
  sizes.probes = spec.probes.value_or(between(50, (budget - sizes.calibration_increments) / per_probe, 200));
  sizes.validation_increments = per_probe * static_cast<double>(sizes.probes);
  return sizes;
}

}  // namespace phynness
