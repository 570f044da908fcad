#include "discretization.hpp"

#include <Eigen/Geometry>
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

/// A compiled form and its constants in each region.
struct Discretization::Kernel {
  const ufcx_form* form;
  std::vector<std::vector<double>> constants;

  Kernel(const ufcx_form& compiled, const FormSet& forms, const FormConstants& of_pass = {}) : form(&compiled) {
    for (int r = 0; r < forms.n_regions(); ++r)
      constants.push_back(api::packed_constants(compiled, forms.constants_in(r, of_pass)));
  }
};

struct Discretization::Dolfinx {
  FormSet forms;
  std::shared_ptr<api::DolfinxMesh> mesh;
  std::shared_ptr<api::Space> space;
  struct Pass {
    Kernel energy, residual, tangent;
  };
  std::vector<Pass> passes;
  std::vector<double> rest_values;  // the state of a shell at rest; empty for solids
};

Discretization::Discretization(const Mesh& mesh, const FormSet& forms, const std::vector<std::uint8_t>& cell_regions)
    : _dolfinx(std::make_unique<Dolfinx>()) {
  auto& d = *_dolfinx;
  d.forms = forms;
  d.mesh = api::create_mesh(mesh.nodes, mesh.cells);
  d.space = api::create_space(forms.element, *forms.residual, d.mesh);
  for (const auto& of_pass : forms.passes)
    d.passes.push_back(
        {{*forms.energy, forms, of_pass}, {*forms.residual, forms, of_pass}, {*forms.tangent, forms, of_pass}});
  if (forms.gauge_energy)
    d.passes.push_back({{*forms.gauge_energy, forms}, {*forms.gauge_residual, forms}, {*forms.gauge_tangent, forms}});

  _n_dofs = api::n_dofs(*d.space);
  _n_nodes = mesh.n_nodes();
  _n_cells = api::n_cells(*d.mesh);
  const int block = api::block_size(*d.space);
  for (int cell = 0; cell < _n_cells; ++cell)
    for (const auto b : api::cell_blocks(*d.space, cell))
      for (int k = 0; k < block; ++k) _element_dofs.push_back(block * b + k);
  _n_element_dofs = static_cast<int>(_element_dofs.size()) / _n_cells;
  number_points(mesh);
  find_regions(mesh, cell_regions);
  if (forms.element->mixed) split_pressures();
  if (forms.edges.energy) find_edge_patches();
  if (forms.element->is_shell) d.rest_values = rest_state(mesh);
}

Discretization::~Discretization() = default;
Discretization::Discretization(Discretization&&) noexcept = default;

void Discretization::number_points(const Mesh& mesh) {
  const auto& d = *_dolfinx;
  const bool mixed = d.forms.element->mixed, shell = d.forms.element->is_shell;
  std::vector<std::shared_ptr<const api::Space>> component;
  for (int k = 0; k < (shell ? 6 : mixed ? 4 : 0); ++k) component.push_back(api::mixed_component(*d.space, k, shell));

  _point_dofs.assign(_n_nodes, {-1, -1, -1});
  std::vector<std::int32_t> pressure(mixed ? _n_nodes : 0, -1);
  std::map<std::array<std::int32_t, 2>, std::int32_t> edge_point;
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto nodes = api::cell_nodes(*d.mesh, cell);
    const auto blocks = component.empty() ? api::cell_blocks(*d.space, cell) : api::cell_blocks(*component[0], cell);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      std::int32_t point;
      if (i < nodes.size()) {
        point = nodes[i];
      } else {
        const auto& ends = api::edge_vertices(nodes.size())[i - nodes.size()];
        std::array<std::int32_t, 2> edge{nodes[ends[0]], nodes[ends[1]]};
        if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
        const auto [entry, is_new] = edge_point.try_emplace(edge, static_cast<std::int32_t>(_point_dofs.size()));
        point = entry->second;
        if (is_new) {
          _edges.push_back(edge);
          _point_dofs.push_back({});
        }
      }
      for (int k = 0; k < 3; ++k)
        _point_dofs[point][k] = component.empty() ? 3 * blocks[i] + k : api::cell_blocks(*component[k], cell)[i];
      if (shell && i >= nodes.size()) {
        _director_dofs.resize(_edges.size());
        for (int k = 0; k < 3; ++k)
          _director_dofs[point - _n_nodes][k] = api::cell_blocks(*component[3 + k], cell)[i - nodes.size()];
      }
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

void Discretization::find_regions(const Mesh& mesh, const std::vector<std::uint8_t>& cell_regions) {
  _regions.assign(static_cast<std::size_t>(_n_cells), 0);
  if (cell_regions.empty()) return;
  const auto sorted = [](auto nodes) {
    std::sort(nodes.begin(), nodes.end());
    return std::vector<std::int32_t>(nodes.begin(), nodes.end());
  };
  std::map<std::vector<std::int32_t>, std::uint8_t> region_of;
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c)
    region_of[sorted(mesh.cells.row(c).eval())] = cell_regions.at(static_cast<std::size_t>(c));
  for (int cell = 0; cell < _n_cells; ++cell)
    _regions[cell] = region_of.at(sorted(api::cell_nodes(*_dolfinx->mesh, cell)));
}

void Discretization::split_pressures() {
  // The pressure of the first region at a node is the dof of dolfinx.
  std::vector<std::int32_t> first(static_cast<std::size_t>(_n_nodes), -1);
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> extra_pressures;
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto nodes = cell_nodes(cell);
    for (std::size_t i = 0; i < 4; ++i) {
      auto& region = first[nodes[i]];
      if (region < 0) region = _regions[cell];
      if (region == _regions[cell]) continue;
      const auto [entry, is_new] = extra_pressures.try_emplace({nodes[i], _regions[cell]}, _n_dofs);
      if (is_new) _pressure_dofs.push_back(_n_dofs++);
      _element_dofs[static_cast<std::size_t>((cell + 1) * _n_element_dofs - 4) + i] = entry->second;
    }
  }
}

const FormSet& Discretization::forms() const { return _dolfinx->forms; }

std::vector<double> Discretization::rest_state(const Mesh& mesh) const {
  std::map<std::array<std::int32_t, 2>, Eigen::RowVector3d> normals;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto corner = [&](int i) -> Eigen::RowVector3d { return mesh.nodes.row(mesh.cells(t, i % 3)); };
    const Eigen::RowVector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (int i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(mesh.cells(t, i), mesh.cells(t, (i + 1) % 3));
      normals.try_emplace({a, b}, Eigen::RowVector3d::Zero()).first->second += normal;
    }
  }
  std::vector<double> values(static_cast<std::size_t>(_n_dofs), 0.0);
  for (int p = _n_nodes; p < n_points(); ++p) {
    const Eigen::RowVector3d director = normals.at(edge(p)).normalized();
    for (int k = 0; k < 3; ++k) {
      values[static_cast<std::size_t>(dofs(p)[k])] = 1;  // a marker (forms/shell.py)
      values[static_cast<std::size_t>(director_dofs(p)[k])] = director[k];
    }
  }
  return values;
}

void Discretization::pack_coefficients(int cell, std::span<const int> coefficients, std::span<const double> state,
                                       std::vector<double>& w) const {
  const auto dofs = block_dofs(cell);
  w.resize(coefficients.size() * dofs.size());
  double* to = w.data();
  for (const int coefficient : coefficients) {
    const double* values = coefficient == 0 ? state.data() : _dolfinx->rest_values.data();
    for (const auto dof : dofs) *to++ = values[dof];
    if (region(cell) > 0)
      for (std::size_t i = 1; i <= n_pressures(); ++i) to[-static_cast<std::ptrdiff_t>(i)] *= pressure_unit(cell);
  }
}

template <class Take>
void Discretization::integrate(const Kernel& kernel, std::span<const double> state, std::span<double> values,
                               Take&& visit) const {
  const auto coefficients = api::coefficients(*kernel.form);
  std::vector<double> w;
  std::array<double, 12> x;
  for (int cell = 0; cell < _n_cells; ++cell) {
    pack_coefficients(cell, coefficients, state, w);
    api::cell_coordinates(*_dolfinx->mesh, cell, x);
    api::tabulate(*kernel.form, values, w, kernel.constants[_regions[cell]], x);
    visit(cell);
  }
}

double Discretization::energy(std::span<const double> state) {
  double sum = 0;
  for (const auto& pass : _dolfinx->passes) {
    double of_pass = 0;
    integrate(pass.energy, state, {&of_pass, 1}, [](int) {});
    sum += of_pass;
  }
  for (int e = 0; e < _edge_patches.size(); ++e)
    sum += _edge_patches.volume(e) * _edge_patches.energy_density(e, state);
  return _extra_energy ? sum + _extra_energy->energy(state) : sum;
}

void Discretization::residual(std::span<const double> state, std::span<double> out) {
  std::fill(out.begin(), out.end(), 0.0);
  std::vector<double> values(static_cast<std::size_t>(_n_element_dofs), 0.0);
  for (const auto& pass : _dolfinx->passes)
    integrate(pass.residual, state, values, [&](int cell) {
      if (region(cell) > 0)
        for (std::size_t i = values.size() - n_pressures(); i < values.size(); ++i) values[i] *= pressure_unit(cell);
      std::size_t i = 0;
      for (const auto dof : block_dofs(cell)) out[dof] += values[i++];
      std::fill(values.begin(), values.end(), 0.0);
    });
  _edge_patches.add_residual(state, out);
  if (_extra_energy) _extra_energy->add_residual(state, out);
}

double Discretization::min_jacobian(std::span<const double> state) {
  const auto& forms = _dolfinx->forms;
  const std::array<int, 2> both{0, 1};
  const std::span<const int> coefficients(both.data(), forms.element->is_shell ? 2 : 1);
  std::vector<double> w, values(forms.jacobian->num_points);
  std::array<double, 12> x;
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& of_pass : forms.jacobian_passes) {
    std::vector<std::vector<double>> constants;
    for (int r = 0; r < forms.n_regions(); ++r)
      constants.push_back(api::packed_constants(*forms.jacobian, forms.constants_in(r, of_pass)));
    for (int cell = 0; cell < _n_cells; ++cell) {
      pack_coefficients(cell, coefficients, state, w);
      api::cell_coordinates(*_dolfinx->mesh, cell, x);
      std::fill(values.begin(), values.end(), 0.0);
      api::tabulate(*forms.jacobian, values, w, constants[_regions[cell]], x);
      for (double J : values) {
        if (std::isnan(J)) J = -std::numeric_limits<double>::infinity();
        smallest = std::min(smallest, J);
      }
    }
  }
  return std::min(smallest, _edge_patches.min_jacobian(state));
}

void Discretization::field_integrals(Field field, std::span<const double> state, std::span<double> out) const {
  const Kernel functional(*_dolfinx->forms.fields[static_cast<std::size_t>(field)], _dolfinx->forms);
  std::vector<double> w;
  std::array<double, 12> x;
  for (int cell = 0; cell < _n_cells; ++cell) {
    const auto integral = [&] {
      double value = 0;
      api::tabulate(*functional.form, {&value, 1}, w, functional.constants[_regions[cell]], x);
      return value;
    };
    pack_coefficients(cell, api::coefficients(*functional.form), state, w);
    api::cell_coordinates(*_dolfinx->mesh, cell, x);
    if (_edge_patches.size() == 0) {
      out[cell] = integral();
    } else if (field == Field::energy_density) {
      out[cell] = integral();
      for (const auto e : _edge_patches.edges_of_cell(cell))
        out[cell] += cell_volume(cell) / 6 * _edge_patches.energy_density(e, state);
    } else {
      // Each sixth of the cell has the gradient of an edge and the pressure of the cell.
      out[cell] = 0;
      for (const auto e : _edge_patches.edges_of_cell(cell)) {
        set_gradient(cell, _edge_patches.gradient(e, state), x, w);
        out[cell] += integral() / 6;
      }
    }
  }
}

std::array<std::int32_t, 4> Discretization::cell_nodes(int cell) const {
  const auto nodes = api::cell_nodes(*_dolfinx->mesh, cell);
  return {nodes[0], nodes[1], nodes[2], nodes.at(3)};
}

Eigen::Matrix3d Discretization::cell_edge_vectors(int cell) const {
  std::array<double, 12> x;
  api::cell_coordinates(*_dolfinx->mesh, cell, x);
  const auto corner = Eigen::Map<const Points>(x.data(), 4, 3);
  return corner.bottomRows<3>().rowwise() - corner.row(0);
}

Eigen::Matrix<double, 4, 3> Discretization::cell_shape_gradients(int cell) const {
  Eigen::Matrix<double, 4, 3> shape_gradients;
  shape_gradients.bottomRows<3>() = cell_edge_vectors(cell).inverse().transpose();
  shape_gradients.row(0) = -shape_gradients.bottomRows<3>().colwise().sum();
  return shape_gradients;
}

double Discretization::cell_volume(int cell) const { return std::abs(cell_edge_vectors(cell).determinant()) / 6; }

void Discretization::set_gradient(int cell, const EdgePatches::Gradient& F, std::span<const double, 12> x,
                                  std::vector<double>& w) const {
  const auto dofs = block_dofs(cell);
  const auto nodes = cell_nodes(cell);
  for (std::size_t a = 0; a < 4; ++a) {
    const Eigen::Vector3d X(x[3 * a], x[3 * a + 1], x[3 * a + 2]), u = F * X - X;
    for (std::size_t k = 0; k < 3; ++k)
      w[std::find(dofs.begin(), dofs.end(), _point_dofs[nodes[a]][k]) - dofs.begin()] = u[k];
  }
}

void Discretization::find_edge_patches() {
  std::vector<std::array<std::int32_t, 4>> nodes;
  std::vector<double> volumes;
  std::vector<Eigen::Matrix<double, 4, 3>> shape_gradients;
  for (int cell = 0; cell < _n_cells; ++cell) {
    nodes.push_back(cell_nodes(cell));
    volumes.push_back(cell_volume(cell));
    shape_gradients.push_back(cell_shape_gradients(cell));
  }
  _edge_patches = EdgePatches(nodes, volumes, shape_gradients, _point_dofs, _regions, _dolfinx->forms);
}

void Discretization::block_tangents(std::span<const double> state, Convexity convexity,
                                    const TangentVisitor& visit_sum) {
  std::vector<double> sum, convex_sum;
  const TangentVisitor add_extra_energy = [&](std::int32_t block, std::span<const double> exact,
                                              std::span<const double> near) {
    sum.assign(exact.begin(), exact.end());
    convex_sum.assign(near.begin(), near.end());
    _extra_energy->add_tangent(block, state, sum);
    if (!near.empty()) _extra_energy->add_tangent(block, state, convex_sum);
    visit_sum(block, sum, convex_sum);
  };
  const TangentVisitor& visit = _extra_energy ? add_extra_energy : visit_sum;
  const auto m = static_cast<Eigen::Index>(_n_element_dofs);
  const auto size = static_cast<std::size_t>(m * m);
  // Only the block of the displacements, which come first, is made convex. Without the shear energy the tangent of a
  // cell is indefinite, but the sum over cells is zero for constant pressure.
  const Eigen::Index n_u = m - static_cast<Eigen::Index>(n_pressures());
  const bool convex = convexity == Convexity::strictly || (convexity == Convexity::nearly && _edge_patches.size() == 0);
  Eigen::Matrix<double, 12, 12> linear;
  Eigen::MatrixXd quadratic, nearest;
  const auto visit_cell = [&](std::int32_t cell, std::span<const double> values) {
    if (!convex) return visit(cell, values, convexity == Convexity::none ? std::span<const double>{} : values);
    nearest = Eigen::Map<const Eigen::MatrixXd>(values.data(), m, m);
    if (n_u == 12) {
      linear = nearest.topLeftCorner<12, 12>();
      if (make_convex(linear, convexity)) nearest.topLeftCorner<12, 12>() = linear;
    } else {
      quadratic = nearest.topLeftCorner(n_u, n_u);
      if (make_convex(quadratic, convexity)) nearest.topLeftCorner(n_u, n_u) = quadratic;
    }
    visit(cell, values, {nearest.data(), size});
  };

  std::vector<double> values(size, 0.0);
  const auto integrate_cells = [&](const Kernel& kernel, const auto& take_values) {
    integrate(kernel, state, values, [&](int cell) {
      Eigen::Map<Eigen::MatrixXd> tangent(values.data(), m, m);
      if (region(cell) > 0) {
        tangent.bottomRows(m - n_u) *= pressure_unit(cell);
        tangent.rightCols(m - n_u) *= pressure_unit(cell);
      }
      take_values(cell);
      std::fill(values.begin(), values.end(), 0.0);
    });
  };
  const auto& passes = _dolfinx->passes;
  if (passes.size() == 1) {
    integrate_cells(passes.front().tangent, [&](int cell) { visit_cell(cell, values); });
  } else {
    std::vector<double> sums(size * static_cast<std::size_t>(_n_cells), 0.0);
    const auto sum_of = [&](int cell) { return sums.data() + size * static_cast<std::size_t>(cell); };
    for (const auto& pass : passes)
      integrate_cells(pass.tangent, [&](int cell) {
        for (std::size_t i = 0; i < size; ++i) sum_of(cell)[i] += values[i];
      });
    for (std::int32_t cell = 0; cell < _n_cells; ++cell) visit_cell(cell, {sum_of(cell), size});
  }
  std::vector<double> exact_edge, convex_edge;
  for (int e = 0; e < _edge_patches.size(); ++e) {
    _edge_patches.tangent(e, state, convexity, exact_edge, convex_edge);
    visit(_n_cells + e, exact_edge, convex_edge);
  }
}

}  // namespace phynness
