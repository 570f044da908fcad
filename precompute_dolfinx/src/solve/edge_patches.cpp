#include "edge_patches.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "../dolfinx_api.hpp"

namespace phynness {
namespace {

namespace api = dolfinx_api;

}  // namespace

EdgePatches::EdgePatches(const std::vector<std::array<std::int32_t, 4>>& cells, const std::vector<double>& volumes,
                         const std::vector<Eigen::Matrix<double, 4, 3>>& shape_gradients,
                         const std::vector<std::array<std::int32_t, 3>>& dofs, const std::vector<std::uint8_t>& regions,
                         const FormSet& forms)
    : _forms(forms.edges) {
  for (int r = 0; r < forms.n_regions(); ++r) {
    const auto c = forms.constants_in(r);
    _constants.push_back({api::packed_constants(*_forms.energy, c), api::packed_constants(*_forms.residual, c),
                          api::packed_constants(*_forms.tangent, c), api::packed_constants(*_forms.jacobian, c)});
  }
  std::map<std::tuple<std::int32_t, std::int32_t, std::uint8_t>, std::int32_t> edge_number;
  std::vector<std::map<std::int32_t, Eigen::Vector3d>>
      integrals;  // per edge and node: sum_c (V_c / 6) of the gradients
  for (std::size_t c = 0; c < cells.size(); ++c) {
    auto& edges = _cell_edges.emplace_back();
    for (std::size_t e = 0; e < 6; ++e) {
      const auto& [a, b] = api::edge_vertices(4)[e];
      const auto [low, high] = std::minmax(cells[c][a], cells[c][b]);
      const auto [entry, is_new] = edge_number.try_emplace({low, high, regions[c]}, size());
      if (is_new) {
        _region.push_back(regions[c]);
        _volume.push_back(0);
        integrals.emplace_back();
      }
      edges[e] = entry->second;
      _volume[edges[e]] += volumes[c] / 6;
      for (int k = 0; k < 4; ++k)
        integrals[edges[e]].try_emplace(cells[c][k], Eigen::Vector3d::Zero()).first->second +=
            volumes[c] / 6 * shape_gradients[c].row(k).transpose();
    }
  }
  for (int e = 0; e < size(); ++e) {
    for (int k = 0; k < 3; ++k)
      for (const auto& [node, integral] : integrals[e]) {
        _dofs.push_back(dofs[node][k]);
        _gradients.push_back(integral[k] / _volume[e]);
      }
    _start.push_back(_start.back() + integrals[e].size());
  }
}

double EdgePatches::energy_density(int edge, std::span<const double> state) const {
  const Gradient F = gradient(edge, state);
  double energy = 0;
  api::tabulate(*_forms.energy, {&energy, 1}, {F.data(), 9}, constants(edge).energy, unit_volume);
  return energy;
}

void EdgePatches::add_residual(std::span<const double> state, std::span<double> out) const {
  for (int edge = 0; edge < size(); ++edge) {
    const Gradient F = gradient(edge, state);
    Gradient P = Gradient::Zero();
    api::tabulate(*_forms.residual, {P.data(), 9}, {F.data(), 9}, constants(edge).residual, unit_volume);
    P *= _volume[edge];
    const auto [dofs, g] = gradient_operator(edge);
    for (int i = 0; i < 3; ++i)
      for (Eigen::Index a = 0; a < g.cols(); ++a)
        out[dofs(i, a)] += P(i, 0) * g(0, a) + P(i, 1) * g(1, a) + P(i, 2) * g(2, a);
  }
}

double EdgePatches::min_jacobian(std::span<const double> state) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (int edge = 0; edge < size(); ++edge) {
    const Gradient F = gradient(edge, state);
    double J = 0;
    api::tabulate(*_forms.jacobian, {&J, 1}, {F.data(), 9}, constants(edge).jacobian, unit_volume);
    smallest = std::isnan(J) ? -std::numeric_limits<double>::infinity() : std::min(smallest, J);
  }
  return smallest;
}

void EdgePatches::tangent(int edge, std::span<const double> state, Convexity convexity, std::vector<double>& exact,
                          std::vector<double>& convex) const {
  const Gradient F = gradient(edge, state);
  Tangent A = Tangent::Zero();
  api::tabulate(*_forms.tangent, {A.data(), 81}, {F.data(), 9}, constants(edge).tangent, unit_volume);
  A *= _volume[edge];
  to_nodes(edge, A, exact);
  if (convexity == Convexity::none) return;
  make_convex(A, convexity);
  to_nodes(edge, A, convex);
}

void EdgePatches::to_nodes(int edge, const Tangent& of_gradient, std::vector<double>& out) const {
  const auto g = gradient_operator(edge).shape_gradients;
  const Eigen::Index n = g.cols(), m = 3 * n;
  out.resize(static_cast<std::size_t>(m * m));
  const auto K = [&](int i, Eigen::Index a, int k, Eigen::Index b) -> double& {
    return out[static_cast<std::size_t>((i * n + a) * m + k * n + b)];
  };
  for (int i = 0; i < 3; ++i)
    for (int k = i; k < 3; ++k) {
      const Eigen::Matrix3d A = of_gradient.block<3, 3>(3 * i, 3 * k);
      for (Eigen::Index a = 0; a < n; ++a) {
        const Eigen::RowVector3d row = Eigen::RowVector3d(g(0, a), g(1, a), g(2, a)) * A;
        for (Eigen::Index b = 0; b < n; ++b) K(i, a, k, b) = row[0] * g(0, b) + row[1] * g(1, b) + row[2] * g(2, b);
        for (Eigen::Index b = 0; b < n && k > i; ++b) K(k, b, i, a) = K(i, a, k, b);
      }
    }
}

}  // namespace phynness
