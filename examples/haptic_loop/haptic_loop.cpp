// Usage: haptic_loop MODEL_DIR --node J [options]; --help lists them.
#include <phynness/phynness.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>

#include "force_thread.hpp"
#include "picture_thread.hpp"
#include "simulated_device.hpp"

namespace {

const char* const help =
    "haptic_loop MODEL_DIR --node J   a haptic loop at 1 kHz around a model, with a simulated hand and device\n"
    "  --cycles N        milliseconds to run (default 10000)\n"
    "  --free            as fast as possible, without waiting for the clock\n"
    "  --motion FILE     recorded positions of the hand, x y z in m per line, one line per millisecond\n"
    "  --reach METRES    of the synthetic motion (default: half of the trained displacement)\n"
    "  --coupling N/M    stiffness between device and tool (default 400)\n"
    "  --no-controller   observe energy only\n"
    "  --stall A,N       the positions of the device are frozen for N cycles from cycle A on\n"
    "  --contact         the tool is a sphere that approaches, touches, slides and leaves: x and y along the\n"
    "                    surface at node J, z outward; position 0 is a fifth of the reach above the surface\n"
    "  --radius METRES   radius of the sphere (default 0.004)\n"
    "  --friction MU     coefficient of friction of the sphere (default 0)\n"
    "  --fps F           frames per second of the picture thread (default 100)\n"
    "  --realtime        SCHED_FIFO and locked memory, if the user has the permission\n";

struct Options {
  std::string model_dir, motion;
  long node = -1, cycles = 10000, stall_from = -1, stall_cycles = 0;
  double reach_m = 0, frames_per_s = 100, coupling = 400;
  TouchingSettings sphere;
  bool free_running = false, controller = true, realtime = false, contact = false, of_contact = false;
};

double number(const char* option, const char* text) {
  char* end = nullptr;
  const double value = text ? std::strtod(text, &end) : 0;
  if (!text || end == text || *end != 0 || !(value > 0) || value > 1e12)
    throw std::invalid_argument(std::string(option) + " needs a positive number" +
                                (text ? std::string(", not ") + text : ""));
  return value;
}

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto next = [&]() -> const char* { return i + 1 < argc ? argv[++i] : nullptr; };
    if (word == "--help") {
      std::fputs(help, stdout);
      std::exit(0);
    } else if (word == "--node") {
      const char* text = next();
      char* end = nullptr;
      o.node = text ? std::strtol(text, &end, 10) : -1;
      if (!text || *end != 0 || end == text || o.node < 0)
        throw std::invalid_argument("--node needs the number of a node");
    } else if (word == "--cycles") {
      o.cycles = static_cast<long>(number("--cycles", next()));
    } else if (word == "--free") {
      o.free_running = true;
    } else if (word == "--motion") {
      const char* text = next();
      if (!text) throw std::invalid_argument("--motion needs the name of a file");
      o.motion = text;
    } else if (word == "--reach") {
      o.reach_m = number("--reach", next());
    } else if (word == "--coupling") {
      o.coupling = number("--coupling", next());
    } else if (word == "--no-controller") {
      o.controller = false;
    } else if (word == "--stall") {
      const char* text = next();
      if (!text || std::sscanf(text, "%ld,%ld", &o.stall_from, &o.stall_cycles) != 2)
        throw std::invalid_argument("--stall needs a cycle and a number of cycles, such as 500,20");
    } else if (word == "--contact") {
      o.contact = true;
    } else if (word == "--radius") {
      o.sphere.radius_m = number("--radius", next());
      o.of_contact = true;
    } else if (word == "--friction") {
      o.sphere.friction = number("--friction", next());
      o.of_contact = true;
    } else if (word == "--fps") {
      o.frames_per_s = number("--fps", next());
    } else if (word == "--realtime") {
      o.realtime = true;
    } else if (word[0] == '-' || !o.model_dir.empty()) {
      throw std::invalid_argument("unknown option " + word + " (--help lists them)");
    } else {
      o.model_dir = word;
    }
  }
  if (o.of_contact && !o.contact) throw std::invalid_argument("--radius and --friction need --contact");
  if (o.model_dir.empty() || o.node < 0)
    throw std::invalid_argument("a model directory and --node are needed (--help)");
  return o;
}

/// The model and scratch for two threads. All memory is allocated here, before the loop.
class Model {
 public:
  explicit Model(const std::string& folder) {
    const std::string file = folder + "/model.txt";
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error(file + " cannot be read; give a folder that `phynness train -o` wrote");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::size_t bytes = 0;
    check(phn_model_size(text.data(), text.size(), &bytes, nullptr), file);
    _model_memory.reset(new char[bytes]);
    check(phn_model_init(_model_memory.get(), bytes, text.data(), text.size(), &_model, nullptr), file);
    for (int i = 0; i < 2; ++i) {
      check(phn_data_size(_model, 1, &bytes), file);
      _data_memory[i].reset(new char[bytes]);
      check(phn_data_init(_data_memory[i].get(), bytes, _model, 1, &_data[i]), file);
    }
  }
  /// Contact state of one tool.
  phn_contact* make_contact() {
    std::size_t bytes = 0;
    const int status = phn_contact_size(_model, 1, &bytes);
    if (status < 0)
      throw std::runtime_error(std::string("--contact: no triangle can be touched: ") + phn_status_message(status));
    _contact_memory.reset(new char[bytes]);
    phn_contact* contact = nullptr;
    check(phn_contact_init(_contact_memory.get(), bytes, _model, 1, &contact), "--contact");
    return contact;
  }
  const phn_model* model() const { return _model; }
  phn_data* data(int thread) const { return _data[thread]; }

 private:
  static void check(int status, const std::string& file) {
    if (status < 0) throw std::runtime_error(file + ": " + phn_status_message(status));
  }
  std::unique_ptr<char[]> _model_memory, _data_memory[2], _contact_memory;
  const phn_model* _model = nullptr;
  phn_data* _data[2] = {};
};

/// Counts times in ns in bins of an eighth of a power of two, which gives percentiles of any number of cycles in 4 kB.
class Histogram {
 public:
  void add(long ns) {
    const double step = 8 * std::log2(std::max(1.0, static_cast<double>(ns)));
    ++_count[std::min(n_bins - 1, static_cast<int>(step))];
    _most = std::max(_most, ns);
  }
  double percentile_us(double share) const {
    long all = 0, seen = 0;
    for (const long c : _count) all += c;
    for (int i = 0; i < n_bins; ++i) {
      seen += _count[i];
      if (static_cast<double>(seen) >= share * static_cast<double>(all))
        return std::min(1e-3 * std::exp2((i + 1) / 8.0), 1e-3 * static_cast<double>(_most));
    }
    return 0;
  }
  double most_us() const { return 1e-3 * static_cast<double>(_most); }

 private:
  static constexpr int n_bins = 512;
  long _count[n_bins] = {};
  long _most = 0;
};

long time_ns(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return 1000000000L * t.tv_sec + t.tv_nsec;
}
long now_ns() { return time_ns(CLOCK_MONOTONIC); }

void sleep_until(long ns) {
  const timespec t{ns / 1000000000L, ns % 1000000000L};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

void ask_for_realtime() {
  sched_param priority{};
  priority.sched_priority = 80;
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0)
    std::fprintf(stderr, "warning: no SCHED_FIFO (%s): run as root or raise the limit rtprio\n", std::strerror(errno));
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    std::fprintf(stderr, "warning: memory is not locked (%s): raise the limit memlock\n", std::strerror(errno));
}

struct Lateness {
  Histogram computed, woken;
  long missed = 0, missed_by_us = 0;  ///< late cycles; of these, those that computed for at least half a period
};

void run(const Options& o) {
  Model model(o.model_dir);
  const auto node = static_cast<int32_t>(o.node);
  const double rest[3] = {0, 0, 0};
  double force[3];
  phn_trusted trusted;
  const int status = phn_force(model.model(), model.data(0), node, rest, force, nullptr, nullptr);
  if (status < 0) throw std::runtime_error("node " + std::to_string(o.node) + ": " + phn_status_message(status));
  phn_trust(model.model(), node, rest, &trusted);
  const double depth = trusted.trained_depth;

  LoopSettings settings;
  settings.coupling_stiffness_N_per_m = o.coupling;
  settings.passivity_controller = o.controller;
  settings.largest_displacement_m = depth;
  const double reach = o.reach_m > 0 ? o.reach_m : depth / 2;
  const HandMotion motion = o.motion.empty() ? HandMotion(reach) : HandMotion::recorded(o.motion);
  SimulatedDevice device({}, motion);
  std::unique_ptr<TouchingTool> touching;
  if (o.contact) {
    TouchingSettings sphere = o.sphere;
    sphere.clearance_m = reach / 5;
    touching.reset(new TouchingTool(sphere, model.model(), model.data(0), model.make_contact(), node));
  }
  ForceThread loop = touching ? ForceThread(settings, model.model(), *touching)
                              : ForceThread(settings, model.model(), model.data(0), node);
  // Started before the priority is raised, because threads inherit it.
  PictureThread picture(loop.touch(), model.model(), model.data(1), node, o.frames_per_s);
  if (o.realtime) ask_for_realtime();

  static Lateness lateness;
  double largest_force = 0;
  const long period = std::lround(1e9 * settings.period_s), begin = now_ns() + period;
  for (long cycle = 1; cycle <= o.cycles; ++cycle) {
    const long due = begin + cycle * period;
    if (!o.free_running) {
      sleep_until(due);
      lateness.woken.add(now_ns() - due);
    }
    const long start = now_ns(), processor = time_ns(CLOCK_THREAD_CPUTIME_ID);
    const auto sample = device.read();
    const Vector3 f = loop.step(sample.position, sample.cycle, cycle);
    lateness.computed.add(now_ns() - start);
    const long computed = time_ns(CLOCK_THREAD_CPUTIME_ID) - processor;
    device.hold(f, cycle >= o.stall_from && cycle < o.stall_from + o.stall_cycles);
    largest_force = std::max(largest_force, length(f));
    if (!o.free_running && now_ns() > due + period) {
      ++lateness.missed;
      lateness.missed_by_us += computed > period / 2;
    }
  }
  const double seconds = 1e-9 * static_cast<double>(now_ns() - begin);
  picture.stop();

  std::printf("%ld cycles in %.1f s, %s, node %ld, coupling %g N/m\n", o.cycles, seconds,
              o.free_running ? "free-running" : "1 kHz", o.node, o.coupling);
  std::printf("computation, us      median %.2f  p99 %.2f  p99.9 %.2f  largest %.2f\n",
              lateness.computed.percentile_us(0.5), lateness.computed.percentile_us(0.99),
              lateness.computed.percentile_us(0.999), lateness.computed.most_us());
  if (!o.free_running) {
    std::printf("wake-up delay, us    median %.2f  p99 %.2f  p99.9 %.2f  largest %.2f\n",
                lateness.woken.percentile_us(0.5), lateness.woken.percentile_us(0.99),
                lateness.woken.percentile_us(0.999), lateness.woken.most_us());
    std::printf("missed deadlines     %ld, of these %ld because of the computation\n", lateness.missed,
                lateness.missed_by_us);
  }
  std::printf("energy               %.3g mJ taken from the hand, at most %.3g mJ generated\n", 1e3 * loop.work(),
              1e3 * loop.most_generated());
  std::printf("force                largest %.3g N; zero for %ld cycles with stale positions\n", largest_force,
              loop.stale_cycles());
  if (touching)
    std::printf("contact              %ld touches, %.1f %% of the cycles\n", touching->touches(),
                100.0 * static_cast<double>(touching->cycles_in_contact()) / static_cast<double>(o.cycles));
  std::printf("outside training     %ld cycles\n", loop.warnings());
  std::printf("picture              %ld frames, slowest deformation %.1f us, largest displacement %.3g mm\n",
              picture.frames(), picture.slowest_frame_us(), 1e3 * picture.largest_displacement_m());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(parse(argc, argv));
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error("results could not be written to stdout");
    return 0;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
