// Model against dolfinx: fresh probes, the error measure (17) and stricter ones, beside the trivial
// predictors.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <phynness/evaluation/runtime_speed.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Fractions. Empty samples give zeros and n = 0.
struct ErrorStatistics {
  double mean = 0, median = 0, p95 = 0, max = 0;
  std::int64_t n = 0;
  static ErrorStatistics of(std::vector<double> samples);
};

/// Spearman's: 1 if b grows with a, -1 if it falls, equal values sharing their rank; none for fewer than
/// three pairs or where one of them does not vary.
std::optional<double> rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

/// Of one scalar field, at all output nodes, those that the tool holds included.
struct FieldErrors {
  ErrorStatistics nodal;  ///< (17): |prediction - FE| over the largest FE value of that active node and group
  ErrorStatistics l2;     ///< per probe: Euclidean norm over the output nodes of the difference, over that of FE
};

/// (17): |prediction - FE| over the largest FE norm of that active node's probes of the same group (inside,
/// outside).
struct GroupErrors {
  ErrorStatistics force;
  ErrorStatistics displacement;         ///< all output nodes but the prescribed ones
  ErrorStatistics displacement_moving;  ///< of these, per probe, the tenth that moves most
  ErrorStatistics field_l2;             ///< per probe: |u - u_FE| / |u_FE| Euclidean norms over the same nodes
  ErrorStatistics force_relative;       ///< per probe: |f - f_FE| / |f_FE|
  std::vector<FieldErrors> fields;      ///< one for each of Model::fields
};

struct PredictorErrors {
  GroupErrors inside, outside;
};

enum class Predictor { model, linear, zero };
inline constexpr std::array<Predictor, 3> predictors{Predictor::model, Predictor::linear, Predictor::zero};
const char* name(Predictor);

/// One solved probe, to be looked at.
struct ForceExample {
  std::int32_t node = 0;
  Vec3 displacement_m{}, finite_elements_N{}, model_N{}, linear_N{};
};

/// One solved probe and its errors. Displacements: means over the output nodes that count; 0 where the model
/// has forces only.
struct ProbeRecord {
  std::int32_t node = 0;
  bool outside = false;
  Vec3 displacement_m{}, finite_elements_N{}, model_N{};
  double force_error = 0, force_error_linear = 0;  ///< (17)
  double displacement_error = 0, displacement_error_linear = 0;
};

/// Forces of the finite elements along one of a node's rays.
struct ForceCurve {
  std::int32_t node = 0;
  Vec3 direction{};
  std::vector<double> depth_m;
  std::vector<Vec3> force_N;
};

struct ValidationReport {
  std::int64_t probes = 0;  ///< asked for: inside and outside together
  std::int64_t failed = 0;  ///< of them, not solved by the finite elements
  std::int64_t solved_inside = 0, solved_outside = 0;
  std::int64_t rays = 0, rays_finished = 0;  ///< planned, with at most two probes each; fewer if interrupted
  std::vector<std::int32_t> nodes;           ///< active nodes probed
  std::vector<double> fixed_distance_m;      ///< of each of them, to the nearest fixed node
  double outside_factor = 0;                 ///< outside: R < |d| <= this * R
  std::array<PredictorErrors, 3> errors;     ///< by Predictor
  /// Spearman's rank correlation of the force's error with the distance from what was trained, over the
  /// model's probes inside the range and beyond; none where there are fewer than three.
  std::optional<double> distance_correlation_inside, distance_correlation_outside;
  std::vector<ForceExample> examples;  ///< the first probe inside the range of a few nodes
  std::vector<ProbeRecord> records;    ///< by node; inside before outside
  std::vector<ForceCurve> curves;      ///< of the first ray of each node
  std::vector<double> output_error;    ///< per output node: mean error (17) of its displacement, probes inside
  RuntimeSpeed speed;
  double seconds = 0;                 ///< wall time
  double solve_ms_per_increment = 0;  ///< CPU of this validation's rays; set-up of body and nodes left out
  bool interrupted() const { return rays_finished < rays; }
  const PredictorErrors& of(Predictor p) const { return errors[static_cast<std::size_t>(p)]; }
};

/// Where the model's mean error (17) is larger than that of the linear predictor, and not negligible.
struct WorseThanLinear {
  const char* what;  ///< "force" or "displacement"
  bool outside = false;
  double model = 0, linear = 0;
  /// One sentence, without a full stop.
  std::string sentence() const;
};
std::vector<WorseThanLinear> worse_than_linear(const ValidationReport& report);

/// |d| = outside_factor R is the paper's 4 cm after training to 2.8 cm.
inline constexpr double outside_factor = 4.0 / 2.8;

class SolverSession;

/// Solves fresh probes on the model's own mesh: directions uniform on the sphere (the inward half of it for
/// hemisphere scenes), magnitudes uniform; half of the probes inside the trained range, half beyond. At least
/// ten active nodes where there are as many, two in ten of them among the nearest to the fixed nodes. Collective over
/// the session's ranks, the result is the same for any number of them; complete on rank 0.
/// @param nodes  active nodes probed; 0: a twentieth of the probes, at least ten. (17) divides by the largest
/// response
///               of a node's probes, so few probes a node make large errors of it
/// Where `stop` says so it ends with the rays that are finished.
/// @throws Error if the scene's physics or mesh is not the model's
ValidationReport validate(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                          std::int64_t probes, std::uint64_t seed,
                          const std::function<void(std::int64_t, std::int64_t)>& progress = {},
                          const std::function<bool()>& stop = {}, std::int64_t nodes = 0);

}  // namespace phynness
