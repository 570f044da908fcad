// Work along closed paths, integrated from forces, which is energy that a model could supply to a device; and jumps of
// the force while a tool slides from triangle to triangle.
#include <phynness/phynness.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <random>

#include "closed_paths.hpp"
#include "exit_status.hpp"

namespace {

using phynness::LoadedModel;
using phynness::Loop;
using Vector = Eigen::Vector3d;

class Paths {
 public:
  Paths(const LoadedModel& model, std::uint64_t seed) : _model(model), _random(seed) {
    std::vector<std::int32_t> active;
    for (const auto& node : model.model().nodes) active.push_back(node.node);
    const auto& surface = model.model().surface;
    const auto is_active = [&](std::int32_t node) { return std::binary_search(active.begin(), active.end(), node); };
    for (Eigen::Index t = 0; t < surface.rows(); ++t)
      if (is_active(surface(t, 0)) && is_active(surface(t, 1)) && is_active(surface(t, 2)))
        _triangles.push_back({surface(t, 0), surface(t, 1), surface(t, 2)});
    for (const auto& triangle : _triangles)
      for (std::size_t k = 0; k < 3; ++k) _neighbor[{triangle[k], triangle[(k + 1) % 3]}] = triangle[(k + 2) % 3];
  }

  bool has_points() const { return !_triangles.empty(); }

  /// A quadrilateral of displacements at one node, with corners uniform in the ball of the trained depth.
  Loop at_node() {
    const auto& nodes = _model.model().nodes;
    const std::int32_t node = nodes[index(nodes.size())].node;
    return quadrilateral(
        [&](const Vector& d, Vector& force) { return phynness::force_and_energy(_model, node, d, force); });
  }

  /// The same at one point of the surface.
  Loop at_point() {
    const auto& triangle = _triangles[index(_triangles.size())];
    const double s = std::sqrt(uniform()), q = uniform();
    phn_tool tool{{triangle[0], triangle[1], triangle[2]}, {1 - s, s * (1 - q), s * q}, {}};
    return quadrilateral([&](const Vector& d, Vector& force) {
      for (int k = 0; k < 3; ++k) tool.displacement[k] = d[k];
      return coupled(tool, force);
    });
  }

  /// A tool with a constant displacement slides around a node, across every edge at this node. The work on the body is
  /// the force times the motion of the material under the tool: the sum over corners of weight force . du.
  Loop sliding(int steps_per_triangle) {
    std::vector<std::array<std::int32_t, 3>> ring;
    std::int32_t center = 0;
    for (int attempt = 0; attempt < 1000 && ring.empty(); ++attempt) {
      center = _triangles[index(_triangles.size())][0];
      ring = ring_of(center);
    }
    if (ring.empty()) return {};
    const Vector d = in_ball();
    const double radius = 0.2 + 0.6 * uniform();
    Loop loop;
    State first, last;
    for (const auto& triangle : ring)
      for (int i = 0; i < steps_per_triangle; ++i) {
        const double s = static_cast<double>(i) / steps_per_triangle;
        const State state = slid_to({center, triangle[1], triangle[2]}, {1 - radius, radius * (1 - s), radius * s}, d);
        loop.energy = std::max(loop.energy, std::abs(state.energy));
        if (last.u.size() > 0)
          loop.work += work_between(last, state);
        else
          first = state;
        last = state;
      }
    loop.work += work_between(last, first);
    return loop;
  }

  /// A tool with a constant displacement slides by `step` [m] from one triangle to another, across an edge or in every
  /// fourth case across a node. @return change of the force over its size
  double slide(double step) {
    const auto& from = _triangles[index(_triangles.size())];
    const std::size_t first = index(3);
    const std::int32_t a = from[first], b = from[(first + 1) % 3], c = from[(first + 2) % 3];
    const bool over_node = index(4) == 0;
    const double at = over_node ? 0 : uniform();
    const auto other = _neighbor.find({b, a});
    const std::int32_t beyond = over_node ? opposite(a, b, c) : other == _neighbor.end() ? -1 : other->second;
    if (beyond < 0) return 0;
    const Vector d = in_ball(), edge = (1 - at) * point(a) + at * point(b);
    Vector forces[2];
    for (int side = 0; side < 2; ++side) {
      const std::int32_t inside = side == 0 ? c : beyond;
      const double part = std::min(0.3, step / 2 / (point(inside) - edge).norm());
      const phn_tool tool{{a, b, inside}, {(1 - part) * (1 - at), (1 - part) * at, part}, {d[0], d[1], d[2]}};
      coupled(tool, forces[side]);
    }
    const double size = std::max(forces[0].norm(), forces[1].norm());
    return size > 0 ? (forces[1] - forces[0]).norm() / size : 0;
  }

 private:
  /// Another neighbour of node a, for a path across a: the second next corner around it.
  std::int32_t opposite(std::int32_t a, std::int32_t b, std::int32_t c) const {
    std::int32_t at = c;
    for (int turn = 0; turn < 2; ++turn) {
      const auto next = _neighbor.find({a, at});
      if (next == _neighbor.end() || next->second == b) break;
      at = next->second;
    }
    return at;
  }
  Vector point(std::int32_t node) const {
    const auto& model = _model.model();
    const auto at = std::lower_bound(model.output.begin(), model.output.end(), node) - model.output.begin();
    return model.output_points.row(at).transpose();
  }

  struct State {
    std::vector<double> u;                ///< n_output x 3
    std::map<std::int32_t, Vector> pull;  ///< position among the output nodes: weight times force
    double energy = 0;
  };

  double uniform() { return static_cast<double>(_random() >> 11) * 0x1p-53; }
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
  Vector in_ball() {
    Vector d;
    do {
      for (double& x : d) x = 2 * uniform() - 1;
    } while (d.norm() > 1);
    return d * _model.model().max_displacement_m;
  }

  double coupled(const phn_tool& tool, Vector& force) {
    phn_coupled result{};
    if (!_model.data().couple(tool, force, &result).ok())
      throw phynness::failure("the runtime refuses a tool", "", "this is a defect");
    if (!phynness::schema::traits(_model.model().family).has_energy)
      result.energy = force.dot(Vector(tool.displacement[0], tool.displacement[1], tool.displacement[2])) / 2;
    return result.energy;
  }

  template <class Respond>
  Loop quadrilateral(const Respond& respond) {
    std::array<Vector, 4> corners;
    for (auto& corner : corners) corner = in_ball();
    return phynness::around_quadrilateral(corners, respond);
  }

  /// The triangles around a node in order, each beginning with the node; empty if they do not form a closed fan.
  std::vector<std::array<std::int32_t, 3>> ring_of(std::int32_t center) const {
    std::map<std::int32_t, std::array<std::int32_t, 3>> next;
    for (auto triangle : _triangles)
      for (int turn = 0; turn < 3; ++turn) {
        if (triangle[0] == center) next[triangle[1]] = triangle;
        std::rotate(triangle.begin(), triangle.begin() + 1, triangle.end());
      }
    std::vector<std::array<std::int32_t, 3>> ring;
    if (next.empty()) return ring;
    std::int32_t at = next.begin()->first;
    for (std::size_t i = 0; i < next.size(); ++i) {
      const auto it = next.find(at);
      if (it == next.end()) return {};
      ring.push_back(it->second);
      at = it->second[2];
    }
    if (at != next.begin()->first) ring.clear();
    return ring;
  }

  State slid_to(const std::array<std::int32_t, 3>& nodes, const std::array<double, 3>& weights, const Vector& d) {
    const phn_tool tool{{nodes[0], nodes[1], nodes[2]}, {weights[0], weights[1], weights[2]}, {d[0], d[1], d[2]}};
    State state;
    Vector force;
    state.energy = coupled(tool, force);
    state.u.resize(3 * static_cast<std::size_t>(_model.runtime().n_output()));
    _model.data().coupled_deform({state.u.data(), static_cast<std::size_t>(state.u.size())}).ignore();
    const auto& output = _model.model().output;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = std::lower_bound(output.begin(), output.end(), nodes[k]) - output.begin();
      state.pull[static_cast<std::int32_t>(at)] = weights[k] * force;
    }
    return state;
  }

  /// Trapezoidal rule.
  static double work_between(const State& a, const State& b) {
    const auto u = [](const State& state, std::int32_t at) {
      return Vector(&state.u[3 * static_cast<std::size_t>(at)]);
    };
    double work = 0;
    for (const State* state : {&a, &b})
      for (const auto& [at, pull] : state->pull) work += pull.dot(u(b, at) - u(a, at)) / 2;
    return work;
  }

  const LoadedModel& _model;
  std::mt19937_64 _random;
  std::vector<std::array<std::int32_t, 3>> _triangles;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> _neighbor;  ///< of a directed edge: third corner
};

/// Prints quantiles and a histogram by decades of |work| / energy.
nlohmann::ordered_json report(const char* what, const std::vector<Loop>& loops) {
  std::vector<double> ratio;
  for (const auto& loop : loops)
    if (loop.energy > 0) ratio.push_back(std::abs(loop.work) / loop.energy);
  if (ratio.empty()) return {};
  std::sort(ratio.begin(), ratio.end());
  const auto quantile = [&](double q) {
    return ratio[static_cast<std::size_t>(q * static_cast<double>(ratio.size() - 1))];
  };
  std::printf("%-44s %zu loops: median %.1e, p95 %.1e, largest %.1e\n", what, ratio.size(), quantile(0.5),
              quantile(0.95), ratio.back());
  std::map<int, int> decades;
  for (const double r : ratio) ++decades[r > 0 ? static_cast<int>(std::floor(std::log10(r))) : -20];
  nlohmann::ordered_json histogram;
  for (const auto& [decade, n] : decades) {
    std::printf("  1e%+03d ... %5d %s\n", decade, n,
                std::string(static_cast<std::size_t>(60 * n) / ratio.size(), '#').c_str());
    histogram["1e" + std::to_string(decade)] = n;
  }
  return {{"median", quantile(0.5)}, {"p95", quantile(0.95)}, {"max", ratio.back()}, {"by_decade", histogram}};
}

nlohmann::ordered_json report_slides(Paths& paths, int n) {
  nlohmann::ordered_json out;
  std::printf("slides across edges and nodes, %d of each size: change of the force over its size\n", n);
  for (const double step : {1e-4, 1e-5, 1e-6, 1e-7}) {
    std::vector<double> change;
    for (int i = 0; i < n; ++i) change.push_back(paths.slide(step));
    std::sort(change.begin(), change.end());
    const auto last = static_cast<double>(change.size() - 1);
    const double median = change[static_cast<std::size_t>(0.5 * last)],
                 high = change[static_cast<std::size_t>(0.999 * last)];
    std::printf("  %.0e m: median %.1e, 99.9 %% %.1e, largest %.1e\n", step, median, high, change.back());
    out.push_back({{"step_m", step}, {"median", median}, {"p99.9", high}, {"max", change.back()}});
  }
  return out;
}

int run(int argc, char** argv) {
  CLI::App app("Work along closed paths, integrated from the forces of a model, over the largest energy on the path");
  std::string directory, json_file;
  int loops = 1000, steps = 200, slides = 0;
  std::uint64_t seed = 1;
  app.add_option("MODEL_DIR", directory)->required();
  app.add_option("--loops", loops, "number of loops of each kind")->check(CLI::Range(1, 1'000'000));
  app.add_option("--steps", steps, "steps of a sliding tool in each triangle")->check(CLI::Range(2, 100'000));
  app.add_option("--slides", slides, "number of short slides across edges and nodes, of each size")
      ->check(CLI::Range(0, 10'000'000));
  app.add_option("--seed", seed);
  app.add_option("--json", json_file);
  CLI11_PARSE(app, argc, argv);
  const LoadedModel model(directory);
  Paths paths(model, seed);
  nlohmann::ordered_json out;
  const auto measure = [&](const char* key, const char* what, const auto& walk) {
    std::vector<Loop> walked;
    for (int i = 0; i < loops; ++i) walked.push_back(walk());
    out[key] = report(what, walked);
  };
  measure("at_nodes", "quadrilaterals at nodes", [&] { return paths.at_node(); });
  if (paths.has_points()) {
    measure("at_points", "quadrilaterals at points between nodes", [&] { return paths.at_point(); });
    measure("sliding", "sliding around a node over its edges", [&] { return paths.sliding(steps); });
    if (slides > 0) out["slides"] = report_slides(paths, slides);
  }
  if (!json_file.empty()) phynness::write_text_file(json_file, out.dump(2) + "\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
