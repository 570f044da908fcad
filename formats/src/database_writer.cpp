// Making a database: header, logs, and packing them into the finished file.
#include <unistd.h>

#include <algorithm>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>

#include "database_layout.hpp"
#include "database_log.hpp"
#include "database_resume.hpp"

namespace phynness {
namespace fs = std::filesystem;
namespace layout = database_layout;
namespace path = database_layout::path;
namespace dl = database_log;

namespace {

DatabaseHeader with_hashes(DatabaseHeader header) {
  if (header.mesh_hash.empty()) header.mesh_hash = mesh_hash(header.mesh);
  if (header.physics_hash.empty())
    header.physics_hash = physics_hash(
        parse_scene(header.scene_text, header.scene_name, header.scene_folder, MeshFile::may_be_absent));
  return header;
}

void check_folder(const fs::path& file) {
  const auto folder = fs::absolute(file).parent_path();
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw input_error("the folder for the database does not exist", folder.string(),
                      "make it with: mkdir -p " + folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw input_error("the folder for the database is not writable", folder.string(),
                      "change its permissions, or write elsewhere");
}

bool holds_logs(const fs::path& folder) {
  std::error_code code;
  return fs::is_directory(folder, code) && !fs::is_empty(folder, code);
}

void make_log_folder(const fs::path& file) {
  std::error_code code;
  fs::create_directories(dl::folder(file), code);
  if (code)
    throw failure("cannot make the folder of logs " + dl::folder(file).string(), code.message(),
                  "check permissions and free space");
}

/// The arrays of a few active nodes that are small enough to be collected before they are written.
struct SmallArrays {
  std::vector<std::int8_t> status;
  std::vector<double> force, energy, tangent, min_jacobian, seconds;
  std::vector<std::int32_t> negative_pivots, iterations, cutbacks;

  void add(const Ray& ray) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (Status s : ray.status) status.push_back(static_cast<std::int8_t>(s));
    append(force, ray.force);
    append(energy, ray.energy);
    append(tangent, ray.tangent);
    append(negative_pivots, ray.negative_pivots);
    append(iterations, ray.iterations);
    append(cutbacks, ray.cutbacks);
    append(min_jacobian, ray.min_jacobian);
    append(seconds, ray.seconds);
  }
  void write(hdf5::File& file, hsize_t first, hsize_t count) const {
    file.write_slab(path::status, first, count, status.data());
    file.write_slab(path::force, first, count, force.data());
    file.write_slab(path::energy, first, count, energy.data());
    if (!tangent.empty()) file.write_slab(path::tangent, first, count, tangent.data());
    file.write_slab(path::negative_pivots, first, count, negative_pivots.data());
    file.write_slab(path::iterations, first, count, iterations.data());
    file.write_slab(path::cutbacks, first, count, cutbacks.data());
    file.write_slab(path::min_jacobian, first, count, min_jacobian.data());
    file.write_slab(path::seconds, first, count, seconds.data());
  }
};

/// For each ray that is solved its first whole record. @throws Error if rays are missing
std::vector<dl::Entry> one_record_per_ray(const dl::Index& index, const dl::Layout& sizes,
                                          const MirroredRays& mirrored, const fs::path& file) {
  const std::size_t total =
      static_cast<std::size_t>(sizes.n_active) * static_cast<std::size_t>(sizes.n_directions);
  std::vector<dl::Entry> records(total, dl::Entry{-1, -1, -1, -1});
  const auto wanted = static_cast<std::size_t>(mirrored.n_solved());
  std::size_t found = 0;
  for (const auto& entry : index.entries) {
    if (!mirrored.is_solved(entry.active, entry.direction)) continue;
    auto& slot =
        records[static_cast<std::size_t>(entry.active) * static_cast<std::size_t>(sizes.n_directions) +
                static_cast<std::size_t>(entry.direction)];
    if (slot.log < 0) slot = entry, ++found;
  }
  if (found < wanted)
    throw failure("the database " + file.string() + " cannot be packed: rays are missing",
                  std::to_string(wanted - found) + " of " + std::to_string(wanted),
                  "solve them with: phynness precompute SCENE -o " + file.string() + " --resume");
  return records;
}

void write_responses(hdf5::File& out, const DatabaseHeader& header, const dl::Index& index,
                     const std::vector<dl::Entry>& records, const MirroredRays& mirrored) {
  const dl::Layout sizes(header);
  std::vector<Descriptor> logs;
  for (const auto& log : index.logs) logs.push_back(open_for_reading(log));
  std::vector<unsigned char> payload(sizes.payload_bytes());
  const hsize_t batch = layout::nodes_per_chunk(header), n_active = header.sets.active.size();

  layout::create_responses(out, header);
  for (hsize_t first = 0; first < n_active; first += batch) {
    const hsize_t count = std::min(batch, n_active - first);
    SmallArrays small;
    for (hsize_t active = first; active < first + count; ++active) {
      std::vector<double> displacement;
      for (std::size_t d = 0; d < header.directions.size(); ++d) {
        const auto a = static_cast<std::int32_t>(active), direction = static_cast<std::int32_t>(d);
        const auto& source = mirrored.source(a, direction);
        const auto& record = records[static_cast<std::size_t>(source.active) * header.directions.size() +
                                     static_cast<std::size_t>(source.direction)];
        const auto log = static_cast<std::size_t>(record.log);
        if (read_at(logs[log], index.logs[log], record.offset, payload.data(), payload.size()) <
            payload.size())
          throw failure("a log became shorter while it was packed", index.logs[log].string(),
                        "let one process at a time use the database");
        Ray ray = dl::decode(payload.data(), sizes);
        if (!source.is_itself()) ray = mirrored.image(ray, a, direction);
        small.add(ray);
        displacement.insert(displacement.end(), ray.displacement.begin(), ray.displacement.end());
      }
      out.write_slab(path::displacement, active, 1, displacement.data());
    }
    small.write(out, first, count);
  }
}

}  // namespace

void DatabaseWriter::create(const fs::path& file, const DatabaseHeader& given, bool resume) {
  const DatabaseHeader header = with_hashes(given);
  layout::check_header(header);
  check_folder(file);
  std::error_code code;
  const bool exists = fs::exists(file, code);
  if (exists && !resume)
    throw input_error("the database exists already, and finished work is never overwritten", file.string(),
                      "continue it with --resume, or choose another name, or delete it yourself");
  if (exists) {
    refuse_other_work(read_database_header(file), header, file);
    if (Database::is_complete(file))
      fs::remove_all(dl::folder(file), code);  // left over if a process died between packing and tidying up
    else
      make_log_folder(file);
    return;
  }
  if (!resume && holds_logs(dl::folder(file)))
    throw input_error("logs of an earlier run are there, but their database is not",
                      dl::folder(file).string(), "continue from them with --resume, or delete the folder");
  make_log_folder(file);
  const fs::path partial = file.string() + ".tmp";
  auto out = hdf5::File::create(partial);
  layout::write_header(out, header, false);
  out.close();
  replace_durably(partial, file);
}

std::vector<char> DatabaseWriter::logged(const fs::path& file, const DatabaseHeader& given) {
  const DatabaseHeader header = with_hashes(given);
  std::vector<char> flags(header.sets.active.size() * header.directions.size(), 0);
  if (Database::is_complete(file)) {
    std::fill(flags.begin(), flags.end(), char{1});
    return flags;
  }
  const std::size_t n_directions = header.directions.size();
  for (const auto& entry : dl::scan(file, header).entries)
    flags[static_cast<std::size_t>(entry.active) * n_directions + static_cast<std::size_t>(entry.direction)] =
        1;
  const MirroredRays mirrored(header);
  const auto solved = flags;
  for (std::size_t ray = 0; ray < flags.size(); ++ray) {
    const auto& source = mirrored.source(static_cast<std::int32_t>(ray / n_directions),
                                         static_cast<std::int32_t>(ray % n_directions));
    flags[ray] = solved[static_cast<std::size_t>(source.active) * n_directions +
                        static_cast<std::size_t>(source.direction)];
  }
  return flags;
}

struct DatabaseWriter::Impl {
  AppendFile log;
  dl::Layout sizes;
};

DatabaseWriter::DatabaseWriter(const fs::path& file, const DatabaseHeader& given, int rank) {
  const DatabaseHeader header = with_hashes(given);
  make_log_folder(file);
  std::string digits = std::to_string(rank);
  digits.insert(0, digits.size() < 4 ? 4 - digits.size() : 0, '0');
  const std::string stem = (dl::folder(file) / ("rank-" + digits)).string();
  fs::path log = stem;
  for (int again = 1; fs::exists(log); ++again) log = stem + "-" + std::to_string(again);
  _impl = std::make_unique<Impl>(Impl{AppendFile::create(log), dl::Layout(header)});
  const auto opening = dl::encode_opening(header);
  _impl->log.append(opening.data(), opening.size());
}
DatabaseWriter::~DatabaseWriter() = default;
DatabaseWriter::DatabaseWriter(DatabaseWriter&&) noexcept = default;
DatabaseWriter& DatabaseWriter::operator=(DatabaseWriter&&) noexcept = default;

void DatabaseWriter::append(const Ray& ray) {
  const auto record = dl::encode(ray, _impl->sizes);
  _impl->log.append(record.data(), record.size());
}
void DatabaseWriter::close() { _impl->log.close(); }

void DatabaseWriter::pack(const fs::path& file, const DatabaseHeader& given) {
  const DatabaseHeader header = with_hashes(given);
  refuse_other_work(read_database_header(file), header, file);
  std::error_code code;
  if (!Database::is_complete(file)) {
    const auto index = dl::scan(file, header);
    const MirroredRays mirrored(header);
    const auto records = one_record_per_ray(index, dl::Layout(header), mirrored, file);
    const fs::path packing = file.string() + ".packing";
    try {
      auto out = hdf5::File::create(packing);
      layout::write_header(out, header, true);
      write_responses(out, header, index, records, mirrored);
      out.close();
      replace_durably(packing, file);
    } catch (...) {
      fs::remove(packing, code);
      throw;
    }
  }
  fs::remove_all(dl::folder(file), code);
}

DatabaseProgress database_progress(const fs::path& file) {
  const auto header = read_database_header(file);
  DatabaseProgress progress;
  progress.complete = Database::is_complete(file);
  const MirroredRays mirrored(header);
  progress.rays_total = mirrored.n_solved();
  if (progress.complete) {
    progress.rays_logged = progress.rays_total;
    return progress;
  }
  const auto flags = DatabaseWriter::logged(file, header);
  const auto n_directions = static_cast<std::int64_t>(header.directions.size());
  for (std::int64_t ray = 0; ray < static_cast<std::int64_t>(flags.size()); ++ray)
    progress.rays_logged += flags[static_cast<std::size_t>(ray)] &&
                            mirrored.is_solved(static_cast<std::int32_t>(ray / n_directions),
                                               static_cast<std::int32_t>(ray % n_directions));
  progress.damage = dl::scan(file, header).damage;
  return progress;
}

}  // namespace phynness
