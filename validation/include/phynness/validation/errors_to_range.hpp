// Errors over probes that are drawn up to the largest displacement R of the scene, whatever the model trained, split by
// the warnings of the runtime.
#pragma once

#include <array>
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
  double weight = 1;                  ///< NodePlan::weight, for the shares of errors below their bound
  /// Bound of error_N; infinite outside of the trained range. Not a number: the model has no bounds.
  double bound_N = std::numeric_limits<double>::quiet_NaN();
  ProbeErrors model, linear;
  bool solved() const { return status == Status::converged; }
  static void members(auto& p, auto&& each) {
    each(p.node, p.displacement_m, p.beyond, p.flagged, p.status, p.reached_m, p.error_N, p.largest_N, p.weight,
         p.bound_N, p.model, p.linear);
  }
  /// Of probes that are not solved.
  static void describe(const auto& result, auto&& see) {
    see("node", result.node);
    see("displacement", result.displacement_m);
    see("depth_m", result.depth_m());
    see("reached_m", result.reached_m >= 0 ? result.reached_m : undefined);
    see("reason", name(result.status));
    see("flagged", result.flagged);
  }
  double depth_m() const;
};

/// Whether a status of the runtime warns of a state. PHN_WARNING_INCOMPLETE alone does not: it is a property of a node,
/// and is returned for all of its states.
bool is_flagged(int status);

struct PredictionErrors {
  ErrorStatistics force, displacement;
  double wrong = 0;  ///< share of the forces that are off by more than wrong_fraction of their own size
  static void describe(const auto& e, auto&& see) {
    see("force", e.force);
    see("wrong", e.force.n > 0 ? e.wrong : undefined);
    see("displacement", e.displacement);
  }
};

/// Statistics of some probes. Shares refer to drawn probes, errors to solved ones.
struct JudgedErrors {
  std::int64_t probes = 0, solved = 0;
  double share = 0;  ///< of this group in all drawn probes
  PredictionErrors model, linear;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(probes, solved, share);
    PredictionErrors::describe(result.model, see);
    see("linear", result.linear);
  }
};

/// Model errors of one node over its solved probes up to R: means, undefined (nan) if nothing was solved.
struct ErrorsOfNode {
  std::int32_t node = 0;
  double force = 0, displacement = 0;
  static void describe(const auto& e, auto&& see) {
    see("nodes", e.node);
    see("force_error", e.force);
    see("displacement_error", e.displacement);
  }
};

/// The node with the largest error of the force among solved probes to R without a warning, or, if there are none, with
/// one.
struct WorstNode {
  std::int32_t node = 0;
  double error_N = 0, mean_error_N = 0, largest_N = 0;
  bool flagged = false;
};

struct ErrorsByWarning {
  JudgedErrors all, unflagged, flagged;
  std::vector<JudgedProbe> unreached;  ///< probes that the finite elements do not reach, without errors
  PHYNNESS_FIGURES(all, unflagged, flagged, unreached)
};
ErrorsByWarning errors_by_warning(const std::vector<JudgedProbe>& probes);

struct ErrorsToRange : ErrorsByWarning {  ///< depth in (0, R]
  double range_m = 0;                     ///< R of the scene
  JudgedErrors beyond;                    ///< depth in (R, outside_factor R]
  std::vector<ErrorsOfNode> nodes;        ///< ascending
  std::optional<WorstNode> worst;         ///< empty if nothing was solved
  std::optional<BoundCoverage> bounds;    ///< of a model that has bounds: solved probes up to R that have one
};
ErrorsToRange errors_to_range(const std::vector<JudgedProbe>& probes, double range_m);

/// A fraction in percent without the sign, for tables and sentences: at most five characters; "-" if it is undefined.
std::string in_percent(double fraction);

}  // namespace phynness
