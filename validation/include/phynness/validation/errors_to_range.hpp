// Errors of probes up to the largest displacement R of the scene, independent of the trained range, by the warnings of
// the runtime.
#pragma once

#include <limits>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <string>
#include <vector>

namespace phynness {

/// A force is wrong if its error is larger than this fraction of its magnitude.
inline constexpr double wrong_fraction = 0.1;
/// The magnitude by which an error is divided is at least this fraction of the node's largest force.
inline constexpr double force_floor = 0.01;

/// Errors of one prediction. They are nan if all finite element forces of the node are 0.
struct ProbeErrors {
  double force = 0;                  ///< |f - f_FE| / largest |f_FE| of the node
  double force_own = 0;              ///< |f - f_FE| / max(|f_FE|, force_floor * largest |f_FE| of the node)
  std::vector<double> displacement;  ///< per counted output node: |u - u_FE| / largest |u_FE| of the node
  static void members(auto& e, auto&& each) { each(e.force, e.force_own, e.displacement); }
};

/// A probe with its errors if it was solved.
struct ProbeResult {
  std::int32_t node = 0;  ///< the node, or the number of a point between nodes or of a pair of tools
  Vec3 displacement_m{};
  bool beyond = false;   ///< the depth is in (R, outside_factor R]
  bool flagged = false;  ///< the runtime warns of this state (is_flagged)
  Status status = Status::not_solved;
  double reached_m = 0;  ///< deepest converged depth of the ray of an unsolved probe; negative if unknown
  double error_N = 0, force_N = 0, largest_N = 0;  ///< of solved probes: |f - f_FE|, |f_FE|, largest |f_FE| of the node
  double weight = 1;                               ///< NodePlan::weight, for the coverage of bounds
  /// Bound of error_N; infinite outside the trained range, nan if the model has no bounds.
  double bound_N = std::numeric_limits<double>::quiet_NaN();
  ProbeErrors model, linear;
  bool solved() const { return status == Status::converged; }
  static void members(auto& p, auto&& each) {
    each(p.node, p.displacement_m, p.beyond, p.flagged, p.status, p.reached_m, p.error_N, p.force_N, p.largest_N,
         p.weight, p.bound_N, p.model, p.linear);
  }
  /// Describes an unsolved probe.
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

/// Whether a status of the runtime contains another warning than PHN_WARNING_INCOMPLETE, which a node has in all
/// states.
bool is_flagged(int status);

struct PredictionErrors {
  ErrorStatistics force, displacement;
  double wrong = 0;  ///< share of forces with an error above wrong_fraction
  static void describe(const auto& e, auto&& see) {
    see("force", e.force);
    see("wrong", e.force.n > 0 ? e.wrong : undefined);
    see("displacement", e.displacement);
  }
};

/// Statistics of a group of probes. Shares refer to all probes, errors to solved ones.
struct ProbeStatistics {
  std::int64_t probes = 0, solved = 0;
  double share = 0;  ///< share of this group in all probes
  PredictionErrors model, linear;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(probes, solved, share);
    PredictionErrors::describe(result.model, see);
    see("linear", result.linear);
  }
};

/// Mean errors of the model over the solved probes of a node up to R; nan if none was solved.
struct ErrorsOfNode {
  std::int32_t node = 0;
  double force = 0, displacement = 0;
  static void describe(const auto& e, auto&& see) {
    see("nodes", e.node);
    see("force_error", e.force);
    see("displacement_error", e.displacement);
  }
};

/// The node with the largest force error of the solved probes up to R without a warning, or with a warning if there are
/// no others.
struct WorstNode {
  std::int32_t node = 0;
  double error_N = 0, mean_error_N = 0, largest_N = 0;
  bool flagged = false;
};

struct ErrorsByWarning {
  ProbeStatistics all, unflagged, flagged;
  std::vector<ProbeResult> unreached;  ///< probes without a finite element solution
  PHYNNESS_FIGURES(all, unflagged, flagged, unreached)
};
ErrorsByWarning errors_by_warning(const std::vector<ProbeResult>& probes);

struct ErrorsToRange : ErrorsByWarning {          ///< depth in (0, R]
  double range_m = 0;                             ///< R of the scene
  ProbeStatistics beyond;                         ///< depth in (R, outside_factor R]
  std::vector<ErrorsOfNode> nodes;                ///< ascending
  std::optional<WorstNode> worst;                 ///< empty if nothing was solved
  std::optional<BoundCoverage> bounds;            ///< coverage of solved probes up to R; empty without bounds
  double median_bound_N = 0, median_force_N = 0;  ///< of the states of `bounds`
};
ErrorsToRange errors_to_range(const std::vector<ProbeResult>& probes, double range_m);

/// A fraction in percent without the sign, for tables and sentences: at most five characters; "-" if it is undefined.
std::string in_percent(double fraction);

}  // namespace phynness
