#include "node_networks.hpp"

#include <cmath>
#include <phynness/training/network_fit.hpp>
#include <random>

#include "errors.hpp"
#include "field_network.hpp"

namespace phynness::study {
namespace {

double norm(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

Eigen::Vector3d said_at(const RbfNetwork& network, const NetworkPoints& points, std::size_t p) {
  Eigen::VectorXd inputs(points.n_inputs());
  inputs.head(3) = points.displacements.row(points.displacement[p]);
  if (!points.place.empty()) inputs.tail(3) = points.places.row(points.place[p]);
  return evaluate(network, inputs);
}

/// The paper's test: points that were not used in training.
Errors on_points(const RbfNetwork& network, const NetworkPoints& points) {
  Errors errors;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d truth = points.outputs.row(static_cast<Eigen::Index>(p));
    errors.add((said_at(network, points, p) - truth).norm(), truth.norm());
  }
  return errors;
}

/// New solves at all output nodes that the tool does not hold. @param group  0: inside, 1: outside of the trained range
Errors on_fresh_fields(const FieldNetwork& network, const NodeProbes& probes, std::size_t group) {
  Errors errors;
  for (const auto& state : probes.states[group]) {
    const Points said = network.field(state.d);
    for (Eigen::Index i = 0; i < said.rows(); ++i)
      if (probes.counts[static_cast<std::size_t>(i)])
        errors.add((said.row(i) - state.u_FE.row(i)).norm(), state.u_FE.row(i).norm());
  }
  return errors;
}

Errors on_fresh_forces(const RbfNetwork& network, const NodeProbes& probes, std::size_t group) {
  Errors errors;
  for (const auto& state : probes.states[group]) {
    const Eigen::Vector3d said = evaluate(network, Eigen::Vector3d(state.d[0], state.d[1], state.d[2]));
    const Eigen::Vector3d truth(state.force_FE[0], state.force_FE[1], state.force_FE[2]);
    errors.add((said - truth).norm(), norm(state.force_FE));
  }
  return errors;
}

NetworkErrors row_of(double x, const NetworkFit& fit, const Errors& held, const Errors& fresh, const Errors& beyond) {
  return {x,
          static_cast<int>(fit.centers.size()),
          held.mean(),
          held.max(),
          fresh.mean(),
          fresh.max(),
          beyond.mean(),
          beyond.max()};
}

/// A deformation network with its errors.
struct MeasuredField {
  NetworkErrors errors;
  Histogram held, fresh;
};
MeasuredField measured(const NodeUnderStudy& node, const NetworkPoints& train, const NetworkPoints& held_out, double x,
                       int neurons, double spread) {
  const NetworkFit fit = fit_network(train, {neurons, spread});
  const FieldNetwork network(fit.network, node.data.tables().output_points);
  const Errors held = on_points(fit.network, held_out), fresh = on_fresh_fields(network, node.probes, 0),
               beyond = on_fresh_fields(network, node.probes, 1);
  return {row_of(x, fit, held, fresh, beyond), held.histogram(), fresh.histogram()};
}

NetworkPoints part_of(const NetworkPoints& points, std::size_t first, std::size_t count,
                      const std::vector<std::size_t>& order) {
  NetworkPoints part;
  part.displacements = points.displacements;
  part.outputs.resize(static_cast<Eigen::Index>(count), 3);
  for (std::size_t i = 0; i < count; ++i) {
    const auto p = order[first + i];
    part.displacement.push_back(points.displacement[p]);
    part.outputs.row(static_cast<Eigen::Index>(i)) = points.outputs.row(static_cast<Eigen::Index>(p));
  }
  return part;
}

}  // namespace

void measure_deformation(const NodeUnderStudy& node, const StudySizes& sizes, NodeMeasurements& out) {
  const auto points = [&](int samples, NetworkPoints& held_out) {
    return deformation_points(node.data.tables(), node.rays, node.touched, out.node, samples, sizes.seed, &held_out,
                              sizes.test_pairs);
  };
  NetworkPoints held_out;
  const NetworkPoints train = points(sizes.training_pairs, held_out);
  for (const int neurons : sizes.neurons)
    out.by_neurons.push_back(measured(node, train, held_out, neurons, neurons, node.deformation_spread).errors);
  for (const int neurons : sizes.histogram_neurons) {
    const auto m = measured(node, train, held_out, neurons, neurons, node.deformation_spread);
    out.histograms.push_back({neurons, m.held, m.fresh});
  }
  for (const double spread : sizes.spreads)
    out.by_spread.push_back(measured(node, train, held_out, spread, sizes.study_neurons, spread).errors);
  for (const int samples : sizes.samples) {
    NetworkPoints others;
    const NetworkPoints some = points(samples, others);
    if (static_cast<int>(some.size()) < samples || others.size() == 0) continue;  // the database has no more points
    out.by_samples.push_back(
        measured(node, some, others, samples, sizes.study_neurons, node.deformation_spread).errors);
  }
}

NetworkFit fit_force(const NodeUnderStudy& node, int neurons) {
  const NetworkPoints points = force_points(node.data.tables(), node.rays);
  return fit_network(points, {std::min(neurons, static_cast<int>(points.size()) - 1), node.force_spread});
}

void measure_forces(const NodeUnderStudy& node, const StudySizes& sizes, NodeMeasurements& out) {
  const NetworkPoints all = force_points(node.data.tables(), node.rays);
  std::vector<std::size_t> order(all.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 random(sizes.seed + static_cast<std::uint64_t>(out.node));
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[static_cast<std::size_t>(uniform(random) * static_cast<double>(i))]);
  // Databases with fewer increments are divided in the proportion of the paper.
  const auto wanted = static_cast<double>(sizes.force_training_pairs + sizes.force_test_pairs);
  const double scale = std::min(1.0, static_cast<double>(all.size()) / wanted);
  const auto n_train = static_cast<std::size_t>(scale * sizes.force_training_pairs),
             n_test = static_cast<std::size_t>(scale * sizes.force_test_pairs);
  if (n_train < 2 || n_test < 1) return;
  const NetworkPoints train = part_of(all, 0, n_train, order), test = part_of(all, n_train, n_test, order);
  for (const int neurons : sizes.force_neurons) {
    const auto row = [&](const NetworkFit& fit, const Errors& held) {
      return row_of(neurons, fit, held, on_fresh_forces(fit.network, node.probes, 0),
                    on_fresh_forces(fit.network, node.probes, 1));
    };
    if (neurons < static_cast<int>(n_train)) {
      const NetworkFit fit = fit_network(train, {neurons, node.force_spread});
      out.force_as_paper.push_back(row(fit, on_points(fit.network, test)));
    }
    if (neurons < static_cast<int>(all.size())) out.force_all.push_back(row(fit_force(node, neurons), {}));
  }
}

}  // namespace phynness::study
