#include "discretization.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "../dolfinx_api.hpp"

namespace phynness {

namespace api = dolfinx_api;

void quiet_logging() { api::quiet_logging(); }

struct Discretization::Dolfinx {
  FormSet forms;
  std::shared_ptr<api::DolfinxMesh> mesh;
  std::shared_ptr<api::Space> space;
  std::shared_ptr<api::Function> w;
  std::unique_ptr<api::Form> energy, residual, tangent;

  // The forms read this copy; the solver never hands out its own vector (FEniCS/dolfinx issue 3507).
  void set(std::span<const double> state) { api::set_values(*w, state); }
};

Discretization::Discretization(const Mesh& mesh, const FormSet& forms)
    : _dolfinx(std::make_unique<Dolfinx>()) {
  auto& d = *_dolfinx;
  d.forms = forms;
  d.mesh = api::create_mesh(mesh.nodes, mesh.cells);
  d.space = api::create_space(forms.element, d.mesh);
  d.w = std::make_shared<api::Function>(d.space);
  std::map<std::string, std::shared_ptr<const api::Constant>> constants;
  for (const auto& [name, value] : forms.constants)
    constants[name] = std::make_shared<const api::Constant>(value);
  d.energy = std::make_unique<api::Form>(api::create_form(*forms.energy, {}, d.w, constants, d.mesh));
  d.residual =
      std::make_unique<api::Form>(api::create_form(*forms.residual, {d.space}, d.w, constants, d.mesh));
  d.tangent = std::make_unique<api::Form>(
      api::create_form(*forms.tangent, {d.space, d.space}, d.w, constants, d.mesh));

  _n_dofs = api::n_dofs(*d.space);
  _n_nodes = mesh.n_nodes();
  _n_cells = api::n_cells(*d.mesh);
  const int block = api::block_size(*d.space);
  for (int cell = 0; cell < _n_cells; ++cell)
    for (const auto b : api::cell_blocks(*d.space, cell))
      for (int k = 0; k < block; ++k) _element_dofs.push_back(block * b + k);
  _n_element_dofs = static_cast<int>(_element_dofs.size()) / _n_cells;
  number_points(mesh);
}

Discretization::~Discretization() = default;
Discretization::Discretization(Discretization&&) noexcept = default;

void Discretization::number_points(const Mesh& mesh) {
  const auto& d = *_dolfinx;
  const bool mixed = is_mixed(d.forms.element);
  std::array<std::shared_ptr<const api::Space>, 4> component;
  if (mixed)
    for (int k = 0; k < 4; ++k) component[k] = api::mixed_component(*d.space, k);

  _point_dofs.assign(_n_nodes, {-1, -1, -1});
  std::vector<std::int32_t> pressure(mixed ? _n_nodes : 0, -1);
  std::map<std::array<std::int32_t, 2>, std::int32_t> edge_point;
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto nodes = api::cell_nodes(*d.mesh, cell);
    const auto blocks = mixed ? api::cell_blocks(*component[0], cell) : api::cell_blocks(*d.space, cell);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      std::int32_t point;
      if (i < 4) {
        point = nodes[i];
      } else {
        const auto& ends = api::edge_vertices()[i - 4];
        std::array<std::int32_t, 2> edge{nodes[ends[0]], nodes[ends[1]]};
        if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
        const auto [entry, is_new] =
            edge_point.try_emplace(edge, static_cast<std::int32_t>(_point_dofs.size()));
        point = entry->second;
        if (is_new) {
          _edges.push_back(edge);
          _point_dofs.push_back({});
        }
      }
      for (int k = 0; k < 3; ++k)
        _point_dofs[point][k] = mixed ? api::cell_blocks(*component[k], cell)[i] : 3 * blocks[i] + k;
    }
    if (mixed)
      for (int i = 0; i < 4; ++i) pressure[nodes[i]] = api::cell_blocks(*component[3], cell)[i];
  }
  _pressure_dofs = std::move(pressure);

  _surface = mesh.surface;
  _points.resize(n_points(), 3);
  _points.topRows(_n_nodes) = mesh.nodes;
  _on_surface.assign(n_points(), 0);
  for (Eigen::Index i = 0; i < mesh.surface.size(); ++i) _on_surface[mesh.surface.data()[i]] = 1;
  std::set<std::array<std::int32_t, 2>> surface_edges;
  for (Eigen::Index t = 0; t < mesh.surface.rows() && !_edges.empty(); ++t)
    for (int i = 0; i < 3; ++i) {
      const auto a = mesh.surface(t, i), b = mesh.surface(t, (i + 1) % 3);
      surface_edges.insert({std::min(a, b), std::max(a, b)});
    }
  for (std::size_t e = 0; e < _edges.size(); ++e) {
    const auto [a, b] = _edges[e];
    _points.row(_n_nodes + static_cast<Eigen::Index>(e)) = (mesh.nodes.row(a) + mesh.nodes.row(b)) / 2;
    _on_surface[_n_nodes + e] = surface_edges.contains({a, b}) ? 1 : 0;
  }
}

const FormSet& Discretization::forms() const { return _dolfinx->forms; }

double Discretization::energy(std::span<const double> state) {
  _dolfinx->set(state);
  return api::assemble_scalar(*_dolfinx->energy);
}

void Discretization::residual(std::span<const double> state, std::span<double> out) {
  _dolfinx->set(state);
  std::fill(out.begin(), out.end(), 0.0);
  api::assemble_vector(out, *_dolfinx->residual);
}

double Discretization::min_jacobian(std::span<const double> state) {
  const auto& expression = *_dolfinx->forms.jacobian;
  std::vector<double> w(_n_element_dofs), values(expression.num_points);
  std::array<double, 12> x;
  double least = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto dofs = element_dofs(cell);
    std::transform(dofs.begin(), dofs.end(), w.begin(), [&](auto i) { return state[i]; });
    api::cell_coordinates(*_dolfinx->mesh, cell, x);
    std::fill(values.begin(), values.end(), 0.0);
    api::tabulate(expression, values, w, x);
    for (const double J : values)
      least = std::isnan(J) ? -std::numeric_limits<double>::infinity() : std::min(least, J);
  }
  return least;
}

void Discretization::cell_integrals(const ufcx_form& functional, std::span<const double> state,
                                    std::span<double> out) const {
  const auto constants = api::packed_constants(functional, _dolfinx->forms.constants);
  std::vector<double> w(_n_element_dofs);
  std::array<double, 12> x;
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto dofs = element_dofs(cell);
    std::transform(dofs.begin(), dofs.end(), w.begin(), [&](auto i) { return state[i]; });
    api::cell_coordinates(*_dolfinx->mesh, cell, x);
    out[cell] = api::tabulate_cell(functional, w, constants, x);
  }
}

std::array<std::int32_t, 4> Discretization::cell_nodes(int cell) const {
  return api::cell_nodes(*_dolfinx->mesh, cell);
}

double Discretization::cell_volume(int cell) const {
  std::array<double, 12> x;
  api::cell_coordinates(*_dolfinx->mesh, cell, x);
  const auto corner = Eigen::Map<const Points>(x.data(), 4, 3);
  const Eigen::Matrix3d edges = corner.bottomRows<3>().rowwise() - corner.row(0);
  return std::abs(edges.determinant()) / 6;
}

void Discretization::element_tangents(
    std::span<const double> state, const std::function<void(std::int32_t, std::span<const double>)>& take) {
  _dolfinx->set(state);
  api::for_each_element_matrix(*_dolfinx->tangent, take);
}

}  // namespace phynness
