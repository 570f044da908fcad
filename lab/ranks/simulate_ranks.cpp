// A run of `phynness precompute` on 1 to 10,000 ranks, simulated from measured parts: every rank, task and fetch of the
// counter, with the tasks of the program itself.
//
//   phynness_simulate_ranks SAMPLE.h5 WHOLE.h5 [--start 0.75 --node-setup 0.005 --disk-rate 1e9 ...]
//
// SAMPLE.h5 gives the CPU seconds of rays: a node of the whole scene has those of the nearest node of the sample.
// WHOLE.h5, finished or just begun, gives the nodes, directions and increments of the whole scene.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <numeric>
#include <phynness/formats/database.hpp>
#include <phynness/formats/ray_tasks.hpp>
#include <queue>
#include <random>

namespace phynness {
namespace {

/// Measured; the default values are those of docs/decisions/smaller-choices.md.
struct Parts {
  double start_s = 0.75;        ///< of a rank: program, scene, mesh, discretization
  double node_setup_s = 0.005;  ///< when a rank begins with a node
  double counter_s = 5e-6;      ///< of the counter, which serves one rank at a time
  double append_B_per_s = 500e6;
  double scan_B_per_s = 550e6;
  double pack_B_per_s = 43e6;     ///< read, decoded, compressed
  double reserve_s = 15e-6;       ///< of rank 0, for a chunk
  double exchange_B_per_s = 1e9;  ///< of numbers that all ranks get
  double disk_B_per_s = 1e9;      ///< of the file system, shared by all ranks
  double end_s = 0.02;            ///< create, close, force to the disk and rename
};

struct Scene {
  DatabaseHeader header;
  std::vector<RayIndex> rays;
  std::vector<double> seconds;  ///< of each ray
  double log_bytes = 0;
};

/// @return seconds until the last rank has solved its last ray
double solving_s(const Scene& scene, const Parts& parts, int n_ranks, std::vector<double>& rays_of_rank) {
  const auto tasks = ray_tasks(scene.rays, n_ranks);
  using Free = std::pair<double, int>;
  std::priority_queue<Free, std::vector<Free>, std::greater<>> ranks;
  for (int r = 0; r < n_ranks; ++r) ranks.emplace(parts.start_s, r);
  std::vector<std::int32_t> touched(static_cast<std::size_t>(n_ranks), -1);
  rays_of_rank.assign(touched.size(), 0);
  double counter_free = 0, end = 0;
  for (std::size_t t = 0; t + 1 < tasks.size(); ++t) {
    auto [time, rank] = ranks.top();
    ranks.pop();
    counter_free = time = std::max(time, counter_free) + parts.counter_s;
    const auto first = static_cast<std::size_t>(tasks[t]), last = static_cast<std::size_t>(tasks[t + 1]);
    auto& node = touched[static_cast<std::size_t>(rank)];
    if (std::exchange(node, scene.rays[first].active) != scene.rays[first].active) time += parts.node_setup_s;
    for (auto i = first; i < last; ++i) time += scene.seconds[i] + record_bytes(scene.header) / parts.append_B_per_s;
    rays_of_rank[static_cast<std::size_t>(rank)] += static_cast<double>(last - first);
    end = std::max(end, time);
    ranks.emplace(time, rank);
  }
  return end;
}

struct Packing {
  double scan_s = 0, compress_s = 0, exchange_s = 0, serial_s = 0, disk_s = 0;
  double sum() const { return scan_s + compress_s + exchange_s + serial_s + disk_s; }
};

/// @param most_rays  that a rank has solved
Packing packing_s(const Scene& scene, const Parts& parts, int n_ranks, double most_rays) {
  const auto n_nodes = static_cast<double>(scene.header.sets.active.size());
  const double chunks = 2.5 * n_nodes;  // those of output nodes, and of other columns of several nodes
  Packing packing;
  packing.scan_s = most_rays * record_bytes(scene.header) / parts.scan_B_per_s;
  packing.compress_s = std::ceil(n_nodes / n_ranks) * scene.log_bytes / n_nodes / parts.pack_B_per_s;
  if (n_ranks > 1)
    packing.exchange_s = (32 * static_cast<double>(scene.rays.size()) + 16 * chunks) / parts.exchange_B_per_s;
  packing.serial_s = parts.reserve_s * chunks + parts.end_s;
  packing.disk_s = 0.82 * scene.log_bytes / parts.disk_B_per_s;
  return packing;
}

Scene drawn(const std::string& sample, const std::string& whole) {
  Scene scene{read_database_header(whole), {}, {}, 0};
  const auto database = Database::open(sample);
  const std::size_t n_directions = database.header().directions.size(),
                    n_increments = database.header().magnitudes_m.size(), n = database.header().sets.active.size();
  std::vector<double> seconds(n * n_directions * n_increments);
  database.read("seconds", 0, n, seconds.data());
  scene.rays = rays_left(scene.header, std::vector<char>(scene.header.sets.active.size() * n_directions, 0));
  std::vector<std::size_t> node_of(scene.header.sets.active.size());
  const auto& nodes = scene.header.mesh.nodes;
  const auto squared = [&](std::int32_t a, std::int32_t b) { return (nodes.row(a) - nodes.row(b)).squaredNorm(); };
  for (std::size_t a = 0; a < node_of.size(); ++a)
    for (std::size_t b = 1; b < n; ++b) {
      const auto& of = database.header().sets.active;
      if (squared(scene.header.sets.active[a], of[b]) < squared(scene.header.sets.active[a], of[node_of[a]]))
        node_of[a] = b;
    }
  for (const auto& ray : scene.rays) {
    const auto at =
        seconds.begin() + static_cast<std::ptrdiff_t>((node_of[static_cast<std::size_t>(ray.active)] * n_directions +
                                                       static_cast<std::size_t>(ray.direction)) *
                                                      n_increments);
    scene.seconds.push_back(std::accumulate(at, at + static_cast<std::ptrdiff_t>(n_increments), 0.0));
  }
  scene.log_bytes = static_cast<double>(scene.rays.size()) * record_bytes(scene.header);
  return scene;
}

void run(const std::string& sample, const std::string& whole, const Parts& parts) {
  const auto scene = drawn(sample, whole);
  fmt::print("{} rays, {:.0f} core-s, longest {:.2f} s; {:.0f} MB of logs\n", scene.rays.size(),
             std::accumulate(scene.seconds.begin(), scene.seconds.end(), 0.0), *std::ranges::max_element(scene.seconds),
             scene.log_bytes / 1e6);
  fmt::print("{:>6} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>10}\n", "ranks", "solved s", "scan s", "compr. s",
             "exch. s", "serial s", "disk s", "total s", "efficiency");
  double of_one = 0;
  for (const int n : {1, 2, 10, 50, 100, 158, 200, 300, 400, 500, 1000, 2000, 5000, 10000}) {
    std::vector<double> rays;
    const double solved = solving_s(scene, parts, n, rays);
    const auto packing = packing_s(scene, parts, n, *std::ranges::max_element(rays));
    const double total = solved + packing.sum();
    if (n == 1) of_one = total;
    fmt::print("{:>6} {:>9.2f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.2f} {:>8.1f} %\n", n, solved,
               packing.scan_s, packing.compress_s, packing.exchange_s, packing.serial_s, packing.disk_s, total,
               100 * of_one / (n * total));
  }
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  CLI::App app{"Simulates precompute on many ranks"};
  std::string sample, whole;
  phynness::Parts parts;
  app.add_option("SAMPLE", sample)->required();
  app.add_option("WHOLE", whole)->required();
  for (auto& [name, value] : {std::pair{"--start", &parts.start_s},
                              {"--node-setup", &parts.node_setup_s},
                              {"--counter", &parts.counter_s},
                              {"--append-rate", &parts.append_B_per_s},
                              {"--scan-rate", &parts.scan_B_per_s},
                              {"--pack-rate", &parts.pack_B_per_s},
                              {"--reserve", &parts.reserve_s},
                              {"--exchange-rate", &parts.exchange_B_per_s},
                              {"--disk-rate", &parts.disk_B_per_s},
                              {"--end", &parts.end_s}})
    app.add_option(name, *value)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  phynness::run(sample, whole, parts);
}
