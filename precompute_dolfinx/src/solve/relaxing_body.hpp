// Stress relaxation in cells and edges with a constant deformation gradient, by Simo's recursion (1987, doi
// 10.1016/0045-7825(87)90107-1).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <phynness/formats/scene.hpp>
#include <span>
#include <vector>

#include "discretization.hpp"

namespace phynness {

/// Whether every cell and edge of the element has a constant deformation gradient.
bool has_relaxation(Element element);

/// W = shape(F) + lambda/2 g^2. The second Piola-Kirchhoff stress S of shape relaxes,
///     S(t) = g_inf S_e + sum_i h_i,   dh_i/dt = -h_i / tau_i + g_i dS_e/dt,   S_e = F^-1 d shape/dF,
/// and that of lambda does not. For laws with an isochoric shape, shape includes mu/3 g^2 as in edge-smoothed elements.
/// Within a step S_e is linear in time; then S = c S_e(F) + H with a number c and a tensor H of each cell or edge,
/// which is the stress of the energy c shape + H : (F^T F - I) / 2. In the linear theory S and F^T F - I are those of
/// small strains.
///
/// The stabilization of the pressure p, which is divided by mu, relaxes with mu: it has c y in place of grad p, where y
/// is the gradient whose relaxing stress is grad p, so that grad p = c y + H in each cell.
class RelaxingBody : public BlockEnergy {
 public:
  /// The body begins at rest. @pre has_relaxation(element of the body)
  RelaxingBody(const Discretization& body, const Material& material, const Relaxation& relaxation);

  /// Begins a time step. @pre dt_s > 0
  void begin_step(double dt_s);
  /// Ends the time step at an equilibrium.
  void end_step(std::span<const double> state);

  double energy(std::span<const double> state) const override;
  void add_residual(std::span<const double> state, std::span<double> out) const override;
  void add_tangent(std::int32_t block, std::span<const double> state, std::span<double> tangent) const override;

 private:
  using Tensor = EdgePatches::Gradient;
  struct Block {
    int region = 0;
    double weight = 0;                          ///< volume times the share of shape that is a function of this gradient
    ByComponent<std::int32_t> dofs, positions;  ///< of the displacements; their positions in the dofs of the block
    ByComponent<double> shape_gradients;        ///< as in GradientOperator
    std::vector<Tensor> history;                ///< h_i
    Tensor elastic = Tensor::Zero(), stress_offset = Tensor::Zero();  ///< S_e of the last step, and H
  };
  /// The stabilization of a cell; without relaxation its energy is -weight/2 |F^-T grad p|^2.
  struct Stabilized {
    double weight = 0;
    std::array<std::int32_t, 4> dofs{};  ///< dofs of the pressures
    Eigen::Matrix<double, 4, 3> shape_gradients;
    std::vector<Eigen::Vector3d> history;
    Eigen::Vector3d elastic_gradient = Eigen::Vector3d::Zero(), gradient_offset = Eigen::Vector3d::Zero();  ///< y, H
  };
  /// A term -k/2 |F^-T (grad p - H)|^2 that is added to a cell.
  struct StabilizationTerm {
    double k = 0;
    Eigen::Vector3d g, m;  ///< g = F^-T (grad p - H), m = F^-1 g
    Eigen::Matrix3d inverse;
  };
  /// The terms that replace the stabilization of the forms: the relaxing one, and the negative of that of the forms.
  std::array<StabilizationTerm, 2> terms_of(std::size_t cell, const Tensor& F, std::span<const double> state) const;
  static Eigen::Vector3d pressure_gradient(const Stabilized& cell, std::span<const double> state);
  Tensor gradient(const Block& block, std::span<const double> state) const;
  Tensor shape_stress(const Block& block, const Tensor& F) const;  ///< d shape/dF

  EdgeForms _law;
  struct Constants {
    std::vector<double> energy, residual, tangent;
  };
  std::vector<Constants> _constants;  ///< per region
  bool _finite;
  Relaxation _relaxation;
  std::vector<double> _decay, _stress_factor;  ///< of the step: h_i <- decay h_i + stress_factor (change of S_e)
  double _elastic_factor = 1;
  std::vector<Block> _blocks;           ///< the cells first
  std::vector<Stabilized> _stabilized;  ///< per cell; none in other elements
};

}  // namespace phynness
