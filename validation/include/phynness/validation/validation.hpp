// Comparison of a model, and of trivial predictors, with new finite element solutions by the error measure (17) and
// stricter measures.
#pragma once

#include <array>
#include <phynness/formats/progress.hpp>
#include <phynness/validation/errors_to_range.hpp>
#include <phynness/validation/model_figures.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Errors of one scalar field at all output nodes, including prescribed ones; samples, or their statistics.
template <class Errors>
struct FieldMeasures {
  Errors nodal;  ///< (17): |prediction - FE| over the largest FE value of the active node and group
  Errors l2;     ///< per probe: Euclidean norm over the output nodes of the difference, over that of FE
  static void describe(auto& result, auto&& see) { PHYNNESS_SEE(nodal, l2); }
};

/// (17): |prediction - FE| over the largest FE norm of the probes of the same active node and group (inside, outside).
template <class Errors>
struct GroupMeasures {
  Errors force;
  Errors displacement;  ///< all output nodes except the prescribed ones
  Errors field_l2;      ///< per probe: |u - u_FE| / |u_FE| Euclidean norms over the same nodes
  static void describe(auto& result, auto&& see) {
    see("force", result.force, "force, eq. (17)");
    see("displacement", result.displacement, "displacement, eq. (17)");
    see("field_l2", result.field_l2, "field, relative L2");
  }
};
struct GroupErrors : GroupMeasures<ErrorStatistics> {
  ByName<FieldMeasures<ErrorStatistics>> fields;  ///< errors of each of Model::fields
  static void describe(const auto& e, auto&& see) {
    GroupMeasures::describe(e, see);
    if (!e.fields.empty()) see("fields", e.fields);
  }
  /// The titled rows of tables.
  ByName<ErrorStatistics> rows() const;
};

struct PredictorErrors {
  GroupErrors inside, outside;
  PHYNNESS_FIGURES(inside, outside)
};

enum class Predictor { model, linear, zero };
inline constexpr std::array<Predictor, 3> predictors{Predictor::model, Predictor::linear, Predictor::zero};
const char* name(Predictor);

/// A solved probe and its errors. The displacement error is the mean over the counted nodes of (17); 0 for a model of
/// forces only.
struct ProbeRecord {
  std::int32_t node = 0;
  bool outside = false;
  Vec3 displacement_m{}, finite_elements_N{}, model_N{};
  double force_error = 0, displacement_error = 0;  ///< (17)
};

/// A probe with a large error of the force, with the displacements of the output nodes (n_output x 3 [m]).
struct ShownState {
  std::int32_t node = 0;
  Vec3 displacement_m{};
  double force_error = 0;  ///< (17)
  Points finite_elements_m, model_m;
  static void members(auto& s, auto&& each) {
    each(s.node, s.displacement_m, s.force_error, s.finite_elements_m, s.model_m);
  }
};
inline constexpr std::size_t most_shown_states = 3;

/// Finite element forces along one ray of a node.
struct ForceCurve {
  std::int32_t node = 0;
  Vec3 direction{};
  std::vector<double> depth_m;
  std::vector<Vec3> force_N;
  static void members(auto& c, auto&& each) { each(c.node, c.direction, c.depth_m, c.force_N); }
};

struct ValidationReport {
  std::int64_t probes = 0;  ///< requested probes, inside and outside
  std::int64_t failed = 0;  ///< probes that the finite elements did not solve
  std::int64_t solved_inside = 0, solved_outside = 0;
  std::int64_t rays = 0, rays_finished = 0;  ///< planned; fewer if interrupted
  std::vector<std::int32_t> nodes;           ///< probed active nodes
  std::vector<double> fixed_distance_m;      ///< distance of each to the nearest fixed node
  double outside_factor = 0;                 ///< outside: R < |d| <= this * R
  std::array<PredictorErrors, 3> errors;     ///< by Predictor
  ErrorsToRange to_range;                    ///< errors in the same directions at depths up to the scene's R
  std::vector<ProbeRecord> records;          ///< sorted by node; inside before outside
  std::vector<ForceCurve> curves;            ///< forces along the first ray of each node
  std::vector<ShownState> shown;     ///< states with the largest force errors inside; empty for a model of forces only
  std::vector<double> output_error;  ///< per output node: mean displacement error (17) of the probes inside
  RuntimeSpeed speed;
  double seconds = 0;  ///< wall time
  /// CPU time of the rays of this validation, without preparation of body and nodes.
  double solve_ms_per_increment = 0;
  bool interrupted() const { return rays_finished < rays; }
  const PredictorErrors& of(Predictor p) const { return errors[static_cast<std::size_t>(p)]; }
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(probes, failed, rays, rays_finished, solved_inside, solved_outside);
    PredictorErrors::describe(result.of(Predictor::model), see);
    see("linear", result.of(Predictor::linear));
    see("zero", result.of(Predictor::zero));
    see("force_us", result.speed.force_us);
    see("deformation_us", result.speed.deformation_us);
    see("field_us", result.speed.field_us);
    PHYNNESS_SEE(seconds, solve_ms_per_increment);
    ErrorsToRange::describe(result.to_range, see);
    see("beyond", result.to_range.beyond);
    if (result.to_range.bounds) see("bounds", *result.to_range.bounds);
  }
};

/// A group of probes in which the model's mean error (17) is not negligible and larger than that of the linear
/// predictor.
struct WorseThanLinear {
  const char* what;   ///< "force" or "displacement"
  const char* range;  ///< "inside" or "outside" of the trained range, "points" (tools between nodes), "rim" or "pairs"
                      ///< (two tools without a warning); of a reduced body with "body_" before it
  double model = 0, linear = 0;
  bool is_of_body() const { return std::string_view(range).starts_with("body"); }
  /// One sentence, without a full stop.
  std::string sentence() const;
  static void describe(const auto& result, auto&& see) {
    see("error", result.what);
    PHYNNESS_SEE(range, model, linear);
  }
};
std::vector<WorseThanLinear> worse_than_linear(const ValidationReport& report);

/// In the paper |d| is at most 4 cm = outside_factor R, with training up to R = 2.8 cm.
inline constexpr double outside_factor = 4.0 / 2.8;

class SolverSession;

/// Solves new probes on the mesh of the model. Directions are uniform on the sphere (in scenes with hemispheres on the
/// inward half of it), magnitudes are uniform. Half of the probes are inside the trained range, half outside. As many
/// are drawn up to the scene's R, and beyond it, for ErrorsToRange; where the trained range ends at R they are the same
/// probes, and elsewhere they are further states of the same ray. At least ten active nodes are probed if the model has
/// so many, two of ten beside the fixed nodes. Collective over the ranks of the session; the result is the same for any
/// number of ranks and complete on rank 0. If `stop` returns true, the function returns the finished rays.
/// @param nodes  number of probed active nodes; 0: a twentieth of the probes, at least ten. (17) divides by the largest
///               response of the probes of a node, so that few probes per node result in large errors
/// @throws Error (input) if physics or mesh of the scene differ from those of the model
ValidationReport validate(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          std::int64_t probes, std::uint64_t seed, const OnProgress& progress = {},
                          const ShouldStop& stop = {}, std::int64_t nodes = 0);

}  // namespace phynness
