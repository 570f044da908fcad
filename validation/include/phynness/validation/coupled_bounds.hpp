// Statistics of the bounds of forces of tools between nodes of a model (formats/model.md, Bounds) and of tools of a
// body (formats/body.md, Bounds).
#pragma once

#include <phynness/formats/body.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/named_organ.hpp>
#include <vector>

namespace phynness {

enum class CoupledKind : std::int32_t { one, several };  ///< the number of tools

/// One tool in a solved state of a random ray.
struct CoupledState {
  std::int32_t ray = 0;  ///< number of the ray among those of the same kind
  CoupledKind kind = CoupledKind::one;
  std::int32_t n_tools = 1;  ///< number of tools of the state
  phn_tool tool{};
  Vec3 force_N{};                 ///< force of the finite elements
  Vec3 predicted_N{};             ///< force that the body predicts
  std::array<double, 3> terms{};  ///< x, y and z of formats/body.md (Bounds), for a body
};

/// Five-fold cross-validation of the bounds of one kind over the rays.
struct CoupledCoverage {
  std::int64_t rays = 0;
  BoundCoverage all;
  double promised = 0;  ///< smallest promised_coverage() over the numbers of tools
  double flagged = 0;   ///< share of drawn states without a bound, because the runtime flags them
  static void describe(const auto& c, auto&& see) {
    see("rays", c.rays);
    see("promised", c.promised);
    see("flagged", c.flagged);
    see("all", c.all);
  }
};

/// Sets the coefficients of the bound of one tool between nodes, if there are at least 20 rays.
/// @param model   has bounds at its nodes
/// @param found   receives all members except `flagged`
void add_bound_between(Model& model, const Mesh& mesh, const std::vector<CoupledState>& states, CoupledCoverage& found);
/// Sets the coefficients of the bounds of a body for one tool and for several; a kind needs at least 20 rays.
void add_coupled_bounds(ReducedBody& body, double coverage, const std::vector<CoupledState>& states,
                        std::array<CoupledCoverage, 2>& found);

}  // namespace phynness
