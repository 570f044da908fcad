// One tool anywhere on the surface, and two tools at nodes, compared with finite element solves.
#pragma once

#include <phynness/phynness.h>
#include <array>
#include <cmath>
#include <cstdint>
#include <phynness/formats/described.hpp>
#include <phynness/validation/named_organ.hpp>
#include <phynness/validation/validation.hpp>
#include <vector>

namespace phynness {

/// How often answers to solved displacements have a warning, and how their bounds hold.
struct AnswerCounts {
  std::int64_t unsettled = 0, outside = 0, near = 0;  ///< answers with this warning
  std::int64_t bounded = 0, covered = 0;  ///< forces with a bound; of these, with an error that is not above it
  /// @param truth  [N] of the finite elements
  void take(const OrganResponse& said, const std::vector<Vec3>& truth) {
    unsettled += (said.status & PHN_WARNING_UNSETTLED) != 0;
    outside += (said.status & PHN_WARNING_OUTSIDE) != 0;
    near += (said.status & PHN_WARNING_NEAR) != 0;
    for (std::size_t t = 0; t < said.bound_N.size(); ++t) {
      if (!said.bound_N[t]) continue;
      const Vec3 own = *said.force_N[t], &right = truth[t];
      ++bounded;
      covered += std::hypot(own[0] - right[0], own[1] - right[1], own[2] - right[2]) <= *said.bound_N[t];
    }
  }
  PHYNNESS_FIGURES(unsettled, outside, near, bounded, covered)
};

/// (17) over the largest finite element response to the displacements of the same point.
using PointErrors = GroupMeasures<ErrorStatistics>;

struct PointReport : ErrorsByWarning {  ///< the model, by warnings of phn_couple; its nodes are points, by number
  std::int64_t points = 0, displacements = 0;  ///< requested points, and displacements of each
  std::int64_t finished = 0;                   ///< finished points; fewer than `points` if it was interrupted
  std::int64_t failed = 0;                     ///< displacements that the finite elements did not solve, or refused to
  PointErrors coupled;                         ///< the model at the points
  PointErrors linear;                          ///< unit responses of the undeformed body at the points
  std::optional<PointErrors> body;             ///< a reduced body at the points; empty without one
  AnswerCounts answers, body_answers;
  double seconds = 0;
  bool interrupted() const { return finished < points; }
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(points, finished, displacements, failed, coupled, linear, answers);
    if (result.body) see("body", *result.body);
    if (result.body) see("body_answers", result.body_answers);
    ErrorsByWarning::describe(result, see);
  }
};

/// For tools between nodes.
std::vector<WorseThanLinear> worse_than_linear(const PointReport& report);

/// Triangles whose corners are all probed; or at the rim of these, where one or two are.
enum class SurfacePart { probed, rim };

/// Random points are distributed uniformly in such triangles; each of them has the same probability. Directions are
/// uniform on the sphere, or in scenes with hemispheres on the inward half of it. Magnitudes are uniform up to the
/// scene's R, whatever was trained. Collective; the result is the same for any number of ranks and complete on rank 0.
/// If `stop` returns true, the function returns the finished points.
/// @param body  of the same mesh and physics; null: none
/// @return without points if there is no rim
/// @throws Error (input) if no triangle has three active corners, or if the model has forces only
PointReport validate_points(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                            const NamedOrgan* body, SurfacePart part, std::int64_t points, std::int64_t displacements,
                            std::uint64_t seed, const OnProgress& progress = {}, const ShouldStop& stop = {});

/// Pairs that a reduced body answers, or else a model of node probes, by warnings of their status. Errors of force are
/// those of the worse tool, over the larger one of the two finite element forces, or as force_own over its own. Errors
/// of displacements are means over the nodes that count in (17), of a body those that it has.
struct PairReport : ErrorsByWarning {
  std::int64_t pairs = 0;     ///< requested
  std::int64_t finished = 0;  ///< fewer than `pairs` if it was interrupted
  std::int64_t failed = 0;    ///< finished pairs that the finite elements did not solve
  double depth_m = 0;
  bool by_body = false;
  AnswerCounts answers;
  double seconds = 0;
  bool interrupted() const { return finished < pairs; }
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(pairs, finished, failed, depth_m, by_body, answers);
    ErrorsByWarning::describe(result, see);
  }
};

/// For two tools of a model, over all pairs.
std::vector<WorseThanLinear> worse_than_linear(const PairReport& report);

/// Default depth of both tools as a fraction of the trained depth: 12 mm of the paper's 28.
inline constexpr double pair_depth_fraction = 12.0 / 28;

/// Random pairs of active nodes. Directions are uniform on the sphere,
/// or in scenes with hemispheres on the inward half of it. Both tools have the depth `depth_m`. Collective; the result
/// is the same for any number of ranks and complete on rank 0. If `stop` returns true, the function returns the
/// finished pairs.
/// @param body  of the same mesh and physics; null: none, if the model has node probes
/// @throws Error (input) if the model has no two active nodes that can be touched at the same time, or if it has forces
///   only, or round tools and there is no body
PairReport validate_pairs(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const NamedOrgan* body, std::int64_t pairs, double depth_m, std::uint64_t seed,
                          const OnProgress& progress = {}, const ShouldStop& stop = {});

}  // namespace phynness
