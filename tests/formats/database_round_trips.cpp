// Claims: the values that are read are those that were appended, bit for bit (float32 displacements: rounded once, to
// nearest). The distribution of rays over logs has no influence. The summary counts the contents. A log has the bytes
// that formats/database.md describes.
#include <algorithm>

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

class RoundTrip : public DatabaseTest {};

void expect_same(const Ray& found, const Ray& expected, bool float64) {
  EXPECT_EQ(found.active, expected.active);
  EXPECT_EQ(found.direction, expected.direction);
  EXPECT_EQ(found.status, expected.status);
  EXPECT_EQ(found.force, expected.force);
  EXPECT_EQ(found.energy, expected.energy);
  EXPECT_EQ(found.tangent, expected.tangent);
  EXPECT_EQ(found.negative_pivots, expected.negative_pivots);
  EXPECT_EQ(found.iterations, expected.iterations);
  EXPECT_EQ(found.cutbacks, expected.cutbacks);
  EXPECT_EQ(found.min_jacobian, expected.min_jacobian);
  EXPECT_EQ(found.seconds, expected.seconds);
  expect_same_end(found.end, expected.end);
  ASSERT_EQ(found.displacement.size(), expected.displacement.size());
  for (std::size_t i = 0; i < expected.displacement.size(); ++i) {
    const double u = expected.displacement[i];
    EXPECT_EQ(found.displacement[i], float64 ? u : static_cast<double>(static_cast<float>(u)));
  }
}

void expect_round_trip(const fs::path& file, const DatabaseHeader& header) {
  const Database database = Database::open(file);
  const auto rays = all_rays(header);
  std::size_t next = 0;
  for (std::int32_t active = 0; active < 3; ++active)
    for (const Ray& ray : database.rays(active)) expect_same(ray, rays[next++], header.float64);
  EXPECT_EQ(next, rays.size());
}

TEST_F(RoundTrip, is_exact_with_float64) {
  const auto header = small_header(true);
  write_database(header);
  expect_round_trip(file, header);
  EXPECT_EQ(read_database_header(file).mesh.regions, header.mesh.regions);
  EXPECT_FALSE(fs::exists(log));
  EXPECT_FALSE(fs::exists(file.string() + ".packing"));
  EXPECT_FALSE(fs::exists(file.string() + ".tmp"));
}

TEST_F(RoundTrip, rounds_displacements_once_with_float32) {
  const auto header = small_header(false);
  write_database(header);
  expect_round_trip(file, header);
}

TEST_F(RoundTrip, rounds_displacements_within_the_tolerance_of_the_scene) {
  for (const double tolerance : {0.1, 0.03, 1e-3, 1.0 / 4096}) {
    const auto scene =
        parse_scene(database_scene + "[database]\nfield_tolerance = " + std::to_string(tolerance) + "\n", "", ".");
    auto header = small_header(true);
    header.field_bits = database_header(scene, header.mesh, header.sets).field_bits;
    write_database(header);
    EXPECT_EQ(read_database_header(file).field_bits, header.field_bits);
    const Database database = Database::open(file);
    double largest = 0;  // share of the tolerance
    for (const Ray& expected : all_rays(header)) {
      const Ray found = database.rays(expected.active)[static_cast<std::size_t>(expected.direction)];
      EXPECT_EQ(found.force, expected.force);
      const std::size_t n = expected.displacement.size() / header.magnitudes_m.size();
      for (std::size_t i = 0; i < expected.displacement.size(); ++i)
        largest = std::max(largest, std::abs(found.displacement[i] - expected.displacement[i]) /
                                        (tolerance * header.magnitudes_m[i / n]));
    }
    // The step is a power of two, so that a quarter of the tolerance may be left unused.
    EXPECT_LE(largest, 1) << tolerance;
    EXPECT_GT(largest, 0.24) << tolerance;
    fs::remove(file);
  }
}

TEST_F(RoundTrip, keeps_responses_at_rest) {
  auto header = small_header(true);
  header.sets.linear = {3, 5};
  header.sets.linear_tools = {{{1, 3}, {0.25, 0.75}, true}, {{5}, {1}, true}};
  write_logs(header);
  const auto response = [&](std::int32_t point) {
    AtRest one{{3, 1, 0, 1, 4, 0, 0, 0, 5 + 1.0 / 3 * point}, {}};
    for (std::size_t i = 0; i < 9 * header.sets.output.size(); ++i)
      one.displacement.push_back(std::sin(static_cast<double>(i) + 100 * point));
    return one;
  };
  EXPECT_EQ(read_database_header(file).sets.linear, header.sets.linear);
  DatabaseWriter::pack(file, header, {}, response);
  expect_round_trip(file, header);
  const auto database = Database::open(file);
  EXPECT_EQ(database.header().sets.linear, header.sets.linear);
  EXPECT_EQ(database.header().sets.linear_tools, header.sets.linear_tools);
  for (const std::int32_t point : {1, 0}) {
    EXPECT_EQ(database.at_rest(point).stiffness_N_per_m, response(point).stiffness_N_per_m);
    EXPECT_EQ(database.at_rest(point).displacement, response(point).displacement);
  }
  EXPECT_THROW(database.at_rest(2), Error);
  EXPECT_THROW(database.at_rest(-1), Error);
}

TEST_F(RoundTrip, works_without_tangents) {
  auto header = small_header(true);
  header.tangents = false;
  write_database(header);
  expect_round_trip(file, header);
}

TEST_F(RoundTrip, keeps_the_header) {
  const auto header = small_header(true);
  write_logs(header);
  EXPECT_FALSE(Database::is_complete(file));
  const auto unfinished = read_database_header(file);
  DatabaseWriter::pack(file, header);
  EXPECT_TRUE(Database::is_complete(file));
  const Database database = Database::open(file);
  for (const DatabaseHeader* h : {&unfinished, &database.header()}) {
    EXPECT_EQ(h->mesh.nodes, header.mesh.nodes);
    EXPECT_EQ(h->mesh.cells, header.mesh.cells);
    EXPECT_EQ(h->mesh.surface, header.mesh.surface);
    EXPECT_EQ(h->mesh.groups, header.mesh.groups);
    EXPECT_EQ(h->sets.fixed, header.sets.fixed);
    EXPECT_EQ(h->sets.active, header.sets.active);
    EXPECT_EQ(h->sets.output, header.sets.output);
    EXPECT_EQ(h->directions, header.directions);
    EXPECT_EQ(h->magnitudes_m, header.magnitudes_m);
    EXPECT_EQ(h->tangents, header.tangents);
    EXPECT_EQ(h->float64, header.float64);
    EXPECT_EQ(h->scene_text, header.scene_text);
    EXPECT_EQ(h->scene_name, header.scene_name);
    EXPECT_EQ(h->scene_folder, header.scene_folder);
    EXPECT_EQ(h->software_version, header.software_version);
    EXPECT_EQ(h->mesh_hash, mesh_hash(header.mesh));
    EXPECT_EQ(h->physics_hash, physics_hash(parse_scene(header.scene_text, "", ".")));
  }
}

TEST_F(RoundTrip, holds_scenes_beyond_the_64_kB_of_an_attribute) {
  const auto header = small_header(true, database_scene + "# " + std::string(200'000, 'x') + "\n");
  write_logs(header);
  EXPECT_EQ(read_database_header(file).scene_text, header.scene_text);
}

TEST_F(RoundTrip, does_not_depend_on_the_number_of_logs) {
  const auto header = small_header(true);
  std::vector<std::vector<char>> files;
  for (int n_logs : {1, 2, 4}) {
    write_database(header, n_logs);
    expect_round_trip(file, header);
    files.push_back(bytes_of(file));
    fs::remove(file);
  }
  ASSERT_FALSE(files[0].empty());
  // No time stamps are stored, so even the files agree.
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST_F(RoundTrip, logs_hold_the_columns_in_the_order_of_the_page) {
  auto header = small_header(false);
  header.fields = {Field::energy_density};
  DatabaseWriter::create(file, header, false);
  const Ray ray = random_ray(header, 1, 2);
  DatabaseWriter writer(file, header, 0);
  writer.append(ray);
  writer.close();

  std::vector<char> payload;
  const auto put = [&](const auto& value) {
    const auto* bytes = reinterpret_cast<const char*>(&value);
    payload.insert(payload.end(), bytes, bytes + sizeof value);
  };
  const auto put_all = [&](const auto& values) { std::for_each(values.begin(), values.end(), put); };
  for (const std::int32_t index : {ray.active, ray.direction}) put(index);
  put(ray.end.reason);
  for (const double value : {ray.end.depth_m, ray.end.fold_depth_m, ray.end.energy_lost_J}) put(value);
  put_all(ray.status);
  for (const auto* values : {&ray.force, &ray.energy, &ray.tangent}) put_all(*values);
  for (const auto* values : {&ray.negative_pivots, &ray.iterations, &ray.cutbacks}) put_all(*values);
  for (const auto* values : {&ray.min_jacobian, &ray.seconds}) put_all(*values);
  for (const auto* values : {&ray.displacement, &ray.fields[0]})
    put_all(std::vector<float>(values->begin(), values->end()));

  const auto found = bytes_of(log / "rank-0000");
  constexpr std::size_t opening = 72, prefix = 8, checksum = 8;
  ASSERT_EQ(found.size(), opening + prefix + payload.size() + checksum);
  EXPECT_EQ(std::string(found.data(), 8), "PHYNLOG5");
  EXPECT_TRUE(std::equal(payload.begin(), payload.end(), found.begin() + opening + prefix));
}

TEST_F(RoundTrip, spans_many_chunks) {
  auto header = small_header(false);
  // 150 directions x 40 increments x 3 components of force exceed a chunk, so each active node has its own.
  header.directions.assign(150, Vec3{1, 0, 0});
  header.magnitudes_m.clear();
  for (int i = 1; i <= 40; ++i) header.magnitudes_m.push_back(0.001 * i);
  write_database(header, 2);
  expect_round_trip(file, header);
}

TEST_F(RoundTrip, statuses_and_summary_count_what_is_there) {
  const auto header = small_header(true);
  write_database(header);
  const Database database = Database::open(file);
  const auto statuses = database.statuses();
  DatabaseSummary expected;
  expected.min_jacobian = 1e300;
  std::size_t at = 0;
  for (const Ray& ray : all_rays(header)) {
    ++expected.rays;
    expected.failed_rays += ray.status.back() != Status::converged;
    for (std::size_t i = 0; i < ray.status.size(); ++i) {
      EXPECT_EQ(statuses.at(at++), ray.status[i]);
      ++expected.states[ray.status[i]];
      expected.newton_iterations += ray.iterations[i];
      expected.seconds += ray.seconds[i];
      if (ray.status[i] != Status::converged) continue;
      expected.unstable_states += ray.negative_pivots[i] > 0;
      expected.min_jacobian = std::min(expected.min_jacobian, ray.min_jacobian[i]);
    }
  }
  const auto summary = summarize(database);
  EXPECT_EQ(summary.states, expected.states);
  EXPECT_EQ(summary.rays, expected.rays);
  EXPECT_EQ(summary.failed_rays, expected.failed_rays);
  EXPECT_EQ(summary.newton_iterations, expected.newton_iterations);
  EXPECT_EQ(summary.unstable_states, expected.unstable_states);
  EXPECT_DOUBLE_EQ(summary.seconds, expected.seconds);
  EXPECT_EQ(summary.min_jacobian, expected.min_jacobian);
}

TEST_F(RoundTrip, ends_of_rays_are_summed_up_by_reason_and_node) {
  const auto header = small_header(true);
  write_database(header);
  const Database database = Database::open(file);
  const auto rays = all_rays(header);
  const auto ends = database.ends();
  ASSERT_EQ(ends.size(), rays.size());
  EndSummary expected;
  double beyond = 0;
  std::vector<double> reached(3, 0.0);
  std::vector<std::int32_t> requested(3, 0), early(3, 0);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayEnd& end = rays[i].end;
    expect_same_end(ends[i], end);
    if (end.reason == EndReason::not_requested) continue;
    const std::size_t node = i / header.directions.size();
    double trained_m = 0;  // the last increment before the end
    for (const double m : header.magnitudes_m)
      if (m <= end.depth_m) trained_m = m;
    const double share = end.is_early() ? std::pow(trained_m / 0.02, 3) : 1;
    ++expected.rays;
    ++expected.reasons[end.reason];
    ++requested[node];
    early[node] += end.is_early();
    reached[node] += share;
    beyond += 1 - share;
    expected.folds += end.fold_depth_m > 0;
  }
  const auto summary = summarize_ends(database);
  EXPECT_EQ(summary.rays, expected.rays);
  EXPECT_EQ(summary.reasons, expected.reasons);
  EXPECT_EQ(summary.folds, expected.folds);
  EXPECT_EQ(summary.early, early);
  // Sums in another order: some roundings of numbers of about 1.
  EXPECT_NEAR(summary.share_of_volume(), beyond / static_cast<double>(expected.rays), 1e-14);
  for (std::size_t node = 0; node < 3; ++node)
    EXPECT_NEAR(summary.reached[node], reached[node] / requested[node], 1e-14);
}

TEST_F(RoundTrip, knows_every_stored_code_by_name) {
  for (int code = -6; code <= 3; ++code) EXPECT_STRNE(name(static_cast<Status>(code)), "unknown") << code;
  for (int code = -1; code <= 4; ++code) EXPECT_STRNE(meaning(static_cast<EndReason>(code)), "unknown") << code;
  EXPECT_STREQ(name(static_cast<Status>(77)), "unknown");
}

TEST_F(RoundTrip, refuses_an_active_node_it_does_not_have) {
  const auto header = small_header(true);
  write_database(header);
  const Database database = Database::open(file);
  expect_names(refusal([&] { database.rays(3); }), {"3", "0 to 2"});
  expect_names(refusal([&] { database.rays(-1); }), {"-1"});
}

}  // namespace
}  // namespace phynness::test
