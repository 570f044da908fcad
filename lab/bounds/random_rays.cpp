// Solves random rays of a database's body: uniform directions, uniform depths. Each state is written with the figures
// that may predict the error of a model. Usage: random_rays DATABASE OUT.csv [--first I] [--every I] [--rays N]
// [--depths N] [--reach FACTOR] [--seed N]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/probe_plan.hpp>

#include "exit_status.hpp"

namespace {

using namespace phynness;

struct Options {
  std::string database, out;
  int first = 0, every = 20, rays = 40, depths = 6;
  double reach = 1.0;
  std::uint64_t seed = 1;
};

void solve_node(ProbeSolver& solver, std::int32_t node, const Options& options, double largest_m,
                std::mt19937_64& random, std::FILE* out) {
  solver.touch({node});
  for (int ray = 0; ray < options.rays; ++ray) {
    const Vec3 e = on_sphere(random);
    std::vector<double> depths(static_cast<std::size_t>(options.depths));
    for (double& s : depths) s = (1e-3 + (options.reach - 1e-3) * uniform(random)) * largest_m;
    std::sort(depths.begin(), depths.end());
    std::size_t done = 0;
    try {
      solver.follow({e}, depths, false, [&](std::size_t i, const Response& r) {
        const bool good = r.status == Status::converged;
        const Vec3 f = good ? r.force_N.at(0) : Vec3{};
        std::fprintf(out, "%d,%d,%.17g,%.17g,%.17g,%.17g,%d,%.17g,%.17g,%.17g,%.17g,%.9g,%d,%d\n", node, ray, e[0],
                     e[1], e[2], depths[i], static_cast<int>(r.status), f[0], f[1], f[2], r.energy_J, r.min_jacobian,
                     r.negative_pivots, r.cutbacks);
        done = i + 1;
        return good;
      });
    } catch (const std::exception& error) {
      std::fprintf(stderr, "node %d ray %d: %s\n", node, ray, error.what());
      solver.recover();
    }
    for (; done < depths.size(); ++done)
      std::fprintf(out, "%d,%d,%.17g,%.17g,%.17g,%.17g,%d,0,0,0,0,0,0,0\n", node, ray, e[0], e[1], e[2], depths[done],
                   static_cast<int>(Status::after_failure));
    std::fflush(out);
  }
}

int run(int argc, char** argv) {
  Options o;
  CLI::App app{"Random rays of the body of a database"};
  app.add_option("DATABASE", o.database)->required();
  app.add_option("OUT", o.out)->required();
  app.add_option("--first", o.first, "index of the first active node");
  app.add_option("--every", o.every, "distance between the indices of the active nodes");
  app.add_option("--rays", o.rays, "rays of each node");
  app.add_option("--depths", o.depths, "states of each ray");
  app.add_option("--reach", o.reach, "largest depth over the database's");
  app.add_option("--seed", o.seed);
  CLI11_PARSE(app, argc, argv);
  SolverSession session;
  const auto database = Database::open(o.database);
  const auto& h = database.header();
  ProbeSolver solver(stored_scene(h), h.mesh, h.sets);
  std::FILE* out = std::fopen(o.out.c_str(), "w");
  if (out == nullptr)
    throw failure("the output cannot be written", o.out, "give a file in a folder where you may write");
  std::fprintf(out, "node,ray,ex,ey,ez,depth_m,status,fx,fy,fz,energy_J,min_J,negative_pivots,cutbacks\n");
  std::mt19937_64 random(o.seed);
  const auto& active = h.sets.active;
  for (std::size_t a = static_cast<std::size_t>(o.first); a < active.size(); a += static_cast<std::size_t>(o.every))
    solve_node(solver, active[a], o, h.magnitudes_m.back(), random, out);
  std::fclose(out);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
