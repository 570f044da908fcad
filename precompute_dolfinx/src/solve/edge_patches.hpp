// The edges of tetrahedra, each with the cells of one region at it, over which an edge-smoothed element averages the
// deformation gradient.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "convexity.hpp"
#include "form_set.hpp"

namespace phynness {

/// A tetrahedron of volume 1: the integral of a constant function is its value.
inline constexpr std::array<double, 12> unit_volume{0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 1};

/// Edge e has the volume V_e and the mean gradient F_e of its cells c, of each of which it has a sixth:
///
///     V_e = sum_c V_c / 6,    F_e = sum_c (V_c / 6) F_c / V_e = I + sum_a u_a g_a^T
///
/// where a are the nodes of these cells and g_a is the mean gradient of the linear function of node a. The shear energy
/// of the body is sum_e V_e shape(F_e), except for a share that remains in the cells (cell_share); the forms of an edge
/// are functions of F_e. At an interface of materials strains jump, so that an edge there counts once for each region.
class EdgePatches {
 public:
  using Gradient = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  /// No edges.
  EdgePatches() = default;
  /// @param cells   nodes of the tetrahedra, and their volumes
  /// @param slopes  gradients of the linear functions of their nodes
  /// @param dofs    of the displacement of each node
  /// @param regions  of the cells
  EdgePatches(const std::vector<std::array<std::int32_t, 4>>& cells, const std::vector<double>& volumes,
              const std::vector<Eigen::Matrix<double, 4, 3>>& slopes,
              const std::vector<std::array<std::int32_t, 3>>& dofs, const std::vector<std::uint8_t>& regions,
              const FormSet& forms);

  int size() const { return static_cast<int>(_volume.size()); }
  /// Dofs of an edge: the first components of its nodes, the second ones, the third ones.
  std::span<const std::int32_t> dofs(int edge) const {
    return {_dofs.data() + 3 * _start[edge], 3 * (_start[edge + 1] - _start[edge])};
  }
  double volume(int edge) const { return _volume[edge]; }
  int region(int edge) const { return _region[edge]; }
  /// g_a of its nodes: the first components of all, the second ones, the third ones.
  std::span<const double> slopes(int edge) const { return {_slope.data() + 3 * _start[edge], dofs(edge).size()}; }
  Gradient gradient(int edge, std::span<const double> state) const;
  /// The edges of a cell.
  const std::array<std::int32_t, 6>& of_cell(int cell) const { return _of_cell[cell]; }

  /// Shear energy per volume.
  double energy_density(int edge, std::span<const double> state) const;
  /// Adds the nodal forces of all edges to `out`.
  void add_residual(std::span<const double> state, std::span<double> out) const;
  /// Smallest J of the mean gradients; negative where the law is not defined.
  double min_jacobian(std::span<const double> state) const;
  /// The tangent of an edge, row-major; all of its eigenvalues become nonnegative if those of the law's tangent do.
  /// @param exact, convex  outputs; `convex` is not written for Convexity::none
  void tangent(int edge, std::span<const double> state, Convexity convexity, std::vector<double>& exact,
               std::vector<double>& convex) const;

 private:
  using Tangent = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;
  void expand(int edge, const Tangent& of_gradient, std::vector<double>& out) const;

  std::vector<double> _volume;
  std::vector<std::size_t> _start{0};  ///< of each edge in the nodes of all edges
  std::vector<std::int32_t> _dofs;
  std::vector<double>
      _slope;  ///< per edge: g_a, the first components of all its nodes, the second ones, the third ones
  std::vector<std::array<std::int32_t, 6>> _of_cell;
  EdgeForms _forms;
  std::vector<std::uint8_t> _region;  ///< of each edge
  struct Constants {
    std::vector<double> energy, residual, tangent, jacobian;
  };
  std::vector<Constants> _constants;  ///< per region
  const Constants& constants(int edge) const { return _constants[_region[edge]]; }
};

}  // namespace phynness
