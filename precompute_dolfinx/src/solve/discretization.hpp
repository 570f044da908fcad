// Discretization of a body by a mesh and an element: dofs of points, energy, residual and element tangents of a state.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <phynness/formats/fields.hpp>
#include <phynness/formats/mesh.hpp>
#include <span>
#include <vector>

#include "convexity.hpp"
#include "edge_patches.hpp"
#include "form_set.hpp"

namespace phynness {

/// Limits dolfinx's own messages to errors.
void quiet_logging();

/// An additional energy that is a sum over the blocks of a discretization.
class BlockEnergy {
 public:
  virtual ~BlockEnergy() = default;
  virtual double energy(std::span<const double> state) const = 0;
  virtual void add_residual(std::span<const double> state, std::span<double> out) const = 0;
  /// Adds the tangent of a block. @param tangent  row-major
  virtual void add_tangent(std::int32_t block, std::span<const double> state, std::span<double> tangent) const = 0;
};

/// A state is a vector of n_dofs() values: displacements and, for mixed elements, pressures; for a shell, displacements
/// of its midsurface and changes of its directors, whose dofs are at the middles of edges. Points are the positions of
/// displacement dofs: the nodes of the mesh in their order and then, for quadratic elements, the middles of edges.
///
/// The pressure is discontinuous between materials: a node at an interface has one pressure for each adjacent region.
/// Pressures have the unit of the shear modulus of their region, so that all rows of a region have the same scale.
class Discretization {
 public:
  /// @param mesh  lengths in units of Scaling::length_m
  /// @param cell_regions  per cell of the mesh: 0 is the body, i + 1 is forms.regions[i]; empty: one material
  Discretization(const Mesh& mesh, const FormSet& forms, const std::vector<std::uint8_t>& cell_regions = {});
  ~Discretization();
  Discretization(Discretization&&) noexcept;

  int n_dofs() const { return _n_dofs; }
  int n_points() const { return static_cast<int>(_point_dofs.size()); }
  int n_nodes() const { return _n_nodes; }
  /// Dofs of the three displacement components of a point.
  const std::array<std::int32_t, 3>& dofs(int point) const { return _point_dofs[point]; }
  /// Dofs of the director at the middle of an edge. @pre a shell, and a point beyond the nodes
  const std::array<std::int32_t, 3>& director_dofs(int point) const { return _director_dofs[point - _n_nodes]; }
  bool has_directors() const { return !_director_dofs.empty(); }
  /// Dofs of the pressure: one per node, then the additional ones at interfaces; empty for displacement elements.
  const std::vector<std::int32_t>& pressure_dofs() const { return _pressure_dofs; }
  /// The two nodes of the edge at whose middle a point is. @pre a point beyond the nodes
  const std::array<std::int32_t, 2>& edge(int point) const { return _edges[point - _n_nodes]; }
  /// Coordinates, n_points x 3, in units of length_m.
  const Points& points() const { return _points; }
  /// Boundary triangles of the mesh.
  const Triangles& surface() const { return _surface; }
  /// True if the point lies on the boundary of the body.
  bool on_surface(int point) const { return _on_surface[point] != 0; }

  int n_cells() const { return _n_cells; }
  int region(int cell) const { return _regions[cell]; }
  /// The energy and its tangent are sums over blocks: the cells and, for an edge-smoothed element, the edges.
  int n_blocks() const { return _n_cells + _edge_patches.size(); }
  /// Dofs of a block; those of a cell are in element order.
  std::span<const std::int32_t> block_dofs(int block) const {
    if (block >= _n_cells) return _edge_patches.dofs(block - _n_cells);
    return {_element_dofs.data() + static_cast<std::size_t>(block) * _n_element_dofs,
            static_cast<std::size_t>(_n_element_dofs)};
  }
  /// The edges of an edge-smoothed element; empty for other elements.
  const EdgePatches& edge_patches() const { return _edge_patches; }

  /// Sets an additional energy, which must outlive its use; null removes it.
  void set_extra_energy(const BlockEnergy* energy) { _extra_energy = energy; }
  /// Stored energy.
  double energy(std::span<const double> state);
  /// Nodal forces that hold the state, and residuals of the pressure equations. @param out  n_dofs, overwritten
  void residual(std::span<const double> state, std::span<double> out);
  /// Smallest J over all quadrature points.
  double min_jacobian(std::span<const double> state);
  /// Receives the number of a block, its tangent, and the nearest positive semidefinite tangent (of the displacements;
  /// empty without convexity). The matrices are row-major, and their rows are the dofs of the block.
  using TangentVisitor = std::function<void(std::int32_t, std::span<const double>, std::span<const double>)>;
  /// Calls `visit` with the tangents of all blocks in order.
  void block_tangents(std::span<const double> state, Convexity convexity, const TangentVisitor& visit);
  /// Integrals of a field over each cell. @param out  n_cells, overwritten
  void field_integrals(Field field, std::span<const double> state, std::span<double> out) const;
  /// Node numbers of a cell, and its volume at rest in units of length_m^3. @pre not a shell
  std::array<std::int32_t, 4> cell_nodes(int cell) const;
  double cell_volume(int cell) const;
  /// Gradients of the linear shape functions of a cell's nodes. @pre not a shell
  Eigen::Matrix<double, 4, 3> cell_shape_gradients(int cell) const;
  const FormSet& forms() const;

 private:
  struct Dolfinx;
  struct Kernel;
  /// The number of pressures of a cell, which are its last dofs.
  std::size_t n_pressures() const { return _pressure_dofs.empty() ? 0 : 4; }
  double pressure_unit(int cell) const { return forms().regions[region(cell) - 1].shear_modulus; }
  /// Evaluates a form in every cell and calls `visit` after each. @param values  accumulates the values of the form
  template <class Take>
  void integrate(const Kernel& kernel, std::span<const double> state, std::span<double> values, Take&& visit) const;
  /// Packs the values of the coefficients of a form or an expression in a cell.
  void pack_coefficients(int cell, std::span<const int> coefficients, std::span<const double> state,
                         std::vector<double>& w) const;
  void number_points(const Mesh& mesh);
  void find_regions(const Mesh& mesh, const std::vector<std::uint8_t>& cell_regions);
  /// Adds a pressure for each further region at the nodes of interfaces.
  void split_pressures();
  void find_edge_patches();
  /// Rows are the edge vectors from the first node of a tetrahedron.
  Eigen::Matrix3d cell_edge_vectors(int cell) const;
  /// Sets the displacements of a cell to F X - X. @param x  coordinates of the cell. @param w  packed dofs of the cell
  void set_gradient(int cell, const EdgePatches::Gradient& F, std::span<const double, 12> x,
                    std::vector<double>& w) const;
  std::vector<double> rest_state(const Mesh& mesh) const;

  std::unique_ptr<Dolfinx> _dolfinx;
  int _n_dofs = 0, _n_nodes = 0, _n_cells = 0, _n_element_dofs = 0;
  std::vector<std::array<std::int32_t, 3>> _point_dofs, _director_dofs;
  std::vector<std::array<std::int32_t, 2>> _edges;
  std::vector<std::int32_t> _pressure_dofs, _element_dofs;
  std::vector<std::uint8_t> _regions;  ///< of the cells, in the order of dolfinx
  std::vector<char> _on_surface;
  Points _points;
  Triangles _surface;
  EdgePatches _edge_patches;
  const BlockEnergy* _extra_energy = nullptr;
};

}  // namespace phynness
