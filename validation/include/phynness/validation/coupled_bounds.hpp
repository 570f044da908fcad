// Statistics of the bounds of forces of tools between nodes of a model (formats/model.md, Bounds) and of tools of a
// body (formats/body.md, Bounds).
#pragma once

#include <phynness/formats/body.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/named_organ.hpp>
#include <vector>

namespace phynness {

/// A solved state of a random ray of one tool between nodes, or of two tools.
struct CoupledState {
  std::int32_t ray = 0;  ///< its number among those of the same kind
  std::int32_t n_tools = 1;
  std::array<phn_tool, 2> tools{};
  std::array<Vec3, 2> force_N{};  ///< of the finite elements
};

/// How the bounds of one kind hold at rays that are left out, a fifth of them at a time.
struct CoupledCoverage {
  std::int64_t rays = 0;
  BoundCoverage all;
  double flagged = 0;  ///< share of the drawn states that the runtime flags and that therefore have no bound
  static void describe(const auto& c, auto&& see) {
    see("rays", c.rays);
    see("flagged", c.flagged);
    see("all", c.all);
  }
};

/// Sets the coefficients of the bound of one tool between nodes; with fewer than 20 rays it stays unknown.
/// @param model   with bounds at nodes
/// @param mesh    of the model
CoupledCoverage add_bound_between(Model& model, const Mesh& mesh, const std::vector<CoupledState>& states);
/// Sets those of a body, of one tool and of two, at every place; a kind with fewer than 20 rays has none.
/// @param increments  in which it is pressed
/// @param states      of both kinds. @return one tool; two tools
std::array<CoupledCoverage, 2> add_coupled_bounds(ReducedBody& body, int increments, double coverage,
                                                  const std::vector<CoupledState>& states);

}  // namespace phynness
