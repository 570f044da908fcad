// Times of the runtime on one core compared with plain loops, for models of the size of the paper's liver.
// Usage: phynness_runtime_bench [--json FILE] [--model MODEL_DIR]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <phynness/training/conservative_fit.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "fine_surface.hpp"
#include "force_accuracy.hpp"
#include "timed_model.hpp"

namespace {

using namespace phynness;
using bench::check;
using bench::displacement;
using bench::median_us;
using bench::sink;

constexpr int n_neurons_force = 100, n_neurons_deformation = 200, n_levels = 3;

struct Loaded : bench::TimedModel {
  explicit Loaded(const std::string& text) : TimedModel(text), surface(organ.model(), n_levels) {
    check(surface.status());
  }
  void refine() { surface.deform(field.data()); }

  FineSurface surface;
};

class Table {
 public:
  void add(const std::string& key, double value, const std::string& words) {
    std::printf(value < 0.005 ? "  %-38s %12.1e   %s\n" : "  %-38s %12.3f   %s\n", key.c_str(), value, words.c_str());
    std::fflush(stdout);
    _json += (_json.empty() ? "{\"" : ", \"") + key + "\": " + number(value);
  }
  /// Adds the time of a loop and its ratio to that of the runtime.
  /// @param unit  of the key, per microsecond
  void beside(const std::string& key, const bench::SideBySide& times, std::size_t at, const std::string& words,
              double unit = 1) {
    add(key, unit * times.us[at], words);
    add(key + "_ratio", times.ratio[at], "ratio to the runtime in the same round");
  }
  bool write(const std::string& file) const {
    std::ofstream out(file);
    out << _json << "}\n";
    return static_cast<bool>(out);
  }

 private:
  /// With all digits, because rounding errors are small.
  static std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
  }

  std::string _json;
};

double frames_per_s(Loaded& loaded, std::int32_t touched) {
  return 1e6 / median_us([&](int i) {
           double d[3];
           displacement(i, d);
           loaded.deform(touched, d);
           loaded.refine();
           sink = static_cast<double>(loaded.surface.displacements[0]);
         });
}

/// Checks that both builds of the loops compute the same field with and without the table. Tolerance: 200 terms of size
/// 1, each with the rounding of `Real` and of its exponential.
template <class Real>
void require_same_fields(bench::PlainDeformation<Real>& plain) {
  plain.from_network(bench::textbook_loops<Real>(), 7);
  const auto expected = plain.field;
  const auto require_expected = [&] {
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (!(std::abs(plain.field[i] - expected[i]) < 1000 * std::numeric_limits<Real>::epsilon()))
        throw std::runtime_error("the results of the plain loops differ");
  };
  plain.from_network(bench::fast_math_loops<Real>(), 7);
  require_expected();
  plain.from_table(bench::textbook_loops<Real>(), 7);
  require_expected();
  plain.from_table(bench::fast_math_loops<Real>(), 7);
  require_expected();
}

/// The network at every point, with and without a table, by both loops.
template <class Real>
void bench_deformation(Table& table, Loaded& loaded) {
  bench::PlainDeformation<Real> plain(n_neurons_deformation, bench::n_output);
  require_same_fields(plain);
  const auto &textbook = bench::textbook_loops<Real>(), &fast_math = bench::fast_math_loops<Real>();
  const auto node = loaded.node(3);
  const auto times = bench::side_by_side(
      {[&](int i) {
         double d[3];
         displacement(i, d);
         loaded.deform(node, d);
         sink = loaded.field[0];
       },
       [&](int i) { plain.from_network(textbook, i); }, [&](int i) { plain.from_network(fast_math, i); },
       [&](int i) { plain.from_table(textbook, i); }, [&](int i) { plain.from_table(fast_math, i); }});
  table.add("deformation_us_486x200", times.us[0], "486 nodes, 200 neurons [us]");
  table.beside("deformation_us_486x200_plain", times, 1, "textbook loop over the network at every node [us]");
  table.beside("deformation_us_486x200_fast_math", times, 2, "the same with -ffast-math and libmvec [us]");
  table.beside("deformation_us_486x200_table", times, 3, "textbook loop over a table of the nodes' factors [us]");
  table.beside("deformation_us_486x200_table_fast_math", times, 4, "the same with -ffast-math [us]");
  table.add("deformation_plain_over_table", times.ratio[1] / times.ratio[3], "speedup by the table");
}

template <class Real>
void bench_networks(Table& table) {
  constexpr int n_nodes = 20;
  Loaded loaded(write_model_text(bench::networks_model(n_neurons_force, n_neurons_deformation, n_nodes)));
  const bench::PlainForces<Real> plain(n_neurons_force, n_nodes);
  const auto times =
      bench::side_by_side({[&](int i) { loaded.force(i); }, [&](int i) { plain(bench::textbook_loops<Real>(), i); },
                           [&](int i) { plain(bench::fast_math_loops<Real>(), i); }});
  table.add("force_ns_100", 1e3 * times.us[0], "force of 100 neurons, 20 nodes in turn [ns]");
  table.beside("force_ns_100_plain", times, 1, "textbook loop, in the same precision [ns]", 1e3);
  table.beside("force_ns_100_fast_math", times, 2, "the same with -ffast-math and libmvec [ns]", 1e3);
  bench_deformation<Real>(table, loaded);
  table.add("frames_per_s_38018_rbfn", frames_per_s(loaded, loaded.node(3)),
            "the same with three levels of subdivision");
  table.add("frames_per_s_38018_plain", 1e6 / bench::plain_deformation_us(n_neurons_deformation, 38018),
            "textbook loop at every point, in double");
}

void bench_modes(Table& table, Loaded& loaded) {
  const auto times =
      bench::side_by_side({[&](int i) { loaded.force(i); }, [&](int i) { loaded.force_and_stiffness(i); },
                           [&](int i) { loaded.force_energy_and_stiffness(i); }});
  table.add("force_ns_modal", 1e3 * times.us[0], "force of family modal [ns]");
  table.beside("force_stiffness_ns_modal", times, 1, "force and stiffness [ns]", 1e3);
  table.beside("force_energy_stiffness_ns_modal", times, 2, "force, energy and stiffness [ns]", 1e3);
  std::int32_t next = 0;
  const double prepare = median_us([&](int) {
    // Every fourth node in turn, which is never among the three prepared nodes.
    check(loaded.prepare(loaded.node(next = (next + 1) % 4)));
  });
  const double unprepared = median_us([&](int i) {
    double d[3];
    displacement(i, d);
    loaded.deform(loaded.node(next = (next + 1) % 4), d);
    sink = loaded.field[0];
  });
  check(loaded.prepare(loaded.node(7)));
  const double modal = loaded.deformation_us(loaded.node(7));
  table.add("deformation_us_486_modal", modal, "deformation of a prepared node [us]");
  table.add("deformation_us_486_modal_first", unprepared, "first deformation of a node, with preparation [us]");
  table.add("prepare_us_486_modal", prepare, "phn_prepare [us]");
  table.add("surface_us_38018", median_us([&](int) {
              loaded.refine();
              sink = static_cast<double>(loaded.surface.displacements[0]);
            }),
            "three levels of subdivision [us]");
  table.add("frames_per_s_38018_modal", frames_per_s(loaded, loaded.node(7)), "deformation with subdivision");
}

void accuracy_of_forces(Table& table, const Model& model, Loaded& loaded) {
  if (!schema::traits(model.family).has_modes) return;
  const auto rounding = bench::rounding_of_forces(model, loaded.organ);
  table.add("force_rounding_median", rounding.median,
            "largest difference from sums in double, over the largest force of the node: median over nodes");
  table.add("force_rounding_max", rounding.worst, "the worst node");
  for (const double share : {1.0, 0.1}) {
    const auto work = bench::work_of_loops(model, loaded.organ, share);
    const std::string size = share < 1 ? "_tenth" : "",
                      of = share < 1 ? " of a tenth of the trained depth" : " of the trained depth";
    table.add("loop_work_median" + size, work.median,
              "work along closed loops" + of + ", over the largest energy on the path: median");
    table.add("loop_work_max" + size, work.worst, "the worst loop");
  }
}

struct Contact {
  explicit Contact(Loaded& l) : loaded(l) { check(l.organ.reset()); }
  phn_contact_state step(const phn_contact_tool& tool) {
    phn_contact_state state;
    check(loaded.organ.touch({&tool, 1}, {&state, 1}));
    return state;
  }
  /// A tool of 4 mm on a circle of 1 cm over the middle of the body, in steps of 0.1 mm, at `depth` below first
  /// contact.
  std::vector<phn_contact_tool> circle(double depth, double friction) {
    const phn_info& info = loaded.organ.info();
    const double* x = info.output_points;
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = high[k] = x[k];
      for (int o = 0; o < info.n_output; ++o) {
        low[k] = std::min(low[k], x[3 * o + k]);
        high[k] = std::max(high[k], x[3 * o + k]);
      }
    }
    std::vector<phn_contact_tool> path;
    for (int i = 0; i < 628; ++i) {
      phn_contact_tool tool = {{(low[0] + high[0]) / 2 + 0.01 * std::cos(0.01 * i),
                                (low[1] + high[1]) / 2 + 0.01 * std::sin(0.01 * i), high[2] + 0.02},
                               0.004,
                               friction,
                               PHN_TOOL_GRASP};  // sticks at any force
      check(loaded.organ.reset());
      step(tool);
      tool.center[2] = (low[2] + high[2]) / 2;
      tool.center[2] = step(tool).proxy[2] - depth;
      tool.mode = PHN_TOOL_PRESS;
      path.push_back(tool);
    }
    return path;
  }
  double cycle_us(double depth, double friction, bool moves) {
    const std::vector<phn_contact_tool> path = circle(depth, friction);
    phn_contact_tool above = path[0];
    above.center[2] += depth + 0.001;
    check(loaded.organ.reset());
    step(above);
    std::size_t next = 0;
    return median_us([&](int) { sink = step(path[moves ? ++next % path.size() : 0]).force[0]; });
  }

  Loaded& loaded;
};

/// Times of queries. For trained models also times of contact cycles and of one coupled force; with arbitrary
/// coefficients the positions of tools would be arbitrary, too.
void bench_contact(Table& table, Loaded& loaded, bool trained) {
  Contact contact(loaded);
  const auto path = contact.circle(0, 0);
  table.add("nearest_us", median_us([&](int i) {
              phn_tool found;
              double point[3];
              check(loaded.organ.nearest(path[static_cast<std::size_t>(i) % path.size()].center, found, point));
              sink = point[0];
            }),
            "phn_nearest [us]");
  table.add("contact_us_free", contact.cycle_us(-0.001, 0, true), "cycle of a tool 1 mm above the surface [us]");
  if (!trained) return;
  phn_tool held;
  check(loaded.organ.nearest(path[0].center, held));
  held.displacement[2] = -0.005;
  table.add("couple_us", median_us([&](int) {
              double force[3];
              check(phn_couple(loaded.organ.model(), loaded.organ.data(), 1, &held, force, nullptr));
              sink = force[0];
            }),
            "phn_couple of one tool [us]");
  table.add("contact_us_sticking", contact.cycle_us(0.005, 1e3, false), "cycle of a pressed, sticking tool [us]");
  table.add("contact_us_sliding", contact.cycle_us(0.005, 0.3, true), "cycle of a tool that slides with friction [us]");
  table.add("contact_us_frictionless", contact.cycle_us(0.005, 0, true),
            "cycle of a tool that slides without friction [us]");
}

/// Several tools, distributed over the body and moved at every call: at nodes, and in the middles of triangles.
void bench_several_tools(Table& table, const Loaded& loaded) {
  constexpr std::size_t most = 8;
  Organ organ(loaded.text, {}, int{most});
  check(organ.status());

  std::vector<phn_tool> at_nodes, between;
  const phn_info& info = organ.info();
  const std::set<std::int32_t> touchable(info.active_nodes, info.active_nodes + info.n_active);
  for (const std::int32_t node : touchable) at_nodes.push_back({{node, -1, -1}, {1, 0, 0}, {}});
  for (int t = 0; t < info.n_triangles; ++t) {
    const std::int32_t* nodes = info.triangles + 3 * t;
    if (!std::all_of(nodes, nodes + 3, [&](std::int32_t node) { return touchable.count(node) == 1; })) continue;
    between.push_back({{nodes[0], nodes[1], nodes[2]}, {0.4, 0.3, 0.3}, {}});
  }
  if (between.size() < most) return;
  const auto couple_us = [&](const std::vector<phn_tool>& places, std::size_t n_tools) {
    std::array<phn_tool, most> tools;
    for (std::size_t k = 0; k < n_tools; ++k) tools[k] = places[places.size() * k / n_tools];
    return median_us([&](int i) {
      for (std::size_t k = 0; k < n_tools; ++k) displacement(i + 7 * static_cast<int>(k), tools[k].displacement);
      double forces[3 * most];
      check(phn_couple(organ.model(), organ.data(), static_cast<std::int32_t>(n_tools), tools.data(), forces, nullptr));
      sink = forces[0];
    });
  };
  double forces[6];
  const std::array<phn_tool, 2> two = {at_nodes.front(), at_nodes.back()};
  const bool round = organ.hold(two, forces) == PHN_ERROR_ROUND_TOOLS;
  for (const std::size_t n_tools : {1u, 2u, 4u, 8u}) {
    if (round && n_tools > 1) break;
    const std::string n = std::to_string(n_tools), tools = n + (n_tools == 1 ? " tool" : " tools");
    table.add("couple_us_nodes_" + n, couple_us(at_nodes, n_tools), tools + " at nodes [us]");
    table.add("couple_us_between_" + n, couple_us(between, n_tools), tools + " between nodes [us]");
  }
}

int run(int argc, char** argv) {
  std::string json, model_dir;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--json") json = argv[i + 1];
    if (option == "--model") model_dir = argv[i + 1];
  }
  if (argc != 1 + 2 * (!json.empty() + !model_dir.empty())) {
    std::fprintf(stderr, "usage: %s [--json FILE] [--model MODEL_DIR]\n", argv[0]);
    return 2;
  }
  Table table;
  std::printf("runtime, one core, medians; models of arbitrary coefficients, 486 output nodes, 596 vertices\n");
  bench_networks<double>(table);
  std::printf("family modal: 64 shared and 16 own modes, 78 centers of amplitudes, 30 near nodes, 78 of forces\n");
  {
    Loaded loaded(write_model_text(bench::modal_model(78, 64, 16, 78, 30, bench::n_output)));
    if (loaded.surface.n_vertices() != 38018) throw std::runtime_error("not 38018 vertices");
    bench_modes(table, loaded);
    bench_contact(table, loaded, false);
  }
  if (!model_dir.empty()) {
    const std::string text = read_model_texts(model_dir).model;
    Loaded loaded(text);
    std::printf("%s: %d output nodes, %d fine vertices (not in the JSON file)\n", model_dir.c_str(),
                loaded.organ.info().n_output, loaded.surface.n_vertices());
    Table other;
    bench_modes(other, loaded);
    accuracy_of_forces(other, read_model_text(text, model_dir), loaded);
    bench_contact(other, loaded, true);
    bench_several_tools(other, loaded);
  }
  if (json.empty() || table.write(json)) return 0;
  std::fprintf(stderr, "writing failed: %s\n", json.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
