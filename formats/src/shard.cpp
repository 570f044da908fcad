#include <algorithm>
#include <charconv>
#include <phynness/formats/error.hpp>
#include <phynness/formats/shard.hpp>

namespace phynness {
namespace {

std::string marker(const Shard& shard) {
  return ".shard-" + std::to_string(shard.index) + "-of-" + std::to_string(shard.count);
}

}  // namespace

std::string Shard::str() const { return std::to_string(index) + "/" + std::to_string(count); }

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char *at = text.data(), *end = at + text.size();
  const auto first = std::from_chars(at, end, shard.index);
  bool good = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  if (good) {
    const auto second = std::from_chars(first.ptr + 1, end, shard.count);
    good = second.ec == std::errc{} && second.ptr == end;
  }
  if (!good || shard.count < 1)
    throw input_error("a shard must be i/n with two integers", "'" + text + "'",
                      "give for example --shard 0/8 for the first of eight shards");
  if (shard.index < 0 || shard.index >= shard.count)
    throw input_error(
        "there is no such shard", "'" + text + "'",
        "shards start with 0; the last is " + std::to_string(shard.count - 1) + "/" + std::to_string(shard.count));
  return shard;
}

std::vector<std::int32_t> shards_of_rays(std::size_t n_active, std::size_t n_directions, std::int32_t count) {
  // The costs of runs differ; 16 runs per shard make the costs of the shards similar.
  constexpr std::int64_t wanted_runs = 16;
  const auto rays = static_cast<std::int64_t>(n_active * n_directions);
  const auto longest = static_cast<std::size_t>(
      std::clamp<std::int64_t>(rays / (wanted_runs * count), 1, static_cast<std::int64_t>(n_directions)));
  const std::size_t runs_per_node = (n_directions + longest - 1) / longest;
  std::vector<std::int32_t> owners(n_active * n_directions, -1);
  std::int64_t dealt = 0;
  for (std::size_t run = 0; run < runs_per_node; ++run) {
    // The first direction d with d * runs_per_node / n_directions == run.
    const std::size_t first = (run * n_directions + runs_per_node - 1) / runs_per_node;
    const std::size_t last = ((run + 1) * n_directions + runs_per_node - 1) / runs_per_node;
    for (std::size_t node = 0; node < owners.size(); node += n_directions, ++dealt)
      std::fill(&owners[node] + first, &owners[node] + last, static_cast<std::int32_t>(dealt % count));
  }
  return owners;
}

std::filesystem::path shard_file(const std::filesystem::path& database, const Shard& shard) {
  auto name = database.stem().string() + marker(shard) + database.extension().string();
  return database.parent_path() / name;
}

std::filesystem::path database_of(const std::filesystem::path& file, const Shard& shard) {
  const auto stem = file.stem().string(), mark = marker(shard);
  if (stem.size() <= mark.size() || !stem.ends_with(mark)) return file;
  return file.parent_path() / (stem.substr(0, stem.size() - mark.size()) + file.extension().string());
}

}  // namespace phynness
