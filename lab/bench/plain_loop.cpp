#include "plain_loop.hpp"

#include <cmath>
#include <stdexcept>

#include "solve/constraint.hpp"
#include "solve/discretization.hpp"
#include "solve/petsc_check.hpp"
#include "solve/scaling.hpp"

namespace phynness::bench {
namespace {

Mesh scaled(Mesh mesh, double length_m) {
  mesh.nodes /= length_m;
  return mesh;
}

}  // namespace

struct PlainLoop::Impl {
  Impl(const Scene& s, const Mesh& mesh, const NodeSets& sets)
      : scene(s),
        scaling(Scaling::of(mesh, s.material)),
        body(scaled(mesh, scaling.length_m), form_set(s.material, s.solver.element, scaling.modulus_Pa)),
        fixed(fixed_points(body, sets.fixed)),
        fixed_dofs(displacement_dofs(body, fixed)) {
    const auto n = static_cast<PetscInt>(body.n_dofs());
    state.assign(body.n_dofs(), 0.0);
    residual.assign(body.n_dofs(), 0.0);
    PHYNNESS_PETSC(MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 900, nullptr, matrix.address()));
    PHYNNESS_PETSC(MatSetOption(matrix, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    PHYNNESS_PETSC(VecCreateSeq(PETSC_COMM_SELF, n, x.address()));
    PHYNNESS_PETSC(VecDuplicate(x, r.address()));
    PHYNNESS_PETSC(SNESCreate(PETSC_COMM_SELF, snes.address()));
    PHYNNESS_PETSC(SNESSetFunction(snes, r, form_function, this));
    PHYNNESS_PETSC(SNESSetJacobian(snes, matrix, matrix, form_jacobian, this));
    PHYNNESS_PETSC(SNESSetConvergenceTest(snes, test_convergence, this, nullptr));
    PHYNNESS_PETSC(SNESSetTolerances(snes, 0, 0, 0, scene.solver.max_iterations, 10000));
    KSP ksp;
    PC pc;
    PHYNNESS_PETSC(SNESGetKSP(snes, &ksp));
    PHYNNESS_PETSC(KSPSetType(ksp, KSPPREONLY));
    PHYNNESS_PETSC(KSPGetPC(ksp, &pc));
    PHYNNESS_PETSC(PCSetType(pc, PCLU));
    PHYNNESS_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  }

  static void read(Vec from, std::vector<double>& to) {
    const PetscScalar* values = nullptr;
    PHYNNESS_PETSC(VecGetArrayRead(from, &values));
    std::copy_n(values, to.size(), to.begin());
    PHYNNESS_PETSC(VecRestoreArrayRead(from, &values));
  }

  static PetscErrorCode form_function(SNES snes, Vec x, Vec r, void* context) {
    auto& self = *static_cast<Impl*>(context);
    read(x, self.state);
    self.body.residual(self.state, self.residual);
    ++self.counts.residuals;
    PetscScalar* out = nullptr;
    PetscCall(VecGetArray(r, &out));
    bool finite = true;
    self.reactions = 0;
    for (int dof = 0; dof < self.body.n_dofs(); ++dof) {
      const double value = self.residual[dof];
      if (!self.is_free[dof]) self.reactions += value * value;
      out[dof] = self.is_free[dof] ? value : 0.0;
      finite = finite && std::isfinite(out[dof]);
    }
    self.reactions = std::sqrt(self.reactions);
    PetscCall(VecRestoreArray(r, &out));
    if (!finite) PetscCall(SNESSetFunctionDomainError(snes));
    return 0;
  }

  static PetscErrorCode form_jacobian(SNES, Vec x, Mat matrix, Mat, void* context) {
    auto& self = *static_cast<Impl*>(context);
    read(x, self.state);
    PetscCall(MatZeroEntries(matrix));
    self.body.block_tangents(
        self.state, Convexity::none, [&](std::int32_t block, std::span<const double> tangent, std::span<const double>) {
          const auto dofs = self.body.block_dofs(block);
          const auto m = static_cast<PetscInt>(dofs.size());
          PHYNNESS_PETSC(MatSetValues(matrix, m, dofs.data(), m, dofs.data(), tangent.data(), ADD_VALUES));
        });
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(
        MatZeroRowsColumns(matrix, static_cast<PetscInt>(self.held.size()), self.held.data(), 1.0, nullptr, nullptr));
    ++self.counts.tangents;
    ++self.counts.factorizations;
    ++self.counts.substitutions;
    return 0;
  }

  static PetscErrorCode test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal norm,
                                         SNESConvergedReason* reason, void* context) {
    const auto& self = *static_cast<Impl*>(context);
    *reason = SNES_CONVERGED_ITERATING;
    if (!std::isfinite(norm))
      *reason = SNES_DIVERGED_FUNCTION_NANORINF;
    else if (norm <= self.scene.solver.relative_tolerance * self.reactions)
      *reason = SNES_CONVERGED_FNORM_RELATIVE;
    return 0;
  }

  Scene scene;
  Scaling scaling;
  Discretization body;
  std::vector<char> fixed;
  std::vector<std::int32_t> fixed_dofs;
  std::vector<PetscInt> held;  // fixed and prescribed dofs
  std::vector<char> is_free;
  std::vector<double> state, residual;
  double reactions = 0;
  SolverCounts counts;
  PetscMat matrix;
  PetscVec x, r;
  PetscSnes snes;
};

PlainLoop::PlainLoop(const Scene& scene, const Mesh& mesh, const NodeSets& sets)
    : _impl(std::make_unique<Impl>(scene, mesh, sets)) {}
PlainLoop::~PlainLoop() = default;

SolverCounts PlainLoop::counts() const { return _impl->counts; }

std::vector<PlainState> PlainLoop::ray(std::int32_t node, const Vec3& full_depth_m, int increments) {
  auto& s = *_impl;
  if (s.scene.probe.kind != ProbeKind::node) throw std::logic_error("the plain loop is of node probes");
  const auto constraint = tool_constraint(s.body, {at_node(node)}, 0, s.fixed);
  s.held.assign(s.fixed_dofs.begin(), s.fixed_dofs.end());
  s.held.insert(s.held.end(), constraint.dofs.begin(), constraint.dofs.end());
  s.is_free.assign(s.body.n_dofs(), 1);
  for (const auto dof : s.held) s.is_free[dof] = 0;

  const Eigen::Vector3d depth = Eigen::Vector3d(full_depth_m[0], full_depth_m[1], full_depth_m[2]) / s.scaling.length_m;
  std::vector<double> state(s.body.n_dofs(), 0.0);
  std::vector<PlainState> out;
  for (int i = 1; i <= increments; ++i) {
    if (i > 1)
      for (auto& value : state) value *= static_cast<double>(i) / (i - 1);
    const Eigen::VectorXd prescribed = constraint.G * (depth * i / increments);
    for (std::size_t c = 0; c < constraint.dofs.size(); ++c)
      state[constraint.dofs[c]] = prescribed[static_cast<Eigen::Index>(c)];
    PetscScalar* values = nullptr;
    PHYNNESS_PETSC(VecGetArray(s.x, &values));
    std::copy(state.begin(), state.end(), values);
    PHYNNESS_PETSC(VecRestoreArray(s.x, &values));
    PHYNNESS_PETSC(SNESSolve(s.snes, nullptr, s.x));
    SNESConvergedReason reason;
    PetscInt iterations = 0;
    PHYNNESS_PETSC(SNESGetConvergedReason(s.snes, &reason));
    PHYNNESS_PETSC(SNESGetIterationNumber(s.snes, &iterations));
    PlainState result;
    result.iterations = static_cast<int>(iterations);
    Impl::read(s.x, state);
    result.converged = reason > 0 && (!s.body.forms().checks_jacobian || s.body.min_jacobian(state) > 0);
    if (result.converged) {
      s.body.residual(state, s.residual);
      Eigen::VectorXd reaction(static_cast<Eigen::Index>(constraint.dofs.size()));
      for (std::size_t c = 0; c < constraint.dofs.size(); ++c)
        reaction[static_cast<Eigen::Index>(c)] = s.residual[constraint.dofs[c]];
      const Eigen::VectorXd force = constraint.G.transpose() * reaction;
      for (int k = 0; k < 3; ++k) result.force_N[k] = force[k] * s.scaling.force_N();
    }
    out.push_back(result);
    if (!result.converged) break;
  }
  return out;
}

}  // namespace phynness::bench
