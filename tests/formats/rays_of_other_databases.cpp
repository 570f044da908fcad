// Claims: a database that takes the rays of another one is, byte for byte, the one of which every ray was written,
// failed ones too. A database seen as that of a part of its nodes has the rays of that part, and seen to a smaller
// depth their first increments, with the ends that they have there. To a larger depth it has the rays that end before.
// Forces, energies and stresses scale with all moduli. Rays of another physics, mesh, step or storage are refused with
// the keys that differ.

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

/// What happens to a ray of three increments, and what is left of it in a study of the first two of them.
struct Fate {
  std::vector<Status> status;
  RayEnd deep, shallow;
};
constexpr double second_m = 0.02 / 3, third_m = 0.02;
const Fate fates[] = {
    {{Status::converged, Status::converged, Status::converged},
     {EndReason::full_depth, third_m},
     {EndReason::full_depth, second_m}},
    {{Status::converged, Status::converged, Status::after_end},
     {EndReason::fold, second_m, second_m + 1e-4, 2e-6},  // found in the increment that the other study does not have
     {EndReason::full_depth, second_m}},
    {{Status::converged, Status::after_end, Status::after_end},
     {EndReason::fold, 0.004, 0.0042, 3e-6},
     {EndReason::fold, 0.004, 0.0042, 3e-6}},
    {{Status::converged, Status::converged, Status::converged},  // goes on beyond its fold
     {EndReason::full_depth, third_m, 0.005, 4e-6},
     {EndReason::full_depth, second_m, 0.005, 4e-6}},
    {{Status::converged, Status::after_end, Status::after_end},
     {EndReason::crushed, 0.0061},
     {EndReason::crushed, 0.0061}},
    {{Status::converged, Status::converged, Status::after_end},  // the limit ends no ray at its last increment
     {EndReason::force_limit, second_m},
     {EndReason::full_depth, second_m}},
    {{Status::converged, Status::diverged, Status::after_failure},
     {EndReason::solver, 0.005},
     {EndReason::solver, 0.005}},
};

class Depths : public OtherDatabases {
 protected:
  static DatabaseHeader shallow(const DatabaseHeader& deep) {
    auto header = deep;
    header.magnitudes_m.pop_back();
    const std::string depth = "max_displacement_m = 0.02", number = "increments = 3";
    header.scene_text.replace(header.scene_text.find(depth), depth.size(), "max_displacement_m = 0.006666666666666667");
    header.scene_text.replace(header.scene_text.find(number), number.size(), "increments = 2");
    header.physics_hash = physics_hash(stored_scene(header));
    return header;
  }
  /// A ray with the fate of its direction, as a study with the first increments, or all, stores it.
  static Ray ray(const DatabaseHeader& header, std::size_t active, std::size_t direction) {
    const auto deep = study({1, 2, 4}, {1, 2, 3}, 0, 7);
    const Fate& fate = fates[direction];
    Ray ray = ray_of(deep, active, direction);
    const std::size_t n = header.magnitudes_m.size();
    ray.status = fate.status;
    ray.end = n < 3 ? fate.shallow : fate.deep;
    for (auto* values : {&ray.force, &ray.energy, &ray.tangent, &ray.min_jacobian, &ray.seconds, &ray.displacement,
                         &ray.fields.front()})
      values->resize(values->size() / 3 * n);
    for (auto* values : {&ray.negative_pivots, &ray.iterations, &ray.cutbacks}) values->resize(n);
    ray.status.resize(n);
    return ray;
  }
  void write(const fs::path& path, const DatabaseHeader& header, const std::vector<char>& without) {
    DatabaseWriter log(path, header, 1);
    for (std::size_t i = 0; i < 21; ++i)
      if (!without[i]) log.append(ray(header, i / 7, i % 7));
    log.close();
    DatabaseWriter::pack(path, header);
  }
  fs::path fresh(const char* name, const DatabaseHeader& header) {
    DatabaseWriter::create(folder() / name, header, false);
    write(folder() / name, header, std::vector<char>(21, 0));
    return folder() / name;
  }
};

TEST_F(Depths, a_smaller_one_has_the_first_increments_of_every_ray) {
  const auto deep = study({1, 2, 4}, {1, 2, 3}, 0, 7), wanted = shallow(deep);
  const auto from = fresh("deep.h5", deep);
  EXPECT_EQ(coverage(deep, wanted), Coverage::whole);
  const auto flags = Database::rays_for(from, wanted);
  EXPECT_EQ(std::count(flags.begin(), flags.end(), char{1}), 21);
  DatabaseWriter::create(file, wanted, false);
  DatabaseWriter::take(file, wanted, from, flags);
  DatabaseWriter::pack(file, wanted);
  EXPECT_EQ(bytes_of(file), bytes_of(fresh("shallow.h5", wanted)));
  const auto seen = Database::open(from, wanted).ends(), alone = Database::open(file).ends();
  for (std::size_t i = 0; i < seen.size(); ++i) expect_same_end(seen[i], alone[i]);
}

TEST_F(Depths, a_larger_one_has_the_rays_that_end_before) {
  const auto deep = study({1, 2, 4}, {1, 2, 3}, 0, 7), then = shallow(deep);
  const auto from = fresh("shallow.h5", then);
  EXPECT_EQ(coverage(then, deep), Coverage::part);
  const auto flags = Database::rays_for(from, deep);
  for (std::size_t i = 0; i < 21; ++i) EXPECT_EQ(flags[i], i % 7 == 2 || i % 7 == 4 || i % 7 == 6) << i;
  DatabaseWriter::create(file, deep, false);
  DatabaseWriter::take(file, deep, from, flags);
  write(file, deep, flags);
  const auto grown = Database::open(file), whole = Database::open(fresh("deep.h5", deep));
  EXPECT_EQ(grown.statuses(), whole.statuses());
  const auto ends = grown.ends(), expected = whole.ends();
  for (std::size_t i = 0; i < 21; ++i) expect_same_end(ends[i], expected[i]);
  // A ray that goes on is there to be compared with.
  const auto begun = Database::open(from, deep).rays(0).front(), solved = ray(deep, 0, 0);
  EXPECT_EQ(begun.status, (std::vector{Status::converged, Status::converged, Status::not_solved}));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(begun.force[i], solved.force[i]);
}

// All numbers are doubled, which has no rounding.
TEST_F(OtherDatabases, scale_with_all_moduli) {
  const auto then = study({1, 2}, {1, 2, 3}, 0, 7);
  const auto changed = [&](const std::vector<std::pair<std::string, std::string>>& changes) {
    auto now = then;
    for (const auto& [from, to] : changes) now.scene_text.replace(now.scene_text.find(from), from.size(), to);
    now.physics_hash = physics_hash(stored_scene(now));
    return now;
  };
  const std::pair<std::string, std::string> c10{"250.0", "500.0"}, bulk{"100e3", "200e3"};
  const auto stiffer = changed({c10, bulk});
  const auto from = whole("then.h5", then);
  const auto flags = Database::rays_for(from, stiffer);
  EXPECT_EQ(std::count(flags.begin(), flags.end(), char{1}), 14);
  EXPECT_EQ(coverage(then, stiffer), Coverage::other) << "other numbers are in the file";
  DatabaseWriter::create(file, stiffer, false);
  DatabaseWriter::take(file, stiffer, from, flags);
  DatabaseWriter::pack(file, stiffer);
  const auto scaled = Database::open(file);
  for (std::size_t active = 0; active < 2; ++active)
    for (std::size_t d = 0; d < 7; ++d) {
      const auto found = scaled.rays(static_cast<std::int32_t>(active))[d];
      auto expected = ray_of(then, active, d);
      for (auto* values : {&expected.force, &expected.energy, &expected.tangent})
        for (double& x : *values) x *= 2;
      EXPECT_EQ(found.force, expected.force);
      EXPECT_EQ(found.energy, expected.energy);
      EXPECT_EQ(found.tangent, expected.tangent);
      EXPECT_EQ(found.status, expected.status);
      EXPECT_EQ(found.min_jacobian, expected.min_jacobian);
      for (std::size_t i = 0; i < found.displacement.size(); ++i)
        EXPECT_EQ(found.displacement[i], static_cast<float>(expected.displacement[i]));
      for (std::size_t i = 0; i < found.fields[0].size(); ++i)
        EXPECT_EQ(found.fields[0][i], 2 * static_cast<float>(expected.fields[0][i]));
      EXPECT_EQ(found.end.depth_m, expected.end.depth_m);
      EXPECT_EQ(found.end.energy_lost_J, 2 * expected.end.energy_lost_J);
    }
  // One modulus alone, and a limit of the force that does not grow with the moduli, give other states.
  expect_contains(refusal([&] { Database::rays_for(from, changed({c10})); }),
                  {"material.shear_modulus_Pa: 500", "1000 now"});
  const std::pair<std::string, std::string> limit{"increments = 3", "increments = 3\nmax_force_N = 3.0"},
      larger{"increments = 3", "increments = 3\nmax_force_N = 6.0"};
  const auto limited = whole("limited.h5", changed({limit}));
  expect_contains(refusal([&] {
                    Database::rays_for(limited, changed({c10, bulk, limit}));
                  }),
                  {"max_force_N: 3 in the file, 3 now", "larger by the factor of the moduli, 2"});
  expect_contains(refusal([&] { Database::rays_for(limited, then); }), {"max_force_N: 3 in the file, 0 now"});
  EXPECT_EQ(Database::rays_for(limited, changed({c10, bulk, larger})).front(), 1);
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
  deeper.magnitudes_m = {0.01 / 3, 0.02 / 3, 0.021, 0.04};
  expect_contains(refused(then, deeper), {"probe.max_displacement_m", "3 to 0.02 m in the file, 4 to 0.04 m now"});
  auto searched = then;
  searched.fold_halvings = 5;
  expect_contains(refused(searched, then), {"another search for folds", "2^5 in the file", "2^4 now"});
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
  auto rounded = then;
  rounded.field_bits = 12;
  expect_contains(refused(rounded, then), {"field_tolerance", "12 bits in the file, every bit now"});
  EXPECT_EQ(coverage(then, rounded), Coverage::whole) << "finer than asked for";
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
