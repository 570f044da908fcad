#include "elements.hpp"

#include <Eigen/LU>
#include <cassert>
#include <cmath>
#include <map>
#include <phynness/schema/body_laws.hpp>
#include <tuple>
#include <utility>

namespace phynness::reduced {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Entries = std::vector<Eigen::Triplet<double>>;

const runtime::BodyLaw& law_of(const Elements& elements) {
  const auto* law = runtime::find_body_law(name(elements.law));
  assert(law);  // the build makes all of them from the same files
  return *law;
}

Sparse sparse_matrix(Index rows, Index cols, const Entries& entries) {
  Sparse matrix(rows, cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// n x n_points: picks some points.
Sparse selection_matrix(const std::vector<std::int32_t>& points, Index n_points) {
  Entries entries;
  for (std::size_t i = 0; i < points.size(); ++i) entries.emplace_back(static_cast<int>(i), points[i], 1.0);
  return sparse_matrix(static_cast<Index>(points.size()), n_points, entries);
}

}  // namespace

Elements::Elements(const Mesh& mesh, const Scene& scene)
    : n_nodes(mesh.n_nodes()), n_cells(mesh.n_cells()), law(scene.material.law) {
  const bool is_smoothed = scene.solver.element == element_named("es-p1-p1");
  const double alpha = is_smoothed ? smoothed_alpha : stabilization_alpha;
  std::vector<double> kappas, moduli;
  for (const Material* material : materials(scene)) {
    moduli.push_back(material->shear_modulus_Pa);
    kappas.push_back(law->isochoric ? material->bulk_modulus_Pa : material->lame_lambda_Pa);
    parts.push_back({material->parameters, is_smoothed && law->isochoric ? 2 * moduli.back() / 3 : 0});
  }
  part_of = mesh.regions;
  part_of.resize(static_cast<std::size_t>(n_cells), 0);
  // The first part that a node belongs to has its pressure; others have further ones.
  std::vector<int> first(static_cast<std::size_t>(n_nodes), -1);
  std::map<std::pair<std::int32_t, int>, int> further;
  const auto pressure_at = [&](std::int32_t node, int part) {
    int& own = first[static_cast<std::size_t>(node)];
    if (own < 0) own = part;
    if (own == part) return static_cast<int>(node);
    return further.try_emplace({node, part}, static_cast<int>(n_nodes) + static_cast<int>(further.size()))
        .first->second;
  };

  VectorXd volume(n_cells);
  std::array<Entries, 3> derivative_entries;
  Entries pressure_entries, stiffness, soft, shares;
  std::map<std::tuple<std::int32_t, std::int32_t, int>, int> edges;
  VectorXd bulk_share(n_cells);
  std::vector<double> size_of_edge;
  for (int c = 0; c < static_cast<int>(n_cells); ++c) {
    const int part = part_of[static_cast<std::size_t>(c)];
    const double kappa = kappas[static_cast<std::size_t>(part)], mu = moduli[static_cast<std::size_t>(part)];
    bulk_share[c] = 1 - parts[static_cast<std::size_t>(part)].bulk_in_shape_Pa / kappa;
    std::array<int, 4> pressures;
    for (int a = 0; a < 4; ++a) pressures[static_cast<std::size_t>(a)] = pressure_at(mesh.cells(c, a), part);
    Eigen::Matrix<double, 4, 3> x, shape_gradients;
    for (int a = 0; a < 4; ++a) x.row(a) = mesh.nodes.row(mesh.cells(c, a));
    const Eigen::Matrix3d sides = x.bottomRows<3>().rowwise() - x.row(0);
    volume[c] = std::abs(sides.determinant()) / 6;
    shape_gradients.bottomRows<3>() = sides.inverse().transpose();
    shape_gradients.row(0) = -shape_gradients.bottomRows<3>().colwise().sum();
    double longest2 = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) {
        longest2 = std::max(longest2, (x.row(a) - x.row(b)).squaredNorm());
        if (!is_smoothed) continue;
        const auto [low, high] = std::minmax(mesh.cells(c, a), mesh.cells(c, b));
        const auto [edge, is_new] = edges.try_emplace({low, high, part}, static_cast<int>(edges.size()));
        if (is_new) size_of_edge.push_back(0), part_of.push_back(static_cast<std::uint8_t>(part));
        size_of_edge[static_cast<std::size_t>(edge->second)] += volume[c] / 6;
        shares.emplace_back(edge->second, c, volume[c] / 6);
      }
    for (int a = 0; a < 4; ++a) {
      const int node = mesh.cells(c, a);
      for (int j = 0; j < 3; ++j)
        derivative_entries[static_cast<std::size_t>(j)].emplace_back(c, node, shape_gradients(a, j));
      pressure_entries.emplace_back(c, pressures[static_cast<std::size_t>(a)], 0.25);
      for (int b = 0; b < 4; ++b) {
        const double dots = volume[c] * shape_gradients.row(a).dot(shape_gradients.row(b));
        stiffness.emplace_back(node, mesh.cells(c, b), dots);
        soft.emplace_back(pressures[static_cast<std::size_t>(a)], pressures[static_cast<std::size_t>(b)],
                          bulk_share[c] / kappa * volume[c] * (a == b ? 2 : 1) / 20 + alpha * longest2 / mu * dots);
      }
    }
  }
  const auto n_edges = static_cast<Index>(size_of_edge.size());
  n_points = n_cells + n_edges;
  const Eigen::Map<const VectorXd> of_edges(size_of_edge.data(), n_edges);
  shear.resize(n_points);
  shear << (is_smoothed ? cell_share : 1) * volume, (1 - cell_share) * of_edges;
  bulk.resize(n_points);
  bulk << bulk_share.cwiseProduct(volume), VectorXd::Zero(n_edges);
  // Cells, then means of the cells at each edge.
  Entries means;
  for (int c = 0; c < static_cast<int>(n_cells); ++c) means.emplace_back(c, c, 1.0);
  for (const auto& s : shares)
    means.emplace_back(static_cast<int>(n_cells) + s.row(), s.col(), s.value() / of_edges[s.row()]);
  const Sparse mean = sparse_matrix(n_points, n_cells, means);
  for (std::size_t j = 0; j < 3; ++j) derivative[j] = mean * sparse_matrix(n_cells, n_nodes, derivative_entries[j]);
  const Index n_pressures = n_nodes + std::ssize(further);
  pressure_values = sparse_matrix(n_points, n_pressures, pressure_entries);
  laplace = sparse_matrix(n_nodes, n_nodes, stiffness);
  compressibility = sparse_matrix(n_pressures, n_pressures, soft);
}

std::array<Sparse, 3> Elements::derivative_at(const std::vector<std::int32_t>& points) const {
  const Sparse rows = selection_matrix(points, n_points);
  return {Sparse(rows * derivative[0]), Sparse(rows * derivative[1]), Sparse(rows * derivative[2])};
}

Sparse Elements::pressure_values_at(const std::vector<std::int32_t>& points) const {
  return selection_matrix(points, n_points) * pressure_values;
}

MatrixXd Elements::laplace_of(const MatrixXd& fields) const {
  const Eigen::Map<const MatrixXd> components(fields.data(), n_nodes, 3 * fields.cols());
  return product(laplace, components).reshaped(fields.rows(), fields.cols());
}

std::array<MatrixXd, 9> gradients(const std::array<Sparse, 3>& derivative, const MatrixXd& fields) {
  const Index n = derivative[0].cols();
  std::array<MatrixXd, 9> out;
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < 3; ++j)
      out[static_cast<std::size_t>(3 * i + j)] =
          product(derivative[static_cast<std::size_t>(j)], fields.middleRows(i * n, n));
  return out;
}

std::optional<EnergyDensities> energy_densities(const Elements& elements, const VectorXd& u) {
  const runtime::BodyLaw& law = law_of(elements);
  const Index n = elements.n_points;
  AtPoints F(9, n);
  const auto gradient = gradients(elements.derivative, u);
  for (Index k = 0; k < 9; ++k) F.row(k) = gradient[static_cast<std::size_t>(k)].transpose().array() + (k % 4 == 0);
  EnergyDensities out{VectorXd(n), VectorXd(n), AtPoints(9, n), AtPoints(9, n)};
  for (Index p = 0; p < n; ++p) {
    const Elements::Part& part = elements.parts[elements.part_of[static_cast<std::size_t>(p)]];
    const double *parameters = part.parameters.data(), bulk = part.bulk_in_shape_Pa;
    if (!law.shape(F.col(p).data(), parameters, out.shape[p], out.shape_first.col(p).data(), nullptr) ||
        !law.volumetric(F.col(p).data(), parameters, out.g[p], out.g_first.col(p).data(), nullptr))
      return std::nullopt;
    out.shape[p] += bulk / 2 * out.g[p] * out.g[p];
    out.shape_first.col(p) += bulk * out.g[p] * out.g_first.col(p);
  }
  return out;
}

std::vector<RestDerivatives> derivatives_at_rest(const Elements& elements) {
  const runtime::BodyLaw& law = law_of(elements);
  const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<RestDerivatives> all;
  for (const auto& [parameters, bulk_Pa] : elements.parts) {
    RestDerivatives& rest = all.emplace_back();
    double value = 0, first[9];
    law.shape(F, parameters.data(), value, first, rest.shape.data());
    law.volumetric(F, parameters.data(), value, rest.g.data(), nullptr);
    rest.shape += bulk_Pa * rest.g * rest.g.transpose();
  }
  return all;
}

}  // namespace phynness::reduced
