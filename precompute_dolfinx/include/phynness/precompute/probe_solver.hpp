// Solver for one body under tools: single displacements and rays. In SI units and without types of dolfinx.
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

/// One equilibrium state.
struct Response {
  Status status = Status::converged;
  std::vector<Vec3> force_N;  ///< per tool: the force that holds the displacement
  double energy_J = 0;
  Points displacement_m;            ///< n_nodes x 3, all nodes of the mesh
  Eigen::MatrixXd fields;           ///< n_nodes x n_fields: fields of the scene's [database], in their units
  Eigen::MatrixXd tangent_N_per_m;  ///< dF/dd, 3 n_tools square; empty unless requested
  int negative_pivots = 0, iterations = 0, cutbacks = 0;
  double min_jacobian = 1;
  double relative_residual = 0;
};

/// Counts of all computations so far, including failed attempts.
struct SolverCounts {
  std::int64_t residuals = 0, tangents = 0, factorizations = 0, substitutions = 0;
};

/// Response of the linearized body at rest: the linear predictor.
struct RestResponse {
  Eigen::MatrixXd stiffness_N_per_m;  ///< 3 n_tools square
  Eigen::MatrixXd sensitivity;        ///< (3 n_nodes) x (3 n_tools): du/dd, row 3 i + k is component k at node i
};

/// The limits at which ProbeSolver::follow() ends a ray. By default it ends at the last value of s.
struct RayLimits {
  bool find_folds = false;   ///< compares the work of the force with the change of the stored energy
  bool stop_at_fold = true;  ///< false: the first fold is recorded, and the ray continues
  double resolution = 0;     ///< interval of s to which a fold is located
  double min_jacobian = 0;   ///< a smaller J ends the ray, except for linear laws
  double max_force_N = 0;    ///< the ray ends at the first larger force; 0: no limit
};

/// The exception of touch(), follow() and solve() after a stop request (ProbeSolver::set_stop). The solver remains
/// usable.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// The displacements of the touched tools at one time.
struct TimeStep {
  double time_s = 0;
  std::vector<Vec3> displacement_m;
  std::vector<SurfacePoint> places{};  ///< places of the tools; empty if they are unchanged
};

/// The solver of this process. Ranks share no data.
/// @pre a SolverSession exists during the lifetime of every ProbeSolver
class ProbeSolver {
 public:
  /// Uses material, solver, probe and database specification of the scene.
  /// @throws Error
  ProbeSolver(const Scene& scene, const Mesh& mesh, const NodeSets& sets);
  ~ProbeSolver();
  ProbeSolver(ProbeSolver&&) noexcept;

  /// @throws Error (input) if the node is not on the surface, or if it is fixed
  void check_touched(std::int32_t node) const;
  /// Puts tools at nodes and computes their stiffness at rest, which later solves use.
  /// @throws Error if a node is not on the surface or is fixed, if tools are at one place, or if the tangent at rest
  /// could not be factorized; a later call may succeed
  void touch(const std::vector<std::int32_t>& nodes);
  /// Puts tools at any points of the surface. Some corners of their triangles may be fixed.
  void touch_points(const std::vector<SurfacePoint>& points);
  const RestResponse& rest() const;
  /// The response at rest to a single round tool, as after touch_points(). All calls until the next touch() share one
  /// factorization, and each needs three substitutions. Afterwards nothing is touched.
  /// @throws Error as touch()
  RestResponse single_tool_at_rest(const SurfacePoint& point);
  RestResponse single_tool_at_rest(std::int32_t node) { return single_tool_at_rest(at_node(node)); }
  /// Scalar fields of a displacement by linear theory, n_nodes x n_fields, in their units. They are computed from the
  /// sensitivities at rest at a very small displacement and scaled by the power with which each field grows.
  /// @pre as many displacements [m] as touched tools, not all zero
  Eigen::MatrixXd linear_fields(const std::vector<Vec3>& displacement_m) const;
  /// Moves tool t along displacement_m[t] * s for the ascending values of s, starting at rest. Calls `on_response` for
  /// every value in order, until it returns false. Values beyond the end of the ray have Status::after_end.
  /// @return end of the ray; its depths are values of s
  RayEnd follow(const std::vector<Vec3>& displacement_m, const std::vector<double>& s_values, bool tangents,
                const std::function<bool(std::size_t, const Response&)>& on_response, const RayLimits& limits = {});

  /// The limits of the scene's [probe], for values of s in metres.
  RayLimits limits_of_rays() const;

  /// Solves for one displacement in `increments` equal steps.
  Response solve(const std::vector<Vec3>& displacement_m, int increments, bool tangents = false);

  /// Begins a motion of the touched tools in time, from rest, of a body that relaxes.
  /// @throws Error (input) if the element is not P1, p1-p1 or es-p1-p1
  void begin_motion(const Relaxation& relaxation);
  /// Advances the motion by a step that is linear in time. Substeps that exceed an increment of the scene, or that do
  /// not converge, are halved. A tool whose place changes holds the body at the new place.
  /// @param force_N  receives the force of each tool. @return Status::converged, or another status without a step
  /// @throws Error (input) if the time is not later than that of the previous step
  Status move(const TimeStep& step, std::vector<Vec3>& force_N);

  /// Must be called after an exception of follow() or solve(). Recreates the state of the libraries.
  void recover();

  /// Polls `stop` between iterations. A solve that continues for `patience_s` seconds after the first true throws
  /// Interrupted. The default lets most rays finish.
  void set_stop(std::function<bool()> stop, double patience_s = 2);

  int n_dofs() const;
  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

/// Initializes PETSc and MPI for the duration of the program. PETSc's options are read from PETSC_OPTIONS, not from the
/// command line. BLAS uses one thread, because probes are solved in parallel.
class SolverSession {
 public:
  SolverSession();
  ~SolverSession();
  SolverSession(const SolverSession&) = delete;
  int rank() const { return _rank; }
  int size() const { return _size; }
  /// Runs `work` on every rank. If it throws on one rank, this function throws on all ranks, so that no rank waits for
  /// another one. Collective. @throws Error with the message of the first failed rank on rank 0, without text on the
  /// others
  void together(const std::function<void()>& work) const;
  /// Sum over all ranks, on all ranks. Collective.
  double sum(double value) const;
  /// The value of rank 0, on all ranks, which wait for it without using a processor. Collective.
  bool broadcast(bool value) const;
  std::int64_t total(std::int64_t n) const { return static_cast<std::int64_t>(sum(static_cast<double>(n))); }
  /// The concatenated values of all ranks on rank 0; empty on other ranks. Collective.
  /// @tparam T  double or unsigned char
  template <class T>
  std::vector<T> gather(const std::vector<T>& values) const;

 private:
  int _rank = 0, _size = 1;
};

}  // namespace phynness
