// Claims: a database that takes the rays of another one, finished or not, of fewer nodes and directions or to a smaller
// depth, is, byte for byte, the one of which every ray was written, failed ones too. Rays of another physics, mesh,
// step or storage are refused with the keys that differ.

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

/// Every node and direction that a database of these tests may have.
DatabaseHeader everything() {
  auto header = small_header(false);
  header.sets.active = {1, 2, 3, 4};
  header.sets.tools = single_nodes(header.sets.active);
  header.directions = exploratory_directions(Directions::twenty_six);
  header.directions.resize(9);
  header.fields = {Field::von_mises_stress};
  return header;
}

DatabaseHeader study(const std::vector<std::int32_t>& active, const std::vector<std::int32_t>& output,
                     std::size_t first_direction, std::size_t n_directions) {
  auto header = everything();
  header.sets.active = active;
  header.sets.tools = single_nodes(active);
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
};

TEST_F(OtherDatabases, give_their_rays_bit_for_bit) {
  const auto old = study({1, 2, 4}, {1, 2, 3, 4}, 0, 7), wanted = study({1, 2, 3, 4}, {1, 2, 3, 4}, 0, 9);
  EXPECT_EQ(coverage(old, wanted), Coverage::part);
  const auto is_old = [](std::size_t ray) { return ray / 9 != 2 && ray % 9 < 7; };
  std::vector<char> missing(36, 1), left(36);
  missing[3] = 0;  // logged already
  for (std::size_t ray = 0; ray < 36; ++ray) left[ray] = missing[ray] && is_old(ray);
  const auto finished = whole("old.h5", old), unfinished = folder() / "begun.h5";
  DatabaseWriter::create(unfinished, old, false);
  DatabaseWriter log(unfinished, old, 0);
  for (std::size_t i = 0; i < 21; ++i)
    if (i != 9) log.append(ray_of(old, i / 7, i % 7));
  log.close();
  const auto expected = bytes_of(whole("fresh.h5", wanted));
  for (const auto& from : {finished, unfinished}) {
    const auto grown = folder() / "grown.h5";
    fs::remove(grown);
    DatabaseWriter::create(grown, wanted, false);
    std::int64_t taken = 0;
    for (int rank = 0; rank < 2; ++rank) taken += DatabaseWriter::take(grown, wanted, from, missing, rank, rank, 2);
    EXPECT_EQ(taken, from == finished ? 20 : 19);
    left[1 * 9 + 2] = from == finished;
    finish(grown, wanted, left);
    EXPECT_EQ(bytes_of(grown), expected);
  }
}

/// What happens to a ray of three increments, which a study of the first two of them has, and whether it ends there.
struct Fate {
  std::vector<Status> status;
  RayEnd end;
  bool ends_before;
};
constexpr double second_m = 0.02 / 3, third_m = 0.02;
const Fate fates[] = {
    {{Status::converged, Status::converged, Status::converged}, {EndReason::full_depth, third_m}, false},
    {{Status::converged, Status::converged, Status::after_end},
     {EndReason::fold, second_m, second_m + 1e-4, 2e-6},  // found in the increment that the other study does not have
     false},
    {{Status::converged, Status::after_end, Status::after_end}, {EndReason::fold, 0.004, 0.0042, 3e-6}, true},
    {{Status::converged, Status::after_end, Status::after_end}, {EndReason::crushed, 0.0061}, true},
    {{Status::converged, Status::diverged, Status::after_failure}, {EndReason::solver, 0.005}, true},
    {{Status::converged, Status::library_error, Status::after_failure}, {EndReason::solver, 0.005}, false},
};

TEST_F(OtherDatabases, to_a_smaller_depth_give_the_rays_that_end_before) {
  const auto deep = study({1, 2, 4}, {1, 2, 3}, 0, 6);
  auto shallow = deep;
  shallow.magnitudes_m.pop_back();
  const std::string depth = "max_displacement_m = 0.02", number = "increments = 3";
  shallow.scene_text.replace(shallow.scene_text.find(depth), depth.size(), "max_displacement_m = 0.006666666666666667");
  shallow.scene_text.replace(shallow.scene_text.find(number), number.size(), "increments = 2");
  shallow.physics_hash = physics_hash(stored_scene(shallow));
  EXPECT_EQ(coverage(shallow, deep), Coverage::part);
  EXPECT_EQ(coverage(deep, shallow), Coverage::other) << "increments would be lost";
  const auto ray = [&](const DatabaseHeader& header, std::size_t i) {
    Ray one = ray_of(deep, i / 6, i % 6);
    const std::size_t n = header.magnitudes_m.size();
    one.status = fates[i % 6].status;
    one.end = fates[i % 6].end;
    const auto zeros = [&](std::vector<double>& values) {  // as a study that ends there has them
      std::fill(values.begin() + static_cast<std::ptrdiff_t>(values.size() / 3 * 2), values.end(), 0.0);
      values.resize(values.size() / 3 * n);
    };
    for (auto* values : {&one.force, &one.energy, &one.tangent, &one.min_jacobian, &one.seconds, &one.displacement,
                         &one.fields.front()})
      zeros(*values);
    for (auto* values : {&one.negative_pivots, &one.iterations, &one.cutbacks}) {
      values->back() = 0;
      values->resize(n);
    }
    one.status.resize(n);
    return one;
  };
  const auto write = [&](const fs::path& path, const DatabaseHeader& header, const auto& chosen) {
    if (!fs::exists(path)) DatabaseWriter::create(path, header, false);
    DatabaseWriter log(path, header, 1);
    for (std::size_t i = 0; i < 18; ++i)
      if (chosen(i)) log.append(ray(header, i));
    log.close();
    DatabaseWriter::pack(path, header);
  };
  write(folder() / "shallow.h5", shallow, [](std::size_t) { return true; });
  write(folder() / "deep.h5", deep, [](std::size_t) { return true; });
  DatabaseWriter::create(file, deep, false);
  EXPECT_EQ(DatabaseWriter::take(file, deep, folder() / "shallow.h5", std::vector<char>(18, 1)), 9);
  write(file, deep, [](std::size_t i) { return !fates[i % 6].ends_before; });
  EXPECT_EQ(bytes_of(file), bytes_of(folder() / "deep.h5"));
}

TEST_F(OtherDatabases, are_refused_with_what_differs) {
  const auto refused = [](const DatabaseHeader& before, const DatabaseHeader& now) {
    return refusal([&] { require_same_rays(before, now, "then.h5"); });
  };
  const auto then = study({1, 2, 4}, {1, 2, 3}, 0, 7);
  const auto scene = [&](const std::string& from, const std::string& to) {
    auto now = then;
    now.scene_text.replace(now.scene_text.find(from), from.size(), to);
    now.physics_hash = physics_hash(stored_scene(now));
    return now;
  };
  expect_names(refused(then, scene("100e3", "200e3")), {"does not have all rays", "material.lame_lambda_Pa: 99666"});
  auto deeper = scene("0.02", "0.04");
  deeper.magnitudes_m = {0.01 / 3, 0.02 / 3, 0.021, 0.04};
  expect_names(refused(then, deeper), {"probe.max_displacement_m", "3 to 0.02 m in the file, 4 to 0.04 m now"});
  expect_names(refused(then, scene("\"P1\"", "\"P2\"")), {"solver.element: P1 in the file, P2 now"});
  auto moved = then;
  moved.mesh.nodes(5, 0) += 1e-9;
  expect_names(refused(then, moved), {"another mesh"});
  auto held = then;
  held.sets.fixed = {0, 5};
  expect_names(refused(then, held), {"other fixed nodes"});
  auto stored = then;
  stored.float64 = true;
  stored.tangents = false;
  expect_names(refused(then, stored), {"tangents", "displacement_precision"});
  auto rounded = then;
  rounded.field_bits = 12;
  expect_names(refused(rounded, then), {"field_tolerance", "12 bits in the file, every bit now"});
  expect_names(refused(then, study({1}, {1, 4}, 0, 7)), {"other output nodes: 3 in the file, 2 now"});
}

TEST_F(OtherDatabases, cover_what_a_study_wants) {
  const auto then = study({1, 2}, {1, 2, 3}, 0, 7);
  EXPECT_EQ(coverage(then, then), Coverage::same);
  EXPECT_EQ(coverage(then, study({2}, {1, 2, 3}, 0, 7)), Coverage::other) << "would lose nodes";
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2, 3}, 0, 7)), Coverage::part);
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2}, 0, 7)), Coverage::other) << "would lose displacements";
  EXPECT_EQ(coverage(then, study({1, 2, 3}, {1, 2, 3, 4}, 0, 7)), Coverage::other) << "lacks displacements";
  EXPECT_EQ(coverage(then, study({2, 3}, {1, 2, 3}, 0, 7)), Coverage::other);
  EXPECT_EQ(coverage(then, study({1, 2}, {1, 2, 3}, 0, 6)), Coverage::other) << "would lose directions";
  EXPECT_EQ(coverage(then, study({1, 2}, {1, 2, 3}, 0, 8)), Coverage::part);
  expect_names(refusal([&] {
                 DatabaseWriter::create(whole("then.h5", then), study({2, 3}, {1, 2, 3}, 0, 7), true);
               }),
               {"other active nodes", "would be lost"});
  auto stored = then;
  stored.tangents = false;
  EXPECT_EQ(coverage(then, stored), Coverage::other);
}

}  // namespace
}  // namespace phynness::test
