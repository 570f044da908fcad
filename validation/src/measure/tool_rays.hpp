// The rays of a calibration.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/discretization.hpp>
#include <vector>

namespace phynness {

/// Tools on the surface that move to fractions of their displacements.
struct ToolRay {
  std::vector<phn_tool> tools;
  std::vector<double> fractions;  ///< ascending, in (0, 1]; empty: the stiffness of one tool at rest
};

/// The tools of a ray at a fraction of their displacements.
std::vector<phn_tool> tools_at(const ToolRay& ray, double fraction);

/// The finite element forces of rays on this rank.
class RayForces {
 public:
  /// @param reference  the variant that is solved; places refer to the database's mesh
  RayForces(const DatabaseHeader& header, Variant reference, ShouldStop stop);

  /// Forces [N] of all tools for each fraction, or the columns of the stiffness [N/m]; fewer if the ray ends early.
  /// @throws Interrupted
  std::vector<Vec3> solve(const ToolRay& ray);

 private:
  SurfacePoint point_of(const phn_tool& tool) const;

  const DatabaseHeader& _header;
  VariantBody _body;
  ProbeSolver _solver;
  std::vector<phn_tool> _touched_tools;  ///< the tools that the solver touches
};

}  // namespace phynness
