#include <stdlib.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/planning/packing_trial.hpp>
#include <span>

namespace phynness {
namespace fs = std::filesystem;
namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& parent) {
    std::string pattern = (parent / "phynness-plan-XXXXXX").string();
    if (!::mkdtemp(pattern.data()))
      throw failure("cannot make a folder for the packing trial", parent.string() + ": " + std::strerror(errno),
                    "set TMPDIR to a folder that can be written");
    path = pattern;
  }
  ~TemporaryFolder() {
    std::error_code code;
    fs::remove_all(path, code);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  fs::path path;
};

/// The rays as a rectangular database of nodes and directions, with as many directions as the node with the fewest has.
std::vector<std::vector<Ray>> by_node(const std::vector<Ray>& rays) {
  std::vector<std::vector<Ray>> nodes;
  for (const auto& ray : rays) {
    if (nodes.empty() || nodes.back().front().active != ray.active) nodes.emplace_back();
    nodes.back().push_back(ray);
  }
  std::size_t least = nodes.front().size();
  for (const auto& node : nodes) least = std::min(least, node.size());
  for (auto& node : nodes) node.resize(least);
  return nodes;
}

struct Packed {
  double n_rays = 0, empty_bytes = 0, log_bytes = 0, file_bytes = 0, append_s = 0, pack_s = 0;
};

/// Writes and packs a database of these nodes.
Packed pack(const DatabaseHeader& whole, std::span<const std::vector<Ray>> nodes, const fs::path& file) {
  DatabaseHeader header = whole;
  header.sets.active.clear();
  header.sets.mirror.reset();  // a sample of nodes is not symmetric
  for (const auto& node : nodes)
    header.sets.active.push_back(whole.sets.active[static_cast<std::size_t>(node.front().active)]);
  header.directions.resize(nodes.front().size());
  DatabaseWriter::create(file, header, false);
  Packed packed;
  packed.empty_bytes = static_cast<double>(fs::file_size(file));
  double start = cpu_seconds();
  {
    DatabaseWriter log(file, header, 0);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t d = 0; d < nodes[a].size(); ++d) {
        Ray ray = nodes[a][d];
        ray.active = static_cast<std::int32_t>(a);
        ray.direction = static_cast<std::int32_t>(d);
        log.append(ray);
        ++packed.n_rays;
      }
    log.close();
  }
  packed.append_s = cpu_seconds() - start;
  for (const auto& entry : fs::directory_iterator(file.string() + ".log"))
    packed.log_bytes += static_cast<double>(entry.file_size());
  start = cpu_seconds();
  DatabaseWriter::pack(file, header);
  packed.pack_s = cpu_seconds() - start;
  packed.file_bytes = static_cast<double>(fs::file_size(file));
  return packed;
}

}  // namespace

PackingTrial try_packing(const DatabaseHeader& whole, const std::vector<Ray>& rays, const fs::path& folder) {
  assert(!rays.empty());
  const TemporaryFolder temporary(folder);
  PackingTrial trial;
  const auto whole_file = temporary.path / "whole.h5";
  DatabaseWriter::create(whole_file, whole, false);
  trial.header_bytes = static_cast<double>(fs::file_size(whole_file));

  const auto nodes = by_node(rays);
  const std::span all(nodes);
  // Two sizes allow to subtract the part that does not grow with the rays.
  std::optional<Packed> half;
  if (all.size() > 1) half = pack(whole, all.first(all.size() / 2), temporary.path / "half.h5");
  const Packed full = pack(whole, all, temporary.path / "full.h5");
  trial.append_s_per_ray = full.append_s / full.n_rays;
  trial.record_bytes = full.log_bytes / full.n_rays;
  trial.pack_s_per_ray = full.pack_s / full.n_rays;
  const double responses = full.file_bytes - full.empty_bytes;
  trial.packed_bytes_per_ray = responses / full.n_rays;
  if (half) {
    trial.packed_bytes_per_ray = (responses - (half->file_bytes - half->empty_bytes)) / (full.n_rays - half->n_rays);
    trial.header_bytes += responses - full.n_rays * trial.packed_bytes_per_ray;
  }
  return trial;
}

}  // namespace phynness
