// CPU time per converged increment of the plain loop and of ProbeSolver, for the same rays in the same run. Nodes and
// directions are a random sample, because all rays of a node would take the plain loop minutes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <random>

#include "exit_status.hpp"
#include "plain_loop.hpp"

namespace {

using namespace phynness;

double cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Options {
  std::string scene = PHYNNESS_SCENES "/liver_case3.toml";
  std::vector<std::string> elements = {"P1", "p1-p1", "P2", "taylor-hood"};
  int nodes = 4, rays = 4, increments = 0, only_node = -1, only_direction = -1;
  unsigned seed = 1;
  double depth_m = 0, bulk_over_shear = 0;
  bool plain = true, verbose = false;
  std::string json;
};

struct Sample {
  std::vector<std::int32_t> node;
  std::vector<std::vector<int>> directions;  // per node
};

Sample draw(const Options& options, const NodeSets& sets, int n_directions) {
  std::mt19937 random(options.seed);
  Sample sample;
  std::sample(sets.active.begin(), sets.active.end(), std::back_inserter(sample.node), options.nodes, random);
  for (std::size_t i = 0; i < sample.node.size(); ++i) {
    std::vector<int> all(n_directions), some;
    for (int d = 0; d < n_directions; ++d) all[d] = d;
    std::sample(all.begin(), all.end(), std::back_inserter(some), options.rays, random);
    sample.directions.push_back(some);
  }
  if (options.only_node >= 0) sample = {{options.only_node}, {{std::max(0, options.only_direction)}}};
  return sample;
}

struct Tally {
  double cpu_ms = 0;
  int converged = 0, tried = 0, full_rays = 0, rays = 0, cutbacks = 0;
  SolverCounts counts;
  double per_increment(double x) const { return x / std::max(1, converged); }
};

void print(const char* name, const Tally& t) {
  std::printf("  %-10s %4d of %4d  %7.2f %8.2f %8.2f %8.2f %8.2f %9.2f ms\n", name, t.converged, t.tried,
              t.per_increment(t.cutbacks), t.per_increment(static_cast<double>(t.counts.residuals)),
              t.per_increment(static_cast<double>(t.counts.tangents)),
              t.per_increment(static_cast<double>(t.counts.factorizations)),
              t.per_increment(static_cast<double>(t.counts.substitutions)), t.per_increment(t.cpu_ms));
  std::fflush(stdout);
}

std::string key_of(std::string element) {
  std::transform(element.begin(), element.end(), element.begin(),
                 [](unsigned char c) { return c == '-' ? '_' : static_cast<char>(std::tolower(c)); });
  return element;
}

/// Results of one solver for the sample.
struct Run {
  Tally tally;
  std::vector<Vec3> force;  ///< 0 if not converged
  std::vector<double> ray_ms;
  std::vector<char> full;  ///< rays to full depth
};

struct Task {
  const Scene& scene;
  const Mesh& mesh;
  const NodeSets& sets;
  DatabaseHeader header;
  Sample sample;
  int n_increments() const { return static_cast<int>(header.magnitudes_m.size()); }
};

Run run_plain(const Task& task) {
  Run run;
  const int n = task.n_increments();
  bench::PlainLoop loop(task.scene, task.mesh, task.sets);
  const double start = cpu_ms();
  for (std::size_t a = 0; a < task.sample.node.size(); ++a)
    for (const int d : task.sample.directions[a]) {
      Vec3 depth = task.header.directions[d];
      for (auto& x : depth) x *= task.header.magnitudes_m.back();
      const double before = cpu_ms();
      const auto states = loop.ray(task.sample.node[a], depth, n);
      run.ray_ms.push_back(cpu_ms() - before);
      for (const auto& state : states) run.tally.converged += state.converged;
      for (int i = 0; i < n; ++i) run.force.push_back(i < static_cast<int>(states.size()) ? states[i].force_N : Vec3{});
      run.tally.tried += n;
      ++run.tally.rays;
      run.full.push_back(states.back().converged && static_cast<int>(states.size()) == n);
      run.tally.full_rays += run.full.back();
    }
  run.tally.cpu_ms = cpu_ms() - start;
  run.tally.counts = loop.counts();
  return run;
}

void print_increment(std::int32_t node, int direction, std::size_t increment, const Response& response,
                     const SolverCounts& before, const SolverCounts& after) {
  std::printf(
      "node %d direction %d increment %zu: status %d, %d iterations, %d cutbacks, J "
      "%.3f, negative pivots %d, %lld factorizations, %lld residuals\n",
      node, direction, increment, static_cast<int>(response.status), response.iterations, response.cutbacks,
      response.min_jacobian, response.negative_pivots,
      static_cast<long long>(after.factorizations - before.factorizations),
      static_cast<long long>(after.residuals - before.residuals));
}

Run run_ours(const Task& task, bool verbose) {
  Run run;
  ProbeSolver solver(task.scene, task.mesh, task.sets);
  const double start = cpu_ms();
  double touching = 0;
  for (std::size_t a = 0; a < task.sample.node.size(); ++a) {
    // The preparation of a node is shared by all of its rays, of which only some are in the sample.
    const double before = cpu_ms();
    solver.touch({task.sample.node[a]});
    touching += (cpu_ms() - before) * (1 - static_cast<double>(task.sample.directions[a].size()) /
                                               static_cast<double>(task.header.directions.size()));
    for (const int d : task.sample.directions[a]) {
      bool all = true;
      SolverCounts last = solver.counts();
      const double ray_start = cpu_ms();
      solver.follow({task.header.directions[d]}, task.header.magnitudes_m, false,
                    [&](std::size_t i, const Response& response) {
                      const bool good = response.status == Status::converged;
                      run.tally.converged += good;
                      run.tally.cutbacks += response.cutbacks;
                      if (verbose) {
                        print_increment(task.sample.node[a], d, i, response, last, solver.counts());
                        last = solver.counts();
                      }
                      all = all && good;
                      run.force.push_back(good ? response.force_N[0] : Vec3{});
                      return true;
                    });
      run.ray_ms.push_back(cpu_ms() - ray_start);
      run.tally.tried += task.n_increments();
      ++run.tally.rays;
      run.full.push_back(all);
      run.tally.full_rays += all;
    }
  }
  run.tally.cpu_ms = cpu_ms() - start - touching;
  run.tally.counts = solver.counts();
  return run;
}

struct Agreement {
  double worst = 0;
  int compared = 0, elsewhere = 0;
};

Agreement compare(const std::vector<Vec3>& plain, const std::vector<Vec3>& ours) {
  Agreement found;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> a(plain[i].data()), b(ours[i].data());
    if (a.norm() == 0 || b.norm() == 0) continue;
    ++found.compared;
    const double error = (a - b).norm() / a.norm();
    if (error > 1e-4)
      ++found.elsewhere;  // a different equilibrium, not a difference by rounding
    else
      found.worst = std::max(found.worst, error);
  }
  return found;
}

void report_ratio(const Run& plain, const Run& ours, int n, const std::string& key, nlohmann::ordered_json& json) {
  const Agreement found = compare(plain.force, ours.force);
  const double ratio = plain.tally.per_increment(plain.tally.cpu_ms) / ours.tally.per_increment(ours.tally.cpu_ms);
  std::printf(
      "  ratio %.2f; rays to full depth %d and %d of %d; forces of %d common states agree to %.1e, %d are "
      "other equilibria\n",
      ratio, plain.tally.full_rays, ours.tally.full_rays, ours.tally.rays, found.compared, found.worst,
      found.elsewhere);
  double plain_common = 0, our_common = 0;
  for (std::size_t r = 0; r < plain.full.size(); ++r)
    if (plain.full[r]) {
      plain_common += plain.ray_ms[r];
      our_common += ours.ray_ms[r];
    }
  const int increments = std::max(1, plain.tally.full_rays * n);
  std::printf(
      "  on the %d rays that the plain loop brings to full depth: %.2f and %.2f ms per increment, ratio "
      "%.2f\n",
      plain.tally.full_rays, plain_common / increments, our_common / increments,
      our_common > 0 ? plain_common / our_common : 0.0);
  if (our_common > 0) json["cpu_ratio_easy_rays_" + key] = plain_common / our_common;
  json["cpu_ratio_" + key] = ratio;
  json["cpu_ms_per_increment_" + key] = ours.tally.per_increment(ours.tally.cpu_ms);
  json["cpu_ms_per_increment_" + key + "_plain"] = plain.tally.per_increment(plain.tally.cpu_ms);
  json["factorizations_per_increment_" + key] =
      ours.tally.per_increment(static_cast<double>(ours.tally.counts.factorizations));
  json["factorizations_per_increment_" + key + "_plain"] =
      plain.tally.per_increment(static_cast<double>(plain.tally.counts.factorizations));
  json["largest_force_difference_" + key] = found.worst;
  json["other_equilibria_" + key] = found.elsewhere;
}

void measure(const Options& options, const std::string& element, Scene scene, const Mesh& mesh, const NodeSets& sets,
             nlohmann::ordered_json& json) {
  scene.solver.element = element_named(element);
  Task task{scene, mesh, sets, database_header(scene, mesh, sets), {}};
  task.sample = draw(options, sets, static_cast<int>(task.header.directions.size()));
  const int n = task.n_increments();
  Run plain;
  if (options.plain) plain = run_plain(task);
  const Run ours = run_ours(task, options.verbose);
  std::printf("\n%s, K/mu = %.4g, %s, %d increments to %.3g mm, %d nodes x %d directions (seed %u), %d dofs\n",
              element.c_str(), scene.material.bulk_modulus_Pa / scene.material.shear_modulus_Pa,
              scene.probe.kind == ProbeKind::node ? "node probes" : "patch probes", n,
              1e3 * task.header.magnitudes_m.back(), options.nodes, options.rays, options.seed,
              ProbeSolver(scene, mesh, sets).n_dofs());
  std::printf("  per converged    increments  cutbacks residuals tangents factoriz. substit.  CPU\n");
  if (options.plain) print("plain loop", plain.tally);
  print("phynness", ours.tally);
  if (options.plain) report_ratio(plain, ours, n, key_of(element), json);
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("CPU per converged increment, the plain loop against phynness");
  app.add_option("--scene", options.scene, "scene file");
  app.add_option("--elements", options.elements, "P1, p1-p1, P2, taylor-hood")->delimiter(',');
  app.add_option("--nodes", options.nodes, "number of random active nodes");
  app.add_option("--rays", options.rays, "number of random directions at each");
  app.add_option("--seed", options.seed, "seed of the sample");
  app.add_option("--increments", options.increments, "number of increments (default: of the scene)");
  app.add_option("--depth-m", options.depth_m, "depth (default: of the scene)");
  app.add_option("--bulk-over-shear", options.bulk_over_shear, "K/mu (default: of the scene)");
  app.add_flag("!--without-plain", options.plain, "do not run the plain loop");
  app.add_option("--node", options.only_node, "this node instead of random nodes");
  app.add_option("--direction", options.only_direction, "this direction instead of random directions");
  app.add_flag("--verbose", options.verbose, "print a line for each increment");
  app.add_option("--json", options.json, "write the results as JSON");
  CLI11_PARSE(app, argc, argv);
  const SolverSession session;
  Scene scene = read_scene(options.scene);
  if (options.increments > 0) scene.probe.increments = options.increments;
  if (options.depth_m > 0) scene.probe.max_displacement_m = options.depth_m;
  if (options.bulk_over_shear > 0) {
    auto& m = scene.material;
    std::vector<std::pair<std::string_view, double>> given{
        {"bulk_modulus_Pa", options.bulk_over_shear * m.shear_modulus_Pa}};
    for (std::size_t i = 0; i < m.parameters.size(); ++i)
      if (const std::string_view key = m.law->parameters[i].key; key != "bulk_modulus_Pa" && key != "lame_lambda_Pa")
        given.emplace_back(key, m.parameters[i]);
    m = material_of(m.law, given);
  }
  const auto made = make_mesh(scene);
  const auto sets = resolve_selections(scene, made.mesh);
  std::printf("solver, %s: %d nodes, %d cells, %zu active nodes\n", scene.title.c_str(),
              static_cast<int>(made.mesh.nodes.rows()), static_cast<int>(made.mesh.cells.rows()), sets.active.size());
  nlohmann::ordered_json json;
  for (const auto& element : options.elements) measure(options, element, scene, made.mesh, sets, json);
  if (!options.json.empty()) {
    std::ofstream out(options.json);
    out << json.dump(1) << "\n";
    if (!out) throw failure("writing failed", options.json, "free space on the disk");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
