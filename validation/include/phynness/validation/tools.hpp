// Tools anywhere on the surface, and two tools at nodes: coupled responses of the model compared with finite element
// solves with point constraints, or with both nodes prescribed.
#pragma once

#include <phynness/phynness.h>
#include <array>
#include <cstdint>
#include <phynness/formats/described.hpp>
#include <phynness/validation/loaded_body.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

namespace phynness {

/// How often a reduced body warns, and how its bounds hold.
struct BodyWarnings {
  std::int64_t unsettled = 0, outside = 0;  ///< answers with this warning of phn_body_press
  std::int64_t bounded = 0, covered = 0;    ///< forces with a bound; of these, with an error that is not above it
  void take(int status, std::int64_t with_bound, std::int64_t below) {
    bounded += with_bound;
    covered += below;
    unsettled += (status & PHN_WARNING_UNSETTLED) != 0;
    outside += (status & PHN_WARNING_OUTSIDE) != 0;
  }
  PHYNNESS_FIGURES(unsettled, outside, bounded, covered)
};

/// As in (17), over the largest finite element response to the displacements of the same point.
struct PointErrors {
  ErrorStatistics force, displacement, field_l2;
  static void describe(const auto& e, auto&& see) {
    see("force", e.force, "force, as eq. (17)");
    see("displacement", e.displacement, "displacement");
    see("field_l2", e.field_l2, "field, relative L2");
  }
};

/// A finished place between nodes. By linear predictor, model and reduced body, over the solved displacements: the mean
/// error, like ErrorsOfNode::force (not a number: none), and how many have a warning.
struct PointRecord {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  std::array<double, 3> error{};
  std::array<std::int64_t, 3> flagged{};
};

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
  std::vector<PointRecord> records;  ///< in the order of the seed; on rank 0
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

/// coupled: a model of node probes. alone: the force of each tool without the other one, and the sum of the two fields.
/// paper: the weights (15)-(16) of node probes, which define no force. linear: the response of the undeformed body to
/// both tools. body: a reduced body, if one is given; its displacements are compared at the nodes that it has.
enum class PairPredictor { coupled, alone, paper, linear, body };
inline constexpr std::array<PairPredictor, 5> pair_predictors{
    PairPredictor::coupled, PairPredictor::alone, PairPredictor::paper, PairPredictor::linear, PairPredictor::body};
const char* name(PairPredictor);

/// Fractions of one pair, or their statistics. Of the errors of force of the two tools the larger one counts.
template <class Error>
struct PairMeasures {
  Error force{};             ///< difference over the larger one of the two finite element forces
  Error force_own{};         ///< difference over the finite element force of the same tool
  Error displacement_all{};  ///< mean difference over the largest displacement, with touched nodes
  Error displacement{};      ///< as (17): mean difference over the largest displacement, without touched nodes
  Error field_l2{};          ///< ratio of Euclidean norms over the same nodes
  static void describe(auto& e, auto&& see) {
    see("force", e.force, "force of the worse tool, relative to the larger force");
    see("force_own", e.force_own, "force of the worse tool, relative to its own force");
    see("displacement_all", e.displacement_all, "displacement, mean of all nodes, relative to the largest");
    see("displacement", e.displacement, "displacement as in eq. (17), without touched nodes");
    see("field_l2", e.field_l2, "field, relative L2");
  }
};
using PairStatistics = PairMeasures<ErrorStatistics>;
struct PairErrors : PairMeasures<double> {
  double force_floored = 0;  ///< force_own with a denominator of at least force_floor * the larger force
};

/// Who answers two tools.
struct PairAnswers {
  bool has_nodes = false;  ///< a model of node probes, which is coupled
  bool has_body = false;   ///< a reduced body
  bool has(PairPredictor p) const {
    if (p == PairPredictor::body) return has_body;
    return has_nodes || p == PairPredictor::alone || p == PairPredictor::linear;
  }
};
void see_errors(const auto& result, auto&& see) {
  for (const auto p : pair_predictors)
    if (result.has(p)) see(name(p), result.of(p));
}

struct PairRecord : PairAnswers {
  std::array<std::int32_t, 2> nodes{};
  std::array<Vec3, 2> displacement_m{};
  double distance_m = 0;              ///< between the nodes at rest
  bool solved = false;                ///< by the finite elements; if false, the members behind `status` are 0
  Status ended = Status::not_solved;  ///< converged, or why it was not solved
  int status = 0;                     ///< warnings of phn_couple; of round tools those of the body
  int body_status = 0;                ///< of phn_body_press: warnings
  std::int64_t body_bounded = 0, body_covered = 0;  ///< of BodyWarnings
  double residual_m = 0;
  /// Larger error of the model for each tool alone compared with a solve for this tool alone, over the finite element
  /// force; infinite if a tool alone was not solved. This part of the error of a pair is not caused by coupling.
  double single_force = 0;
  std::array<PairErrors, pair_predictors.size()> errors;  ///< by PairPredictor
  const PairErrors& of(PairPredictor p) const { return errors[static_cast<std::size_t>(p)]; }
  static void describe(const auto& result, auto&& see) {
    see("nodes", result.nodes);
    see("displacement", result.displacement_m);
    see("distance", result.distance_m);
    see("solved", result.solved);
    see("flagged", is_flagged(result.status));
    if (!result.solved) return see("reason", name(result.ended));
    see("unsettled", (result.status & PHN_WARNING_UNSETTLED) != 0);
    see("outside", (result.status & PHN_WARNING_OUTSIDE) != 0);
    see("single_force", result.single_force);
    see_errors(result, see);
    if (result.has_body) see("body_flagged", is_flagged(result.body_status));
  }
};

/// Pairs of one kind: all pairs, pairs of a range of distance, or pairs by convergence of the model.
struct PairGroup : PairAnswers {
  std::int64_t pairs = 0;
  std::array<PairStatistics, pair_predictors.size()> errors;  ///< by PairPredictor
  const PairStatistics& of(PairPredictor p) const { return errors[static_cast<std::size_t>(p)]; }
  static void describe(const auto& result, auto&& see) {
    see("pairs", result.pairs);
    see_errors(result, see);
  }
};

struct PairReport {
  std::int64_t pairs = 0;                   ///< requested
  std::int64_t finished = 0;                ///< fewer than `pairs` if it was interrupted
  std::int64_t failed = 0;                  ///< finished pairs that the finite elements did not solve
  std::int64_t unsettled = 0, outside = 0;  ///< solved pairs with this warning of PairRecord::status
  double depth_m = 0, far_m = 0;
  double largest_residual_m = 0;
  PairGroup all, near, far;
  PairGroup unflagged;  ///< pairs without _OUTSIDE and _UNSETTLED
  PairGroup right;      ///< pairs for which single_force is at most `right_alone`
  ErrorStatistics single_force;
  /// Of node probes: force of the worse tool, displacement as PairErrors::displacement.
  std::optional<ErrorsByWarning> by_warning;
  std::optional<BodyWarnings> body_warnings;       ///< of solved pairs; empty without a body
  std::optional<ErrorsByWarning> body_by_warning;  ///< as by_warning
  std::vector<PairRecord> records;                 ///< finished pairs, in the order of the seed
  double seconds = 0;
  bool interrupted() const { return finished < pairs; }
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(pairs, finished, failed, unsettled, outside, depth_m, far_m, largest_residual_m, all, near, far);
    see("unflagged", result.unflagged);
    see("right_alone", result.right);
    PHYNNESS_SEE(single_force, records);
    if (result.by_warning) see("by_warning", *result.by_warning);
    if (result.body_warnings) see("body_warnings", *result.body_warnings);
    if (result.body_by_warning) see("body_by_warning", *result.body_by_warning);
  }
};

/// For two tools, over all pairs.
std::vector<WorseThanLinear> worse_than_linear(const PairReport& report);

/// Default depth of both tools as a fraction of the trained depth: 12 mm of the paper's 28.
inline constexpr double pair_depth_fraction = 12.0 / 28;
/// Largest error of force of a tool alone for which the error of a pair is attributed to coupling.
inline constexpr double right_alone = 0.02;
/// Distance of the tools, as a fraction of the longest extent of the body, from which on a pair is called far.
inline constexpr double far_fraction = 0.3;

/// Random pairs of active nodes. Directions are uniform on the sphere,
/// or in scenes with hemispheres on the inward half of it. Both tools have the depth `depth_m`. Collective; the result
/// is the same for any number of ranks and complete on rank 0. If `stop` returns true, the function returns the
/// finished pairs.
/// @param body  of the same mesh and physics; null: none, if the model has node probes
/// @throws Error (input) if the model has no two active nodes that can be touched at the same time, or if it has forces
///   only, or round tools and there is no body
PairReport validate_pairs(const SolverSession& session, const Scene& scene, const LoadedModel& model, LoadedBody* body,
                          std::int64_t pairs, double depth_m, std::uint64_t seed, const OnProgress& progress = {},
                          const ShouldStop& stop = {});

}  // namespace phynness
