// A reduced body under two tools in real time: a few steps in every millisecond, against converged forces.
//
//   phynness_follow_path BODY.txt [--steps 1 2 3 --gaps 2 1 0.6 --speed 0.05 --depth 0.33 --seconds 2 --leap]
//   phynness_follow_path BODY.txt --loops 100 [--depth 0.33]
//
// Two round tools slide over the surface towards places that go to and fro, near the gap from each other, and press in
// turning directions. With --leap they are at the nearest places of the surface, which leap where it is curved.
// Errors of the force of the worse tool are in per cent of the largest force on the way, those of unsettled moments
// apart; times are of this thread.
//
// With --loops one tool goes once around a random node, a third of its radius away, alone and beside a second tool that
// stays, both with a constant displacement in a random direction. The difference of the energies before and after is
// the work of the loop, because the forces are the derivatives of the energy.
#include "body_of_study.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <median_time.hpp>
#include <optional>
#include <random>

namespace phynness {
namespace {

struct Options {
  std::string file;
  std::vector<int> steps{1, 2, 3};
  std::vector<double> gaps{2, 1, 0.6};
  double speed_m_per_s = 0.05, depth = 1.0 / 3, seconds = 2;
  int loops = 0;
  bool leap = false;
};

class State {
 public:
  explicit State(const Body& body) : _body(body) {
    std::size_t bytes = 0;
    require(phn_body_state_size(body.get(), 2, &bytes), "phn_body_state_size");
    _memory.resize(bytes);
    require(phn_body_state_init(_memory.data(), bytes, body.get(), 2, &_state), "phn_body_state_init");
  }
  int press(const std::array<phn_tool, 2>& tools, int steps, int n_tools = 2) {
    const int status = phn_body_press(_body.get(), _state, n_tools, tools.data(), steps, forces[0].data(), &pressed);
    require(status, "phn_body_press");
    return status;
  }
  void reset() { require(phn_body_press(_body.get(), _state, 0, nullptr, 1, nullptr, nullptr), "phn_body_press"); }

  std::array<Vector3d, 2> forces{};
  phn_body_pressed pressed{};

 private:
  const Body& _body;
  std::vector<char> _memory;
  phn_body_state* _state = nullptr;
};

int any_node(const Body& body, std::mt19937& random) {
  return static_cast<int>(random() % static_cast<unsigned>(body.info.n_nodes));
}

phn_tool tool_at(const Body& body, int node) { return {{body.info.nodes[node], -1, -1}, {1, 0, 0}, {0, 0, 0}}; }

/// Whether a tool at the node is where the body is trained.
bool is_trained(State& state, const Body& body, int node) { return state.press({tool_at(body, node)}, 1, 1) == PHN_OK; }

/// Tools in every millisecond.
std::vector<std::array<phn_tool, 2>> path(const Body& body, const Options& options, double gap) {
  std::mt19937 random(1);
  const auto any = [&] { return any_node(body, random); };
  const double radius = body.info.tool_radius_m;
  State state(body);
  const auto trained = [&](int node) { return is_trained(state, body, node); };
  std::array<Vector3d, 2> from, to;
  for (auto* ends : {&from, &to})
    for (int attempt = 0;; ++attempt) {
      if (attempt == 100'000) throw std::runtime_error("no two nodes have this gap between them");
      const int a = any(), b = any();
      const double apart = (body.point(a) - body.point(b)).norm() / radius;
      if (std::abs(apart - gap) > 0.15 * gap + 0.05 || !trained(a) || !trained(b)) continue;
      if (ends == &to &&
          ((body.point(a) - from[0]).norm() > 2 * radius || (body.point(b) - from[1]).norm() > 2 * radius))
        continue;
      *ends = {body.point(a), body.point(b)};
      break;
    }
  const double way = std::max((to[0] - from[0]).norm(), (to[1] - from[1]).norm());
  std::vector<std::array<phn_tool, 2>> moments;
  std::array<Vector3d, 2> place = from, normal;
  for (std::size_t i = 0; i < 2; ++i) body.nearest(place[i], normal[i]);
  const double pi = std::acos(-1.0);
  for (int k = 0; k < 1000 * options.seconds; ++k) {
    const double t = k / 1000.0, gone = std::fmod(t * options.speed_m_per_s / std::max(way, 1e-9), 2.0);
    const double share = gone < 1 ? gone : 2 - gone;  // to and fro
    std::array<phn_tool, 2> tools;
    for (std::size_t i = 0; i < 2; ++i) {
      Vector3d step = (1 - share) * from[i] + share * to[i] - place[i];
      if (!options.leap) {
        step -= step.dot(normal[i]) * normal[i];
        step *= std::min(1.0, 2e-3 * options.speed_m_per_s / std::max(step.norm(), 1e-12));
      }
      place[i] += step;
      tools[i] = body.nearest(place[i], normal[i]);
      for (int j = 0; j < 3; ++j)
        tools[i].displacement[j] = options.depth * body.info.max_displacement_m * std::min(1.0, 5 * t) /
                                   std::sqrt(3.0) *
                                   std::sin(2 * pi * (i == 0 ? 1.0 : 1.7) * t + 2.1 * j + static_cast<double>(i));
    }
    moments.push_back(tools);
  }
  return moments;
}

/// Over the largest energy on the way: of the loop of one tool, and beside a second one. Empty where a moment is
/// unsettled.
std::array<std::optional<double>, 2> work_of_loop(const Body& body, double depth, std::mt19937& random) {
  constexpr int moments = 120, plenty = 400;
  const double radius = body.info.tool_radius_m, pi = std::acos(-1.0);
  State state(body);
  const auto draw = [&](const auto& belongs) {
    for (int attempt = 0; attempt < 100'000; ++attempt)
      if (const int node = any_node(body, random); belongs(node) && is_trained(state, body, node)) return node;
    throw std::runtime_error("no node is near enough to another one");
  };
  const int middle = draw([](int) { return true; });
  const int other = draw([&](int node) {
    const double apart = (body.point(node) - body.point(middle)).norm() / radius;
    return apart > 0.5 && apart < 3;
  });
  std::array<phn_tool, 2> tools{tool_at(body, middle), tool_at(body, other)};
  std::array<Vector3d, 2> displacement;
  for (auto& d : displacement) {
    std::normal_distribution<> normal;
    d = depth * body.info.max_displacement_m * Vector3d::NullaryExpr([&] { return normal(random); }).normalized();
  }
  Vector3d x = body.point(middle), normal;
  body.nearest(x, normal);
  const Vector3d along = normal.unitOrthogonal(), across = normal.cross(along);
  std::array<std::optional<double>, 2> work;
  for (int n_tools : {1, 2}) {
    state.reset();
    double first = 0, largest = 0;
    bool settles = true;
    for (int k = -4; k <= moments; ++k) {  // in five increments to the depth, where the loop begins
      const double angle = 2 * pi * std::max(k, 0) / moments;
      Vector3d at = body.point(middle) + radius / 3 * (std::cos(angle) * along + std::sin(angle) * across), up;
      tools[0] = body.nearest(at, up);
      for (std::size_t i = 0; i < 2; ++i)
        Eigen::Map<Vector3d>(tools[i].displacement) = std::min(1.0, (k + 5) / 5.0) * displacement[i];
      settles = !(state.press(tools, plenty, n_tools) & PHN_WARNING_UNSETTLED) && settles;
      if (k == 0) first = state.pressed.energy;
      largest = std::max(largest, state.pressed.energy);
    }
    if (settles) work[static_cast<std::size_t>(n_tools - 1)] = std::abs(state.pressed.energy - first) / largest;
  }
  return work;
}

void run_loops(const Options& options) {
  const Body body(options.file);
  std::mt19937 random(1);
  std::array<std::vector<double>, 2> works;
  for (int loop = 0; loop < options.loops; ++loop) {
    const auto work = work_of_loop(body, options.depth, random);
    for (std::size_t kind = 0; kind < 2; ++kind)
      if (work[kind]) works[kind].push_back(100 * *work[kind]);
  }
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const auto& of = works[kind];
    fmt::print("{}: {} loops, {} unsettled", kind == 0 ? "one tool" : "beside a second tool", of.size(),
               options.loops - std::ssize(of));
    if (!of.empty())
      fmt::print("; work over the largest energy [%], median {:.2g}, 95 % {:.2g}, largest {:.2g}; {} above 1 %",
                 at(of, 0.5), at(of, 0.95), at(of, 1), std::ranges::count_if(of, [](double work) { return work > 1; }));
    fmt::print("\n");
  }
}

void run(const Options& options) {
  if (options.loops > 0) return run_loops(options);
  const Body body(options.file);
  fmt::print("{} modes, {} cells; errors [%] and times [us]: median, 99 %, largest\n", body.info.n_modes,
             body.info.n_cells);
  for (const double gap : options.gaps) {
    const auto moments = path(body, options, gap);
    std::vector<std::array<Vector3d, 2>> truth;
    std::vector<char> known;
    double largest = 0;
    State slow(body);
    for (const auto& tools : moments) {
      constexpr int plenty = 400;
      known.push_back(!(slow.press(tools, plenty) & PHN_WARNING_UNSETTLED));
      truth.push_back(slow.forces);
      for (const auto& f : slow.forces) largest = std::max(largest, f.norm());
    }
    for (const int steps : options.steps) {
      State state(body);
      std::vector<double> errors, of_unsettled, us;
      for (std::size_t k = 0; k < moments.size(); ++k) {
        bool is_unsettled = false;
        us.push_back(bench::time_of(
            1, [&](int) { is_unsettled = (state.press(moments[k], steps) & PHN_WARNING_UNSETTLED) != 0; }));
        const double error =
            100 / largest * std::max((state.forces[0] - truth[k][0]).norm(), (state.forces[1] - truth[k][1]).norm());
        if (known[k]) (is_unsettled ? of_unsettled : errors).push_back(error);
      }
      fmt::print("gap {:.1f} R, {} steps: errors {:.2g} {:.2g} {:.2g}; times {:.0f} {:.0f} {:.0f}; unsettled {:.1f} %",
                 gap, steps, at(errors, 0.5), at(errors, 0.99), at(errors, 1), at(us, 0.5), at(us, 0.99), at(us, 1),
                 100.0 * static_cast<double>(of_unsettled.size()) / static_cast<double>(moments.size()));
      if (!of_unsettled.empty())
        fmt::print(" with errors {:.2g} {:.2g} {:.2g}", at(of_unsettled, 0.5), at(of_unsettled, 0.99),
                   at(of_unsettled, 1));
      fmt::print("; not known {}\n", std::count(known.begin(), known.end(), 0));
    }
  }
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  CLI::App app("A reduced body that follows two tools in real time");
  phynness::Options options;
  app.add_option("body", options.file)->required();
  app.add_option("--steps", options.steps);
  app.add_option("--gaps", options.gaps, "between the tools, in radii");
  app.add_option("--speed", options.speed_m_per_s);
  app.add_option("--depth", options.depth, "over that of the training");
  app.add_option("--seconds", options.seconds);
  app.add_option("--loops", options.loops, "work of so many closed loops, and no path in time");
  app.add_flag("--leap", options.leap);
  return phynness::run_study(app, argc, argv, [&] { phynness::run(options); });
}
