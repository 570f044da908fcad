// A model in the runtime's hands and the times of its calls, beside those of plain loops.
#pragma once

#include <array>
#include <phynness/phynness.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "liver_sized_model.hpp"
#include "median_time.hpp"
#include "plain_runtime.hpp"

namespace phynness::bench {

inline void check(rt::Status status) {
  if (!status.ok()) throw std::runtime_error(status.message());
}

/// Results go here, so that somebody reads them.
inline volatile double sink = 0;

/// As a hand moves: another displacement for each call, within 15 mm.
inline void displacement(int i, double* d) {
  for (int k = 0; k < 3; ++k) d[k] = 0.0003 * ((i * (k + 3)) % 50);
}

struct TimedModel {
  explicit TimedModel(const std::string& text) : model(text), data(model, 1) {
    check(model.status());
    check(data.status());
    field.resize(3 * static_cast<std::size_t>(model.n_output()));
  }

  std::int32_t node(int i) const {
    const auto nodes = model.active_nodes();
    return nodes[static_cast<std::size_t>(i) % nodes.size()];
  }
  void deform(std::int32_t touched, rt::In3 d) { data.deform(touched, d, field).ignore(); }
  /// All active nodes in turn.
  double force_us() {
    return median_us([&](int i) {
      double d[3], f[3];
      displacement(i, d);
      data.force(node(i), d, f).ignore();
      sink = f[0];
    });
  }
  double deformation_us(std::int32_t touched) {
    return median_us([&](int i) {
      double d[3];
      displacement(i, d);
      deform(touched, d);
      sink = field[0];
    });
  }

  rt::Model model;
  rt::Data data;
  std::vector<double> field;
};

template <int N, class Real = double>
PlainNetwork<N, Real> plain_network(int n_neurons) {
  Arbitrary arbitrary;
  PlainNetwork<N, Real> net;
  net.neurons.resize(static_cast<std::size_t>(n_neurons));
  net.spread = static_cast<Real>(1.4);
  for (auto& neuron : net.neurons) {
    for (Real& c : neuron.center) c = static_cast<Real>(arbitrary.number());
    for (Real& w : neuron.weight) w = static_cast<Real>(arbitrary.number());
  }
  return net;
}

template <class Real = double>
double plain_force_us(int n_neurons) {
  const auto net = plain_network<3, Real>(n_neurons);
  return median_us([&](int i) {
    double d[3];
    Real f[3];
    displacement(i, d);
    const Real at[3] = {static_cast<Real>(d[0]), static_cast<Real>(d[1]), static_cast<Real>(d[2])};
    plain_force(net, at, f);
    sink = static_cast<double>(f[0]);
  });
}

inline double plain_deformation_us(int n_neurons, std::size_t n_points) {
  const auto net = plain_network<6>(n_neurons);
  Arbitrary arbitrary;
  std::vector<std::array<double, 3>> points(n_points);
  for (auto& point : points) point = {arbitrary.number(), arbitrary.number(), arbitrary.number()};
  std::vector<double> field(3 * n_points);
  return median_us([&](int i) {
    double d[3];
    displacement(i, d);
    plain_deformation(net, points, d, field.data());
    sink = field[0];
  });
}

}  // namespace phynness::bench
