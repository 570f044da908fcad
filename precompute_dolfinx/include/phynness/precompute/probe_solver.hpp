// One body under tools: solves of single displacements and of rays. In SI units; no dolfinx type in sight.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <phynness/formats/database.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <vector>

namespace phynness {

/// A tool holds a surface node (or a patch around it) at a displacement.
struct Tool {
  std::int32_t node = 0;
  Vec3 displacement_m{};
};

/// One equilibrium state.
struct Response {
  Status status = Status::converged;
  std::vector<Vec3> force_N;  ///< per tool: must be applied to hold the displacement
  double energy_J = 0;
  Points displacement_m;            ///< n_nodes x 3, all nodes of the mesh
  Eigen::MatrixXd fields;           ///< n_nodes x n_fields: those of the scene's [database], in their units
  Eigen::MatrixXd tangent_N_per_m;  ///< 3 n_tools square, dF/dd, if asked for
  int negative_pivots = 0, iterations = 0, cutbacks = 0;
  double min_jacobian = 1;
  double relative_residual = 0;
};

/// What was computed so far, failed attempts included.
struct SolverCounts {
  std::int64_t residuals = 0, tangents = 0, factorizations = 0, substitutions = 0;
};

/// What the undeformed body says about a probe: the linear predictor.
struct RestResponse {
  Eigen::MatrixXd stiffness_N_per_m;  ///< 3 n_tools square
  Eigen::MatrixXd sensitivity;        ///< (3 n_nodes) x (3 n_tools): du/dd, row 3 i + k is component k at node i
};

class Team;

/// What touch(), follow() and solve() throw where a person wants an end (ProbeSolver::set_stop). The solver can be
/// used again afterwards.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// Owns the discretized body on this process alone. Ranks share nothing, but for the factorizations of a
/// team.
/// @pre a SolverSession lives as long as any ProbeSolver
class ProbeSolver {
 public:
  /// Uses material, solver, probe and database specification of the scene.
  /// @param team  null, or the team that this rank leads, whose others are in Team::serve() whenever
  /// something is solved
  /// @throws Error
  ProbeSolver(const Scene& scene, const Mesh& mesh, const NodeSets& sets, Team* team = nullptr);
  ~ProbeSolver();
  ProbeSolver(ProbeSolver&&) noexcept;

  /// Chooses the touched nodes. Rest stiffness is computed once for them and shared by what follows.
  /// @throws Error if a node is not on the surface, is fixed, or named twice, or if the tangent at rest could
  /// not be factorized; another call may then succeed
  void touch(const std::vector<std::int32_t>& nodes);
  const RestResponse& rest() const;
  /// The fields that linear theory gives a displacement: those of the sensitivities at rest, at a
  /// displacement so small that the body is linear, scaled up by the power with which each grows. n_nodes x
  /// n_fields, in their units.
  /// @pre as many displacements [m] as touched tools, not all zero
  Eigen::MatrixXd linear_fields(const std::vector<Vec3>& displacement_m) const;
  /// Nodes moved by touched tool t, with weights w (u_i = w_i d); the touched node itself has weight 1.
  std::vector<std::pair<std::int32_t, double>> prescribed(std::size_t tool = 0) const;

  /// Moves tool t along displacement_m[t] * s for the ascending values of s, starting at rest.
  /// `take` gets every value in order; return false to stop.
  void follow(const std::vector<Vec3>& displacement_m, const std::vector<double>& s_values, bool tangents,
              const std::function<bool(std::size_t, const Response&)>& take);

  /// One displacement, reached in `increments` equal steps.
  Response solve(const std::vector<Vec3>& displacement_m, int increments, bool tangents = false);

  /// After an exception of follow() or solve(), before the next call: what libraries keep between calls
  /// begins anew.
  void recover();

  /// `stop` is asked between two iterations. A solve that is still at work two seconds after it first said true
  /// throws Interrupted, so that most rays under way are finished and none keeps a person waiting.
  void set_stop(std::function<bool()> stop);

  int n_dofs() const;
  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

/// PETSc and MPI for the life of the program. PETSc's own options are read from PETSC_OPTIONS, not from the
/// command line. BLAS threads are switched off: parallelism is over probes.
class SolverSession {
 public:
  SolverSession();
  ~SolverSession();
  SolverSession(const SolverSession&) = delete;
  int rank() const { return _rank; }
  int size() const { return _size; }
  /// Runs `work` on every rank and makes an exception of one the exception of all, so that no rank waits for
  /// one that has left. Collective. @throws Error with the message of the first rank that failed on rank 0,
  /// without text on the others
  void together(const std::function<void()>& work) const;
  /// Sum over all ranks, on all ranks. Collective.
  double sum(double value) const;
  /// All ranks' values one after the other, on rank 0; empty elsewhere. Collective.
  std::vector<double> gather(const std::vector<double>& values) const;

 private:
  int _rank = 0, _size = 1;
};

}  // namespace phynness
