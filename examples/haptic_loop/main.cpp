// A simulated hand that moves one or two tools on a model or a body, a thousand times a second:
// docs/howto/haptic-loop.md. Usage: haptic_loop MODEL_DIR|- MOTION [OPTIONS]     (-: a body alone)
//   slide    one tool, to and fro           same     two tools with the same push, which meet and leave again
//   closed   one tool, round a circle       opposed  the same, one pushes and one pulls
//                                           pinch    the same, both push and move towards each other
// --body FILE             a body.txt, which two round tools need
// --sphere RADIUS         spheres, which find their place themselves, in place of held tools; --friction MU
// --at X,Y,Z              the middle of the motion: the nearest point of the surface [the middle of the probed
//                         nodes; of a body alone the highest]; --along X,Y,Z
// --depth, --reach, --speed     in metres, and at most in metres in a second
// --device                a simulated device with phn_loop between hand and tool
// --csv FILE              time, position, force, energy, status, and the tool that holds the body, which plot.py draws
// Exit status: 0; 1: an error; 2: wrong usage; 3: the loop tripped.
#include <phynness/phynness_loop.h>
#include <phynness/phynness.hpp>

#include <cstdlib>
#include <map>

namespace {

using Vector = std::array<double, 3>;
constexpr double period_s = 1e-3, pi = 3.14159265358979323846;

Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
Vector operator-(const Vector& a, const Vector& b) { return a + -1.0 * b; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Vector& a) { return std::sqrt(dot(a, a)); }
Vector unit(const Vector& a) { return 1 / norm(a) * a; }

/// What the hand wants of a tool: a point near the undeformed surface, and the tool's distance from it.
struct Wanted {
  Vector point, displacement;
};

/// From 0 to 1 without a jump of the velocity, which is pi / 2 in the middle.
double smooth(double x) { return (1 - std::cos(pi * std::clamp(x, 0.0, 1.0))) / 2; }

/// The motion: tools are pushed in from `start` over the surface, moved there and back, and drawn out, at speeds up to
/// `speed`.
struct Hand {
  std::string motion;
  Vector at, normal, along;
  double depth, reach, speed, start;

  int n_tools() const { return motion == "slide" || motion == "closed" ? 1 : 2; }
  double time_of(double way) const { return pi / 2 * way / speed; }
  double time_in() const { return time_of(depth + start); }
  double time_there() const { return time_of(motion == "closed" ? pi * depth / 2 : reach); }
  double duration_s() const { return 2 * (time_in() + time_there()); }
  /// The distance of two tools from each other, or the place of one that slides.
  double away(double time_s) const {
    const double legs = (time_s - time_in()) / time_there();
    return reach * (1 - smooth(legs) + smooth(legs - 1));
  }
  Wanted operator()(int tool, double time_s) const {
    const double in = smooth(std::min(time_s, duration_s() - time_s) / time_in());
    const double deep = in * (depth + start) - start, apart = (tool == 0 ? -0.5 : 0.5) * away(time_s);
    const Vector push = -deep * normal;
    if (motion == "closed") {
      const double turn = 2 * pi * smooth((time_s - time_in()) / (2 * time_there()));
      return {at, push + depth / 2 * (std::sin(turn) * along + (1 - std::cos(turn)) * normal)};
    }
    if (motion == "slide") return {at + (away(time_s) - reach / 2) * along, push};
    if (motion == "opposed" && tool == 1) return {at + apart * along, -1 * push};
    if (motion == "pinch") return {at + apart * along, 0.3 * push + (tool == 0 ? 0.7 : -0.7) * deep * along};
    return {at + apart * along, push};
  }
};

/// A device and the hand that holds it: replace them by calls of the manufacturer's library. Without `is_used` the hand
/// is where it wants to be; else it is a spring and a damper that hold a mass with friction, and positions have steps.
struct Device {
  bool is_used;
  Vector at, velocity{};

  Vector position() const {
    Vector measured = at;
    for (double& x : measured) x = is_used ? 2e-5 * std::round(x / 2e-5) : x;
    return measured;
  }
  /// Applies a force [N] for one period.
  void apply(const Vector& force, const Vector& wanted) {
    constexpr int steps = 20;
    constexpr double mass_kg = 0.08, friction = 0.5, hand_N_per_m = 250, hand_Ns_per_m = 4, dt = period_s / steps;
    for (int i = 0; is_used && i < steps; ++i) {
      velocity =
          velocity + dt / mass_kg * (force + hand_N_per_m * (wanted - at) - (hand_Ns_per_m + friction) * velocity);
      at = at + dt * velocity;
    }
  }
};

/// What the body does to a tool in one cycle.
struct Answer {
  Vector force{}, displacement{};  // on the body [N]; of the touched point [m]
  bool in_contact = true;
};

double total_work_J(const std::vector<phn_loop_report>& reports) {
  double sum = 0;
  for (const phn_loop_report& report : reports) sum += report.work_J;
  return sum;
}

int run(phynness::Organ& organ, Hand hand, double radius, double friction, bool with_device, std::FILE* csv) {
  const auto n = static_cast<std::size_t>(hand.n_tools());
  // All memory is taken before the loop.
  std::vector<Device> device(n);
  std::vector<phn_tool> tools(n);
  std::vector<phn_contact_tool> spheres(n);
  std::vector<phn_contact_state> states(n);
  std::vector<Answer> answer(n), before(n);
  std::vector<Vector> goal(n), tip(n), tip_before(n);
  std::vector<double> forces(3 * n);
  std::vector<std::vector<std::byte>> memory(n);
  std::vector<phn_loop*> loop(n);
  std::vector<phn_loop_report> told(n);
  phn_loop_settings settings;
  std::size_t bytes = 0;
  phn_loop_defaults(&settings);
  settings.position_resolution_m = 2e-5;
  phn_loop_size(&bytes);
  for (std::size_t t = 0; t < n; ++t) {
    const Wanted first = hand(static_cast<int>(t), 0);
    device[t] = {with_device, first.point + first.displacement};
    memory[t].resize(bytes);
    if (const int status = phn_loop_init(memory[t].data(), bytes, &settings, &loop[t]); status < 0) return status;
    phn_loop_engage(loop[t]);
  }
  double largest = 0, change = 0, settled_change = 0, taken = 0, given = 0;
  long unsettled = 0, outside = 0, near = 0, cycles = 0;
  phynness::Organ::Status status, last;
  for (double now_s = period_s; now_s < hand.duration_s(); now_s += period_s, ++cycles, last = status) {
    for (std::size_t t = 0; t < n; ++t) {
      const Wanted wanted = hand(static_cast<int>(t), now_s);
      goal[t] = wanted.point + wanted.displacement;
      if (!with_device) device[t].at = goal[t];
      const Vector position = device[t].position();
      if (with_device) phn_loop_read(loop[t], position.data(), now_s, now_s, tip[t].data());
      if (!with_device) tip[t] = position;
      // A held tool is at the point of the surface that is nearest to the hand's; a sphere finds its own.
      spheres[t] = {{tip[t][0], tip[t][1], tip[t][2]}, radius, friction, PHN_TOOL_PRESS};
      const auto found = organ.nearest(wanted.point, tools[t]);
      if (!found.ok()) return found;
      for (std::size_t k = 0; k < 3; ++k) tools[t].displacement[k] = tip[t][k] - wanted.point[k];
    }
    phynness::OrganReport report;
    status = radius > 0 ? organ.touch(spheres, states, &report) : organ.hold(tools, forces, &report);
    for (std::size_t t = 0; t < n; ++t) {
      const double* force = radius > 0 ? states[t].force : &forces[3 * t];
      const phn_tool& held = radius > 0 ? states[t].held : tools[t];
      const double* touched = held.displacement;
      answer[t] = {{force[0], force[1], force[2]}, {touched[0], touched[1], touched[2]}};
      answer[t].in_contact = radius == 0 || states[t].in_contact != 0;
      Vector on_device = -1 * answer[t].force;
      if (with_device) {
        phn_loop_response response{};
        response.status = status;
        response.in_contact = answer[t].in_contact;
        response.energy = n == 1 && report.energy_J > 0 ? report.energy_J : -1;
        std::copy_n(answer[t].force.data(), 3, response.force);
        std::copy_n(answer[t].displacement.data(), 3, response.displacement);
        phn_loop_hold(loop[t], &response, now_s, on_device.data());
        phn_loop_info(loop[t], &told[t]);
      }
      device[t].apply(on_device, goal[t]);
      // What the hand feels.
      const double jump = cycles > 0 ? norm(answer[t].force - before[t].force) : 0;
      largest = std::max(largest, norm(answer[t].force));
      change = std::max(change, jump);
      if (!status.unsettled() && !last.unsettled()) settled_change = std::max(settled_change, jump);
      // What the hand gives is not what the tool does: the loop is between them, and its observer knows. Without it, a
      // held tool works where its displacement changes, and not where its place does.
      const Vector moved = radius > 0 ? tip[t] - tip_before[t] : answer[t].displacement - before[t].displacement;
      if (cycles > 0 && !with_device) taken += dot(0.5 * (answer[t].force + before[t].force), moved);
      if (with_device) taken = total_work_J(told);
      before[t] = answer[t];
      tip_before[t] = tip[t];
      if (csv != nullptr)
        std::fprintf(csv,
                     "%.3f,%zu,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%.9g,%.9g,%d,%d,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,"
                     "%.9g,%.9g\n",
                     now_s, t, tip[t][0], tip[t][1], tip[t][2], force[0], force[1], force[2], report.energy_J,
                     static_cast<int>(status), taken, hand.away(now_s), held.nodes[0], held.nodes[1], held.nodes[2],
                     held.weights[0], held.weights[1], held.weights[2], touched[0], touched[1], touched[2],
                     radius > 0 ? states[t].scale : 1, radius > 0 ? states[t].unbalanced : 0);
    }
    given = std::max(given, -taken);
    unsettled += status.unsettled();
    outside += status.outside();
    near += status.are_near();
    if (status < 0) return status;
  }
  if (largest == 0) {
    std::printf("nothing was touched: a sphere must start outside of the body; choose another place with --at\n");
    return 1;
  }
  std::printf("%ld cycles, largest force %.3g N, largest change in a cycle %.3g %% of it, settled %.3g %%\n", cycles,
              largest, 100 * change / largest, 100 * settled_change / largest);
  std::printf("of %ld cycles, %ld unsettled, %ld of near tools, %ld outside of the probed part or depth\n", cycles,
              unsettled, near, outside);
  if (2 * outside > cycles)
    std::printf(
        "--at X,Y,Z moves the tools to another place, such as the middle of the probed part; a model of points that "
        "are farther apart than the tool's radius has no place without this warning\n");
  if (!with_device)
    std::printf("energy taken from the hand %.3g mJ, at most given to it %.3g mJ\n", 1e3 * taken, 1e3 * given);
  bool is_tripped = false;
  for (std::size_t t = 0; with_device && t < n; ++t) {
    const phn_loop_report& report = told[t];
    std::printf("tool %zu: work %.3g mJ (positive: taken from the hand), at most given to it %.3g mJ. %s\n", t,
                1e3 * report.work_J, 1e3 * report.most_delivered_J, phn_loop_trip_message(report.trip));
    is_tripped |= report.trip != PHN_TRIP_NONE;
  }
  return is_tripped ? 3 : 0;
}

/// The place of the surface above the middle of the probed nodes, or, if it is more than twice as far from the middle
/// as the nearest of these, this node; of a body alone a point above the highest.
Vector find_middle(const phynness::Organ& organ) {
  const phn_info& info = organ.info();
  std::vector<Vector> probed;
  Vector middle{}, above{0, 0, 1};
  for (int o = 0, a = 0; o < info.n_output && a < info.n_active; ++o) {
    if (info.output_nodes[o] != info.active_nodes[a]) continue;
    const double* x = info.output_points + 3 * o;
    probed.push_back({x[0], x[1], x[2]});
    ++a;
  }
  if (probed.empty()) return above;
  for (const Vector& x : probed) middle = middle + (1.0 / info.n_active) * x;
  const auto is_nearer = [&](const Vector& a, const Vector& b) { return norm(a - middle) < norm(b - middle); };
  const auto node = *std::min_element(probed.begin(), probed.end(), is_nearer);
  above = middle;
  for (const Vector& x : probed) above[2] = std::max(above[2], x[2]);
  phn_tool tool;
  if (Vector at{}; organ.nearest(above, tool, at).ok()) above = at;
  return norm(above - middle) > 2 * norm(node - middle) ? node : above;
}

/// The outward normal, as a sphere that grasps the surface finds it.
bool find_normal(phynness::Organ& organ, Hand& hand) {
  const phn_contact_tool probe{{hand.at[0], hand.at[1], hand.at[2]}, 1e-3 * hand.reach, 0, PHN_TOOL_GRASP};
  phn_contact_state state;
  const bool is_found = organ.touch({&probe, 1}, {&state, 1}).ok() && state.in_contact != 0;
  std::copy_n(state.normal, 3, hand.normal.data());
  hand.along = hand.along - dot(hand.along, hand.normal) * hand.normal;
  return is_found && norm(hand.along) > 0 && organ.reset().ok();
}

int stop(int code, const char* what, const char* why) {
  std::fprintf(stderr, "%s: %s\n", what, why);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  std::map<std::string, std::string> given;
  const std::string known = " --body --sphere --friction --at --along --depth --reach --speed --device --csv ";
  for (int i = 3; i < argc; ++i) {
    const std::string name = argv[i];
    if (known.find(" " + name + " ") == std::string::npos) return stop(2, argv[i], "is no option");
    if (name != "--device" && i + 1 == argc) return stop(2, argv[i], "has no value");
    given[name] = name == "--device" ? "1" : argv[++i];
  }
  const auto text = [&](const char* name) { return given.count(name) != 0 ? given[name].c_str() : nullptr; };
  const auto number = [&](const char* name, double otherwise) {
    if (text(name) == nullptr) return otherwise;
    char* end = nullptr;
    const double value = std::strtod(text(name), &end);
    if (*end != '\0') std::exit(stop(2, name, "is not a number"));
    return value;
  };
  const auto vector = [&](const char* name, Vector otherwise) {
    const char* at = text(name);
    if (at == nullptr) return otherwise;
    Vector is{};
    if (std::sscanf(at, "%lf,%lf,%lf", &is[0], &is[1], &is[2]) != 3) std::exit(stop(2, name, "is not X,Y,Z"));
    return is;
  };
  const char* usage = "haptic_loop MODEL_DIR|- slide|closed|same|opposed|pinch [OPTIONS]";
  if (argc < 3 ||
      std::string(" slide closed same opposed pinch ").find(" " + std::string(argv[2]) + " ") == std::string::npos)
    return stop(2, "usage", usage);
  const bool no_model = std::string(argv[1]) == "-";
  phynness::Organ organ = phynness::Organ::read(no_model ? nullptr : argv[1], text("--body"), 2);
  if (!organ) return stop(1, "cannot load", organ.problem().c_str());

  const double trained =
      organ.body() != nullptr ? organ.body_info().max_displacement_m : organ.info().max_displacement_m;
  const double size = organ.body_info().tool_radius_m > 0 ? organ.body_info().tool_radius_m : 2 * trained;
  Hand hand{argv[2],
            vector("--at", find_middle(organ)),
            {},
            vector("--along", {1, 0.1, 0.01}),
            number("--depth", trained / 2),
            number("--reach", 1.5 * size),
            number("--speed", 0.1),
            0};
  const double radius = number("--sphere", 0), friction = number("--friction", 0);
  for (const char* name : {"--depth", "--reach", "--speed", "--sphere"}) {
    if (text(name) != nullptr && !(number(name, 0) > 0)) return stop(2, name, "is no number above 0");
    if (name != std::string("--speed") && number(name, 0) > 1) return stop(2, name, "is more than 1 m: give metres");
  }
  phn_tool tool;
  double distance = 0;
  auto status = organ.nearest(hand.at, tool, hand.at, distance);
  if (!status.ok()) return stop(1, "--at", status.message());
  if (distance > 1) return stop(2, "--at", "is more than 1 m from the surface: give metres");
  if (!find_normal(organ, hand)) return stop(1, "--at", "the surface cannot be touched there");
  hand.along = unit(hand.along);
  if (radius > 0) {
    hand.at = hand.at + radius * hand.normal;
    hand.start = radius / 10;
  }
  std::FILE* csv = text("--csv") != nullptr ? std::fopen(text("--csv"), "w") : nullptr;
  if (text("--csv") != nullptr && csv == nullptr) return stop(1, text("--csv"), "cannot be written");
  if (csv != nullptr)
    std::fprintf(csv,
                 "time_s,tool,x_m,y_m,z_m,fx_N,fy_N,fz_N,energy_J,status,taken_J,apart_m,"
                 "node0,node1,node2,weight0,weight1,weight2,ux_m,uy_m,uz_m,scale,unbalanced_N\n");
  const int result = run(organ, hand, radius, friction, text("--device") != nullptr, csv);
  if (csv != nullptr) std::fclose(csv);
  if (result <= PHN_ERROR_SETTING) return stop(1, argv[2], phn_loop_trip_message(result));
  return result < 0 ? stop(1, argv[2], phn_status_message(result)) : result;
}
