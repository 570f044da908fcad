// A haptic loop at 1 kHz around a trained model: docs/howto/haptic-loop.md.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <phynness/devices/recorded_device.hpp>
#include <phynness/devices/simulated_device.hpp>
#include <phynness/phynness_loop.hpp>
#include <stdexcept>
#include <string>

namespace rt = phynness::rt;
using namespace phynness::devices;

const char* const help =
    "haptic_loop MODEL_DIR --node J [options]   a haptic loop with a simulated hand and device\n"
    "  --contact 1      a sphere touches the surface above node J; 0: the tool holds node J (0)\n"
    "  --radius M       of the sphere (0.004)      --friction MU   of the sphere (0)\n"
    "  --cycles N       milliseconds (10000)       --reach M       of the hand (half of the trained displacement)\n"
    "  --coupling K     in N/m (400)               --damping B     of the simulated device, in Ns/m (0.5)\n"
    "  --latency N      of positions, samples (1)  --motion FILE   replays a motion of node J instead\n"
    "                                                (formats/motion.md)\n"
    "Exit status: 0; 1: an error; 2: wrong options; 3: the loop tripped (the last line says why)\n";

struct Options {
  std::string folder, motion;
  double node = -1, contact = 0, radius = 0.004, friction = 0, cycles = 10000, reach = 0, coupling = 400, damping = 0.5,
         latency = 1;
};

std::string short_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

Options parse(int argc, char** argv) {
  Options o;
  const struct Row {
    const char* name;
    double* value;
    double largest;
    bool is_whole;
  } table[] = {{"--node", &o.node, 1e9, true},          {"--contact", &o.contact, 1, true},
               {"--radius", &o.radius, 0.1, false},     {"--friction", &o.friction, 2, false},
               {"--cycles", &o.cycles, 1e9, true},      {"--reach", &o.reach, 0.2, false},
               {"--coupling", &o.coupling, 1e5, false}, {"--damping", &o.damping, 100, false},
               {"--latency", &o.latency, 100, true}};
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i], text = i + 1 < argc ? argv[i + 1] : "";
    const Row* found = nullptr;
    for (const auto& row : table) found = name == row.name ? &row : found;
    if (name == "--help") std::exit(std::fputs(help, stdout) < 0);
    if (found != nullptr || name == "--motion") ++i;
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (found != nullptr && (text.empty() || *end != 0 || !(number >= 0 && number <= found->largest) ||
                             (found->is_whole && number != std::floor(number))))
      throw std::invalid_argument(name + " needs a " + (found->is_whole ? "whole " : "") + "number from 0 to " +
                                  short_text(found->largest) + ", not \"" + text + "\"");
    if (found != nullptr)
      *found->value = number;
    else if (name == "--motion" && !text.empty())
      o.motion = text;
    else if (name[0] != '-' && o.folder.empty())
      o.folder = name;
    else
      throw std::invalid_argument("unknown option " + name + " (--help)");
  }
  if (o.folder.empty() || o.node < 0) throw std::invalid_argument("a model directory and --node are needed (--help)");
  return o;
}

void check(int status, const std::string& what) {
  if (status < 0) throw std::runtime_error(what + ": " + phn_status_message(status));
}

/// @return the reason for which the loop tripped
int run(const Options& o) {
  // All memory is allocated before the loop.
  const rt::Model model = rt::Model::read((o.folder + "/model.txt").c_str());
  check(model.status(), o.folder + "/model.txt (MODEL_DIR is the output of `phynness train`)");
  const auto node = static_cast<std::int32_t>(o.node);
  const double deepest = model.info().max_displacement_m, reach = o.reach > 0 ? o.reach : 0.5 * deepest;
  SimulatedDeviceSettings simulated;
  simulated.latency_samples = static_cast<int>(o.latency);
  simulated.friction_Ns_per_m = o.damping;
  SimulatedDevice hand(simulated, HandMotion(reach));
  RecordedDevice recorded(o.motion);
  Device& device = o.motion.empty() ? static_cast<Device&>(hand) : recorded;
  device.open();

  phn_loop_settings settings = settings_for(device.traits());
  settings.coupling_N_per_m = o.coupling;
  settings.reach_m = deepest;
  if (!o.motion.empty()) settings.check_force_N = 0;  // test pulses have no effect on a recorded motion
  rt::Tools data(model, 1);
  rt::Contact contact;
  rt::HeldNode held(model, data, node);
  const double rest[3] = {0, 0, 0};
  if (o.contact > 0) contact = rt::Contact(model, 1);
  if (o.contact > 0) check(contact.status(), "--contact");
  check(o.contact > 0 ? int(rt::place_above(model, node, o.radius + 0.2 * reach, settings)) : held.at(rest).status,
        "--node " + std::to_string(node));
  rt::TouchingSphere sphere(contact, data, o.radius, o.friction);
  rt::Loop loop(settings);
  check(loop.status(), "--coupling");
  check(loop.engage(), "engage");

  long n = 0, touching = 0;
  double largest = 0;
  for (; n < static_cast<long>(o.cycles) && device.wait(); ++n) {
    phn_loop_sample sample;
    double tool[3], force[3], really[3];
    const bool arrived = device.read(sample);
    loop.read(arrived ? &sample : nullptr, device.now(), tool).ignore();
    const phn_loop_response response = o.contact > 0 ? sphere.at(tool) : held.at(tool);
    loop.hold(response, device.now(), force).ignore();
    device.hold(force);
    if (device.held(really)) loop.held(really).ignore();
    if (loop.report().state == PHN_LOOP_CHECKING) hand.count_energy_from_now();
    touching += response.in_contact;
    largest = std::fmax(largest, std::hypot(force[0], force[1], force[2]));
  }
  device.close();

  const phn_loop_report r = loop.report();
  std::printf("%s: %ld cycles, touching in %ld, largest force %.3g N\n", device.traits().name.c_str(), n, touching,
              largest);
  std::printf("energy taken from the device %.4g mJ, most delivered %.3g mJ; controller active in %ld cycles\n",
              1e3 * r.work_J, 1e3 * r.most_delivered_J, static_cast<long>(r.limited));
  if (o.motion.empty())
    std::printf("true energy taken %.4g mJ, most delivered %.3g mJ; most given to the hand %.3g mJ\n",
                -1e3 * hand.energy().delivered, 1e3 * hand.energy().most_delivered, 1e3 * hand.energy().most_to_hand);
  std::printf("%s\n", phn_loop_trip_message(r.trip));
  return r.trip;
}

int main(int argc, char** argv) {
  try {
    const int trip = run(parse(argc, argv));
    return std::fflush(stdout) != 0 ? 1 : trip != PHN_TRIP_NONE ? 3 : 0;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
