// The edges of tetrahedra with their adjacent cells of one region, over which an edge-smoothed element averages the
// deformation gradient.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "convexity.hpp"
#include "form_set.hpp"

namespace phynness {

/// A tetrahedron of volume 1: the integral of a constant function is its value.
inline constexpr std::array<double, 12> unit_volume{0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 1};

/// Values by component or direction (row) and node (column).
template <class Scalar>
using ByComponent = Eigen::Matrix<Scalar, 3, Eigen::Dynamic, Eigen::RowMajor>;

/// The displacement gradient of a cell or an edge, a linear map of the displacements of its nodes.
struct GradientOperator {
  Eigen::Map<const ByComponent<std::int32_t>> dofs;  ///< dofs(i, a): component i of the displacement of node a
  Eigen::Map<const ByComponent<double>>
      shape_gradients;  ///< shape_gradients(j, a): derivative of shape function a along j
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> deformation_gradient(std::span<const double> state) const {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> F = F.Identity();
    for (int i = 0; i < 3; ++i)
      for (Eigen::Index a = 0; a < dofs.cols(); ++a)
        for (int j = 0; j < 3; ++j) F(i, j) += state[dofs(i, a)] * shape_gradients(j, a);
    return F;
  }
};

/// Edge e has a sixth of each adjacent cell c, hence the volume V_e and the mean gradient F_e:
///
///     V_e = sum_c V_c / 6,    F_e = sum_c (V_c / 6) F_c / V_e = I + sum_a u_a g_a^T
///
/// where a are the nodes of these cells and g_a is the mean gradient of the shape function of node a. The shear energy
/// of the body is sum_e V_e shape(F_e), except for the share cell_share, which remains in the cells. The forms of an
/// edge are functions of F_e. An edge at an interface exists once for each region, because strains are discontinuous
/// there.
class EdgePatches {
 public:
  using Gradient = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  /// There are no edges.
  EdgePatches() = default;
  /// @param cells   nodes of the tetrahedra
  /// @param shape_gradients  gradients of the linear shape functions of their nodes
  /// @param dofs     displacement dofs of each node
  /// @param regions  region of each cell
  EdgePatches(const std::vector<std::array<std::int32_t, 4>>& cells, const std::vector<double>& volumes,
              const std::vector<Eigen::Matrix<double, 4, 3>>& shape_gradients,
              const std::vector<std::array<std::int32_t, 3>>& dofs, const std::vector<std::uint8_t>& regions,
              const FormSet& forms);

  int size() const { return static_cast<int>(_volume.size()); }
  /// Dofs of an edge: the first components of its nodes, the second ones, the third ones.
  std::span<const std::int32_t> dofs(int edge) const {
    return {_dofs.data() + 3 * _start[edge], 3 * (_start[edge + 1] - _start[edge])};
  }
  double volume(int edge) const { return _volume[edge]; }
  int region(int edge) const { return _region[edge]; }
  GradientOperator gradient_operator(int edge) const {
    const auto n = static_cast<Eigen::Index>(_start[edge + 1] - _start[edge]);
    return {{_dofs.data() + 3 * _start[edge], 3, n}, {_gradients.data() + 3 * _start[edge], 3, n}};
  }
  Gradient gradient(int edge, std::span<const double> state) const {
    return gradient_operator(edge).deformation_gradient(state);
  }
  /// The edges of a cell.
  const std::array<std::int32_t, 6>& edges_of_cell(int cell) const { return _cell_edges[cell]; }

  /// Shear energy per volume.
  double energy_density(int edge, std::span<const double> state) const;
  /// Adds the nodal forces of all edges to `out`.
  void add_residual(std::span<const double> state, std::span<double> out) const;
  /// Smallest J of the mean gradients; negative if the law is undefined.
  double min_jacobian(std::span<const double> state) const;
  /// The tangent of an edge, row-major, and the one without negative eigenvalues.
  /// @param exact, convex  outputs; `convex` is not written for Convexity::none
  void tangent(int edge, std::span<const double> state, Convexity convexity, std::vector<double>& exact,
               std::vector<double>& convex) const;

 private:
  using Tangent = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;
  void to_nodes(int edge, const Tangent& of_gradient, std::vector<double>& out) const;

  std::vector<double> _volume;
  std::vector<std::size_t> _start{0};  ///< of each edge in the nodes of all edges
  std::vector<std::int32_t> _dofs;     ///< GradientOperator::dofs of each edge
  std::vector<double> _gradients;      ///< GradientOperator::shape_gradients of each edge
  std::vector<std::array<std::int32_t, 6>> _cell_edges;
  EdgeForms _forms;
  std::vector<std::uint8_t> _region;  ///< of each edge
  struct Constants {
    std::vector<double> energy, residual, tangent, jacobian;
  };
  std::vector<Constants> _constants;  ///< per region
  const Constants& constants(int edge) const { return _constants[_region[edge]]; }
};

}  // namespace phynness
