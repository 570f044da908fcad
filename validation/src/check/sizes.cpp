#include <algorithm>
#include <cmath>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/sizes.hpp>

namespace phynness {
namespace {

/// Of the increments of checks, when both sizes are to be chosen. Bounds need more than means and quantiles do.
constexpr double part_of_calibration = 0.6;

/// Increments of a probe. Two share a ray from rest, one of them 1 to 1.43 times as deep as the trained range, so that
/// a ray has 1.2 times the increments of the database, and about 1.5 more for the two depths.
double increments_per_probe(int increments) { return (1.2 * increments + 1.5) / 2; }

/// The rays that a scene asks for at least.
std::int64_t wanted_rays(const Scene& scene, const DatabaseHeader& header) {
  const auto flags = requested_rays(scene, header.mesh, header);
  return std::count(flags.begin(), flags.end(), char{1});
}

/// Whether a tool between nodes is answered: in a triangle of the surface.
bool answers_between(const Scene& scene, const DatabaseHeader& header) {
  const auto& [mesh, sets] = std::tie(header.mesh, header.sets);
  NodeList known = sets.active;
  if (scene.probe.kind == ProbeKind::patch && known.size() > 2) {
    const auto made =
        probe_coordinates(mesh.nodes, mesh.surface, sets.active, sets.fixed, scene.probe.tool_radius_m).covered;
    known.insert(known.end(), made.begin(), made.end());
    std::sort(known.begin(), known.end());
  }
  const auto triangles = mesh.surface.rowwise();
  return std::any_of(triangles.begin(), triangles.end(), [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](std::int32_t node) { return std::binary_search(known.begin(), known.end(), node); });
  });
}

std::int64_t between(double least, double value, double most) {
  return static_cast<std::int64_t>(std::floor(std::clamp(value, least, most)));
}

}  // namespace

CheckSizes sizes_of_checks(const Scene& scene, const DatabaseHeader& header, bool bounded) {
  const double half = 0.5 * static_cast<double>(wanted_rays(scene, header)) * scene.probe.increments;
  const auto& given = scene.validation;
  CheckSizes sizes;
  if (bounded) {
    const bool with_between = answers_between(scene, header);
    const double without = calibration_increments(0, with_between),
                 per_ray = (calibration_increments(1000, with_between) - without) / 1000;
    sizes.calibration_rays =
        given.calibration_rays.value_or(between(100, (part_of_calibration * half - without) / per_ray, 1000));
    sizes.calibration_increments = calibration_increments(sizes.calibration_rays, with_between);
  }
  const double per_probe = increments_per_probe(scene.probe.increments);
  sizes.probes = given.probes.value_or(between(50, (half - sizes.calibration_increments) / per_probe, 200));
  sizes.validation_increments = per_probe * static_cast<double>(sizes.probes);
  return sizes;
}

}  // namespace phynness
