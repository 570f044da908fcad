#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/database_merge.hpp>
#include <phynness/formats/error.hpp>

#include "database_pack.hpp"
#include "database_scan.hpp"
#include "database_study.hpp"

namespace phynness {
namespace {

namespace fs = std::filesystem;
namespace dl = database_log;

DatabaseHeader header_of_unfinished(const fs::path& shard) {
  auto header = read_database_header(shard);
  if (Database::is_complete(shard))
    throw input_error("a finished database cannot be merged", shard.string(), "give unfinished shards only");
  if (const auto holder = DatabaseLock::holder(shard); !holder.empty())
    throw input_error("the shard " + shard.string() + " is still being computed", holder,
                      "wait until this process ends, or stop it, then merge again");
  return header;
}

}  // namespace

MergeReport merge_shards(const std::vector<fs::path>& shards, const fs::path& output) {
  check_folder_of(output);
  std::error_code code;
  if (fs::exists(output, code))
    throw input_error("the output exists and is not overwritten", output.string(),
                      "choose another name, or delete the file");
  const DatabaseLock lock(output);
  if (!dl::logs_of(output).empty())
    throw input_error("the output has logs of an earlier run", dl::folder(output).string(),
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
                        "merge only shards of the same scene and mesh");
    if (!partition) partition = found.shard;
    dl::scan(shard, header, index);
  }
  header.shard.reset();

  const auto records = one_record_per_ray(index, header);
  MergeReport report;
  report.rays_total = std::ssize(records);
  report.damage = index.damage;
  const auto n_directions = header.directions.size();
  std::vector<std::int32_t> owners;
  if (partition) owners = shards_of_rays(header.sets.active.size(), n_directions, partition->count);
  for (const auto& [active, direction] : missing_rays(records, n_directions)) {
    MissingRay ray{header.sets.active[static_cast<std::size_t>(active)], direction, {}};
    if (partition)
      ray.owner = Shard{owners[static_cast<std::size_t>(active) * n_directions + static_cast<std::size_t>(direction)],
                        partition->count};
    report.missing.push_back(ray);
  }
  if (!report.missing.empty()) return report;
  try {
    write_packed(output, header, index, records);
  } catch (const Error& error) {
    if (error.kind() == Error::Kind::input) throw;
    throw failure(error.what(), "",
                  "check free space (df) and permissions, then merge again: the shards are as they were");
  }
  return report;
}

}  // namespace phynness
