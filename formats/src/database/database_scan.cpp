#include "database_scan.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <string_view>

namespace phynness::database_log {
namespace {

/// Fills `bytes` from an offset on. @return false if the file ends before
bool read_at(std::ifstream& file, std::int64_t offset, std::vector<unsigned char>& bytes) {
  file.clear();
  file.seekg(offset).read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes));
  return file.good();
}

/// Reads one log record by record.
struct LogScan {
  const std::filesystem::path& path;
  std::int32_t number;
  const std::vector<unsigned char>& opening;
  const Layout& layout;
  Index& index;
  std::ifstream file{path, std::ios::binary};
  std::int64_t size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  std::vector<unsigned char> record = std::vector<unsigned char>(layout.record_bytes());

  void run() {
    // A damaged record is left out: all have the same size.
    for (std::int64_t at = read_opening(), bytes = std::ssize(record); at < size; at += bytes)
      if (const char* defect = take(at)) index.damage.push_back({path, defect, std::min(bytes, size - at)});
  }

  /// @return offset of the first record. @throws Error (input) if the log belongs to another physics or mesh
  std::int64_t read_opening() {
    if (size == 0) return 0;
    std::vector<unsigned char> found(opening.size());
    if (!read_at(file, 0, found)) {
      index.damage.push_back({path, "torn opening", size});
      return size;
    }
    if (found == opening) return static_cast<std::int64_t>(found.size());
    const std::size_t body = found.size() - checksum_bytes;
    Fnv1a64 hash;
    hash.add(found.data(), body);
    if (value_at<std::uint64_t>(found.data() + body) != hash.value()) {
      index.damage.push_back({path, "corrupted opening", size});
      return size;
    }
    throw input_error("the log belongs to another scene or mesh than the database", path.string(),
                      "use the scene with which it was begun, or delete this log to solve its rays again");
  }

  /// Adds the record at an offset. @return its defect, or nullptr
  const char* take(std::int64_t at) {
    if (!read_at(file, at, record)) return "torn record";
    const std::size_t checked = record.size() - checksum_bytes;
    if (!std::equal(record_magic.begin(), record_magic.end(), record.begin()) ||
        value_at<std::uint32_t>(record.data() + record_magic.size()) != layout.payload_bytes ||
        value_at<std::uint64_t>(record.data() + checked) != record_checksum(opening, record.data(), checked))
      return "corrupted record";
    const auto active = value_at<std::int32_t>(record.data() + prefix_bytes);
    const auto direction = value_at<std::int32_t>(record.data() + prefix_bytes + sizeof(std::int32_t));
    if (active < 0 || active >= layout.n_active || direction < 0 || direction >= layout.n_directions)
      return "record of a ray that is not in the database";
    index.entries.push_back({active, direction, number, at + static_cast<std::int64_t>(prefix_bytes)});
    return nullptr;
  }
};

/// rank-0012, or rank-0012-3 where a rank began another log.
bool is_name_of_log(const std::string& name) {
  constexpr std::string_view prefix = "rank-";
  return name.starts_with(prefix) && name.find_first_not_of("0123456789-", prefix.size()) == name.npos;
}

}  // namespace

std::vector<std::filesystem::path> logs_of(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> logs;
  const auto dir = folder(file);
  std::error_code code;
  if (!std::filesystem::is_directory(dir, code)) return logs;
  for (const auto& item : std::filesystem::directory_iterator(dir))
    if (item.is_regular_file() && is_name_of_log(item.path().filename().string())) logs.push_back(item.path());
  std::sort(logs.begin(), logs.end());
  return logs;
}

Index scan(const std::filesystem::path& file, const DatabaseHeader& header, const PackingRanks& ranks) {
  Index index, found;  // of all processes; by this one, with the same numbers of logs
  std::vector<std::int64_t> names;
  ranks.together([&] {
    // One list for all: a network file system may show new files of others late.
    if (ranks.rank != 0) return;
    for (const auto& log : logs_of(file))
      for (const char c : log.filename().string() + '/') names.push_back(c);
  });
  std::string name;
  for (const auto c : ranks.gathered(names))
    if (c != '/')
      name += static_cast<char>(c);
    else
      index.logs.push_back(folder(file) / std::exchange(name, ""));
  ranks.together([&] {
    const auto opening = encode_opening(header);
    const Layout layout(header);
    const auto n_ranks = static_cast<std::size_t>(ranks.size);
    for (auto i = static_cast<std::size_t>(ranks.rank); i < index.logs.size(); i += n_ranks)
      LogScan{index.logs[i], static_cast<std::int32_t>(i), opening, layout, found}.run();
  });
  index.damage = std::move(found.damage);
  std::vector<std::int64_t> numbers;
  for (const auto& entry : found.entries)
    numbers.insert(numbers.end(), {entry.active, entry.direction, entry.log, entry.offset});
  numbers = ranks.gathered(numbers);
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    const auto of_32_bits = [&](std::size_t k) { return static_cast<std::int32_t>(numbers[i + k]); };
    index.entries.push_back({of_32_bits(0), of_32_bits(1), of_32_bits(2), numbers[i + 3]});
  }
  std::ranges::stable_sort(index.entries, {}, &Entry::log);
  return index;
}

Ray RayReader::read(const Entry& entry, std::optional<bool> of_output_nodes) {
  const auto& log = _index.logs[static_cast<std::size_t>(entry.log)];
  auto file = _open.find(entry.log);
  if (file == _open.end()) {
    // Much less than the usual limit of a process, and enough that neighbouring rays use the same open files.
    constexpr std::size_t most_open = 64;
    if (_open.size() >= most_open) _open.clear();
    file = _open.emplace(entry.log, std::ifstream(log, std::ios::binary)).first;
  }
  if (!read_at(file->second, entry.offset, _payload))
    throw failure("a log became shorter while it was packed", log.string(),
                  "make sure that only one process uses the database");
  return decode(_payload.data(), _layout, of_output_nodes);
}

}  // namespace phynness::database_log
