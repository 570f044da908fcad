// A model in the runtime and the times of its calls, compared with those of plain loops.
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

inline void check(int status) {
  if (status < 0) throw std::runtime_error(phn_status_message(status));
}

/// Receives results, so that the compiler does not remove the calls.
inline volatile double sink = 0;

/// Displacements within 15 mm that change from call to call, as in a haptic loop.
inline void displacement(int i, double* d) {
  for (int k = 0; k < 3; ++k) d[k] = 0.0003 * ((i * (k + 3)) % 50);
}

struct TimedModel {
  explicit TimedModel(std::string of_model) : text(std::move(of_model)), organ(text) {
    check(organ.status());
    field.resize(organ.n_deform());
  }

  std::int32_t node(int i) const { return organ.info().active_nodes[i % organ.info().n_active]; }
  void deform(std::int32_t touched, const double (&d)[3]) {
    const phn_tool tool = phn_tool_at(touched, d);
    phn_deform(organ.model(), organ.data(), &tool, field.data());
  }
  int prepare(std::int32_t touched) {
    const double rest[3] = {0, 0, 0};
    const phn_tool tool = phn_tool_at(touched, rest);
    return phn_prepare(organ.model(), organ.data(), &tool);
  }
  /// All active nodes in turn.
  void force(int i) {
    double d[3], f[3];
    displacement(i, d);
    const phn_tool tool = phn_tool_at(node(i), d);
    phn_force(organ.model(), organ.data(), &tool, f, nullptr, nullptr);
    sink = f[0];
  }
  /// The same with the stiffness, and also with the energy.
  void force_and_stiffness(int i) {
    double d[3], f[3], k[9];
    displacement(i, d);
    const phn_tool tool = phn_tool_at(node(i), d);
    check(phn_force(organ.model(), organ.data(), &tool, f, nullptr, k));
    sink = f[0] + k[0];
  }
  void force_energy_and_stiffness(int i) {
    double d[3], f[3], e, k[9];
    displacement(i, d);
    const phn_tool tool = phn_tool_at(node(i), d);
    phn_force(organ.model(), organ.data(), &tool, f, &e, k);
    sink = f[0] + e + k[0];
  }
  double force_us() {
    return median_us([&](int i) { force(i); });
  }
  double deformation_us(std::int32_t touched) {
    return median_us([&](int i) {
      double d[3];
      displacement(i, d);
      deform(touched, d);
      sink = field[0];
    });
  }

  std::string text;
  Organ organ;
  std::vector<double> field;
};

template <int N, class Real = double>
PlainNetwork<N, Real> plain_network(int n_neurons, Arbitrary& arbitrary) {
  PlainNetwork<N, Real> net;
  net.spread = static_cast<Real>(1.4);
  for (int i = 0; i < n_neurons; ++i) {
    for (auto& c : net.center) c.push_back(static_cast<Real>(arbitrary.number()));
    for (auto& w : net.weight) w.push_back(static_cast<Real>(arbitrary.number()));
  }
  return net;
}

template <class Real>
std::array<Real, 3> displacement_in(int i) {
  double d[3];
  displacement(i, d);
  return {static_cast<Real>(d[0]), static_cast<Real>(d[1]), static_cast<Real>(d[2])};
}

/// Forces of `n_nodes` networks in turn.
template <class Real>
struct PlainForces {
  PlainForces(int n_neurons, int n_nodes) {
    Arbitrary arbitrary;
    for (int a = 0; a < n_nodes; ++a) nets.push_back(plain_network<3, Real>(n_neurons, arbitrary));
  }
  void operator()(const PlainLoops<Real>& loops, int i) const {
    Real f[3];
    loops.force(nets[static_cast<std::size_t>(i) % nets.size()], displacement_in<Real>(i).data(), f);
    sink = static_cast<double>(f[0]);
  }
  std::vector<PlainNetwork<3, Real>> nets;
};

template <class Real>
struct PlainDeformation {
  PlainDeformation(int n_neurons, std::size_t n_points) {
    Arbitrary arbitrary;
    net = plain_network<6, Real>(n_neurons, arbitrary);
    points.resize(n_points);
    for (auto& point : points)
      for (Real& x : point) x = static_cast<Real>(arbitrary.number());
    table.resize(static_cast<std::size_t>(n_neurons) * n_points);
    field.resize(3 * n_points);
    sums.resize(3 * n_points);
    textbook_loops<Real>().tabulate(net, points, table.data());
  }
  void from_network(const PlainLoops<Real>& loops, int i) {
    loops.deformation(net, points, displacement_in<Real>(i).data(), field.data());
    sink = static_cast<double>(field[0]);
  }
  void from_table(const PlainLoops<Real>& loops, int i) {
    loops.tabulated_deformation(net, static_cast<int>(points.size()), table.data(), displacement_in<Real>(i).data(),
                                sums.data(), field.data());
    sink = static_cast<double>(field[0]);
  }

  PlainNetwork<6, Real> net;
  typename PlainLoops<Real>::Points points;
  std::vector<Real> table, field, sums;
};

inline double plain_deformation_us(int n_neurons, std::size_t n_points) {
  PlainDeformation<double> plain(n_neurons, n_points);
  return median_us([&](int i) { plain.from_network(textbook_loops<double>(), i); });
}

}  // namespace phynness::bench
