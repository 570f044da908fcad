// The only file that depends on the version of dolfinx: 0.5, or 0.9 and later. Everything here is serial, with one mesh
// per process (MPI_COMM_SELF).
#pragma once

#include <dolfinx/common/MPI.h>
#include <dolfinx/common/log.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/graph/AdjacencyList.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/cell_types.h>
#include <ufcx.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <string>
#include <vector>

#if PHYNNESS_DOLFINX == 5
#elif PHYNNESS_DOLFINX >= 9
#include <basix/finite-element.h>
#include <dolfinx/fem/FiniteElement.h>
#include <dolfinx/mesh/utils.h>
#else
#error "phynness supports dolfinx 0.5 and 0.9 to 0.11; add the differences of another version to dolfinx_api.hpp"
#endif

namespace phynness::dolfinx_api {

#if PHYNNESS_DOLFINX == 5
using DolfinxMesh = dolfinx::mesh::Mesh;
using Space = dolfinx::fem::FunctionSpace;
#else
using DolfinxMesh = dolfinx::mesh::Mesh<double>;
using Space = dolfinx::fem::FunctionSpace<double>;
#endif

/// Limits dolfinx's own messages to errors.
inline void quiet_logging() {
#if PHYNNESS_DOLFINX == 5
  loguru::g_stderr_verbosity = loguru::Verbosity_ERROR;
#else
  spdlog::set_level(spdlog::level::err);
#endif
}

#if PHYNNESS_DOLFINX >= 9
using BasixElement = basix::FiniteElement<double>;

/// A Lagrange element with the same points as in the forms of basix.ufl, because dolfinx compares the hashes of
/// elements.
inline BasixElement lagrange(int degree, basix::cell::type cell = basix::cell::type::tetrahedron) {
  return basix::create_element<double>(basix::element::family::P, cell, degree,
                                       basix::element::lagrange_variant::gll_warped, basix::element::dpc_variant::unset,
                                       false);
}

inline BasixElement crouzeix_raviart() {
  return basix::create_element<double>(basix::element::family::CR, basix::cell::type::triangle, 1,
                                       basix::element::lagrange_variant::unset, basix::element::dpc_variant::unset,
                                       false);
}
#endif

/// Affine tetrahedra, or triangles in space. dolfinx reorders cells for locality; original_cell_index gives their input
/// order, see cell_nodes().
inline std::shared_ptr<DolfinxMesh> create_mesh(const Points& nodes, const Cells& cells) {
  std::vector<std::int64_t> connectivity(cells.data(), cells.data() + cells.size());
  const std::array<std::size_t, 2> shape{static_cast<std::size_t>(nodes.rows()), 3};
  const std::span x(nodes.data(), static_cast<std::size_t>(nodes.size()));
#if PHYNNESS_DOLFINX == 5
  std::vector<std::int32_t> offsets(cells.rows() + 1);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    offsets[i] = static_cast<std::int32_t>(static_cast<std::size_t>(cells.cols()) * i);
  const dolfinx::graph::AdjacencyList<std::int64_t> list(std::move(connectivity), std::move(offsets));
  const dolfinx::fem::CoordinateElement element(
      cells.cols() == 3 ? dolfinx::mesh::CellType::triangle : dolfinx::mesh::CellType::tetrahedron, 1);
  return std::make_shared<DolfinxMesh>(
      dolfinx::mesh::create_mesh(MPI_COMM_SELF, list, element, x, shape, dolfinx::mesh::GhostMode::none));
#else
  const dolfinx::fem::CoordinateElement<double> element(std::make_shared<const BasixElement>(
      lagrange(1, cells.cols() == 3 ? basix::cell::type::triangle : basix::cell::type::tetrahedron)));
  return std::make_shared<DolfinxMesh>(dolfinx::mesh::create_mesh(
      MPI_COMM_SELF, std::span<const std::int64_t>(connectivity), element, x, shape, dolfinx::mesh::GhostMode::none));
#endif
}

inline const dolfinx::mesh::Topology& topology(const DolfinxMesh& mesh) {
#if PHYNNESS_DOLFINX == 5
  return mesh.topology();
#else
  return *mesh.topology();
#endif
}

inline std::int32_t n_cells(const DolfinxMesh& mesh) {
  return topology(mesh).index_map(topology(mesh).dim())->size_local();
}

/// Indices of a cell's vertices in the arrays of the mesh geometry.
inline std::span<const std::int32_t> vertices(const DolfinxMesh& mesh, std::int32_t cell) {
#if PHYNNESS_DOLFINX == 5
  return mesh.geometry().dofmap().links(cell);
#else
  const int n = topology(mesh).dim() + 1;
#if PHYNNESS_DOLFINX <= 10
  return {mesh.geometry().dofmap().data_handle() + n * std::ptrdiff_t{cell}, static_cast<std::size_t>(n)};
#else
  return {mesh.geometry().dofmaps().front().data_handle() + n * std::ptrdiff_t{cell}, static_cast<std::size_t>(n)};
#endif
#endif
}

/// The nodes of a dolfinx cell, numbered as in the arguments of create_mesh, in the vertex order of the cell.
inline std::vector<std::int32_t> cell_nodes(const DolfinxMesh& mesh, std::int32_t cell) {
  const auto& original = mesh.geometry().input_global_indices();
  std::vector<std::int32_t> nodes;
  for (const auto place : vertices(mesh, cell)) nodes.push_back(static_cast<std::int32_t>(original[place]));
  return nodes;
}

/// Coordinates of the cell's vertices as arguments of kernels: n x 3, row-major; a triangle uses 9 of the 12 numbers.
inline void cell_coordinates(const DolfinxMesh& mesh, std::int32_t cell, std::span<double, 12> coordinates) {
  const auto x = mesh.geometry().x();
  const auto places = vertices(mesh, cell);
  for (std::size_t i = 0; i < places.size(); ++i) std::copy_n(x.data() + 3 * places[i], 3, coordinates.data() + 3 * i);
}

#if PHYNNESS_DOLFINX >= 9
inline std::shared_ptr<Space> space_of(const std::shared_ptr<DolfinxMesh>& mesh,
                                       const std::shared_ptr<const dolfinx::fem::FiniteElement<double>>& chosen) {
#if PHYNNESS_DOLFINX == 9
  const auto dofmap = std::make_shared<const dolfinx::fem::DofMap>(dolfinx::fem::create_dofmap(
      mesh->comm(), dolfinx::fem::create_element_dof_layout(*chosen), *mesh->topology(), nullptr, nullptr));
  return std::make_shared<Space>(mesh, chosen, dofmap,
                                 dolfinx::fem::compute_value_shape(chosen, mesh->topology()->dim(), 3));
#else
  return std::make_shared<Space>(dolfinx::fem::create_functionspace(mesh, chosen));
#endif
}

/// Three components of a scalar element.
inline std::shared_ptr<const dolfinx::fem::FiniteElement<double>> vector_of(const BasixElement& scalar) {
#if PHYNNESS_DOLFINX == 9
  return std::make_shared<const dolfinx::fem::FiniteElement<double>>(scalar, 3);
#else
  return std::make_shared<const dolfinx::fem::FiniteElement<double>>(scalar, std::vector<std::size_t>{3});
#endif
}
#endif

/// The space of an element, the same for which its forms are compiled (forms/elements.py).
/// @param residual  form of the element for any law
inline std::shared_ptr<Space> create_space([[maybe_unused]] Element element, [[maybe_unused]] const ufcx_form& residual,
                                           const std::shared_ptr<DolfinxMesh>& mesh) {
#if PHYNNESS_DOLFINX == 5
  // In this version ffcx generates the space together with the form; it is the space of the first argument.
  const auto chosen = std::make_shared<const dolfinx::fem::FiniteElement>(*residual.finite_elements[0]);
  const auto layout = dolfinx::fem::create_element_dof_layout(*residual.dofmaps[0], mesh->topology().cell_type());
  return std::make_shared<Space>(mesh, chosen,
                                 std::make_shared<const dolfinx::fem::DofMap>(dolfinx::fem::create_dofmap(
                                     mesh->comm(), layout, mesh->topology(), nullptr, *chosen)));
#else
  using FiniteElement = dolfinx::fem::FiniteElement<double>;
  using Parts = std::vector<std::shared_ptr<const FiniteElement>>;
  if (element->is_shell)
    return space_of(mesh, std::make_shared<const FiniteElement>(Parts{
                              vector_of(lagrange(2, basix::cell::type::triangle)), vector_of(crouzeix_raviart())}));
  const auto displacement = vector_of(lagrange(element->displacement_degree));
  if (!element->mixed) return space_of(mesh, displacement);
#if PHYNNESS_DOLFINX == 9
  const auto pressure = std::make_shared<const FiniteElement>(lagrange(1), 1);
#else
  const auto pressure = std::make_shared<const FiniteElement>(lagrange(1));
#endif
  return space_of(mesh, std::make_shared<const FiniteElement>(Parts{displacement, pressure}));
#endif
}

inline int block_size(const Space& space) { return space.dofmap()->bs(); }

inline std::int32_t n_dofs(const Space& space) {
  return space.dofmap()->index_map->size_local() * space.dofmap()->index_map_bs();
}

/// Blocks of a cell in element order; dof = block_size * block + component.
inline std::span<const std::int32_t> cell_blocks(const Space& space, std::int32_t cell) {
  return space.dofmap()->cell_dofs(cell);
}

/// Scalar dofs of one displacement component (0..2) of a mixed space, or of its pressure (3), cell by cell. A shell's
/// director has the components 3..5.
inline std::shared_ptr<const Space> mixed_component(const Space& space, int component, bool shell = false) {
  // One level at a time, because dolfinx searches the second number of a path among the children of the root.
#if PHYNNESS_DOLFINX == 5
  if (shell && component >= 3) return space.sub({1})->sub({component - 3});
  return component < 3 ? space.sub({0})->sub({component}) : space.sub({1});
#else
  if (shell && component >= 3) return std::make_shared<const Space>(space.sub({1}).sub({component - 3}));
  return std::make_shared<const Space>(component < 3 ? space.sub({0}).sub({component}) : space.sub({1}));
#endif
}

/// Which function each coefficient of a form is: 0 the state, 1 its values at rest, which shells have.
inline std::span<const int> coefficients(const ufcx_form& form) {
#if PHYNNESS_DOLFINX == 5
  const int* positions = form.original_coefficient_position;
#else
  const int* positions = form.original_coefficient_positions;
#endif
  return {positions, static_cast<std::size_t>(form.num_coefficients)};
}

/// Evaluates an expression of the state of a cell at its points.
/// @param values  num_points; must be zero before the call
/// @param w       dofs of the cell
/// @param c       packed_constants()
/// @param x       cell_coordinates()
inline void tabulate(const ufcx_expression& expression, std::span<double> values, std::span<const double> w,
                     std::span<const double> c, std::span<const double, 12> x) {
#if PHYNNESS_DOLFINX <= 9
  expression.tabulate_tensor_float64(values.data(), w.data(), c.data(), x.data(), nullptr, nullptr);
#else
  expression.tabulate_tensor_float64(values.data(), w.data(), c.data(), x.data(), nullptr, nullptr, nullptr);
#endif
}

/// The constants of a form in the order of its kernel.
inline std::vector<double> packed_constants(const ufcx_form& form, const std::map<std::string, double>& constants) {
  std::vector<double> packed;
  for (const auto& name : dolfinx::fem::get_constant_names(form)) packed.push_back(constants.at(name));
  return packed;
}

inline std::vector<double> packed_constants(const ufcx_expression& expression,
                                            const std::map<std::string, double>& constants) {
  std::vector<double> packed;
  for (int i = 0; i < expression.num_constants; ++i) packed.push_back(constants.at(expression.constant_names[i]));
  return packed;
}

/// Adds the integral of a form over one cell to `values`.
/// @param w  values of its coefficients in the cell
/// @param c  packed_constants()
/// @param x  cell_coordinates()
inline void tabulate(const ufcx_form& form, std::span<double> values, std::span<const double> w,
                     std::span<const double> c, std::span<const double, 12> x) {
#if PHYNNESS_DOLFINX == 5
  const ufcx_integral& integral = *form.integrals(ufcx_integral_type::cell)[0];
#else
  const ufcx_integral& integral = *form.form_integrals[form.form_integral_offsets[cell]];
#endif
#if PHYNNESS_DOLFINX <= 9
  integral.tabulate_tensor_float64(values.data(), w.data(), c.data(), x.data(), nullptr, nullptr);
#else
  integral.tabulate_tensor_float64(values.data(), w.data(), c.data(), x.data(), nullptr, nullptr, nullptr);
#endif
}

/// Edges of the reference tetrahedron (4 vertices) or triangle (3) as pairs of local vertices, in the order of their
/// dofs.
inline const std::vector<std::array<int, 2>>& edge_vertices(std::size_t n_vertices) {
  static const std::vector<std::array<int, 2>> of_tetrahedron{{2, 3}, {1, 3}, {1, 2}, {0, 3}, {0, 2}, {0, 1}},
      of_triangle{{1, 2}, {0, 2}, {0, 1}};
  return n_vertices == 3 ? of_triangle : of_tetrahedron;
}

}  // namespace phynness::dolfinx_api
