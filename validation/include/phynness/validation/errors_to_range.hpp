// Errors over probes that are drawn up to the largest displacement R of the scene, whatever the model trained, split by
// the warnings of the runtime.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <string>
#include <vector>

namespace phynness {

/// A force is called wrong if it is off by more than this fraction of its own size.
inline constexpr double wrong_fraction = 0.1;
/// The size of a force is taken as at least this fraction of the largest one of the node.
inline constexpr double force_floor = 0.01;

/// Errors of one prediction. Not a number: not defined, because all finite element forces of the node are 0.
struct ProbeErrors {
  double force = 0;                  ///< |f - f_FE| / largest |f_FE| of the node
  double force_own = 0;              ///< |f - f_FE| / max(|f_FE|, force_floor * largest |f_FE| of the node)
  std::vector<double> displacement;  ///< per counted output node: |u - u_FE| / largest |u_FE| of the node
  static void members(auto& e, auto&& each) { each(e.force, e.force_own, e.displacement); }
};

/// A drawn probe, solved or not.
struct JudgedProbe {
  std::int32_t node = 0;  ///< or the number of a point between nodes, or of a pair of tools
  Vec3 displacement_m{};
  bool beyond = false;   ///< deeper than R, to outside_factor R
  bool flagged = false;  ///< the runtime warns of this state (is_flagged)
  Status status = Status::not_solved;
  double reached_m = 0;  ///< deepest converged depth of the ray if the probe was not solved; negative: not known
  double error_N = 0, largest_N = 0;  ///< |f - f_FE|, and largest |f_FE| of the node; of solved probes
  double force_N = 0;                 ///< |f| of the model
  double weight = 1;                  ///< NodePlan::weight, for the shares of errors below their bound
  /// Bound of error_N; infinite outside of the trained range. Not a number: the model has no bounds.
  double bound_N = std::numeric_limits<double>::quiet_NaN();
  ProbeErrors model, linear;
  bool solved() const { return status == Status::converged; }
  static void members(auto& p, auto&& each) {
    each(p.node, p.displacement_m, p.beyond, p.flagged, p.status, p.reached_m, p.error_N, p.largest_N, p.force_N,
         p.weight, p.bound_N, p.model, p.linear);
  }
  /// Of probes that are not solved.
  static void describe(const auto& result, auto&& see) {
    see("node", result.node);
    see("displacement", result.displacement_m);
    see("depth_m", result.depth_m());
    see("reached_m", result.reached_m >= 0 ? result.reached_m : undefined);
    see("reason", reason(result));
    see("flagged", result.flagged);
  }
  double depth_m() const;
};

/// Whether a status of the runtime warns of a state. PHN_WARNING_INCOMPLETE alone does not: it is a property of a node,
/// and is returned for all of its states.
bool is_flagged(int status);

/// What is described here is in the JSON of every group of probes, and with a title in the tables of groups.
struct PredictionErrors {
  ErrorStatistics force, displacement;
  double wrong = 0;  ///< share of the forces that are off by more than wrong_fraction of their own size
  static void describe(const auto& e, auto&& see) {
    see("force", e.force, "force");
    see("wrong", e.force.n > 0 ? e.wrong : undefined, "over 10 %");
    see("displacement", e.displacement, "displ.");
  }
};

/// Statistics of some probes. Shares refer to drawn probes, errors to solved ones.
struct JudgedErrors {
  std::int64_t probes = 0, solved = 0;
  double share = 0;  ///< of this group in all drawn probes of the same part (all, a third of the depth, some nodes)
  PredictionErrors model, linear;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(probes, solved, share);
    PredictionErrors::describe(result.model, see);
    see("linear", result.linear);
  }
};

/// One group of probes (all, unflagged or flagged) and its parts.
struct JudgedGroup {
  JudgedErrors overall;
  std::array<JudgedErrors, 3> by_depth;  ///< thirds of R
  JudgedErrors worst_nodes;              ///< probes at ErrorsToRange::worst_nodes
  std::string counted = "nodes";         ///< as in ErrorsToRange
  static void describe(const auto& result, auto&& see) {
    JudgedErrors::describe(result.overall, see);
    see("by_depth", result.by_depth);
    see("worst_" + result.counted, result.worst_nodes);
  }
};

/// Model errors of one node over its solved probes of group `all`.
struct ErrorsOfNode {
  std::int32_t node = 0;
  std::int64_t probes = 0, solved = 0, flagged = 0;   ///< up to R
  double force = 0, force_max = 0, displacement = 0;  ///< means and the maximum; undefined (nan) if nothing was solved
  static void describe(const auto& e, auto&& see) {
    const auto share = [&](std::int64_t n) { return static_cast<double>(n) / static_cast<double>(e.probes); };
    see("nodes", e.node);
    see("force_error", e.force);
    see("displacement_error", e.displacement);
    see("force_error_max", e.force_max);
    see("unflagged", 1 - share(e.flagged));
    see("solved", share(e.solved));
  }
};

/// Probes whose bound is at most a fraction of the largest force of their node.
struct ErrorsToBound {
  double fraction = 0;
  JudgedErrors errors;  ///< share: of all probes up to R
  static void describe(const auto& result, auto&& see) {
    JudgedErrors::describe(result.errors, see);
    see("fraction", result.fraction);
  }
};

/// The bounds of a model over its probes up to R.
struct ErrorsAndBounds {
  BoundCoverage coverage;
  std::vector<ErrorsToBound> at_most;  ///< descending fractions
  /// The bound is at most wrong_fraction of the model's force, of at least force_floor of the node's largest one.
  JudgedErrors right;
  std::vector<BoundedError> samples;
  static void describe(const auto& result, auto&& see) {
    see("states", result.coverage.states);
    BoundCoverage::describe(result.coverage, see);
    PHYNNESS_SEE(at_most, right);
  }
};

/// The node with the largest error of the force among solved probes to R without a warning, or, if there are none, with
/// one.
struct WorstNode {
  std::int32_t node = 0;
  double error_N = 0, mean_error_N = 0, largest_N = 0;
  bool flagged = false;
};

struct ErrorsToRange {
  double range_m = 0;                   ///< R of the scene
  std::string counted = "nodes";        ///< what JudgedProbe::node counts: "nodes" or "points"
  JudgedGroup all, unflagged, flagged;  ///< depth in (0, R]
  JudgedErrors beyond;                  ///< depth in (R, outside_factor R]
  std::vector<ErrorsOfNode> nodes;      ///< ascending
  /// The tenth of the nodes (at least one) with the largest mean error of the model's force in group `all`.
  std::vector<std::int32_t> worst_nodes;
  double least_unflagged = 0;          ///< unflagged share at the tenth of the nodes where it is smallest
  std::optional<WorstNode> worst;      ///< empty if nothing was solved
  std::vector<JudgedProbe> unreached;  ///< probes up to R that the finite elements do not reach, without errors
  std::int64_t unreached_beyond = 0;
  std::optional<ErrorsAndBounds> bounds;  ///< of a model that has bounds
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(all, unflagged, flagged);
    see("worst_" + result.counted, result.worst_nodes);
    PHYNNESS_SEE(least_unflagged, unreached);
    if (result.bounds) see("bounds", *result.bounds);
  }
};

using Belongs = std::function<bool(const JudgedProbe&)>;
/// Statistics of the probes of `part` that are in `group`.
JudgedErrors judged(const std::vector<JudgedProbe>& probes, const Belongs& group, const Belongs& part);
ErrorsToRange errors_to_range(const std::vector<JudgedProbe>& probes, double range_m,
                              const std::string& counted = "nodes");

/// The same for tools that all have one depth.
struct ErrorsByWarning {
  JudgedErrors all, unflagged, flagged;
  std::vector<JudgedProbe> unreached;
  PHYNNESS_FIGURES(all, unflagged, flagged)
};
ErrorsByWarning errors_by_warning(const std::vector<JudgedProbe>& probes);

/// Why the finite elements do not reach a probe, in one word. Only this function names reasons.
const char* reason(const JudgedProbe& unreached);
/// Unreached probes by reason, for a sentence; empty if there are none.
std::string reasons(const std::vector<JudgedProbe>& unreached);
/// One sentence without a full stop: where the finite elements end and why.
/// @param node  what JudgedProbe::node counts: "node" or "point"
std::string sentence(const JudgedProbe& unreached, const std::string& node = "node");

/// A fraction in percent without the sign, for tables and sentences: at most five characters; "-" if it is undefined.
std::string in_percent(double fraction);

/// TableCells of a table for text and HTML, the first row is the heading; in percent.
using TableCells = std::vector<std::vector<std::string>>;
struct NamedErrors {
  std::string name;
  const JudgedErrors* errors = nullptr;
  const JudgedErrors* part_of = nullptr;  ///< a row with as many probes would repeat it and is left out
};
TableCells table_cells(const std::string& title, const std::vector<NamedErrors>& rows);
TableCells table_cells(const std::string& title, const ErrorsByWarning& errors);
/// Sentences below the table: unreached probes by reason, nodes with the smallest unflagged share.
std::vector<std::string> remarks(const ErrorsToRange& errors);

}  // namespace phynness
