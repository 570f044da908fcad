// Tools anywhere on the surface: coupled responses of the model compared with finite element solves with point
// constraints.
#pragma once

#include <cstdint>
#include <phynness/evaluation/loaded_body.hpp>
#include <phynness/validation/body_warnings.hpp>
#include <phynness/validation/validation.hpp>
#include <string>

namespace phynness {

/// Samples or their statistics, normalized as in (17), by the largest finite element response to the displacements of
/// the same point.
template <class Errors>
struct PointMeasures {
  Errors force, displacement, field_l2;
  static void describe(auto& e, auto&& see) {
    see("force", e.force, "force, as eq. (17)");
    see("displacement", e.displacement, "displacement");
    see("field_l2", e.field_l2, "field, relative L2");
  }
};
using PointErrors = PointMeasures<ErrorStatistics>;

struct PointReport {
  std::int64_t points = 0, displacements = 0;  ///< requested points, and displacements of each
  std::int64_t finished = 0;                   ///< finished points; fewer than `points` if it was interrupted
  std::int64_t failed = 0;                     ///< displacements that the finite elements did not solve
  std::int64_t refused = 0;                    ///< of these, displacements of tools that they refuse
  std::string first_refusal;                   ///< the reason of one of them
  std::int64_t unsettled = 0;  ///< solved displacements for which the model returns PHN_WARNING_UNSETTLED
  double largest_residual_m = 0;
  PointErrors coupled;              ///< the model at the points
  PointErrors linear;               ///< unit responses of the undeformed body at the points
  PointErrors at_nodes;             ///< the model at the corner nearest to each point, with the same displacements
  std::optional<PointErrors> body;  ///< a reduced body at the points; empty without one
  std::optional<BodyWarnings> body_warnings;  ///< of solved displacements
  ErrorsToRange to_range;  ///< the model at the points, by warnings of phn_couple; its nodes are points, by number
  double seconds = 0;
  bool interrupted() const { return finished < points; }
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(points, finished, displacements, failed, refused);
    see("first_refusal", result.refused > 0 ? std::optional(result.first_refusal) : std::nullopt);
    PHYNNESS_SEE(unsettled, largest_residual_m, coupled, linear, at_nodes);
    if (result.body) see("body", *result.body);
    if (result.body_warnings) see("body_warnings", *result.body_warnings);
    ErrorsToRange::describe(result.to_range, see);
  }
};

/// For tools between nodes.
std::vector<WorseThanLinear> worse_than_linear(const PointReport& report);

/// Random points are distributed uniformly in triangles whose corners are all active; each such triangle has the same
/// probability. Directions are uniform on the sphere, or in scenes with hemispheres on the inward half of it.
/// Magnitudes are uniform up to the scene's R, whatever was trained. Collective; the result is the same
/// for any number of ranks and complete on rank 0. If `stop` returns true, the function returns the finished points.
/// @param body  of the same mesh and physics; null: none
/// @throws Error (input) if no triangle has three active corners, or if the model has forces only
PointReport validate_points(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                            LoadedBody* body, std::int64_t points, std::int64_t displacements, std::uint64_t seed,
                            const OnProgress& progress = {}, const ShouldStop& stop = {});

}  // namespace phynness
