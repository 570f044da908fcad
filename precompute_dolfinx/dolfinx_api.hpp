// The only file that knows which dolfinx it meets. Everything here is serial: one mesh per process
// (MPI_COMM_SELF).
#pragma once

#include <dolfinx/common/MPI.h>
#include <dolfinx/common/log.h>
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/Form.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/graph/AdjacencyList.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/cell_types.h>
#include <ufcx.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <phynness/formats/mesh.hpp>
#include <span>
#include <string>
#include <vector>

#if PHYNNESS_DOLFINX != 5
#error "this source has been taught dolfinx 0.5 only; other versions belong in this file"
#endif

namespace phynness::dolfinx_api {

using DolfinxMesh = dolfinx::mesh::Mesh;
using Space = dolfinx::fem::FunctionSpace;
using Function = dolfinx::fem::Function<double>;
using Constant = dolfinx::fem::Constant<double>;
using Form = dolfinx::fem::Form<double>;
using SpaceFactory = ufcx_function_space* (*)(const char*);

/// dolfinx's own messages: errors only.
inline void quiet_logging() { loguru::g_stderr_verbosity = loguru::Verbosity_ERROR; }

/// Affine tetrahedra in their given order (dolfinx would reorder cells for locality; here input order is kept
/// through original_cell_index, see cell_nodes()).
inline std::shared_ptr<DolfinxMesh> create_mesh(const Points& nodes, const Cells& cells) {
  std::vector<std::int64_t> connectivity(cells.data(), cells.data() + cells.size());
  std::vector<std::int32_t> offsets(cells.rows() + 1);
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = static_cast<std::int32_t>(4 * i);
  const dolfinx::graph::AdjacencyList<std::int64_t> list(std::move(connectivity), std::move(offsets));
  const dolfinx::fem::CoordinateElement element(dolfinx::mesh::CellType::tetrahedron, 1);
  return std::make_shared<DolfinxMesh>(dolfinx::mesh::create_mesh(
      MPI_COMM_SELF, list, element, std::span(nodes.data(), static_cast<std::size_t>(nodes.size())),
      {static_cast<std::size_t>(nodes.rows()), 3}, dolfinx::mesh::GhostMode::none));
}

inline std::int32_t n_cells(const DolfinxMesh& mesh) { return mesh.geometry().dofmap().num_nodes(); }

/// The four nodes of a dolfinx cell, in the numbers that create_mesh was given and in the cell's own vertex
/// order.
inline std::array<std::int32_t, 4> cell_nodes(const DolfinxMesh& mesh, std::int32_t cell) {
  const auto& original = mesh.geometry().input_global_indices();
  const auto links = mesh.geometry().dofmap().links(cell);
  std::array<std::int32_t, 4> nodes;
  for (int i = 0; i < 4; ++i) nodes[i] = static_cast<std::int32_t>(original[links[i]]);
  return nodes;
}

/// Coordinates of the cell's vertices as the kernels want them: 4 x 3, row-major.
inline void cell_coordinates(const DolfinxMesh& mesh, std::int32_t cell, std::span<double, 12> coordinates) {
  const auto x = mesh.geometry().x();
  const auto links = mesh.geometry().dofmap().links(cell);
  for (int i = 0; i < 4; ++i) std::copy_n(x.data() + 3 * links[i], 3, coordinates.data() + 3 * i);
}

/// The space of a residual's test function, which ffcx calls v_0.
inline std::shared_ptr<Space> create_space(SpaceFactory factory, const std::shared_ptr<DolfinxMesh>& mesh) {
  return std::make_shared<Space>(dolfinx::fem::create_functionspace(factory, "v_0", mesh));
}

inline int block_size(const Space& space) { return space.dofmap()->bs(); }

inline std::int32_t n_dofs(const Space& space) {
  return space.dofmap()->index_map->size_local() * space.dofmap()->index_map_bs();
}

/// Blocks of a cell in element order; dof = block_size * block + component.
inline std::span<const std::int32_t> cell_blocks(const Space& space, std::int32_t cell) {
  return space.dofmap()->cell_dofs(cell);
}

/// Scalar dofs of one displacement component (0..2) of a mixed space, or of its pressure (3), cell by cell.
inline std::shared_ptr<Space> mixed_component(const Space& space, int component) {
  return component < 3 ? space.sub({0})->sub({component}) : space.sub({1});
}

inline Form create_form(const ufcx_form& form, const std::vector<std::shared_ptr<const Space>>& spaces,
                        const std::shared_ptr<const Function>& w,
                        const std::map<std::string, std::shared_ptr<const Constant>>& constants,
                        const std::shared_ptr<const DolfinxMesh>& mesh) {
  std::vector<std::shared_ptr<const Function>> coefficients(form.num_coefficients, w);
  std::vector<std::shared_ptr<const Constant>> ordered;
  for (const auto& name : dolfinx::fem::get_constant_names(form)) ordered.push_back(constants.at(name));
  return dolfinx::fem::create_form<double>(form, spaces, coefficients, ordered, {}, mesh);
}

inline double assemble_scalar(const Form& form) { return dolfinx::fem::assemble_scalar(form); }

/// Adds to `b`.
inline void assemble_vector(std::span<double> b, const Form& form) { dolfinx::fem::assemble_vector(b, form); }

/// Hands each element matrix (row-major, rows and columns in element order) to `take`, cell by cell in cell
/// order.
template <typename Take>
void for_each_element_matrix(const Form& form, Take&& take) {
  std::int32_t cell = 0;
  auto add = [&](std::span<const std::int32_t>, std::span<const std::int32_t>,
                 std::span<const double> values) {
    take(cell++, values);
    return 0;
  };
  dolfinx::fem::assemble_matrix(add, form, {});
}

/// Reference tetrahedron's edges as pairs of local vertices, in the order of its edge dofs.
inline const std::vector<std::vector<int>>& edge_vertices() {
  static const std::vector<std::vector<int>> edges{{2, 3}, {1, 3}, {1, 2}, {0, 3}, {0, 2}, {0, 1}};
  return edges;
}

}  // namespace phynness::dolfinx_api
