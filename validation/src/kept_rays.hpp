// The rays of a calibration: what is solved, and the file that keeps it.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
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

/// Solves rays, and keeps each in a text file as soon as it is solved, so that a later calibration, of whatever model
/// of the body, takes it from there. Each rank writes FILE.rank-N; FILE itself is written at the beginning and at the
/// end. A killed process loses the rays that it is solving.
class KeptRays {
 public:
  /// @param file  empty: nothing is kept. Its rays are used if their body is the same: mesh, fixed nodes, and all of
  /// the physics but the choice of nodes, directions and depths. Collective. @throws Error
  /// @param reference  the finite elements that solve; places are those of the database's mesh
  KeptRays(const SolverSession& session, const DatabaseHeader& header, Variant reference,
           const std::filesystem::path& file, ShouldStop stop);

  /// Forces [N] of the finite elements, for each part those of all tools; fewer if the ray ends early.
  /// @throws Interrupted
  std::vector<Vec3> forces(const ToolRay& ray);
  /// Joins what the ranks have written. Collective. @throws Error
  void close();
  std::int64_t taken() const { return _taken; }  ///< rays that this rank has found in the file

 private:
  std::vector<Vec3> solve(const ToolRay& ray);
  void join() const;

  SurfacePoint point_of(const phn_tool& tool) const;

  const SolverSession& _session;
  const DatabaseHeader& _header;
  VariantBody _body;
  std::filesystem::path _file;
  std::string _begin;
  ProbeSolver _solver;
  std::map<std::string, std::string> _known;  ///< rays and their forces, as in the file
  std::ofstream _out;
  std::string _touched;
  std::int64_t _taken = 0;
};

}  // namespace phynness
