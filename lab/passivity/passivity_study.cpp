// Energies of haptic loops around trained models: what the observer tells beside the truth in the simulated device, the
// list of points at which the loop must be passive, and the map of couplings against latency and damping.
#include <fmt/format.h>
#include <phynness/devices/simulated_device.hpp>
#include <phynness/phynness_loop.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

namespace {

using phynness::devices::HandMotion;
using phynness::devices::SimulatedDevice;
using phynness::devices::SimulatedDeviceSettings;
namespace rt = phynness::rt;

struct Result {
  double taken = 0, most_delivered = 0, most_to_hand = 0, gross = 0, difference = 0, largest = 0;
  long limited = 0, touching = 0;
  int trip = 0;
  double us_per_cycle = 0;
};

struct Case {
  std::string folder;
  int node = 0;
  bool contact = false, controller = true;
  double reach = 0, coupling = 400, friction = 0;
  double harder = 1;  ///< factor of the forces: those of a material that is so much stiffer
  double depth = 0;   ///< of the resting position inside the body [m]
  long cycles = 0;
  SimulatedDeviceSettings device;
};

void scale(phn_loop_response& r, double by) {
  for (double& f : r.force) f *= by;
  for (double& k : r.stiffness) k *= by;
  if (r.energy > 0) r.energy *= by;
}

Result run(const Case& c) {
  const rt::Model model = rt::Model::read((c.folder + "/model.txt").c_str());
  if (!model) throw std::runtime_error(c.folder + "/model.txt: " + model.status().message());
  rt::Tools data(model, 1);
  rt::HeldNode held(model, data, c.node);
  rt::Contact contact;
  SimulatedDevice device(c.device, HandMotion(c.reach));
  phn_loop_settings settings = phynness::devices::settings_for(device.traits());
  settings.coupling_N_per_m = c.coupling;
  settings.passivity_controller = c.controller ? 1 : 0;
  settings.reach_m = model.info().max_displacement_m;
  if (!c.controller) settings.trip_energy_J = settings.trip_force_N = settings.trip_speed_m_per_s = 0;
  settings.origin_m[2] = -c.depth;
  if (c.contact) {
    contact = rt::Contact(model, 1);
    rt::place_above(model, c.node, 0.004 + 0.2 * c.reach, settings).ignore();
  }
  rt::TouchingSphere sphere(contact, data, 0.004, c.friction);
  rt::Loop loop(settings);
  loop.engage().ignore();
  Result r;
  std::vector<double> taken{0};
  std::chrono::duration<double> computing{0};
  bool counting = false;
  for (long i = 0; i < c.cycles; ++i) {
    phn_loop_sample sample;
    double tool[3], force[3], really[3];
    const bool arrived = device.read(sample);
    const auto start = std::chrono::steady_clock::now();
    loop.read(arrived ? &sample : nullptr, device.now(), tool).ignore();
    phn_loop_response response = c.contact ? sphere.at(tool) : held.at(tool);
    scale(response, c.harder);
    loop.hold(response, device.now(), force).ignore();
    computing += std::chrono::steady_clock::now() - start;
    const phn_loop_report report = loop.report();
    if (report.state == PHN_LOOP_CHECKING) {
      device.count_energy_from_now();
    } else {
      counting = true;
    }
    if (counting) {
      const double periods = (device.now() - report.latency_s) / settings.period_s;
      const auto at =
          std::clamp(static_cast<std::size_t>(std::max(0.0, periods + 1e-9)), std::size_t{0}, taken.size() - 1);
      const auto next = std::min(at + 1, taken.size() - 1);
      const double share = std::clamp(periods - static_cast<double>(at), 0.0, 1.0);
      r.difference = std::max(r.difference, std::fabs((1 - share) * taken[at] + share * taken[next] - report.work_J));
    }
    device.hold(force);
    taken.push_back(counting ? -device.energy().delivered : 0);
    if (device.held(really)) loop.held(really).ignore();
    r.touching += response.in_contact;
    r.largest = std::max(r.largest, counting ? std::hypot(force[0], force[1], force[2]) : 0);
  }
  const auto& e = device.energy();
  r.taken = -e.delivered;
  r.most_delivered = e.most_delivered;
  r.most_to_hand = e.most_to_hand;
  r.gross = e.gross;
  r.limited = static_cast<long>(loop.report().limited);
  r.trip = loop.report().trip;
  r.us_per_cycle = 1e6 * computing.count() / static_cast<double>(c.cycles);
  return r;
}

bool colgate(double coupling, double damping, int latency, double of_coupling) {
  return damping > coupling * 1e-3 * (0.5 + latency) + of_coupling;
}

void observer(Case c) {
  struct Point {
    const char* name;
    double jitter_s, late_s, lost, twice;
  };
  fmt::print(
      "| positions | latency | coupling, N/m | damping, Ns/m | exchanged, mJ | difference, mJ | % "
      "|\n|---|---|---|---|---|---|---|\n");
  double worst = 0;
  for (const Point& p : {Point{"regular", 0, 0, 0, 0}, Point{"jitter 0.4 ms", 4e-4, 0, 0, 0},
                         Point{"late up to 3 ms, reordered", 0, 3e-3, 0, 0}, Point{"5 % lost", 0, 0, 0.05, 0},
                         Point{"10 % lost, 10 % twice, late 2 ms", 3e-4, 2e-3, 0.1, 0.1}}) {
    for (int latency = 0; latency <= 5; ++latency) {
      for (const double coupling : {100.0, 400.0, 1000.0, 2000.0}) {
        for (const double damping : {0.05, 0.5, 2.0}) {
          c.coupling = coupling;
          c.device.latency_samples = latency;
          c.device.friction_Ns_per_m = damping;
          c.device.jitter_s = p.jitter_s;
          c.device.late_s = p.late_s;
          c.device.lost = p.lost;
          c.device.twice = p.twice;
          c.controller = false;
          c.cycles = 10'000;
          const Result r = run(c);
          const double share = 100 * r.difference / r.gross;
          const bool within = r.difference <= std::max(2e-5, 0.02 * r.gross);
          if (share > worst || !within)
            fmt::print("| {} | {} | {} | {} | {:.4g} | {:.3g} | {:.2g}{} |\n", p.name, latency, coupling, damping,
                       1e3 * r.gross, 1e3 * r.difference, share, within ? "" : " beyond the bound");
          worst = std::max(worst, share);
        }
      }
    }
  }
  fmt::print("360 points; rows: each new largest share. Largest: {:.2g} %\n\n", worst);
}

void list(Case c) {
  fmt::print(
      "| latency | damping, Ns/m | coupling, N/m | Colgate | delivered at most, mJ | to the hand at most, mJ | "
      "controller active, % | trip |\n|---|---|---|---|---|---|---|---|\n");
  for (const int latency : {0, 1, 2}) {
    for (const double damping : {0.5, 2.0}) {
      for (const double coupling : {100.0, 200.0, 400.0, 700.0, 1000.0, 1500.0, 2000.0}) {
        c.coupling = coupling;
        c.device.latency_samples = latency;
        c.device.friction_Ns_per_m = damping;
        const Result r = run(c);
        fmt::print("| {} | {} | {} | {} | {:.3f} | {:.3f} | {:.2f} | {} |\n", latency, damping, coupling,
                   colgate(coupling, damping, latency, 0.2) ? "yes" : "no", 1e3 * r.most_delivered,
                   1e3 * r.most_to_hand, 100.0 * static_cast<double>(r.limited) / static_cast<double>(c.cycles),
                   r.trip);
      }
    }
  }
  fmt::print("\n");
}

/// A hand that does not move, inside the body from the beginning: what the loop delivers, and what its observer misses.
void still(Case c) {
  fmt::print(
      "| positions in steps of, mm | latency | coupling, N/m | delivered at most, mJ | to the hand at most, mJ | "
      "observer differs by, mJ | trip |\n|---|---|---|---|---|---|---|\n");
  c.depth = 0.75 * c.reach;
  c.reach = 0;
  for (const double resolution : {0.0, 1e-5, 2e-5, 5e-5}) {
    for (const int latency : {0, 1, 2}) {
      for (const double coupling : {400.0, 2000.0}) {
        c.coupling = coupling;
        c.device.resolution_m = resolution;
        c.device.latency_samples = latency;
        const Result r = run(c);
        fmt::print("| {} | {} | {} | {:.3f} | {:.3f} | {:.3f} | {} |\n", 1e3 * resolution, latency, coupling,
                   1e3 * r.most_delivered, 1e3 * r.most_to_hand, 1e3 * r.difference, r.trip);
      }
    }
  }
  fmt::print("\n");
}

/// Energy delivered in 20 s without the controller, and the share of cycles in which the controller acts, as CSV.
void map(Case c, const std::string& file) {
  std::ofstream out(file);
  out << "damping_Ns_per_m,latency_samples,coupling_N_per_m,colgate,delivered_without_controller_J,"
         "delivered_with_controller_J,controller_active,trip\n";
  c.cycles = 20'000;
  for (const double damping : {0.05, 0.5, 2.0}) {
    for (int latency = 0; latency <= 5; ++latency) {
      for (const double coupling : {50.0, 100.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1000.0, 1400.0, 2000.0, 3000.0}) {
        c.coupling = coupling;
        c.device.latency_samples = latency;
        c.device.friction_Ns_per_m = damping;
        c.controller = false;
        const Result without = run(c);
        c.controller = true;
        const Result with = run(c);
        out << fmt::format("{},{},{},{},{:.4g},{:.4g},{:.4g},{}\n", damping, latency, coupling,
                           colgate(coupling, damping, latency, 0.2) ? 1 : 0, without.most_delivered,
                           with.most_delivered, static_cast<double>(with.limited) / static_cast<double>(c.cycles),
                           with.trip);
      }
    }
  }
  if (!out.flush()) throw std::runtime_error(file + " cannot be written; choose another --csv");
  fmt::print("map: {}\n", file);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Energies of haptic loops around a trained model");
  Case c;
  std::string section = "list", csv = "passivity_map.csv";
  app.add_option("MODEL_DIR", c.folder)->required();
  app.add_option("--node", c.node)->required();
  app.add_option("--section", section, "observer, list, still, map or long")
      ->check(CLI::IsMember({"observer", "list", "still", "map", "long"}));
  app.add_option("--reach", c.reach, "of the hand's motion [m]")->default_val(0.02);
  app.add_flag("--contact", c.contact, "a sphere of 4 mm that touches, instead of a held node");
  app.add_option("--friction", c.friction, "of that sphere");
  app.add_option("--cycles", c.cycles, "of each point of list and still")->default_val(100'000);
  app.add_option("--harder", c.harder, "factor of the forces of the body");
  app.add_option("--csv", csv, "of the map");
  CLI11_PARSE(app, argc, argv);
  try {
    if (section == "observer") observer(c);
    if (section == "list") list(c);
    if (section == "still") still(c);
    if (section == "map") map(c, csv);
    if (section == "long") {
      c.cycles = 10'000'000;
      const Result r = run(c);
      fmt::print(
          "10,000,000 cycles: delivered at most {:.3g} mJ, to the hand at most {:.3g} mJ, largest force {:.3g} N, "
          "touching {} cycles, {:.2f} us a cycle: {}\n",
          1e3 * r.most_delivered, 1e3 * r.most_to_hand, r.largest, r.touching, r.us_per_cycle,
          phn_loop_trip_message(r.trip));
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
