// Statistics of the bounds of forces of tools between nodes of a model (formats/model.md, Bounds) and of tools of a
// body (formats/body.md, Bounds).
#pragma once

#include <phynness/formats/body.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/named_organ.hpp>
#include <vector>

namespace phynness {

enum class CoupledKind : std::int32_t { one, several };  ///< tools

/// A tool in a solved state of a random ray.
struct CoupledState {
  std::int32_t ray = 0;  ///< its number among those of the same kind
  CoupledKind kind = CoupledKind::one;
  std::int32_t n_tools = 1;  ///< of its state
  phn_tool tool{};
  Vec3 force_N{};                 ///< of the finite elements
  Vec3 said_N{};                  ///< of a body
  std::array<double, 3> terms{};  ///< of a body: x, y and z of formats/body.md, Bounds
};

/// How the bounds of one kind hold at rays that are left out, a fifth of them at a time.
struct CoupledCoverage {
  std::int64_t rays = 0;
  BoundCoverage all;
  /// Share of fresh errors below the bound that so many rays promise (promised_coverage), of each number of tools.
  double promised = 0;
  double flagged = 0;  ///< share of the drawn states that the runtime flags and that therefore have no bound
  static void describe(const auto& c, auto&& see) {
    see("rays", c.rays);
    see("promised", c.promised);
    see("flagged", c.flagged);
    see("all", c.all);
  }
};

/// Sets the coefficients of the bound of one tool between nodes; with fewer than 20 rays it stays unknown.
/// @param model   with bounds at nodes
/// @param mesh    of the model
/// @param found   receives all but `flagged`
void add_bound_between(Model& model, const Mesh& mesh, const std::vector<CoupledState>& states, CoupledCoverage& found);
/// Sets those of a body, of one tool and of several, at every place; a kind with fewer than 20 rays has none.
void add_coupled_bounds(ReducedBody& body, double coverage, const std::vector<CoupledState>& states,
                        std::array<CoupledCoverage, 2>& found);

}  // namespace phynness
