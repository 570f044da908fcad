#include <map>
#include <phynness/formats/database_merge.hpp>

#include "commands.hpp"

namespace phynness::cli::merge_command {
namespace {

struct Options {
  std::vector<std::filesystem::path> shards;
  std::filesystem::path output;
  OptionalPath json_file;
};

json figures(const Options& options, const MergeReport& report) {
  json missing = json::array(), damage = json::array();
  for (const auto& ray : report.missing) {
    json entry = record("node", ray.node, "direction", ray.direction);
    if (ray.owner) entry["shard"] = ray.owner->str();
    missing.push_back(entry);
  }
  for (const auto& d : report.damage)
    damage.push_back(record("log", d.log.string(), "reason", d.reason, "dropped_bytes", d.dropped_bytes));
  return record("shards", options.shards.size(), "rays", report.rays_total, "complete", report.missing.empty(),
                "missing", missing, "damage", damage);
}

/// The name that precompute --shard was given: that of the first shard without .shard-i-of-n.
std::filesystem::path shards_belong_to(const Options& options) {
  for (const auto& file : options.shards)
    if (const auto progress = database_progress(file); progress.shard) return database_of(file, *progress.shard);
  return options.output;
}

/// The error that lists missing rays, one line per node, and the commands that solve them.
Error rays_missing(const Options& options, const MergeReport& report) {
  std::map<std::int32_t, std::string> directions_of;
  std::map<std::int32_t, std::int64_t> rays_of_shard;
  for (const auto& ray : report.missing) {
    directions_of[ray.node] += fmt::format(" {}", ray.direction);
    if (ray.owner) ++rays_of_shard[ray.owner->index];
  }
  const auto listed = [](const auto& all, const char* what, const auto& line) {
    constexpr std::size_t most = 12;
    std::string text;
    for (std::size_t n = 0; const auto& one : all)
      if (n++ < most) text += "\n" + line(one);
    if (all.size() > most) text += fmt::format("\n  and {} more {} (--json lists all)", all.size() - most, what);
    return text;
  };
  const auto value = fmt::format("{} of {}", report.missing.size(), report.rays_total) +
                     listed(directions_of, "nodes", [](const auto& node) {
                       return fmt::format("  node {}, directions{}", node.first, node.second);
                     });
  std::string remedy = "solve them and merge again; no database was written";
  if (rays_of_shard.empty())
    remedy += fmt::format("\n    phynness precompute SCENE -o {} --resume", options.shards.front().string());
  remedy += listed(rays_of_shard, "shards", [&](const auto& shard) {
    return fmt::format("    phynness precompute SCENE -o {} --shard {}/{} --resume   ({} ray{})",
                       shards_belong_to(options).string(), shard.first, report.missing.front().owner->count,
                       shard.second, shard.second == 1 ? "" : "s");
  });
  return failure("rays are missing", value, remedy);
}

void run(const Options& options) {
  const auto report = merge_shards(options.shards, options.output);
  warn_of_damage(report.damage);
  write_each({[&] { write_json(options.json_file, figures(options, report)); },
              [&] {
                if (!report.missing.empty()) throw rays_missing(options, report);
              }});
  print_result("{} rays of {} shards, {} -> {}; the shards and their .log folders are no longer needed\n",
               report.rays_total, options.shards.size(), bytes(std::filesystem::file_size(options.output)),
               options.output.string());
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "merge", "Merge the shards of precompute --shard i/n into one database", run);
  add_path(command, "SHARD", options.shards, PathKind::input, "database.shard-0-of-8.h5 ...")->required();
  add_output(command, options.output, PathKind::database, "database to write (formats/database.md)");
  add_json(command, options.json_file, "write merged shards, missing rays and damage as JSON");
}

}  // namespace phynness::cli::merge_command
