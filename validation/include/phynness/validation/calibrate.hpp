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
  Variant reference = Variant::scene;  ///< the finite elements from which the bound states the distance
};

struct BoundReport {
  Variant reference = Variant::scene;
  std::int64_t rays = 0, failed_rays = 0, states = 0;
  std::int64_t nodes = 0, planned_nodes = 0;  ///< with rays; fewer than planned if it was interrupted
  bool all_nodes = false;                     ///< of the model have rays
  /// Each fifth of the nodes with the bounds that the others give; of the rays if all nodes have rays.
  BoundCoverage left_out;
  double promised = 0;                                      ///< promised_coverage() of so many nodes, or rays
  double median_bound_N = 0, median_share = 0;              ///< of the states: bound; bound over force
  std::int64_t coupled_rays = 0, planned_coupled_rays = 0;  ///< of tools between nodes; of all tools of a body
  std::int64_t failed_coupled_rays = 0;                     ///< of these, that ended early
  std::array<CoupledCoverage, 2> coupled;                   ///< one tool between nodes, or of a body; several of a body
  double seconds = 0;

  bool interrupted() const { return nodes < planned_nodes || coupled_rays < planned_coupled_rays; }
  static void describe(const auto& result, auto&& see) {
    if (result.planned_nodes > 0) {  // none for a body
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

/// Increments that the calibration of a model with so many rays solves. @param between  with those of tools between
/// nodes
double calibration_increments(std::int64_t rays, bool between);

/// About what a calibration against a finer solution takes, by the times of the database.
struct FinerCost {
  double seconds = 0, memory_bytes = 0;  ///< of all ranks together
};
/// @throws Error (input) if the scene has no such reference, or one that locks
FinerCost finer_cost(const Database& database, const Scene& scene, const BoundSpec& spec, int ranks);

/// Solves random rays of the body and calibrates bounds. Collective; only rank 0 gets a result.
/// @param progress  receives the finished nodes and rays of coupled tools, and their number
/// @param stop  asked between solves; ends the calibration, and the bounds are those of the finished nodes and rays
/// @throws Error (failure) if it ended with fewer than 20 nodes
Model calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, const BoundSpec& spec,
                const OnProgress& progress, const ShouldStop& stop, BoundReport& report);

using OnNote = std::function<void(const std::string&)>;

/// The same for the body, where one tool, two or three act as the model is trained; every depth counts. Only rank 0 has
/// bounds.
/// @param note  receives, before anything is solved, that all states of one tool or of several are flagged
/// @throws Error (failure) if fewer than 20 rays of either kind are solved
void calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, ReducedBody& body,
               const BoundSpec& spec, const OnNote& note, const OnProgress& progress, const ShouldStop& stop,
               BoundReport& report);

}  // namespace phynness
