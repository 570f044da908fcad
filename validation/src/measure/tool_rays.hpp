// The rays of a calibration.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/discretization.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Tools at places of the surface, which move to these parts of their displacements.
struct ToolRay {
  std::vector<phn_tool> tools;
  std::vector<double> parts;  ///< ascending, in (0, 1]; none: the forces at rest of 1 m in x, y and z, of one tool
};

/// The tools of a ray at one of its parts.
std::vector<phn_tool> tools_at(const ToolRay& ray, double part);

/// Solves rays on this rank.
class RayForces {
 public:
  /// @param reference  the finite elements that solve; places are those of the database's mesh
  RayForces(const DatabaseHeader& header, Variant reference, ShouldStop stop);

  /// Forces [N] of the finite elements, for each part those of all tools; fewer if the ray ends early.
  /// @throws Interrupted
  std::vector<Vec3> solve(const ToolRay& ray);

 private:
  SurfacePoint point_of(const phn_tool& tool) const;

  const DatabaseHeader& _header;
  VariantBody _body;
  ProbeSolver _solver;
  std::vector<phn_tool> _touched;  ///< whose places the solver touches
};

}  // namespace phynness
