#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/database_merge.hpp>
#include <phynness/formats/error.hpp>

#include "database_folder.hpp"
#include "database_pack.hpp"
#include "database_resume.hpp"
#include "database_scan.hpp"

namespace phynness {
namespace {

namespace fs = std::filesystem;
namespace dl = database_log;

DatabaseHeader header_of_unfinished(const fs::path& shard) {
  auto header = read_database_header(shard);
  if (Database::is_complete(shard))
    throw input_error("the database is finished already, there is nothing to merge", shard.string(),
                      "give the shards only");
  if (const auto holder = DatabaseLock::holder(shard); !holder.empty())
    throw input_error("the shard " + shard.string() + " is still being computed", holder,
                      "wait for it to end, or stop it, then merge again");
  return header;
}

}  // namespace

MergeReport merge_shards(const std::vector<fs::path>& shards, const fs::path& output) {
  check_folder_of(output);
  std::error_code code;
  if (fs::exists(output, code))
    throw input_error("the output exists already, and finished work is never overwritten", output.string(),
                      "choose another name, or delete it yourself");
  const DatabaseLock lock(output);
  if (!dl::logs_of(output).empty())
    throw input_error("logs of an earlier run are in the output's place", dl::folder(output).string(),
                      "choose another name, or delete the folder");

  DatabaseHeader header;
  dl::Index index;
  std::optional<Shard> partition;
  for (const auto& shard : shards) {
    auto found = header_of_unfinished(shard);
    if (&shard == &shards.front())
      header = found;
    else
      refuse_other_work(found, header, shard, "in " + shards.front().string(),
                        "merge shards of one scene and mesh only");
    if (!partition) partition = found.shard;
    dl::scan(shard, header, index);
  }
  header.shard.reset();

  const auto records = one_record_per_ray(index, header);
  MergeReport report;
  report.rays_total = static_cast<std::int64_t>(records.size());
  report.damage = index.damage;
  const auto n_active = static_cast<std::int32_t>(header.sets.active.size());
  const auto n_directions = static_cast<std::int32_t>(header.directions.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!is_missing(records[i])) continue;
    const auto active = static_cast<std::int32_t>(i / header.directions.size());
    const auto direction = static_cast<std::int32_t>(i % header.directions.size());
    MissingRay ray{header.sets.active[static_cast<std::size_t>(active)], direction, {}};
    if (partition)
      ray.owner =
          Shard{shard_of(active, direction, n_active, n_directions, partition->count), partition->count};
    report.missing.push_back(ray);
  }
  if (report.missing.empty()) write_packed(output, header, index, records);
  return report;
}

}  // namespace phynness
