// One tool anywhere on the surface, and two tools at nodes, compared with finite element solves.
#pragma once

#include <phynness/phynness.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <phynness/formats/body.hpp>
#include <phynness/formats/described.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/validation/named_organ.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

namespace phynness {

/// The remedy for a reduced body with large errors, which is what `reduce` would try next. Measured: a step of the demo
/// then takes 2.3 times as long.
inline std::string larger_body(std::int64_t modes, std::int64_t cells) {
  return "try phynness reduce DATABASE --modes " +
         std::to_string(std::min<std::int64_t>(schema::most_body_modes, grown(modes))) + " --cells " +
         std::to_string(grown(cells)) + ", whose steps take about twice as long";
}

/// Counts of warnings and of covered bounds in the answers to solved displacements.
struct AnswerCounts {
  std::int64_t unsettled = 0, outside = 0, near = 0;  ///< answers with this warning
  std::int64_t bounded = 0, covered = 0;              ///< forces with a bound, and those with an error up to the bound
  std::vector<double> bounds_N, forces_N;             ///< of the bounded ones, the bound and the finite element force
  /// @param solved_force_N  finite element forces
  void add(const OrganResponse& response, const std::vector<Vec3>& solved_force_N) {
    unsettled += (response.status & PHN_WARNING_UNSETTLED) != 0;
    outside += (response.status & PHN_WARNING_OUTSIDE) != 0;
    near += (response.status & PHN_WARNING_NEAR) != 0;
    for (std::size_t t = 0; t < response.bound_N.size(); ++t) {
      if (!response.bound_N[t]) continue;
      const Vec3 predicted = *response.force_N[t], &solved = solved_force_N[t];
      ++bounded;
      bounds_N.push_back(*response.bound_N[t]);
      forces_N.push_back(std::hypot(solved[0], solved[1], solved[2]));
      covered += std::hypot(predicted[0] - solved[0], predicted[1] - solved[1], predicted[2] - solved[2]) <=
                 *response.bound_N[t];
    }
  }
  PHYNNESS_FIGURES(unsettled, outside, near, bounded, covered)
};

/// The errors (17), relative to the largest finite element response of the same point.
using PointErrors = GroupMeasures<ErrorStatistics>;

/// The point with the largest force error of the model, over the largest force of the point.
struct WorstPoint {
  Vec3 at_m{};
  double error = 0;
};

struct PointReport : ErrorsByWarning {         ///< errors of the model; `node` is the number of a point
  std::int64_t points = 0, displacements = 0;  ///< requested points, and displacements per point
  std::int64_t finished = 0;                   ///< finished points; fewer than `points` if it was interrupted
  std::int64_t failed = 0;                     ///< displacements without a finite element solution
  PointErrors coupled;                         ///< the model at the points
  PointErrors linear;                          ///< unit responses of the undeformed body at the points
  std::optional<PointErrors> body;             ///< a reduced body at the points; empty without one
  std::optional<WorstPoint> worst;             ///< empty if nothing was solved
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

/// The triangles with three probed corners, or those at their rim, with one or two.
enum class SurfacePart { probed, rim };

/// Comparisons for tools between nodes.
std::vector<WorseThanLinear> worse_than_linear(const PointReport& report, SurfacePart part);

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

/// Errors for pairs of tools, of a reduced body or of a model of node probes. The force error is that of the worse
/// tool, relative to the larger finite element force; force_own is relative to the force of the tool. Displacement
/// errors are means over the counted nodes of (17), which a body may have only in part.
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

/// Comparisons for pairs of tools without a warning.
std::vector<WorseThanLinear> worse_than_linear(const PairReport& report);

/// Default depth of both tools as a fraction of the trained depth: 12 mm of the paper's 28.
inline constexpr double pair_depth_fraction = 3.0 / 7;
inline constexpr char pair_depth_in_words[] = "3/7";
/// Pairs that `phynness run` compares: with 40 of them the 95th percentile scatters by a factor of two.
inline constexpr int pairs_in_run = 100;

/// Random pairs of places where the body answers without a warning, or of active nodes. Directions are uniform on the
/// sphere, or in scenes with hemispheres on the inward half of it. Both tools have the depth `depth_m`. Collective; the
/// result is the same for any number of ranks and complete on rank 0. If `stop` returns true, the function returns the
/// finished pairs.
/// @param body  of the same mesh and physics; null: none, if the model has node probes
/// @throws Error (input) if the model has no two active nodes that can be touched at the same time, or if it has forces
///   only, or round tools and there is no body
PairReport validate_pairs(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const NamedOrgan* body, std::int64_t pairs, double depth_m, std::uint64_t seed,
                          const OnProgress& progress = {}, const ShouldStop& stop = {});

}  // namespace phynness
