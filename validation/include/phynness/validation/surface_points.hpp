// Tools anywhere on the surface: coupled responses of the model against point-constrained finite element
// solves.
#pragma once

#include <cstdint>
#include <functional>
#include <phynness/validation/validation.hpp>

namespace phynness {

/// Normalized as (17), by the largest finite element response to that place's own displacements.
struct PointErrors {
  ErrorStatistics force, displacement, field_l2;
};

struct PointReport {
  std::int64_t points = 0, displacements = 0;  ///< places asked for, and displacements of each
  std::int64_t finished = 0;                   ///< places; fewer if it was interrupted
  std::int64_t failed = 0;                     ///< displacements that the finite elements did not solve
  std::int64_t unsettled = 0;                  ///< solved ones where the model says PHN_WARNING_UNSETTLED
  double largest_residual_m = 0;
  PointErrors coupled;   ///< the model at the points
  PointErrors linear;    ///< the undeformed body's unit responses at the points
  PointErrors at_nodes;  ///< the model at each point's nearest corner, at the same displacements
  double seconds = 0;
  bool interrupted() const { return finished < points; }
};

/// Random points, uniform in triangles whose corners are all active, triangles drawn alike; directions
/// uniform on the sphere, or the half of it that points inward in hemisphere scenes; magnitudes uniform to
/// where all three corners are trained. Collective; the result is the same for any number of ranks and
/// complete on rank 0. Where `stop` says so it ends with the places that are finished.
/// @throws Error if no triangle has three active corners, or the model has forces only
PointReport validate_points(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                            std::int64_t points, std::int64_t displacements, std::uint64_t seed,
                            const std::function<void(std::int64_t, std::int64_t)>& progress = {},
                            const std::function<bool()>& stop = {});

}  // namespace phynness
