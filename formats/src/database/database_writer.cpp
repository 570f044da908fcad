// Writing a database: header, logs, and packing of the logs into the finished file.
#include <algorithm>
#include <cmath>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>

#include "database_layout.hpp"
#include "database_pack.hpp"
#include "database_scan.hpp"
#include "database_study.hpp"
#include "text/durable_file.hpp"

namespace phynness {
namespace fs = std::filesystem;
namespace layout = database_layout;
namespace dl = database_log;

namespace {

DatabaseHeader with_hashes(DatabaseHeader header) {
  if (header.mesh_hash.empty()) header.mesh_hash = mesh_hash(header.mesh);
  if (header.physics_hash.empty()) header.physics_hash = physics_hash(stored_scene(header));
  return header;
}

/// As rank 0 sees it: a network file system may show a new file late.
bool is_complete(const fs::path& file, const PackingRanks& ranks) {
  std::vector<std::int64_t> complete;
  ranks.together([&] {
    if (ranks.rank == 0) complete = {Database::is_complete(file)};
  });
  return ranks.gathered(complete).front() != 0;
}

/// Rounds displacements as the header asks for.
Ray rounded(Ray ray, const std::vector<double>& magnitudes_m, int bits) {
  const std::size_t n = ray.displacement.size() / magnitudes_m.size();
  for (std::size_t i = 0; i < ray.displacement.size(); ++i) {
    const double step = std::ldexp(1.0, std::ilogb(magnitudes_m[i / n]) - bits);
    ray.displacement[i] = step * std::round(ray.displacement[i] / step);
  }
  return ray;
}

/// The rays of a database, finished or not, of every n-th node from `first` on.
void for_each_ray(const fs::path& file, const DatabaseHeader& header, std::int32_t first, std::int32_t n,
                  const std::function<void(Ray)>& use) {
  const auto n_active = static_cast<std::int32_t>(header.sets.active.size());
  if (Database::is_complete(file)) {
    const auto database = Database::open(file);
    for (auto active = first; active < n_active; active += n)
      for (auto& ray : database.rays(active)) use(std::move(ray));
    return;
  }
  const auto index = dl::scan(file, header);
  dl::RayReader reader(index, header);
  for (const auto& record : one_record_per_ray(index, header))
    if (!is_missing(record) && record.active % n == first) use(reader.read(record));
}

/// Adds the increments that a ray to a smaller depth does not have. @return false if they have to be solved
bool extend(Ray& ray, const DatabaseHeader& header) {
  const auto n = ray.status.size();
  for (const auto& column : columns_of(header))
    if (column.of != ColumnOf::ray) resize_values(ray, column, column.count);
  if (n == ray.status.size()) return true;
  const auto last = ray.status[n - 1];
  // A field may be infinite and the ray go on.
  if (last == Status::converged || last == Status::not_finite) return false;
  std::fill(ray.status.begin() + static_cast<std::ptrdiff_t>(n), ray.status.end(),
            static_cast<int>(last) < 0 ? Status::after_failure : last);
  return true;
}

}  // namespace

bool DatabaseWriter::refuse_begun(const fs::path& file, bool resume) {
  std::error_code code;
  if (fs::is_directory(file, code))
    throw input_error("the database to write is a folder", file.string(),
                      "give the name of a file, for example " + (file / "database.h5").string());
  const bool exists = fs::exists(file, code);
  if (exists && !resume)
    throw input_error("the database exists and is not overwritten", file.string(),
                      "continue it with --resume, or give another -o");
  if (!exists && !resume && !dl::logs_of(file).empty())
    throw input_error("there are logs of an earlier run without their database", dl::folder(file).string(),
                      "continue with --resume, or delete the folder");
  return exists;
}

void DatabaseWriter::check(const fs::path& file, const DatabaseHeader& given, bool resume) {
  const DatabaseHeader header = with_hashes(given);
  check_folder_of(file);
  if (!refuse_begun(file, resume)) return;
  refuse_other_work(read_database_header(file), header, file);
}

void DatabaseWriter::create(const fs::path& file, const DatabaseHeader& given, bool resume, int part) {
  check(file, given, resume);
  const DatabaseHeader header = with_hashes(given);
  std::error_code code;
  if (fs::exists(file, code)) {
    if (Database::is_complete(file))
      remove_logs(file);  // remains if a process ended between packing and removing the logs
    else
      make_log_folder(file);
    return;
  }
  make_log_folder(file);
  auto partial = fs::path(file) += ".tmp";
  if (part > 0) (partial += '-') += std::to_string(part);
  try {
    auto out = hdf5::File::create(partial, layout::header_bytes(header));
    layout::write_header(out, header, false);
    out.close();
    replace_durably(partial, file);
  } catch (...) {
    fs::remove(partial, code);
    throw;
  }
}

std::vector<char> DatabaseWriter::logged(const fs::path& file, const DatabaseHeader& given, const PackingRanks& ranks) {
  const DatabaseHeader header = with_hashes(given);
  std::vector<char> flags(header.sets.active.size() * header.directions.size(), 0);
  if (is_complete(file, ranks)) {
    std::fill(flags.begin(), flags.end(), char{1});
    return flags;
  }
  const auto records = one_record_per_ray(dl::scan(file, header, ranks), header);
  std::transform(records.begin(), records.end(), flags.begin(),
                 [](const dl::Entry& record) { return char{!is_missing(record)}; });
  return flags;
}

struct DatabaseWriter::Impl {
  AppendFile log;
  dl::Layout sizes;
  std::vector<unsigned char> opening;
  std::vector<double> magnitudes_m;
  int field_bits;
};

DatabaseWriter::DatabaseWriter(const fs::path& file, const DatabaseHeader& given, int rank) {
  const DatabaseHeader header = with_hashes(given);
  make_log_folder(file);
  std::string digits = std::to_string(rank);
  digits.insert(0, digits.size() < 4 ? 4 - digits.size() : 0, '0');
  const std::string stem = (dl::folder(file) / ("rank-" + digits)).string();
  fs::path log = stem;
  for (int again = 1; fs::exists(log); ++again) log = stem + "-" + std::to_string(again);
  _impl = std::make_unique<Impl>(
      Impl{AppendFile(log), dl::Layout(header), dl::encode_opening(header), header.magnitudes_m, header.field_bits});
  _impl->log.append(_impl->opening.data(), _impl->opening.size());
}
DatabaseWriter::~DatabaseWriter() = default;
DatabaseWriter::DatabaseWriter(DatabaseWriter&&) noexcept = default;
DatabaseWriter& DatabaseWriter::operator=(DatabaseWriter&&) noexcept = default;

void DatabaseWriter::append(const Ray& ray) {
  const auto stored = _impl->field_bits > 0 ? rounded(ray, _impl->magnitudes_m, _impl->field_bits) : ray;
  const auto record = dl::encode(stored, _impl->sizes, _impl->opening);
  _impl->log.append(record.data(), record.size());
}
void DatabaseWriter::close() { _impl->log.close(); }

std::int64_t DatabaseWriter::take(const fs::path& file, const DatabaseHeader& given, const fs::path& from,
                                  const std::vector<char>& missing, int log_number, int rank, int n_ranks) {
  const DatabaseHeader header = with_hashes(given), stored = read_database_header(from);
  const auto position = [](const auto& all, const auto& one) {
    return static_cast<std::int32_t>(std::ranges::find(all, one) - all.begin());
  };
  std::optional<DatabaseWriter> log;
  std::int64_t n = 0;
  for_each_ray(from, stored, rank, n_ranks, [&](Ray ray) {
    ray.active = position(header.sets.active, stored.sets.active[static_cast<std::size_t>(ray.active)]);
    ray.direction = position(header.directions, stored.directions[static_cast<std::size_t>(ray.direction)]);
    const auto at =
        static_cast<std::size_t>(ray.active) * header.directions.size() + static_cast<std::size_t>(ray.direction);
    if (!missing[at] || ray.status.front() == Status::not_requested ||
        std::ranges::count(ray.status, Status::library_error) > 0 || !extend(ray, header))
      return;
    if (!log) log.emplace(file, header, log_number);
    log->append(ray);
    ++n;
  });
  if (log) log->close();
  return n;
}

void DatabaseWriter::replace(const fs::path& by, const fs::path& file) {
  replace_durably(by, file);
  remove_logs(file);
}

void DatabaseWriter::pack(const fs::path& file, const DatabaseHeader& given, const PackingRanks& ranks,
                          const std::function<AtRest(std::int32_t point)>& at_rest) {
  const DatabaseHeader header = with_hashes(given);
  ranks.together([&] {
    if (ranks.rank == 0) refuse_other_work(read_database_header(file), header, file);
  });
  if (!is_complete(file, ranks)) {
    const auto index = dl::scan(file, header, ranks);
    const auto records = one_record_per_ray(index, header);
    ranks.together([&] {
      if (const auto missing = std::ranges::count_if(records, is_missing); missing > 0)
        throw failure("the database " + file.string() + " cannot be packed: rays are missing",
                      std::to_string(missing) + " of " + std::to_string(records.size()),
                      "solve them with: phynness precompute SCENE -o " + file.string() + " --resume");
    });
    write_packed(file, header, index, records, ranks, at_rest);
  }
  if (ranks.rank == 0) remove_logs(file);
}

DatabaseProgress database_progress(const fs::path& file) {
  const auto header = read_database_header(file);
  DatabaseProgress progress;
  progress.complete = Database::is_complete(file);
  progress.rays_total = static_cast<std::int64_t>(header.sets.active.size() * header.directions.size());
  if (progress.complete) {
    progress.rays_logged = progress.rays_total;
    return progress;
  }
  auto index = dl::scan(file, header);
  const auto records = one_record_per_ray(index, header);
  progress.rays_logged = progress.rays_total - std::ranges::count_if(records, is_missing);
  progress.damage = std::move(index.damage);
  return progress;
}

}  // namespace phynness
