// Calibration of the bounds of the force's error on random rays.
#pragma once

#include <phynness/formats/described.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/error_bounds.hpp>

namespace phynness {

struct BoundSpec {
  std::int64_t rays = 0;
  std::uint64_t seed = 1;
  double coverage = 0.95;
  Variant reference = Variant::scene;  ///< the solution to which the bounded error refers
};

struct BoundReport {
  Variant reference = Variant::scene;
  std::int64_t rays = 0, failed_rays = 0, states = 0;
  std::int64_t nodes = 0, planned_nodes = 0;  ///< finished nodes are fewer than planned after an interruption
  bool all_nodes = false;                     ///< whether every node of the model has rays
  /// Five-fold cross-validation over the nodes, or over the rays if all nodes have rays.
  BoundCoverage left_out;
  double promised = 0;  ///< promised_coverage() for this number of nodes or rays
  double median_bound_N = 0,
         median_share = 0;  ///< medians over the states of the bound, and of the bound over the force
  std::int64_t coupled_rays = 0, planned_coupled_rays = 0;  ///< rays of tools between nodes, or of all tools of a body
  std::int64_t failed_coupled_rays = 0;                     ///< coupled rays that ended early
  std::array<CoupledCoverage, 2> coupled;                   ///< by CoupledKind
  double seconds = 0;

  bool interrupted() const { return nodes < planned_nodes || coupled_rays < planned_coupled_rays; }
  static void describe(const auto& result, auto&& see) {
    if (result.planned_nodes > 0) {  // the calibration of a body plans no nodes
      see("reference", name(result.reference));
      PHYNNESS_SEE(rays, failed_rays, nodes, planned_nodes, all_nodes, states, median_bound_N, median_share, left_out,
                   promised);
    }
    PHYNNESS_SEE(coupled_rays, planned_coupled_rays, failed_coupled_rays);
    see("between", result.coupled[0]);
    if (result.planned_nodes == 0) see("several", result.coupled[1]);
    PHYNNESS_SEE(seconds);
  }
};

/// The increments that the calibration of a model solves. @param between  whether it also solves tools between nodes
double calibration_increments(std::int64_t rays, bool between);
/// The same of a body.
double body_calibration_increments(std::int64_t rays);

/// The estimated cost of a calibration against a finer solution, from the times of the database.
struct FinerCost {
  double seconds = 0, memory_bytes = 0;  ///< sums over all ranks
};
/// @throws Error (input) if the scene has no such reference, or if the reference locks
FinerCost finer_cost(const Database& database, const Scene& scene, const BoundSpec& spec, int ranks);

/// Solves random rays of the body and calibrates bounds. Collective; only rank 0 gets a result.
/// @param progress  receives the numbers of finished and of all nodes and rays of coupled tools
/// @param stop  is polled between solves; true ends the calibration, which then uses the finished nodes and rays
/// @throws Error (failure) if fewer than 20 nodes are finished
Model calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, const BoundSpec& spec,
                const OnProgress& progress, const ShouldStop& stop, BoundReport& report);

using OnNote = std::function<void(const std::string&)>;

/// Calibrates a body, on which one, two or three tools act where the model is trained, at every depth. Only rank 0 gets
/// bounds.
/// @param note  receives a message before the solves if all states of one tool, or of several, are flagged
/// @throws Error (failure) if fewer than 20 rays of either kind are solved
void calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, ReducedBody& body,
               const BoundSpec& spec, const OnNote& note, const OnProgress& progress, const ShouldStop& stop,
               BoundReport& report);

}  // namespace phynness
