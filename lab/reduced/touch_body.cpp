// Spheres that press and slide on a reduced body in real time: phn_contact_step with few steps in every millisecond,
// against the same motion with steps until all is settled.
//
//   phynness_touch_body MODEL.txt BODY.txt [--spheres 2 --steps 1 2 3 --friction 0.2 --speed 0.05 --depth 0.33
//                                           --seconds 2 --gap 1.5 --seed 1]
//
// Their centres go to and fro along straight lines between places above two nodes each, and press along the normals,
// at 1 and 1.7 Hz. The first sphere is alone in the body if there is one. Errors of the force of the worse sphere are
// in per cent of the largest force on the way, those of unsettled moments apart. Numbers are medians, 99 % and the
// largest.
#include <CLI/CLI.hpp>
#include <array>
#include <median_time.hpp>
#include <phynness/phynness_contact.hpp>
#include <random>

#include "body_of_study.hpp"

namespace phynness {
namespace {

using Spheres = std::vector<phn_contact_tool>;

struct Options {
  std::string model, body;
  std::vector<int> steps{1, 2, 3};
  int spheres = 2;
  bool without_body = false;
  unsigned seed = 1;
  double friction = 0.2, speed_m_per_s = 0.05, depth = 1.0 / 3, seconds = 2, gap = 1.5;
};

/// Outward unit normals of the nodes.
std::vector<Vector3d> normals_of(const Body& body) {
  std::vector<Vector3d> normals(static_cast<std::size_t>(body.info.n_nodes), Vector3d::Zero());
  for (int t = 0; t < body.info.n_triangles; ++t) {
    const int* c = body.info.triangles + 3 * t;
    const Vector3d a = body.point(c[0]), area = (body.point(c[1]) - a).cross(body.point(c[2]) - a);
    for (int k = 0; k < 3; ++k) normals[static_cast<std::size_t>(c[k])] += area;
  }
  for (auto& n : normals) n.normalize();
  return normals;
}

/// The spheres in every millisecond.
std::vector<Spheres> path(const rt::Model& model, const Body& body, const Options& options) {
  const auto& info = model.info();
  const auto normals = normals_of(body);
  const double R = body.info.tool_radius_m, radius = R / 3, pi = std::acos(-1.0);
  std::mt19937 random(options.seed);
  const auto any = [&] {
    const int node = info.active_nodes[random() % static_cast<unsigned>(info.n_active)];
    return static_cast<int>(std::lower_bound(body.info.nodes, body.info.nodes + body.info.n_nodes, node) -
                            body.info.nodes);
  };
  const auto near = [&](int a, int b, double low, double high) {
    const double apart = (body.point(a) - body.point(b)).norm() / R;
    return apart >= low && apart <= high;
  };
  // The line between the nodes stays beside the surface and far from what is fixed.
  const auto flat = [&](int a, int b) {
    for (int k = 0; k <= 8; ++k) {
      const Vector3d x = body.point(a) + k / 8.0 * (body.point(b) - body.point(a));
      Vector3d foot = x, normal = Vector3d::Zero();
      body.nearest(foot, normal);
      if ((foot - x).norm() > 0.15 * body.info.max_displacement_m ||
          normal.dot(normals[static_cast<std::size_t>(a)]) < 0.8)
        return false;
      for (int f = 0; f < info.n_fixed; ++f)
        if ((Eigen::Map<const Vector3d>(info.fixed_points + 3 * f) - x).norm() < 1.2 * R) return false;
    }
    return true;
  };
  std::array<std::array<int, 2>, 2> ends{};  // of each sphere: from, to
  for (std::size_t e = 0; e < 2; ++e)
    for (int attempt = 0;; ++attempt) {
      if (attempt == 1'000'000) throw std::runtime_error("no nodes have this gap between them");
      ends[e] = {any(), any()};
      if (!near(ends[e][0], ends[e][1], 0.4, 1.6) || !flat(ends[e][0], ends[e][1])) continue;
      // Tools on opposite sides of a thin organ squeeze it out.
      if (e == 1 &&
          (normals[static_cast<std::size_t>(ends[0][0])].dot(normals[static_cast<std::size_t>(ends[1][0])]) < 0.5 ||
           !near(ends[0][0], ends[1][0], 0.7 * options.gap, 1.3 * options.gap) ||
           !near(ends[0][1], ends[1][1], 0.7 * options.gap, 1.3 * options.gap)))
        continue;
      break;
    }
  std::vector<Spheres> moments;
  for (int k = 0; k < 1000 * options.seconds; ++k) {
    const double t = k / 1000.0;
    Spheres spheres;
    for (std::size_t i = 0; i < static_cast<std::size_t>(options.spheres); ++i) {
      const int a = ends[i][0], b = ends[i][1];
      const double way = (body.point(a) - body.point(b)).norm();
      const double share = (1 - std::cos(2 * t * options.speed_m_per_s / way)) / 2;  // at most at the speed
      const Vector3d normal =
          ((1 - share) * normals[static_cast<std::size_t>(a)] + share * normals[static_cast<std::size_t>(b)])
              .normalized();
      const double press =
          options.depth * body.info.max_displacement_m * std::pow(std::sin(pi * (i == 0 ? 1.0 : 1.7) * t), 2);
      const Vector3d center = (1 - share) * body.point(a) + share * body.point(b) + (radius * 1.02 - press) * normal;
      spheres.push_back({{center[0], center[1], center[2]}, radius, options.friction, PHN_TOOL_PRESS});
    }
    moments.push_back(spheres);
  }
  return moments;
}

struct Moved {
  std::vector<std::vector<Vector3d>> forces, proxies;
  std::vector<double> us;
  std::vector<double> cut_off;  // the largest |force outside of the cone| [N]
  std::vector<char> unsettled;
  std::size_t touched = 0;
  double deepest = 0;  // [m]
};

Moved move(const rt::Model& model, const Body& body, const Options& options, const std::vector<Spheres>& moments,
           int steps) {
  std::size_t bytes = 0;
  require(phn_body_state_size(body.get(), options.spheres, &bytes), "phn_body_state_size");
  std::vector<char> memory(bytes);
  phn_body_state* state = nullptr;
  require(phn_body_state_init(memory.data(), bytes, body.get(), options.spheres, &state), "phn_body_state_init");
  rt::Tools data(model, options.spheres);
  rt::Contact contact(model, options.spheres);
  if (!options.without_body) require(data.attach(body.get(), state, steps), "phn_body_attach");
  Moved moved;
  for (const auto& spheres : moments) {
    std::vector<phn_contact_state> states(spheres.size());
    int status = 0;
    phn_coupled co{};
    moved.us.push_back(bench::time_of(1, [&](int) { status = contact.step(data, spheres, states, &co); }));
    require(status, "phn_contact_step");
    moved.unsettled.push_back((status & PHN_WARNING_UNSETTLED) != 0);
    moved.forces.emplace_back();
    moved.proxies.emplace_back();
    double cut_off = 0;
    for (const auto& of : states) {
      moved.forces.back().emplace_back(of.force);
      moved.proxies.back().emplace_back(of.proxy);
      cut_off = std::max(cut_off, of.unbalanced);
      moved.touched += of.in_contact != 0;
      if (of.in_contact) moved.deepest = std::max(moved.deepest, Vector3d(of.held.displacement).norm());
    }
    moved.cut_off.push_back(cut_off);
    if (getenv("TRACE") && steps == atoi(getenv("TRACE")))
      for (std::size_t i = 0; i < states.size(); ++i) {
        const auto& q = states[i];
        Vector3d n(q.normal), d(q.held.displacement), f(q.force);
        fmt::print(stderr,
                   "{} {} in {} c {:.3f} {:.3f} {:.3f} p {:.3f} {:.3f} {:.3f} |d| {:.3f} d.n {:.3f} |f| {:.3g} unb "
                   "{:.3g} scale {:.3g} E {:.4g} fd/2 {:.4g} res {:.3g} st {} w {:.3f} {:.3f} {:.3f} nodes {} {} {}\n",
                   moved.us.size(), i, q.in_contact, 1e3 * spheres[i].center[0], 1e3 * spheres[i].center[1],
                   1e3 * spheres[i].center[2], 1e3 * q.proxy[0], 1e3 * q.proxy[1], 1e3 * q.proxy[2], 1e3 * d.norm(),
                   1e3 * d.dot(n), f.norm(), q.unbalanced, q.scale, co.energy, 0.5 * f.dot(d) / q.scale, co.residual,
                   status, q.held.weights[0], q.held.weights[1], q.held.weights[2], q.held.nodes[0], q.held.nodes[1],
                   q.held.nodes[2]);
      }
  }
  return moved;
}

std::string three(const std::vector<double>& of, double unit) {
  return of.empty() ? "none"
                    : fmt::format("{:.2g} {:.2g} {:.2g}", at(of, 0.5) / unit, at(of, 0.99) / unit, at(of, 1) / unit);
}

void run(const Options& options) {
  const rt::Model model = rt::Model::read(options.model.c_str());
  require(model.status(), options.model.c_str());
  const Body body(options.body);
  const auto moments = path(model, body, options);
  constexpr int plenty = 400;
  const auto truth = move(model, body, options, moments, plenty);
  double largest = 0;
  for (const auto& forces : truth.forces)
    for (const auto& f : forces) largest = std::max(largest, f.norm());
  const auto share = [](const std::vector<char>& flags) {
    return 100.0 * static_cast<double>(std::count(flags.begin(), flags.end(), 1)) / static_cast<double>(flags.size());
  };
  fmt::print(
      "{} modes, {} cells, largest force {:.3g} N, deepest {:.2f} of the training, in contact {:.0f} %; unsettled "
      "{:.1f} %; outside of the cone {} % of the largest force\n",
      body.info.n_modes, body.info.n_cells, largest, truth.deepest / body.info.max_displacement_m,
      100.0 * static_cast<double>(truth.touched) / static_cast<double>(moments.size() * moments[0].size()),
      share(truth.unsettled), three(truth.cut_off, largest / 100));
  for (const int steps : options.steps) {
    const auto moved = move(model, body, options, moments, steps);
    std::vector<double> errors, of_unsettled, beside;
    for (std::size_t k = 0; k < moments.size(); ++k) {
      double error = 0, away = 0;
      for (std::size_t i = 0; i < moments[k].size(); ++i) {
        error = std::max(error, (moved.forces[k][i] - truth.forces[k][i]).norm());
        away = std::max(away, (moved.proxies[k][i] - truth.proxies[k][i]).norm());
      }
      if (truth.unsettled[k]) continue;
      beside.push_back(away);
      (moved.unsettled[k] ? of_unsettled : errors).push_back(error);
    }
    fmt::print(
        "{} steps: errors {} %; unsettled {:.1f} % with {}; proxies off by {} mm; outside of the cone {} %; times "
        "{} us\n",
        steps, three(errors, largest / 100), share(moved.unsettled), three(of_unsettled, largest / 100),
        three(beside, 1e-3), three(moved.cut_off, largest / 100), three(moved.us, 1));
  }
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  CLI::App app("Spheres on a reduced body in real time");
  phynness::Options options;
  app.add_option("model", options.model)->required();
  app.add_option("body", options.body)->required();
  app.add_option("--steps", options.steps);
  app.add_option("--spheres", options.spheres)->check(CLI::Range(1, 2));
  app.add_option("--friction", options.friction);
  app.add_option("--speed", options.speed_m_per_s);
  app.add_option("--depth", options.depth, "over that of the training");
  app.add_option("--seconds", options.seconds);
  app.add_option("--gap", options.gap, "between the spheres, in radii of the tool");
  app.add_flag("--without-body", options.without_body, "the model answers, as a comparison");
  app.add_option("--seed", options.seed);
  return phynness::run_study(app, argc, argv, [&] { phynness::run(options); });
}
