#include "relaxing_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

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
    c["cell_share"] = 0;  // shape is a function of the gradient only
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
    const auto shape_gradients = body.cell_shape_gradients(cell);
    block.dofs.resize(3, 4);
    block.positions.resize(3, 4);
    block.shape_gradients = shape_gradients.transpose();
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 4; ++a) {
        block.dofs(k, a) = body.dofs(nodes[static_cast<std::size_t>(a)])[static_cast<std::size_t>(k)];
        block.positions(k, a) =
            static_cast<std::int32_t>(std::ranges::find(of_block, block.dofs(k, a)) - of_block.begin());
      }
    _blocks.push_back(std::move(block));
  }
  for (int edge = 0; edge < body.edge_patches().size(); ++edge) {
    const auto [dofs, shape_gradients] = body.edge_patches().gradient_operator(edge);
    Block block;
    block.region = body.edge_patches().region(edge);
    block.weight = body.edge_patches().volume(edge) * (1 - cell_share);
    block.dofs = dofs;
    block.shape_gradients = shape_gradients;
    block.positions.resize(3, dofs.cols());
    std::iota(block.positions.data(), block.positions.data() + block.positions.size(), 0);
    _blocks.push_back(std::move(block));
  }
  if (body.forms().element->mixed)  // p1-p1 and es-p1-p1, which are stabilized
    for (int cell = 0; cell < body.n_cells(); ++cell) {
      Stabilized stabilized;
      // Moduli have the unit of that of the body, and pressures of that of their region.
      const int region = body.region(cell);
      const double mu = region > 0 ? body.forms().regions[static_cast<std::size_t>(region) - 1].shear_modulus : 1;
      stabilized.weight =
          body.forms().constants.at("alpha") * squared_diameter(body, cell) * body.cell_volume(cell) * mu;
      std::ranges::copy(body.block_dofs(cell).last(4), stabilized.dofs.begin());
      stabilized.shape_gradients = body.cell_shape_gradients(cell);
      stabilized.history.assign(static_cast<std::size_t>(relaxation.terms.rows()), Eigen::Vector3d::Zero());
      _stabilized.push_back(std::move(stabilized));
    }
  for (auto& block : _blocks) block.history.assign(static_cast<std::size_t>(relaxation.terms.rows()), Tensor::Zero());
}

void RelaxingBody::begin_step(double dt_s) {
  _decay.clear();
  _stress_factor.clear();
  _elastic_factor = 1;
  for (const auto& term : _relaxation.terms.rowwise()) {
    const double x = dt_s / term[1];
    _decay.push_back(std::exp(-x));
    _stress_factor.push_back(-term[0] * std::expm1(-x) / x);
    _elastic_factor += _stress_factor.back() - term[0];
  }
  for (auto& block : _blocks) {
    block.stress_offset.setZero();
    for (std::size_t i = 0; i < _decay.size(); ++i)
      block.stress_offset += _decay[i] * block.history[i] - _stress_factor[i] * block.elastic;
  }
  for (auto& cell : _stabilized) {
    cell.gradient_offset.setZero();
    for (std::size_t i = 0; i < _decay.size(); ++i)
      cell.gradient_offset += _decay[i] * cell.history[i] - _stress_factor[i] * cell.elastic_gradient;
  }
}

void RelaxingBody::end_step(std::span<const double> state) {
  for (auto& block : _blocks) {
    const Tensor F = gradient(block, state), P = shape_stress(block, F);
    Tensor S = P;
    if (_finite) S = F.inverse() * P;
    S = Tensor((S + S.transpose()) / 2);
    for (std::size_t i = 0; i < _decay.size(); ++i)
      block.history[i] = _decay[i] * block.history[i] + _stress_factor[i] * (S - block.elastic);
    block.elastic = S;
  }
  for (auto& cell : _stabilized) {
    const Eigen::Vector3d y = (pressure_gradient(cell, state) - cell.gradient_offset) / _elastic_factor;
    for (std::size_t i = 0; i < _decay.size(); ++i)
      cell.history[i] = _decay[i] * cell.history[i] + _stress_factor[i] * (y - cell.elastic_gradient);
    cell.elastic_gradient = y;
  }
}

Eigen::Vector3d RelaxingBody::pressure_gradient(const Stabilized& cell, std::span<const double> state) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    gradient += state[static_cast<std::size_t>(cell.dofs[a])] *
                cell.shape_gradients.row(static_cast<Eigen::Index>(a)).transpose();
  return gradient;
}

std::array<RelaxingBody::StabilizationTerm, 2> RelaxingBody::terms_of(std::size_t cell, const Tensor& F,
                                                                      std::span<const double> state) const {
  const auto& stabilized = _stabilized[cell];
  const Eigen::Vector3d gradient = pressure_gradient(stabilized, state);
  std::array<StabilizationTerm, 2> terms;
  for (StabilizationTerm& term : terms) {
    const bool is_relaxing = &term == &terms[0];
    term.k = is_relaxing ? stabilized.weight / _elastic_factor : -stabilized.weight;
    term.inverse.setIdentity();
    if (_finite) term.inverse = F.inverse();
    term.g =
        term.inverse.transpose() * (is_relaxing ? Eigen::Vector3d(gradient - stabilized.gradient_offset) : gradient);
    term.m = term.inverse * term.g;
  }
  return terms;
}

RelaxingBody::Tensor RelaxingBody::gradient(const Block& block, std::span<const double> state) const {
  const auto n = block.dofs.cols();
  return GradientOperator{{block.dofs.data(), 3, n}, {block.shape_gradients.data(), 3, n}}.deformation_gradient(state);
}

RelaxingBody::Tensor RelaxingBody::shape_stress(const Block& block, const Tensor& F) const {
  Tensor P = Tensor::Zero();
  api::tabulate(*_law.residual, {P.data(), 9}, {F.data(), 9},
                _constants[static_cast<std::size_t>(block.region)].residual, unit_volume);
  return P;
}

// The factor is c - 1, because the forms of the body contain shape once.

double RelaxingBody::energy(std::span<const double> state) const {
  double sum = 0;
  for (const auto& block : _blocks) {
    const Tensor F = gradient(block, state);
    double shape = 0;
    api::tabulate(*_law.energy, {&shape, 1}, {F.data(), 9}, _constants[static_cast<std::size_t>(block.region)].energy,
                  unit_volume);
    const Tensor strain =
        _finite ? Tensor((F.transpose() * F - Tensor::Identity()) / 2) : Tensor(F - Tensor::Identity());
    sum += block.weight * ((_elastic_factor - 1) * shape + block.stress_offset.cwiseProduct(strain).sum());
  }
  for (std::size_t cell = 0; cell < _stabilized.size(); ++cell)
    for (const StabilizationTerm& term : terms_of(cell, gradient(_blocks[cell], state), state))
      sum -= term.k / 2 * term.g.squaredNorm();
  return sum;
}

void RelaxingBody::add_residual(std::span<const double> state, std::span<double> out) const {
  for (const auto& block : _blocks) {
    const Tensor F = gradient(block, state);
    Tensor P = (_elastic_factor - 1) * shape_stress(block, F);
    if (_finite)
      P += F * block.stress_offset;
    else
      P += block.stress_offset;
    P *= block.weight;
    for (int i = 0; i < 3; ++i)
      for (Eigen::Index a = 0; a < block.dofs.cols(); ++a)
        for (int j = 0; j < 3; ++j) out[block.dofs(i, a)] += P(i, j) * block.shape_gradients(j, a);
  }
  for (std::size_t cell = 0; cell < _stabilized.size(); ++cell)
    for (const StabilizationTerm& term : terms_of(cell, gradient(_blocks[cell], state), state)) {
      const Eigen::Vector4d of_pressures = term.k * (_stabilized[cell].shape_gradients * term.m);
      const Eigen::Matrix<double, 3, 4> of_nodes =
          term.k * term.g * (_stabilized[cell].shape_gradients * term.m).transpose();
      for (int a = 0; a < 4; ++a) {
        out[_stabilized[cell].dofs[a]] -= of_pressures[a];
        for (int i = 0; i < 3 && _finite; ++i) out[_blocks[cell].dofs(i, a)] += of_nodes(i, a);
      }
    }
}

void RelaxingBody::add_tangent(std::int32_t number, std::span<const double> state, std::span<double> tangent) const {
  const Block& block = _blocks[static_cast<std::size_t>(number)];
  const Tensor F = gradient(block, state);
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> A = A.Zero();
  api::tabulate(*_law.tangent, {A.data(), 81}, {F.data(), 9},
                _constants[static_cast<std::size_t>(block.region)].tangent, unit_volume);
  A *= _elastic_factor - 1;
  for (int i = 0; i < 3 && _finite; ++i) A.block<3, 3>(3 * i, 3 * i) += block.stress_offset;
  A *= block.weight;
  const auto size = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(tangent.size()))));
  const auto& g = block.shape_gradients;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> K(tangent.data(), size, size);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Eigen::MatrixXd of_nodes = g.transpose() * A.block<3, 3>(3 * i, 3 * k) * g;
      for (Eigen::Index a = 0; a < g.cols(); ++a)
        for (Eigen::Index b = 0; b < g.cols(); ++b) K(block.positions(i, a), block.positions(k, b)) += of_nodes(a, b);
    }
  if (static_cast<std::size_t>(number) >= _stabilized.size()) return;
  const auto& cell = _stabilized[static_cast<std::size_t>(number)];
  for (const StabilizationTerm& term : terms_of(static_cast<std::size_t>(number), F, state)) {
    const Eigen::Matrix<double, 4, 3> spatial_gradients =
        cell.shape_gradients * term.inverse;  // rows: F^-T times the shape gradients
    const Eigen::Vector4d along = cell.shape_gradients * term.m;
    const Eigen::Matrix4d gradient_products = spatial_gradients * spatial_gradients.transpose();
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        K(12 + a, 12 + b) -= term.k * gradient_products(a, b);
        for (int i = 0; i < 3 && _finite; ++i) {
          const double coupling = term.k * (spatial_gradients(b, i) * along[a] + term.g[i] * gradient_products(a, b));
          K(block.positions(i, a), 12 + b) += coupling;
          K(12 + b, block.positions(i, a)) += coupling;
          for (int k = 0; k < 3; ++k)
            K(block.positions(i, a), block.positions(k, b)) -=
                term.k *
                (spatial_gradients(b, i) * term.g[k] * along[a] + term.g[i] * spatial_gradients(a, k) * along[b] +
                 term.g[i] * term.g[k] * gradient_products(a, b));
        }
      }
  }
}

}  // namespace phynness
