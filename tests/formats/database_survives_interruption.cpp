// Claims: a process killed at any byte loses at most the ray it was writing; finished work is never
// overwritten; a resumed run continues only the same work; a full disk leaves whole records behind.
#include "database_under_test.hpp"
#include "file_size_limit.hpp"

namespace phynness::test {
namespace {

class Interruption : public DatabaseTest {
 protected:
  static std::ptrdiff_t rays_in(const std::vector<char>& flags) {
    return std::count(flags.begin(), flags.end(), char{1});
  }
};

TEST_F(Interruption, at_any_byte_of_the_last_record_loses_that_record_only) {
  const auto header = small_header(false);
  write_logs(header);
  const auto rays = all_rays(header);
  const fs::path first_log = log / "rank-0000";
  const auto whole = bytes_of(first_log);
  // All records have one size, so the last one's start follows from a log that lacks it.
  std::size_t record = 0;
  {
    DatabaseWriter probe(file, header, 9);
    const auto opening = bytes_of(log / "rank-0009").size();
    record = (whole.size() - opening) / rays.size();
    ASSERT_EQ(opening + record * rays.size(), whole.size());
  }
  fs::remove(log / "rank-0009");

  const auto packed_whole = [&] {
    DatabaseWriter::pack(file, header);
    const auto bytes = bytes_of(file);
    fs::remove(file);
    return bytes;
  }();
  DatabaseWriter::create(file, header, false);
  for (std::size_t cut = 1; cut <= record; ++cut) {
    write_bytes(first_log, {whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(cut)});
    const auto flags = DatabaseWriter::logged(file, header);
    ASSERT_EQ(rays_in(flags), static_cast<std::ptrdiff_t>(rays.size()) - 1) << cut;
    ASSERT_EQ(flags.back(), 0);
    const auto progress = database_progress(file);
    ASSERT_EQ(progress.rays_logged, static_cast<std::int64_t>(rays.size()) - 1);
    if (cut < record) {
      ASSERT_EQ(progress.damage.size(), 1u) << cut;
      ASSERT_EQ(progress.damage[0].dropped_bytes, static_cast<std::int64_t>(record - cut));
      ASSERT_EQ(progress.damage[0].log, first_log);
    } else {
      ASSERT_TRUE(progress.damage.empty());
    }
    // Packing after every cut would take long and show the same.
    if (cut % 397 != 1 && cut != record) continue;
    DatabaseWriter::create(file, header, true);
    expect_names(refusal([&] { DatabaseWriter::pack(file, header); }, Error::Kind::failure), {"1 of 21", "--resume"});
    DatabaseWriter again(file, header, 0);
    again.append(rays.back());
    again.close();
    EXPECT_TRUE(fs::exists(log / "rank-0000-1"));
    DatabaseWriter::pack(file, header);
    ASSERT_EQ(bytes_of(file), packed_whole) << cut;
    fs::remove(file);
    DatabaseWriter::create(file, header, false);
  }
}

TEST_F(Interruption, between_packing_and_tidying_up_is_mended_by_resuming) {
  const auto header = small_header(false);
  write_logs(header);
  fs::copy(log, folder() / "kept", fs::copy_options::recursive);
  DatabaseWriter::pack(file, header);
  fs::rename(folder() / "kept", log);
  const auto finished = bytes_of(file);
  DatabaseWriter::create(file, header, true);
  EXPECT_FALSE(fs::exists(log));
  EXPECT_EQ(rays_in(DatabaseWriter::logged(file, header)), 21);
  DatabaseWriter::pack(file, header);
  EXPECT_EQ(bytes_of(file), finished);
}

TEST_F(Interruption, finished_work_is_never_overwritten) {
  const auto header = small_header(false);
  write_logs(header);
  expect_names(refusal([&] { DatabaseWriter::create(file, header, false); }), {"exists", file.c_str(), "--resume"});
  DatabaseWriter::pack(file, header);
  expect_names(refusal([&] { DatabaseWriter::create(file, header, false); }), {"exists", "--resume"});
  DatabaseWriter::create(file, header, true);
  EXPECT_TRUE(Database::is_complete(file));
  // Any file counts, not only databases.
  const fs::path notes = folder() / "notes.txt";
  write_bytes(notes, {'a'});
  refusal([&] { DatabaseWriter::create(notes, header, false); });
  expect_names(refusal([&] { DatabaseWriter::create(notes, header, true); }), {"HDF5", notes.c_str()});
  EXPECT_EQ(bytes_of(notes).size(), 1u);
}

TEST_F(Interruption, logs_without_their_database_are_not_overwritten_either) {
  const auto header = small_header(false);
  write_logs(header);
  fs::remove(file);
  expect_names(refusal([&] { DatabaseWriter::create(file, header, false); }), {"logs of an earlier run", "--resume"});
  DatabaseWriter::create(file, header, true);
  EXPECT_EQ(rays_in(DatabaseWriter::logged(file, header)), 21);
}

TEST_F(Interruption, resuming_with_another_physics_names_every_key_that_differs) {
  write_logs(small_header(false));
  auto scene = database_scene;
  scene.replace(scene.find("250.0"), 5, "300.0");
  scene.replace(scene.find("increments = 3"), 14, "increments = 5");
  const auto message = refusal([&] { DatabaseWriter::create(file, small_header(false, scene), true); });
  expect_names(message, {"another physics", "material.shear_modulus_Pa: 500 in the file, 600 now",
                         "probe.increments: 3 in the file, 5 now", "another -o"});
  EXPECT_EQ(message.find("probe.kind"), std::string::npos) << message;
}

TEST_F(Interruption, resuming_with_a_deeper_scene_names_the_increments_that_keep_the_rays) {
  const auto header = [](double depth_m, int increments) {
    auto scene = database_scene;
    scene.resize(scene.find("max_displacement_m"));
    const auto n = std::to_string(increments);
    auto h = small_header(false, scene + "max_displacement_m = " + std::to_string(depth_m) + "\nincrements = " + n);
    h.magnitudes_m.clear();
    for (int i = 1; i <= increments; ++i) h.magnitudes_m.push_back(depth_m * i / increments);
    return h;
  };
  DatabaseWriter::create(file, header(0.02, 4), false);
  expect_names(refusal([&] { DatabaseWriter::create(file, header(0.028, 4), true); }),
               {"other increments", "4 to 0.02 m in the file, 4 to 0.028 m now",
                "increments = 6 and max_displacement_m = 0.03,", "another -o"});
  EXPECT_EQ(coverage(header(0.02, 4), header(0.03, 6)), Coverage::part);
}

TEST_F(Interruption, resuming_with_another_training_is_fine) {
  write_logs(small_header(false));
  DatabaseWriter::create(file, small_header(false, database_scene + "[training]\nsamples = 7\n"), true);
  EXPECT_EQ(database_progress(file).rays_logged, 21);
}

TEST_F(Interruption, resuming_on_another_mesh_or_selection_is_refused) {
  write_logs(small_header(false));
  auto other = small_header(false);
  other.mesh.nodes(5, 0) += 1e-9;
  expect_names(refusal([&] { DatabaseWriter::create(file, other, true); }),
               {"another mesh", mesh_hash(other.mesh).c_str(), mesh_hash(small_header(false).mesh).c_str()});
  other = small_header(false);
  other.sets.active = {1, 2, 3};
  expect_names(refusal([&] { DatabaseWriter::create(file, other, true); }),
               {"active nodes", "3 in the file, 3 now, but not the same"});
  other = small_header(false);
  other.sets.output = {1, 2};
  expect_names(refusal([&] { DatabaseWriter::create(file, other, true); }), {"output nodes", "4 in the file, 2 now"});
  other = small_header(false);
  other.tangents = false;
  expect_names(refusal([&] { DatabaseWriter::create(file, other, true); }),
               {"tangents", "true in the file, false now"});
  expect_names(refusal([&] { DatabaseWriter::create(file, small_header(true), true); }),
               {"displacement_precision", "float32 in the file, float64 now"});
}

TEST_F(Interruption, a_log_of_another_mesh_is_refused_by_name) {
  const auto header = small_header(false);
  auto other = header;
  other.mesh.nodes(5, 0) += 1e-9;
  DatabaseWriter::create(file, header, false);
  { DatabaseWriter stranger(file, other, 3); }
  expect_names(refusal([&] { DatabaseWriter::logged(file, header); }), {"rank-0003", "another scene or mesh"});
}

TEST_F(Interruption, a_ray_logged_twice_counts_once) {
  const auto header = small_header(false);
  write_logs(header);
  auto twin = random_ray(header, 0, 0);
  twin.force[0] = 1e9;
  DatabaseWriter writer(file, header, 0);
  writer.append(twin);
  writer.close();
  DatabaseWriter::pack(file, header);
  EXPECT_EQ(Database::open(file).rays(0)[0].force, random_ray(header, 0, 0).force);
}

TEST_F(Interruption, a_ray_of_the_wrong_size_is_refused) {
  const auto header = small_header(false);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter writer(file, header, 0);
  auto ray = random_ray(header, 0, 0);
  ray.displacement.pop_back();
  expect_names(refusal([&] { writer.append(ray); }, Error::Kind::failure), {"active 0, direction 0"});
}

TEST_F(Interruption, a_full_disk_is_an_error_and_leaves_whole_records) {
  const auto header = small_header(false);
  const auto rays = all_rays(header);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter writer(file, header, 0);
  writer.append(rays[0]);
  const auto before = bytes_of(log / "rank-0000");
  {
    // Half a record fits, so that the write is torn before it fails.
    const FileSizeLimit full(before.size() + 200);
    const auto message = refusal([&] { writer.append(rays[1]); }, Error::Kind::failure);
    expect_names(message, {"cannot write", "rank-0000", "free space", "--resume"});
  }
  EXPECT_EQ(bytes_of(log / "rank-0000"), before);
  EXPECT_TRUE(database_progress(file).damage.empty());
  DatabaseWriter again(file, header, 0);  // of a run with more room
  for (std::size_t i = 1; i < rays.size(); ++i) again.append(rays[i]);
  again.close();
  DatabaseWriter::pack(file, header);
  EXPECT_EQ(Database::open(file).rays(2)[6].force, rays.back().force);
}

TEST_F(Interruption, a_full_disk_while_packing_keeps_the_logs) {
  auto header = small_header(true);
  write_logs(header);
  {
    const FileSizeLimit full(6000);
    refusal([&] { DatabaseWriter::pack(file, header); }, Error::Kind::failure);
  }
  EXPECT_FALSE(Database::is_complete(file));
  EXPECT_EQ(database_progress(file).rays_logged, 21);
  EXPECT_FALSE(fs::exists(file.string() + ".packing"));
  DatabaseWriter::pack(file, header);
  EXPECT_TRUE(Database::is_complete(file));
}

}  // namespace
}  // namespace phynness::test
