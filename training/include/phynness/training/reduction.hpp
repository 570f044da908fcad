// A reduced body from a database: the finite elements in the leading modes of the solved fields, summed over a few
// cells with weights (docs/decisions/reduced-body.md).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <phynness/formats/body.hpp>
#include <phynness/formats/database.hpp>
#include <phynness/formats/described.hpp>
#include <phynness/formats/progress.hpp>

namespace phynness {

struct ReductionSpec {
  int modes = 160;   ///< of the displacement; there are a quarter as many of the pressure
  int cells = 0;     ///< points of the sum, cells and edges. All of them, with weight 1, if there are not more.
                     ///< 0: usual_cells(), by whether the body has regions
  int states = 300;  ///< random states of the database, and of several tools, from which pressures and weights follow
  std::uint64_t seed = 1;
};

/// A stiff region changes forces by less than 400 cells are off (docs/decisions/reduced-body.md, Regions).
constexpr int usual_cells(bool has_regions) { return has_regions ? 1600 : 400; }

struct ReductionReport {
  std::int64_t fields = 0;                ///< converged increments of the database
  std::int64_t several_fields = 0;        ///< of several tools
  std::int64_t states = 0;                ///< that the weights fit; 0 if all points have weight 1
  std::int64_t modes = 0, pressures = 0;  ///< at most as many as the fields and states span
  std::int64_t points = 0, cells = 0;     ///< of the whole sum, and those with a weight
  double captured = 0;                    ///< share of all fields' int |grad u|^2 dV that the modes have
  double residual = 0;                    ///< of the weights: error of forces and volumes over their size
  double seconds = 0;
  PHYNNESS_FIGURES(fields, several_fields, states, modes, pressures, points, cells, captured, residual, seconds)
};

/// Whether a body is good enough; if not, one with grown() modes and cells follows.
/// @param several  fields of several tools, to which columns may be added for the next body
using IsEnough = std::function<bool(const ReducedBody&, const ReductionReport&, Eigen::MatrixXd& several)>;

/// Displacements of a body, its rows of modes x any, in states that it takes without tables at rest. There it is often
/// too soft, which solved states do not show (docs/decisions/reduced-body.md).
using OwnStates = std::function<Eigen::MatrixXd(const ReducedBody&)>;

/// The scene of a database that can be reduced. @throws Error (input) if the responses are imported, of another element
///   than p1-p1 and es-p1-p1 or of earlier equations, of a tool that is no longer solved, or without the displacements
///   inside of the body (output = "free")
Scene reducible_scene(const DatabaseHeader& header);

/// @param several    3 n_nodes x any: solved fields of several tools, of each all of its x, then y, then z, of which
///   there are modes, too; without columns: none
/// @param report     output
/// @param progress   called with what is done and of how much, never concurrently
/// @param threads    0: the number of cores; the result is bitwise independent of it
/// @param is_enough  asked for each size; empty: the first is the last. It ends with all fields' modes and all cells.
/// @param own_states  of a body with weights; new ones fit these states, too. All states and all fields of several
///   tools then count alike. Empty: neither
/// @throws Error (input) as reducible_scene(), or without a converged increment; (failure) if the database has values
///   that are not finite
ReducedBody reduce(const Database& database, Eigen::MatrixXd several, const ReductionSpec& spec,
                   ReductionReport& report, const OnProgress& progress = {}, int threads = 0,
                   const IsEnough& is_enough = {}, const OwnStates& own_states = {});

}  // namespace phynness
