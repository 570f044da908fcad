#include "relaxing_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "../dolfinx_api.hpp"

namespace phynness {
namespace {

namespace api = dolfinx_api;

/// The longest edge of a cell, squared: CellDiameter of the forms.
double squared_diameter(const Discretization& body, int cell) {
  double longest = 0;
  const auto nodes = body.cell_nodes(cell);
  for (const auto a : nodes)
    for (const auto b : nodes) longest = std::max(longest, (body.points().row(a) - body.points().row(b)).squaredNorm());
  return longest;
}

}  // namespace

bool has_relaxation(Element element) { return !element->is_shell && element->displacement_degree == 1; }

RelaxingBody::RelaxingBody(const Discretization& body, const Material& material, const Relaxation& relaxation)
    : _law(compiled_forms(material.law, element_named("es-p1-p1")).edges),
      _finite(!material.law->linear),
      _relaxation(relaxation) {
  for (int r = 0; r < body.forms().n_regions(); ++r) {
    auto c = body.forms().constants_in(r);
    c["cell_share"] = 0;  // the whole shape is a function of the gradient
    _constants.push_back({api::packed_constants(*_law.energy, c), api::packed_constants(*_law.residual, c),
                          api::packed_constants(*_law.tangent, c)});
  }
  const bool smoothed = body.edge_patches().size() > 0;
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    Block block;
    block.region = body.region(cell);
    block.weight = body.cell_volume(cell) * (smoothed ? cell_share : 1);
    const auto of_block = body.block_dofs(cell);
    const auto nodes = body.cell_nodes(cell);
    const auto slopes = body.cell_slopes(cell);
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 4; ++a) {
        const auto dof = body.dofs(nodes[static_cast<std::size_t>(a)])[static_cast<std::size_t>(k)];
        block.dofs.push_back(dof);
        block.at.push_back(static_cast<std::int32_t>(std::ranges::find(of_block, dof) - of_block.begin()));
        block.slopes.push_back(slopes(a, k));
      }
    _blocks.push_back(std::move(block));
  }
  for (int edge = 0; edge < body.edge_patches().size(); ++edge) {
    const auto dofs = body.edge_patches().dofs(edge);
    const auto slopes = body.edge_patches().slopes(edge);
    Block block;
    block.region = body.edge_patches().region(edge);
    block.weight = body.edge_patches().volume(edge) * (1 - cell_share);
    block.dofs.assign(dofs.begin(), dofs.end());
    block.slopes.assign(slopes.begin(), slopes.end());
    for (std::size_t i = 0; i < dofs.size(); ++i) block.at.push_back(static_cast<std::int32_t>(i));
    _blocks.push_back(std::move(block));
  }
  if (body.forms().element->mixed)  // p1-p1 and es-p1-p1, which are stabilized
    for (int cell = 0; cell < body.n_cells(); ++cell) {
      Stabilized of_cell;
      // Moduli are in units of that of the body, pressures in units of that of the region.
      const int region = body.region(cell);
      const double mu = region > 0 ? body.forms().regions[static_cast<std::size_t>(region) - 1].shear_modulus : 1;
      of_cell.weight = body.forms().constants.at("alpha") * squared_diameter(body, cell) * body.cell_volume(cell) * mu;
      std::ranges::copy(body.block_dofs(cell).last(4), of_cell.dofs.begin());
      of_cell.slopes = body.cell_slopes(cell);
      of_cell.history.assign(static_cast<std::size_t>(relaxation.terms.rows()), Eigen::Vector3d::Zero());
      _stabilized.push_back(std::move(of_cell));
    }
  for (auto& block : _blocks) block.history.assign(static_cast<std::size_t>(relaxation.terms.rows()), Tensor::Zero());
}

void RelaxingBody::begin_step(double dt_s) {
  _keep.clear();
  _gain.clear();
  _c = 1;
  for (const auto& term : _relaxation.terms.rowwise()) {
    const double x = dt_s / term[1];
    _keep.push_back(std::exp(-x));
    _gain.push_back(-term[0] * std::expm1(-x) / x);
    _c += _gain.back() - term[0];
  }
  for (auto& block : _blocks) {
    block.H.setZero();
    for (std::size_t i = 0; i < _keep.size(); ++i) block.H += _keep[i] * block.history[i] - _gain[i] * block.elastic;
  }
  for (auto& cell : _stabilized) {
    cell.H.setZero();
    for (std::size_t i = 0; i < _keep.size(); ++i) cell.H += _keep[i] * cell.history[i] - _gain[i] * cell.y;
  }
}

void RelaxingBody::end_step(std::span<const double> state) {
  for (auto& block : _blocks) {
    const Tensor F = gradient(block, state), P = shape_stress(block, F);
    Tensor S = P;
    if (_finite) S = F.inverse() * P;
    S = Tensor((S + S.transpose()) / 2);
    for (std::size_t i = 0; i < _keep.size(); ++i)
      block.history[i] = _keep[i] * block.history[i] + _gain[i] * (S - block.elastic);
    block.elastic = S;
  }
  for (auto& cell : _stabilized) {
    const Eigen::Vector3d y = (pressure_slope(cell, state) - cell.H) / _c;
    for (std::size_t i = 0; i < _keep.size(); ++i)
      cell.history[i] = _keep[i] * cell.history[i] + _gain[i] * (y - cell.y);
    cell.y = y;
  }
}

Eigen::Vector3d RelaxingBody::pressure_slope(const Stabilized& cell, std::span<const double> state) {
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    slope += state[static_cast<std::size_t>(cell.dofs[a])] * cell.slopes.row(static_cast<Eigen::Index>(a)).transpose();
  return slope;
}

std::array<RelaxingBody::Term, 2> RelaxingBody::terms_of(std::size_t cell, const Tensor& F,
                                                         std::span<const double> state) const {
  const auto& of_cell = _stabilized[cell];
  const Eigen::Vector3d slope = pressure_slope(of_cell, state);
  std::array<Term, 2> terms;
  for (Term& term : terms) {
    const bool relaxes = &term == &terms[0];
    term.k = relaxes ? of_cell.weight / _c : -of_cell.weight;
    term.inverse.setIdentity();
    if (_finite) term.inverse = F.inverse();
    term.g = term.inverse.transpose() * (relaxes ? Eigen::Vector3d(slope - of_cell.H) : slope);
    term.m = term.inverse * term.g;
  }
  return terms;
}

RelaxingBody::Tensor RelaxingBody::gradient(const Block& block, std::span<const double> state) const {
  const std::size_t n = block.dofs.size() / 3;
  Tensor F = Tensor::Identity();
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t j = 0; j < 3; ++j)
        F(static_cast<int>(i), static_cast<int>(j)) +=
            state[static_cast<std::size_t>(block.dofs[i * n + a])] * block.slopes[j * n + a];
  return F;
}

RelaxingBody::Tensor RelaxingBody::shape_stress(const Block& block, const Tensor& F) const {
  Tensor P = Tensor::Zero();
  api::tabulate(*_law.residual, {P.data(), 9}, {F.data(), 9},
                _constants[static_cast<std::size_t>(block.region)].residual, unit_volume);
  return P;
}

// The forms of the body have shape once, so that c - 1 is added.

double RelaxingBody::energy(std::span<const double> state) const {
  double sum = 0;
  for (const auto& block : _blocks) {
    const Tensor F = gradient(block, state);
    double shape = 0;
    api::tabulate(*_law.energy, {&shape, 1}, {F.data(), 9}, _constants[static_cast<std::size_t>(block.region)].energy,
                  unit_volume);
    const Tensor strain =
        _finite ? Tensor((F.transpose() * F - Tensor::Identity()) / 2) : Tensor(F - Tensor::Identity());
    sum += block.weight * ((_c - 1) * shape + block.H.cwiseProduct(strain).sum());
  }
  for (std::size_t cell = 0; cell < _stabilized.size(); ++cell)
    for (const Term& term : terms_of(cell, gradient(_blocks[cell], state), state))
      sum -= term.k / 2 * term.g.squaredNorm();
  return sum;
}

void RelaxingBody::add_residual(std::span<const double> state, std::span<double> out) const {
  for (const auto& block : _blocks) {
    const Tensor F = gradient(block, state);
    Tensor P = (_c - 1) * shape_stress(block, F);
    if (_finite)
      P += F * block.H;
    else
      P += block.H;
    P *= block.weight;
    const std::size_t n = block.dofs.size() / 3;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t j = 0; j < 3; ++j)
          out[static_cast<std::size_t>(block.dofs[i * n + a])] +=
              P(static_cast<int>(i), static_cast<int>(j)) * block.slopes[j * n + a];
  }
  for (std::size_t cell = 0; cell < _stabilized.size(); ++cell)
    for (const Term& term : terms_of(cell, gradient(_blocks[cell], state), state)) {
      const Eigen::Vector4d of_pressures = term.k * (_stabilized[cell].slopes * term.m);
      const Eigen::Matrix<double, 3, 4> of_nodes = term.k * term.g * (_stabilized[cell].slopes * term.m).transpose();
      for (int a = 0; a < 4; ++a) {
        out[static_cast<std::size_t>(_stabilized[cell].dofs[static_cast<std::size_t>(a)])] -= of_pressures[a];
        for (int i = 0; i < 3 && _finite; ++i)
          out[static_cast<std::size_t>(_blocks[cell].dofs[4 * i + a])] += of_nodes(i, a);
      }
    }
}

void RelaxingBody::add_tangent(std::int32_t number, std::span<const double> state, std::span<double> tangent) const {
  const Block& block = _blocks[static_cast<std::size_t>(number)];
  const Tensor F = gradient(block, state);
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> A = A.Zero();
  api::tabulate(*_law.tangent, {A.data(), 81}, {F.data(), 9},
                _constants[static_cast<std::size_t>(block.region)].tangent, unit_volume);
  A *= _c - 1;
  for (int i = 0; i < 3 && _finite; ++i) A.block<3, 3>(3 * i, 3 * i) += block.H;
  A *= block.weight;
  const auto n = static_cast<Eigen::Index>(block.dofs.size() / 3);
  const auto size = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(tangent.size()))));
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> slopes(block.slopes.data(), 3, n);
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> K(tangent.data(), size, size);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Eigen::MatrixXd of_nodes = slopes.transpose() * A.block<3, 3>(3 * i, 3 * k) * slopes;
      for (Eigen::Index a = 0; a < n; ++a)
        for (Eigen::Index b = 0; b < n; ++b)
          K(block.at[static_cast<std::size_t>(i * n + a)], block.at[static_cast<std::size_t>(k * n + b)]) +=
              of_nodes(a, b);
    }
  if (static_cast<std::size_t>(number) >= _stabilized.size()) return;
  const auto& cell = _stabilized[static_cast<std::size_t>(number)];
  const auto at = [&](int i, int a) { return block.at[4 * i + a]; };
  for (const Term& term : terms_of(static_cast<std::size_t>(number), F, state)) {
    const Eigen::Matrix<double, 4, 3> inward = cell.slopes * term.inverse;  // rows: F^-T times the slopes
    const Eigen::Vector4d along = cell.slopes * term.m;
    const Eigen::Matrix4d squares = inward * inward.transpose();
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        K(12 + a, 12 + b) -= term.k * squares(a, b);
        for (int i = 0; i < 3 && _finite; ++i) {
          const double mixed = term.k * (inward(b, i) * along[a] + term.g[i] * squares(a, b));
          K(at(i, a), 12 + b) += mixed;
          K(12 + b, at(i, a)) += mixed;
          for (int k = 0; k < 3; ++k)
            K(at(i, a), at(k, b)) -=
                term.k * (inward(b, i) * term.g[k] * along[a] + term.g[i] * inward(a, k) * along[b] +
                          term.g[i] * term.g[k] * squares(a, b));
        }
      }
  }
}

}  // namespace phynness
