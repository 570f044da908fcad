// Convergence at extreme parameters, and reasons for failures. Usage: tools/study-robustness [SECTION ...] [--nodes N]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/probe_solver.hpp>

#include "closed_paths.hpp"
#include "exit_status.hpp"
#include "rays.hpp"

namespace {

using namespace phynness;
using namespace phynness::robustness;

const Element elements[] = {element_named("P1"), element_named("p1-p1"), element_named("taylor-hood"),
                            element_named("P2")};
constexpr unsigned seed = 1;

struct Options {
  bool failures = false;
  int nodes = 4, paper_nodes = 12, path_nodes = 4;
};

std::string text(const char* format, double value) {
  char out[64];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

/// Increments at one, two and three element sizes.
const std::vector<std::size_t> element_sizes = {increments_per_element - 1, 2 * increments_per_element - 1,
                                                3 * increments_per_element - 1};
const std::vector<std::string> element_size_names = {"1 h", "2 h", "3 h"};

void cube_row(const std::string& what, const Body& body, const Options& options) {
  const auto tally = follow_rays(body, draw_nodes(body.sets, options.nodes, seed));
  print_row(what, tally, element_sizes);
  if (options.failures) print_failures(tally);
}

void incompressibility(const Options& options) {
  print_header("neo-Hookean cube, 26 directions", element_size_names);
  for (const Element element : elements)
    for (const double ratio : {10.0, 200.0, 2000.0, 23000.0})
      cube_row(text("K/mu %6.0f  ", ratio) + name(element), cube(law_named("neo-hookean"), element, ratio), options);
  print_header("Mooney-Rivlin cube, 26 directions", element_size_names);
  for (const Element element : elements)
    cube_row(text("K/mu %6.0f  ", 23000) + name(element), cube(law_named("mooney-rivlin"), element, 23000), options);
}

void compression(const Options& options) {
  print_header("St. Venant-Kirchhoff cube, inward", element_size_names);
  for (const Element element : elements)
    for (const double ratio : {1.0, 10.0, 200.0}) {
      auto body = cube(law_named("st-venant-kirchhoff"), element, ratio);
      body.scene.probe.directions = Directions::hemisphere;
      cube_row(text("K/mu %6.0f  ", ratio) + name(element), body, options);
    }
}

void slivers(const Options& options) {
  print_header("neo-Hookean cube with slivers", element_size_names);
  constexpr double quality = 0.02;
  for (const Element element : elements) {
    auto body = cube(law_named("neo-hookean"), element, 200);
    const int n = add_slivers(body.mesh, 5, quality);
    cube_row(std::to_string(n) + " cells of " + text("%.3f  ", measure_quality(body.mesh).min_quality) + name(element),
             body, options);
  }
}

/// The same rays in other units, in dimensionless form: the largest difference of forces over the largest force.
void units(const Options& options) {
  std::printf(
      "\nThe same cube in other units: largest difference of a force from that of 0.1 m and 500 Pa, "
      "relative\n");
  std::printf("%-34s %10s %10s %10s %10s\n", "", "1 mm, 1 Pa", "1 mm, 1GPa", "1 m, 1 Pa", "1 m, 1 GPa");
  const auto forces = [&](Law law, Element element, double ratio, double edge_m, double modulus_Pa) {
    const auto body = cube(law, element, ratio, edge_m, modulus_Pa);
    ProbeSolver solver(body.scene, body.mesh, body.sets);
    std::vector<Eigen::Vector3d> all;
    for (const auto node : draw_nodes(body.sets, options.nodes, seed)) {
      solver.touch({node});
      const double d = 0.7 * edge_m / elements_along_edge;
      for (const Vec3& e : {Vec3{0.6, 0, -0.8}, Vec3{0, 0.8, 0.6}}) {
        const auto r = solver.solve({{d * e[0], d * e[1], d * e[2]}}, 2);
        all.push_back(Eigen::Vector3d::Map(r.force_N[0].data()) / (modulus_Pa * edge_m * edge_m));
      }
    }
    return all;
  };
  for (const Law law :
       {law_named("neo-hookean"), law_named("st-venant-kirchhoff"), law_named("mooney-rivlin"), law_named("linear")})
    for (const Element element : elements) {
      const double ratio = 200;
      std::printf("%-34s", (std::string(name(law)) + "  " + name(element)).c_str());
      const auto reference = forces(law, element, ratio, 0.1, 500);
      double size = 0;
      for (const auto& f : reference) size = std::max(size, f.norm());
      for (const double edge_m : {1e-3, 1.0})
        for (const double modulus_Pa : {1.0, 1e9}) {
          const auto scaled = forces(law, element, ratio, edge_m, modulus_Pa);
          double error = 0;
          for (std::size_t i = 0; i < scaled.size(); ++i) error = std::max(error, (scaled[i] - reference[i]).norm());
          std::printf(" %10.1e", error / size);
        }
      std::printf("\n");
      std::fflush(stdout);
    }
}

void paper(const Options& options) {
  const double depth_mm = 1e3 * read_scene(std::string(PHYNNESS_SCENES) + "/liver_case3.toml").probe.max_displacement_m;
  print_header(("paper's liver, node probes, " + text("%.3g mm", depth_mm)).c_str(),
               {text("%.3g mm", depth_mm / 3), text("%.3g mm", 2 * depth_mm / 3), text("%.3g mm", depth_mm)});
  const auto row = [&](const char* what, const char* scene, std::optional<Element> element, int n_nodes) {
    auto body = load(std::string(PHYNNESS_SCENES) + "/" + scene);
    if (element) body.scene.solver.element = *element;
    const auto n = static_cast<std::size_t>(body.scene.probe.increments);
    const std::vector<std::size_t> thirds =
        n == 1 ? std::vector<std::size_t>{0, 0, 0} : std::vector<std::size_t>{n / 3 - 1, 2 * n / 3 - 1, n - 1};
    const auto tally = follow_rays(body, draw_nodes(body.sets, n_nodes, seed));
    print_row(std::string(what) + "  " + name(body.scene.solver.element), tally, thirds);
    if (options.failures) print_failures(tally);
  };
  row("Case 1, linear", "liver_case1.toml", {}, 10 * options.paper_nodes);
  row("Case 3, neo-Hookean", "liver_case3.toml", {}, options.paper_nodes);
  row("Case 3, neo-Hookean", "liver_case3.toml", element_named("p1-p1"), options.paper_nodes);
  row("Case 2, St. Venant-Kirchhoff", "liver_case2.toml", {}, options.paper_nodes);
  row("Case 3, neo-Hookean", "liver_case3.toml", element_named("taylor-hood"), (options.paper_nodes + 5) / 6);
}

void paths(const Options& options) {
  std::printf("\n%-34s %6s %5s %7s %11s %15s %12s %12s %12s\n", "closed paths (two circles a node)", "paths", "open",
              "points", "indefinite", "path-dependent", "vs radial", "loop gap", "work/energy");
  const auto row = [&](const std::string& what, const Body& body, double radius_m) {
    constexpr int n_points = 48;
    const auto t = walk_circles(body, draw_nodes(body.sets, options.path_nodes, seed), radius_m, n_points);
    std::printf("%-34s %6d %5d %7d %10.1f%% %8d of %3d %12.1e %12.1e %12.1e\n", what.c_str(), t.paths, t.open, t.points,
                100.0 * t.indefinite / std::max(1, t.points), t.different, t.compared, t.largest_difference,
                t.largest_gap, t.largest_work);
    if (t.different > 0)
      std::printf(
          "    radial energy higher in %d, found by four times the increments in %d; worst at node %d, "
          "displacement "
          "(%.4g, %.4g, %.4g) m\n",
          t.radial_higher, t.finer_agrees, t.worst_node, t.worst_displacement_m[0], t.worst_displacement_m[1],
          t.worst_displacement_m[2]);
    std::fflush(stdout);
  };
  for (const double share : {0.25, 0.5, 1.0}) {
    const auto body = load(std::string(PHYNNESS_SCENES) + "/liver_case3.toml");
    const double radius_m = share * body.scene.probe.max_displacement_m;
    row("Case 3  P1  " + text("%.0f mm", 1e3 * radius_m), body, radius_m);
  }
  for (const double share : {0.25, 0.5, 1.0}) {
    auto body = load(std::string(PHYNNESS_SCENES) + "/liver_case3.toml");
    body.scene.solver.element = element_named("p1-p1");
    const double radius_m = share * body.scene.probe.max_displacement_m;
    row("Case 3  p1-p1  " + text("%.0f mm", 1e3 * radius_m), body, radius_m);
  }
  for (const Element element : {element_named("taylor-hood"), element_named("P2")})
    for (const double sizes : {1.0, 2.0}) {
      const auto body = cube(law_named("neo-hookean"), element, 200);
      row(std::string("cube K/mu 200  ") + name(element) + text("  %.0f h", sizes), body,
          sizes * body.scene.probe.max_displacement_m / 3);
    }
}

const std::vector<std::pair<std::string, void (*)(const Options&)>> sections = {
    {"incompressibility", incompressibility},
    {"compression", compression},
    {"slivers", slivers},
    {"units", units},
    {"paper", paper},
    {"paths", paths}};

int run(int argc, char** argv) {
  Options options;
  std::vector<std::string> wanted;
  CLI::App app{"Convergence at extreme parameters, and reasons for failures (docs/robustness.md)"};
  std::vector<std::string> names;
  for (const auto& [section, work] : sections) names.push_back(section);
  app.add_option("SECTION", wanted, "tables to compute (default: all)")->check(CLI::IsMember(names));
  app.add_option("--nodes", options.nodes, "number of probed nodes of the cube")->check(CLI::Range(1, 1000));
  app.add_option("--paper-nodes", options.paper_nodes,
                 "number of probed nodes of the liver (Case 1: ten times as many)")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--failures", options.failures, "print every ray that does not reach full depth, with the reason");
  app.add_option("--path-nodes", options.path_nodes, "number of nodes with closed paths")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const SolverSession session;
  for (const auto& [section, work] : sections)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), section) != wanted.end()) work(options);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
