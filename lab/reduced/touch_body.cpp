// Two spheres that press and slide on a reduced body in real time: phn_contact_step with few steps in every
// millisecond, against the same motion with steps until all is settled.
//
//   phynness_touch_body MODEL.txt BODY.txt [--steps 1 2 3 --friction 0.2 --speed 0.05 --depth 0.33 --seconds 2]
//
// Errors of the force of the worse sphere are in per cent of the largest force on the way; times are of this thread.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <median_time.hpp>
#include <phynness/phynness_contact.hpp>
#include <random>
#include <stdexcept>

namespace phynness {
namespace {

using Eigen::Vector3d;
using Spheres = std::array<phn_contact_tool, 2>;

struct Options {
  std::string model, body;
  std::vector<int> steps{1, 2, 3};
  double friction = 0.2, speed_m_per_s = 0.05, depth = 1.0 / 3, seconds = 2, gap = 1.5;
};

void require(int status, const char* what) {
  if (status < 0) throw std::runtime_error(fmt::format("{}: {}", what, phn_status_message(status)));
}

/// A body with its state, in memory of its own.
struct Body {
  explicit Body(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::size_t bytes = 0;
    require(phn_body_size(text.data(), text.size(), &bytes, nullptr), file.c_str());
    memory.resize(bytes);
    require(phn_body_init(memory.data(), bytes, text.data(), text.size(), &body, nullptr), file.c_str());
    require(phn_body_state_size(body, 2, &bytes), "phn_body_state_size");
    state_memory.resize(bytes);
    require(phn_body_state_init(state_memory.data(), bytes, body, 2, &state), "phn_body_state_init");
    require(phn_body_describe(body, &info), "phn_body_describe");
  }
  std::vector<char> memory, state_memory;
  const phn_body* body = nullptr;
  phn_body_state* state = nullptr;
  phn_body_info info{};
};

Vector3d point_of(const rt::Model& model, int vertex) {
  const auto& info = model.info();
  return Eigen::Map<const Vector3d>(vertex < info.n_output ? info.output_points + 3 * vertex
                                                           : info.fixed_points + 3 * (vertex - info.n_output));
}

/// Outward unit normals of the vertices.
std::vector<Vector3d> normals_of(const rt::Model& model) {
  const auto& info = model.info();
  std::vector<Vector3d> normals(static_cast<std::size_t>(info.n_output + info.n_fixed), Vector3d::Zero());
  for (int t = 0; t < info.n_triangles; ++t) {
    const int* c = info.triangles + 3 * t;
    const Vector3d a = point_of(model, c[0]), area = (point_of(model, c[1]) - a).cross(point_of(model, c[2]) - a);
    for (int k = 0; k < 3; ++k) normals[static_cast<std::size_t>(c[k])] += area;
  }
  for (auto& n : normals) n.normalize();
  return normals;
}

/// The spheres in every millisecond: to and fro between active nodes, pressing at 1 and 1.7 Hz.
std::vector<Spheres> path(const rt::Model& model, const Body& body, const Options& options) {
  const auto& info = model.info();
  const auto normals = normals_of(model);
  const double R = body.info.tool_radius_m, radius = R / 3;
  std::mt19937 random(1);
  const auto vertex_of = [&](int node) {
    return static_cast<int>(std::lower_bound(info.output_nodes, info.output_nodes + info.n_output, node) -
                            info.output_nodes);
  };
  const auto any = [&] { return vertex_of(info.active_nodes[random() % static_cast<unsigned>(info.n_active)]); };
  std::array<std::array<int, 2>, 2> ends{};  // from, to
  for (std::size_t e = 0; e < 2; ++e)
    for (int attempt = 0;; ++attempt) {
      if (attempt == 100'000) throw std::runtime_error("no two nodes have this gap between them");
      ends[e] = {any(), any()};
      const auto near = [&](int a, int b, double low, double high) {
        const double apart = (point_of(model, a) - point_of(model, b)).norm() / R;
        return apart >= low && apart <= high &&
               normals[static_cast<std::size_t>(a)].dot(normals[static_cast<std::size_t>(b)]) > 0.5;
      };
      if (!near(ends[e][0], ends[e][1], 0.8 * options.gap, 1.2 * options.gap)) continue;
      if (e == 1 && (!near(ends[0][0], ends[1][0], 0.5, 2) || !near(ends[0][1], ends[1][1], 0.5, 2))) continue;
      break;
    }
  std::vector<Spheres> moments;
  const double pi = std::acos(-1.0), way = (point_of(model, ends[0][0]) - point_of(model, ends[1][0])).norm();
  for (int k = 0; k < 1000 * options.seconds; ++k) {
    const double t = k / 1000.0, gone = std::fmod(t * options.speed_m_per_s / way, 2.0),
                 share = gone < 1 ? gone : 2 - gone;
    Spheres spheres;
    for (std::size_t i = 0; i < 2; ++i) {
      const int a = ends[0][i], b = ends[1][i];
      const Vector3d x = (1 - share) * point_of(model, a) + share * point_of(model, b);
      phn_tool at;
      Vector3d on_surface;
      require(phn_nearest(model.get(), x.data(), &at, on_surface.data()), "phn_nearest");
      Vector3d normal = Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c)
        if (at.weights[c] > 0 && vertex_of(at.nodes[c]) < info.n_output)
          normal += at.weights[c] * normals[static_cast<std::size_t>(vertex_of(at.nodes[c]))];
      const double press =
          options.depth * body.info.max_displacement_m * std::pow(std::sin(pi * (i == 0 ? 1.0 : 1.7) * t), 2);
      const Vector3d center = on_surface + (radius * 1.02 - press) * normal.normalized();
      spheres[i] = {{center[0], center[1], center[2]}, radius, options.friction, PHN_TOOL_PRESS};
    }
    moments.push_back(spheres);
  }
  return moments;
}

double at(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

struct Moved {
  std::vector<std::array<Vector3d, 2>> forces;
  std::vector<double> us;
  std::vector<char> unsettled, unbalanced;
};

Moved move(const rt::Model& model, const Options& options, const std::vector<Spheres>& moments, int steps) {
  Body body(options.body);
  rt::Tools data(model, 2);
  rt::Contact contact(model, 2);
  require(data.attach(body.body, body.state, steps), "phn_body_attach");
  Moved moved;
  for (const auto& spheres : moments) {
    std::array<phn_contact_state, 2> states;
    int status = 0;
    moved.us.push_back(bench::time_of(1, [&](int) { status = contact.step(data, spheres, states); }));
    require(status, "phn_contact_step");
    moved.unsettled.push_back((status & PHN_WARNING_UNSETTLED) != 0);
    moved.forces.emplace_back();
    char unbalanced = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      moved.forces.back()[i] = Eigen::Map<const Vector3d>(states[i].force);
      unbalanced |= states[i].unbalanced > 0.05 * moved.forces.back()[i].norm();
    }
    moved.unbalanced.push_back(unbalanced);
  }
  return moved;
}

void run(const Options& options) {
  const rt::Model model = rt::Model::read(options.model.c_str());
  require(model.status(), options.model.c_str());
  const Body body(options.body);
  const auto moments = path(model, body, options);
  constexpr int plenty = 60;
  const auto truth = move(model, options, moments, plenty);
  double largest = 0;
  for (const auto& forces : truth.forces)
    for (const auto& f : forces) largest = std::max(largest, f.norm());
  fmt::print("{} modes, {} cells, largest force {:.3f} N; errors [%] and times [us]: median, 99 %, largest\n",
             body.info.n_modes, body.info.n_cells, largest);
  for (const int steps : options.steps) {
    const auto moved = move(model, options, moments, steps);
    std::vector<double> errors, settled;
    for (std::size_t k = 0; k < moments.size(); ++k) {
      const double error =
          100 / largest *
          std::max((moved.forces[k][0] - truth.forces[k][0]).norm(), (moved.forces[k][1] - truth.forces[k][1]).norm());
      if (truth.unsettled[k]) continue;
      errors.push_back(error);
      if (!moved.unsettled[k]) settled.push_back(error);
    }
    const auto share = [](const std::vector<char>& flags) {
      return 100.0 * static_cast<double>(std::count(flags.begin(), flags.end(), 1)) / static_cast<double>(flags.size());
    };
    fmt::print(
        "{} steps: errors {:.2g} {:.2g} {:.2g}, settled {:.2g} {:.2g} {:.2g}; times {:.0f} {:.0f} {:.0f}; "
        "unsettled {:.1f} %, beside the cone {:.1f} %\n",
        steps, at(errors, 0.5), at(errors, 0.99), at(errors, 1), at(settled, 0.5), at(settled, 0.99), at(settled, 1),
        at(moved.us, 0.5), at(moved.us, 0.99), at(moved.us, 1), share(moved.unsettled), share(moved.unbalanced));
  }
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  CLI::App app("Two spheres on a reduced body in real time");
  phynness::Options options;
  app.add_option("model", options.model)->required();
  app.add_option("body", options.body)->required();
  app.add_option("--steps", options.steps);
  app.add_option("--friction", options.friction);
  app.add_option("--speed", options.speed_m_per_s);
  app.add_option("--depth", options.depth, "over that of the training");
  app.add_option("--seconds", options.seconds);
  app.add_option("--gap", options.gap, "between the tools, in radii");
  CLI11_PARSE(app, argc, argv);
  try {
    phynness::run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
