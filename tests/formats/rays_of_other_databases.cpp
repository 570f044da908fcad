// Claims: a database that takes the rays of another one is, byte for byte, the one of which every ray was written,
// failed ones too. A database seen as that of a part of its nodes has the rays of that part. Rays of another physics,
// mesh, depth or storage are refused with the keys that differ.
#include <phynness/formats/mirrored_rays.hpp>

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

/// Every node and direction that a database of these tests may have.
DatabaseHeader everything() {
  auto header = small_header(false);
  header.sets.active = {1, 2, 3, 4};
  header.directions = exploratory_directions(Directions::twenty_six);
  header.directions.resize(9);
  header.fields = {Field::von_mises_stress};
  return header;
}

DatabaseHeader study(const std::vector<std::int32_t>& active, const std::vector<std::int32_t>& output,
                     std::size_t first_direction, std::size_t n_directions) {
  auto header = everything();
  header.sets.active = active;
  header.sets.output = output;
  const auto first = header.directions.begin() + static_cast<std::ptrdiff_t>(first_direction);
  header.directions = std::vector<Vec3>(first, first + static_cast<std::ptrdiff_t>(n_directions));
  header.physics_hash = physics_hash(stored_scene(header));
  header.mesh_hash = mesh_hash(header.mesh);
  return header;
}

/// A ray of everything(), as a study stores it.
Ray ray_of(const DatabaseHeader& header, std::size_t active, std::size_t direction) {
  const auto all = everything();
  const auto position = [](const auto& list, const auto& one) {
    return static_cast<int>(std::find(list.begin(), list.end(), one) - list.begin());
  };
  Ray ray = random_ray(all, position(all.sets.active, header.sets.active[active]),
                       position(all.directions, header.directions[direction]));
  const auto chosen = [&](const std::vector<double>& values, std::size_t size) {
    std::vector<double> kept;
    const std::size_t n = all.sets.output.size();
    for (std::size_t i = 0; i < all.magnitudes_m.size(); ++i)
      for (const auto node : header.sets.output) {
        const auto from =
            values.begin() +
            static_cast<std::ptrdiff_t>(size * (i * n + static_cast<std::size_t>(position(all.sets.output, node))));
        kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(size));
      }
    return kept;
  };
  ray.displacement = chosen(ray.displacement, 3);
  for (auto& field : ray.fields) field = chosen(field, 1);
  ray.active = static_cast<std::int32_t>(active);
  ray.direction = static_cast<std::int32_t>(direction);
  if (ray.end.reason == EndReason::not_recorded) ray.end.reason = EndReason::full_depth;
  return ray;
}

class OtherDatabases : public DatabaseTest {
 protected:
  /// Writes the rays without a flag, and packs.
  void finish(const fs::path& path, const DatabaseHeader& header, const std::vector<char>& flags) {
    DatabaseWriter log(path, header, 1);
    for (std::size_t ray = 0; ray < flags.size(); ++ray)
      if (!flags[ray]) log.append(ray_of(header, ray / header.directions.size(), ray % header.directions.size()));
    log.close();
    DatabaseWriter::pack(path, header);
  }
  fs::path whole(const char* name, const DatabaseHeader& header) {
    const auto path = folder() / name;
    DatabaseWriter::create(path, header, false);
    finish(path, header, std::vector<char>(header.sets.active.size() * header.directions.size(), 0));
    return path;
  }
  std::string refused(const DatabaseHeader& then, const DatabaseHeader& now) {
    fs::remove(folder() / "then.h5");
    const auto from = whole("then.h5", then);
    return refusal([&] { Database::rays_for(from, now); });
  }
};

TEST_F(OtherDatabases, give_their_rays_bit_for_bit) {
  const auto from = whole("old.h5", study({1, 2, 4}, {1, 2, 3, 4}, 0, 7));
  struct Case {
    DatabaseHeader wanted;
    std::ptrdiff_t taken;
  };
  const Case cases[] = {{study({1, 2, 3, 4}, {1, 2, 3, 4}, 0, 7), 21},  // more nodes
                        {study({2}, {1, 2, 3, 4}, 0, 7), 7},            // fewer
                        {study({1, 2, 4}, {2, 4}, 0, 7), 21},           // less of the body
                        {study({1, 3, 4}, {1, 3}, 5, 4), 4},            // others, and other directions
                        {study({3}, {1, 2, 3, 4}, 0, 7), 0}};           // none
  for (int number = 0; const auto& [wanted, taken] : cases) {
    const auto flags = Database::rays_for(from, wanted);
    EXPECT_EQ(std::count(flags.begin(), flags.end(), char{1}), taken);
    const auto grown = folder() / ("grown" + std::to_string(number) + ".h5");
    DatabaseWriter::create(grown, wanted, false);
    DatabaseWriter::take(grown, wanted, from, flags);
    finish(grown, wanted, flags);
    EXPECT_EQ(bytes_of(grown), bytes_of(whole(("fresh" + std::to_string(number++) + ".h5").c_str(), wanted)));
  }
}

TEST_F(OtherDatabases, seen_as_that_of_a_part_are_that_part) {
  const auto part = study({2, 4}, {1, 3}, 0, 7);
  const auto seen = Database::open(whole("old.h5", study({1, 2, 4}, {1, 2, 3, 4}, 0, 7)), part);
  const auto alone = Database::open(whole("part.h5", part));
  EXPECT_EQ(seen.header().sets.active, part.sets.active);
  EXPECT_EQ(seen.statuses(), alone.statuses());
  const auto ends = seen.ends(), expected_ends = alone.ends();
  for (std::size_t i = 0; i < ends.size(); ++i) expect_same_end(ends[i], expected_ends[i]);
  EXPECT_EQ(summarize(seen).seconds, summarize(alone).seconds);
  for (std::int32_t active = 0; active < 2; ++active) {
    const auto rays = seen.rays(active), expected = alone.rays(active);
    for (std::size_t d = 0; d < rays.size(); ++d) {
      EXPECT_EQ(rays[d].force, expected[d].force);
      EXPECT_EQ(rays[d].displacement, expected[d].displacement);
      EXPECT_EQ(rays[d].fields, expected[d].fields);
    }
  }
}

TEST_F(OtherDatabases, give_no_ray_that_a_solve_would_not_repeat) {
  auto header = study({1, 2, 4}, {1, 2, 3, 4}, 0, 7);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter log(file, header, 0);
  for (std::size_t i = 0; i < 21; ++i) {
    auto ray = ray_of(header, i / 7, i % 7);
    if (i == 3) ray.status.back() = Status::library_error;
    if (i == 5) ray = empty_ray(header, 0, 5);  // not requested
    log.append(ray);
  }
  log.close();
  DatabaseWriter::pack(file, header);
  const auto flags = Database::rays_for(file, header);
  for (std::size_t i = 0; i < 21; ++i) EXPECT_EQ(flags[i], i != 3 && i != 5) << i;
}

TEST_F(OtherDatabases, are_refused_with_what_differs) {
  const auto then = study({1, 2, 4}, {1, 2, 3}, 0, 7);
  const auto scene = [&](const std::string& from, const std::string& to) {
    auto now = then;
    now.scene_text.replace(now.scene_text.find(from), from.size(), to);
    now.physics_hash = physics_hash(stored_scene(now));
    return now;
  };
  expect_contains(refused(then, scene("100e3", "200e3")), {"no ray", "material.lame_lambda_Pa: 99666"});
  auto deeper = scene("0.02", "0.04");
  deeper.magnitudes_m = {0.01 / 3, 0.02 / 3, 0.02, 0.04};
  expect_contains(refused(then, deeper), {"probe.max_displacement_m", "other increments", "3 in the file, 4 now"});
  expect_contains(refused(then, scene("\"P1\"", "\"P2\"")), {"solver.element: P1 in the file, P2 now"});
  auto moved = then;
  moved.mesh.nodes(5, 0) += 1e-9;
  expect_contains(refused(then, moved), {"another mesh"});  // the hash of the file is still the same
  auto held = then;
  held.sets.fixed = {0, 5};
  expect_contains(refused(then, held), {"other fixed nodes"});
  auto stored = then;
  stored.float64 = true;
  stored.tangents = false;
  expect_contains(refused(then, stored), {"tangents", "displacement_precision"});
  expect_contains(refused(then, study({1}, {1, 4}, 0, 7)), {"output nodes that the database does not hold: 1 of 2"});
  // What no known version has solved is not understood, even if its scene is the same.
  auto unknown = then;
  unknown.physics_hash = "0123456789abcdef";
  expect_contains(refused(unknown, then), {"another physics", "0123456789abcdef in the file"});
}

TEST_F(OtherDatabases, cover_what_a_study_wants) {
  const auto then = study({1, 2}, {1, 2, 3}, 0, 7);
  EXPECT_EQ(coverage(then, then), Coverage::same);
  EXPECT_EQ(coverage(then, study({2}, {1, 3}, 0, 7)), Coverage::whole);
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2, 3}, 0, 7)), Coverage::part);
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2}, 0, 7)), Coverage::other) << "would lose displacements";
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2, 3, 4}, 0, 7)), Coverage::other) << "lacks displacements";
  EXPECT_EQ(coverage(then, study({2, 3}, {1, 2, 3}, 0, 7)), Coverage::other);
  EXPECT_EQ(coverage(then, study({1, 2}, {1, 2, 3}, 0, 6)), Coverage::other);
  auto stored = then;
  stored.tangents = false;
  EXPECT_EQ(coverage(then, stored), Coverage::other);
}

}  // namespace
}  // namespace phynness::test
