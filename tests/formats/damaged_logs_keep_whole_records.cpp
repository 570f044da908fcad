// Claims: a changed byte costs its record only, and a database completed from a damaged log is identical to the
// undamaged one.
#include <algorithm>

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

class DamagedLog : public DatabaseTest {
 protected:
  void SetUp() override {
    header = small_header(false);
    write_logs(header);
    const auto rays = all_rays(header);
    whole = bytes_of(first_log());
    {
      DatabaseWriter probe(file, header, 9);
      opening = bytes_of(log / "rank-0009").size();
    }
    fs::remove(log / "rank-0009");
    record = (whole.size() - opening) / rays.size();
    ASSERT_EQ(opening + record * rays.size(), whole.size());
    DatabaseWriter::pack(file, header);
    packed = bytes_of(file);
    start_again();
  }
  fs::path first_log() const { return log / "rank-0000"; }
  void start_again() {
    fs::remove(file);
    fs::remove_all(log);
    DatabaseWriter::create(file, header, false);
  }
  /// The log's bytes are `bytes`; solves what is missing and packs.
  void complete(const std::vector<char>& bytes) {
    write_bytes(first_log(), bytes);
    const auto flags = DatabaseWriter::logged(file, header);
    DatabaseWriter again(file, header, 0);
    for (const auto& ray : all_rays(header))
      if (!flags[static_cast<std::size_t>(ray.active) * header.directions.size() +
                 static_cast<std::size_t>(ray.direction)])
        again.append(ray);
    again.close();
    DatabaseWriter::pack(file, header);
  }

  DatabaseHeader header;
  std::vector<char> whole, packed;
  std::size_t opening = 0, record = 0;
};

TEST_F(DamagedLog, a_changed_byte_drops_its_record_only) {
  for (const std::size_t victim : {0, 4, 20})
    for (const std::size_t offset : {std::size_t{0}, std::size_t{5}, std::size_t{9}, record / 2, record - 1}) {
      auto changed = whole;
      changed[opening + victim * record + offset] ^= 0x10;
      write_bytes(first_log(), changed);
      const auto progress = database_progress(file);
      EXPECT_EQ(progress.rays_total - progress.rays_logged, 1);
      EXPECT_EQ(DatabaseWriter::logged(file, header)[victim], 0);
      ASSERT_EQ(progress.damage.size(), 1u);
      EXPECT_EQ(progress.damage[0].reason, "corrupted record");
      EXPECT_EQ(progress.damage[0].dropped_bytes, static_cast<std::int64_t>(record));
    }
}

TEST_F(DamagedLog, random_damage_never_changes_the_result) {
  constexpr unsigned seed = 20240611;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (int round = 0; round < 20; ++round) {
    auto bytes = whole;
    for (std::size_t hits = 1 + below(6); hits > 0; --hits) {
      const auto at = below(bytes.size());
      switch (below(4)) {
        case 0:  // flipped bit
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
          break;
        case 1:  // truncated, but not to nothing
          bytes.resize(std::max<std::size_t>(1, bytes.size() - below(2 * record)));
          break;
        case 2:  // zeros, as after a power cut
          for (std::size_t i = at; i < std::min(bytes.size(), at + 600); ++i) bytes[i] = 0;
          break;
        default: {  // a piece moved
          const auto from = below(bytes.size()), length = std::min(bytes.size() - std::max(from, at), record);
          std::copy_n(std::vector<char>(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(from + length))
                          .begin(),
                      length, bytes.begin() + static_cast<std::ptrdiff_t>(at));
        }
      }
    }
    complete(bytes);
    ASSERT_EQ(bytes_of(file), packed) << "seed " << seed << ", round " << round;
    start_again();
  }
}

}  // namespace
}  // namespace phynness::test
