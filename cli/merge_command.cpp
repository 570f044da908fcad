#include <fmt/core.h>

#include <map>
#include <phynness/formats/database_merge.hpp>
#include <phynness/formats/error.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "output_places.hpp"
#include "streams.hpp"

namespace phynness::cli::merge_command {
namespace {

struct Options {
  std::vector<std::filesystem::path> shards;
  std::filesystem::path output;
  std::optional<std::filesystem::path> json_file;
};

json figures(const Options& options, const MergeReport& report) {
  json missing = json::array(), damage = json::array();
  for (const auto& ray : report.missing) {
    json entry{{"node", ray.node}, {"direction", ray.direction}};
    if (ray.owner) entry["shard"] = ray.owner->str();
    missing.push_back(entry);
  }
  for (const auto& d : report.damage)
    damage.push_back({{"log", d.log.string()}, {"reason", d.reason}, {"dropped_bytes", d.dropped_bytes}});
  return {{"shards", options.shards.size()},
          {"rays", report.rays_total},
          {"complete", report.missing.empty()},
          {"missing", missing},
          {"damage", damage}};
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
  constexpr std::size_t most_lines = 12;
  const auto database = shards_belong_to(options);
  std::string value = fmt::format("{} of {}", report.missing.size(), report.rays_total);
  std::size_t line = 0;
  for (const auto& [node, directions] : directions_of) {
    if (line++ == most_lines) break;
    value += fmt::format("\n  node {}, directions{}", node, directions);
  }
  if (directions_of.size() > most_lines)
    value += fmt::format("\n  and {} more nodes (--json lists all)", directions_of.size() - most_lines);

  std::string remedy = "solve them and merge again; no database was written";
  if (rays_of_shard.empty())
    remedy += fmt::format("\n    phynness precompute SCENE -o {} --resume", options.shards.front().string());
  line = 0;
  for (const auto& [index, count] : rays_of_shard) {
    if (line++ == most_lines) break;
    remedy += fmt::format("\n    phynness precompute SCENE -o {} --shard {}/{} --resume   ({} ray{})",
                          database.string(), index, report.missing.front().owner->count, count, count == 1 ? "" : "s");
  }
  if (rays_of_shard.size() > most_lines)
    remedy += fmt::format("\n    and {} more shards (--json lists all)", rays_of_shard.size() - most_lines);
  return failure("rays are missing", value, remedy);
}

void run(const Options& options) {
  const auto report = merge_shards(options.shards, options.output);
  for (const auto& damage : report.damage)
    message("warning: {}: {}; {} are ignored\n", damage.log.string(), damage.reason,
            bytes(static_cast<double>(damage.dropped_bytes)));
  write_each({[&] { write_json(options.json_file, figures(options, report)); },
              [&] {
                if (!report.missing.empty()) throw rays_missing(options, report);
              }});
  print_result("{} rays of {} shards, {} -> {}; the shards and their .log folders are no longer needed\n",
               report.rays_total, options.shards.size(),
               bytes(static_cast<double>(std::filesystem::file_size(options.output))), options.output.string());
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("merge", "Merge the shards of precompute --shard i/n into one database");
  add_path(*command, "SHARD", options->shards, InputKind::whole, "database.shard-0-of-8.h5 ...")->required();
  add_path(*command, "-o,--output", options->output, OutputKind::database, "database to write (formats/database.md)")
      ->required();
  add_path(*command, "--json", options->json_file, OutputKind::file,
           "write merged shards, missing rays and damage as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::merge_command
