// Claims: every ray belongs to one shard, and shards have equal sizes. Merged shards are identical to the file of one
// run. Missing parts are named with their shard. Shards of other work are refused with the difference.
#include <algorithm>
#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/database_merge.hpp>
#include <set>

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

class Shards : public DatabaseTest {
 protected:
  fs::path path_of(int index, int count) const { return shard_file(file, {index, count}); }

  /// Writes the rays of one shard but `without`.
  fs::path write_shard(DatabaseHeader header, int index, int count, int without = -1) {
    header.shard = Shard{index, count};
    const auto shard = path_of(index, count);
    DatabaseWriter::create(shard, header, false);
    DatabaseWriter writer(shard, header, 0);
    const auto rays = all_rays(header);
    const auto owners = shards_of_rays(header.sets.active.size(), header.directions.size(), count);
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (owners[i] == index && static_cast<int>(i) != without) writer.append(rays[i]);
    writer.close();
    return shard;
  }
};

TEST_F(Shards, own_every_ray_once_and_are_even) {
  for (const int n_active : {1, 3, 62, 486})
    for (const int n_directions : {3, 26})
      for (const int count : {1, 2, 3, 7, 64, 500, 20000}) {
        std::vector<int> rays(static_cast<std::size_t>(count), 0);
        const auto all = static_cast<std::size_t>(n_active * n_directions);
        for (const int s :
             shards_of_rays(static_cast<std::size_t>(n_active), static_cast<std::size_t>(n_directions), count)) {
          ASSERT_GE(s, 0);
          ASSERT_LT(s, count);
          ++rays[static_cast<std::size_t>(s)];
        }
        const auto [least, most] = std::minmax_element(rays.begin(), rays.end());
        // The longest run, formats/database.md.
        const int longest = std::clamp(n_active * n_directions / (16 * count), 1, n_directions);
        EXPECT_LE(*most - *least, longest) << n_active << " " << n_directions << " " << count;
      }
}

TEST_F(Shards, do_not_each_get_the_same_directions_of_all_nodes) {
  std::set<std::size_t> directions;
  const auto owners = shards_of_rays(62, 26, 52);
  for (std::size_t ray = 0; ray < owners.size(); ++ray)
    if (owners[ray] == 0) directions.insert(ray % 26);
  EXPECT_GT(directions.size(), 13u);
}

TEST_F(Shards, merge_to_the_file_of_one_run_byte_for_byte) {
  const auto header = small_header(false);
  write_logs(header);
  DatabaseWriter::pack(file, header);
  const auto one_run = bytes_of(file);
  for (const int count : {1, 2, 5, 30}) {
    std::vector<fs::path> shards;
    for (int i = 0; i < count; ++i) shards.push_back(write_shard(header, i, count));
    std::reverse(shards.begin(), shards.end());
    const auto merged = folder() / "merged.h5";
    const auto report = merge_shards(shards, merged);
    EXPECT_TRUE(report.missing.empty());
    EXPECT_EQ(report.rays_total, 21);
    EXPECT_EQ(bytes_of(merged), one_run) << count;
    EXPECT_FALSE(fs::exists(merged.string() + ".log"));
    fs::remove(merged);
  }
}

TEST_F(Shards, missing_rays_are_named_with_their_shard_and_nothing_is_written) {
  const auto header = small_header(false);
  const int lost = 9;  // active 1 (node 2), direction 2
  const int owner = shards_of_rays(std::vector<char>(3 * 7, 1), 7, 3)[lost];
  std::vector<fs::path> shards;
  for (int i = 0; i < 3; ++i) shards.push_back(write_shard(header, i, 3, lost));
  const auto merged = folder() / "merged.h5";
  const auto report = merge_shards(shards, merged);
  ASSERT_EQ(report.missing.size(), 1u);
  EXPECT_EQ(report.missing[0].node, 2);
  EXPECT_EQ(report.missing[0].direction, 2);
  EXPECT_EQ(report.missing[0].owner, (Shard{owner, 3}));
  EXPECT_FALSE(fs::exists(merged));
  // A whole shard that never came.
  shards.erase(shards.begin() + 1);
  for (const auto& ray : merge_shards(shards, merged).missing)
    EXPECT_TRUE(ray.owner == (Shard{1, 3}) || (ray.node == 2 && ray.direction == 2));
}

TEST_F(Shards, a_damaged_shard_loses_its_damaged_rays_only) {
  const auto header = small_header(false);
  std::vector<fs::path> shards{write_shard(header, 0, 2), write_shard(header, 1, 2)};
  const fs::path victim = shards[1].string() + ".log/rank-0000";
  auto bytes = bytes_of(victim);
  bytes[bytes.size() / 2] ^= 0x10;
  write_bytes(victim, bytes);
  const auto report = merge_shards(shards, folder() / "merged.h5");
  ASSERT_EQ(report.damage.size(), 1u);
  EXPECT_EQ(report.damage[0].log, victim);
  ASSERT_EQ(report.missing.size(), 1u);
  EXPECT_EQ(report.missing[0].owner, (Shard{1, 2}));
}

TEST_F(Shards, whose_file_is_damaged_are_mended_from_their_logs) {
  const auto header = small_header(false);
  const std::vector<fs::path> shards{write_shard(header, 0, 2), write_shard(header, 1, 2)};
  const auto merged = folder() / "merged.h5";
  auto bytes = bytes_of(shards[1]);
  bytes.resize(bytes.size() / 2);
  write_bytes(shards[1], bytes);
  expect_contains(refusal([&] { merge_shards(shards, merged); }), {shards[1].c_str(), "delete the file", "--resume"});
  fs::remove(shards[1]);
  auto again = header;
  again.shard = Shard{1, 2};
  DatabaseWriter::create(shards[1], again, true);
  EXPECT_TRUE(merge_shards(shards, merged).missing.empty());
}

TEST_F(Shards, of_other_work_are_refused_with_what_differs) {
  const auto header = small_header(false);
  const auto first = write_shard(header, 0, 2);
  auto scene = database_scene;
  scene.replace(scene.find("250.0"), 5, "300.0");
  const auto other_material = write_shard(small_header(false, scene), 1, 2);
  const auto merged = folder() / "merged.h5";
  expect_contains(refusal([&] {
                    merge_shards({first, other_material}, merged);
                  }),
                  {"material.shear_modulus_Pa: 600 in the file, 500 in", first.c_str(), other_material.c_str()});
  auto mesh = header;
  mesh.mesh.nodes(5, 0) += 1e-9;
  const auto other_mesh = write_shard(mesh, 1, 3);
  expect_contains(refusal([&] { merge_shards({first, other_mesh}, merged); }), {"another mesh", other_mesh.c_str()});
  EXPECT_FALSE(fs::exists(merged));
}

TEST_F(Shards, never_overwrite_and_never_merge_what_is_finished_or_in_work) {
  const auto header = small_header(false);
  const auto shard = write_shard(header, 0, 1);
  write_bytes(file, {'a'});
  expect_contains(refusal([&] { merge_shards({shard}, file); }), {"exists", file.c_str()});
  fs::remove(file);
  const auto merged = folder() / "merged.h5";
  {
    const DatabaseLock lock(shard);
    expect_contains(refusal([&] { merge_shards({shard}, merged); }), {"still being computed", shard.c_str()});
  }
  merge_shards({shard}, merged);
  expect_contains(refusal([&] { merge_shards({merged}, folder() / "again.h5"); }), {"finished", merged.c_str()});
  expect_contains(refusal([&] { Database::open(shard); }), {"is a shard", "phynness merge"});
}

TEST_F(Shards, are_not_merged_into_a_folder_of_logs) {
  const auto header = small_header(false);
  const std::vector<fs::path> shards{write_shard(header, 0, 2), write_shard(header, 1, 2)};
  const auto other = folder() / "other.h5";
  DatabaseWriter::create(other, header, false);
  for (const auto& of : {shards[0], other}) {
    const auto output = fs::path(of.string() + ".log") / "all.h5";
    expect_contains(refusal([&] { merge_shards(shards, output); }), {output.c_str()});
    EXPECT_FALSE(fs::exists(output));
  }
  const auto alias = folder() / "alias";
  fs::create_directory_symlink(other.string() + ".log", alias);
  refusal([&] { merge_shards(shards, alias / "all.h5"); });
}

TEST_F(Shards, are_resumed_as_the_shard_they_are) {
  const auto header = small_header(false);
  const auto shard = write_shard(header, 0, 2);
  EXPECT_EQ(database_progress(shard).rays_logged, database_progress(shard).rays_total);
  auto other = header;
  other.shard = Shard{0, 3};
  expect_contains(refusal([&] { DatabaseWriter::create(shard, other, true); }), {"0/2 in the file, 0/3 now"});
  expect_contains(refusal([&] { DatabaseWriter::create(shard, header, true); }), {"0/2 in the file, no shard now"});
}

TEST_F(Shards, are_written_i_of_n_from_zero) {
  EXPECT_EQ(parse_shard("3/8"), (Shard{3, 8}));
  for (const char* bad : {"", "3", "3/", "/8", "a/b", "3/8x", "3/0", " 3/8", "3/-8", "99999999999/8"})
    expect_contains(refusal([&] { parse_shard(bad); }), {"i/n", bad});
  for (const char* bad : {"8/8", "-1/8"}) expect_contains(refusal([&] { parse_shard(bad); }), {"7/8", bad});
  const fs::path whole = "some/where.v2.h5";
  EXPECT_EQ(shard_file(whole, {3, 8}), "some/where.v2.shard-3-of-8.h5");
  EXPECT_EQ(database_of(shard_file(whole, {3, 8}), {3, 8}), whole);
}

}  // namespace
}  // namespace phynness::test
