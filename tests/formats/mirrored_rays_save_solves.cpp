// Claims: every ray of a symmetric database is solved or is the image of a solved one. The counts are those of the
// group. Images of known responses agree with the reflection. Logs need the solved rays only, also after an
// interruption. A database without a plane of symmetry is not affected.
#include <phynness/formats/database_merge.hpp>
#include <phynness/formats/mirrored_rays.hpp>

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

/// Nodes 1 and 2 are one another's image in x = 0, nodes 3 to 6 lie on the plane.
DatabaseHeader symmetric_header() {
  auto h = small_header(true);
  h.mesh.nodes.resize(7, 3);
  h.mesh.nodes << 0, -1, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 2, 0;
  h.sets.fixed = {0};
  h.sets.active = {1, 2, 3};
  h.sets.output = {1, 2, 4};
  h.directions = exploratory_directions(Directions::twenty_six);
  MirrorSymmetry mirror;
  mirror.normal = {1, 0, 0};
  mirror.image = {0, 2, 1, 3, 4, 5, 6};
  h.sets.mirror = mirror;
  return h;
}

TEST(MirroredRays, SolveOneOfEachPairAndHalfTheDirectionsOnThePlane) {
  auto h = symmetric_header();
  const MirroredRays rays(h);
  // Node 1 is on the side the normal points to: all of its 26. Node 3 is on the plane: of 26 directions 8 lie
  // in it and 18 are 9 pairs.
  EXPECT_EQ(rays.n_solved(), 26 + 0 + 17);
  for (std::int32_t a = 0; a < 3; ++a)
    for (std::int32_t d = 0; d < 26; ++d) {
      const auto& source = rays.source(a, d);
      EXPECT_TRUE(rays.is_solved(source.active, source.direction));
      const auto& e = h.directions[static_cast<std::size_t>(d)];
      const auto& from = h.directions[static_cast<std::size_t>(source.direction)];
      EXPECT_EQ(from[0], source.mirrored ? -e[0] : e[0]);
      EXPECT_EQ(from[1], e[1]);
      EXPECT_FALSE(source.opposite);
    }
  // A linear body: the opposite is known too, which leaves 13 of 26. On the plane d, H d and their opposites
  // are one: of the normal's 2 directions 1 is left, of the plane's 8 directions 4, of the other 16 again 4.
  h.sets.mirror->odd = true;
  EXPECT_EQ(MirroredRays(h).n_solved(), 13 + 9);
  h.directions = exploratory_directions(Directions::three);
  EXPECT_EQ(MirroredRays(h).n_solved(), 3 + 3);
  // Not linear: -x is none of the three, so that probe of node 2 is solved.
  h.sets.mirror->odd = false;
  EXPECT_EQ(MirroredRays(h).n_solved(), 3 + 1 + 3);
  // A plane that maps no direction to another saves nothing and spoils nothing.
  h.sets.mirror->normal = {0.6, 0.8, 0};
  h.directions = {{1, 0, 0}};
  EXPECT_EQ(MirroredRays(h).n_solved(), 3);
}

TEST(MirroredRays, AreReflectedExactly) {
  const auto h = symmetric_header();
  const MirroredRays rays(h);
  const std::int32_t along_minus_x = 0, along_plus_x = 5;
  const Ray solved = random_ray(h, 0, along_plus_x);
  const Ray image = rays.image(solved, 1, along_minus_x);
  EXPECT_EQ(image.active, 1);
  EXPECT_EQ(image.direction, along_minus_x);
  EXPECT_EQ(image.status, solved.status);
  EXPECT_EQ(image.energy, solved.energy);
  EXPECT_EQ(image.min_jacobian, solved.min_jacobian);
  expect_same_end(image.end, solved.end);
  EXPECT_EQ(image.negative_pivots, solved.negative_pivots);
  EXPECT_EQ(image.iterations, std::vector<std::int32_t>(3, 0));
  EXPECT_EQ(image.seconds, std::vector<double>(3, 0.0));
  const std::size_t other[3] = {1, 0, 2};  // outputs 1 and 2 change places, 4 is on the plane
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double sign = k == 0 ? -1 : 1;
      EXPECT_EQ(image.force[3 * i + k], sign * solved.force[3 * i + k]);
      for (std::size_t o = 0; o < 3; ++o)
        EXPECT_EQ(image.displacement[3 * (3 * i + o) + k], sign * solved.displacement[3 * (3 * i + other[o]) + k]);
      for (std::size_t l = 0; l < 3; ++l)
        EXPECT_EQ(image.tangent[9 * i + 3 * k + l],
                  ((k == 0) != (l == 0) ? -1 : 1) * solved.tangent[9 * i + 3 * k + l]);
    }
}

class MirroredDatabase : public DatabaseTest {
 protected:
  /// Appends the solved rays with index in [from, to).
  void append(const DatabaseHeader& h, std::int64_t from, std::int64_t to, int rank) {
    const MirroredRays rays(h);
    DatabaseWriter writer(file, h, rank);
    std::int64_t at = 0;
    for (const Ray& ray : all_rays(h))
      if (rays.is_solved(ray.active, ray.direction) && at++ >= from && at <= to) writer.append(ray);
    writer.close();
  }
};

TEST_F(MirroredDatabase, NeedsTheSolvedRaysOnlyAndHoldsAll) {
  const auto h = symmetric_header();
  DatabaseWriter::create(file, h, false);
  append(h, 0, 20, 0);
  auto progress = database_progress(file);
  EXPECT_EQ(progress.rays_logged, 20);
  EXPECT_EQ(progress.rays_total, 43);
  const auto flags = DatabaseWriter::logged(file, h);
  EXPECT_EQ(std::count(flags.begin(), flags.end(), 1), 40);  // each has an image at node 2
  EXPECT_NE(refusal([&] { DatabaseWriter::pack(file, h); }, Error::Kind::failure).find("23 of 43"), std::string::npos);

  DatabaseWriter::create(file, h, true);  // --resume
  append(h, 20, 43, 1);
  DatabaseWriter::pack(file, h);
  const auto database = Database::open(file);
  ASSERT_TRUE(database.header().sets.mirror);
  EXPECT_EQ(*database.header().sets.mirror, *h.sets.mirror);
  const MirroredRays rays(h);
  for (std::int32_t a = 0; a < 3; ++a)
    for (const Ray& ray : database.rays(a)) {
      const auto& source = rays.source(a, ray.direction);
      const Ray solved = random_ray(h, source.active, source.direction);
      const Ray expected = source.is_itself() ? solved : rays.image(solved, a, ray.direction);
      EXPECT_EQ(ray.force, expected.force);
      EXPECT_EQ(ray.displacement, expected.displacement);
      EXPECT_EQ(ray.iterations, expected.iterations);
    }
}

TEST_F(MirroredDatabase, IsNotResumedWithoutItsPlane) {
  auto h = symmetric_header();
  h.physics_hash = "0123456789abcdef";
  DatabaseWriter::create(file, h, false);
  h.sets.mirror.reset();
  expect_contains(refusal([&] { DatabaseWriter::create(file, h, true); }),
                  {"another mirror plane", "normal 1 0 0, mirrored pairs of nodes: 1 in the file, none now"});
  h.sets.mirror = symmetric_header().sets.mirror;
  h.sets.mirror->image = {0, 2, 1, 4, 3, 5, 6};
  expect_contains(refusal([&] { DatabaseWriter::create(file, h, true); }),
                  {"pairs of nodes: 1 in the file", "pairs of nodes: 2 now"});
  h.sets.mirror->image = {0, 1, 2, 4, 3, 5, 6};
  expect_contains(refusal([&] { DatabaseWriter::create(file, h, true); }), {"but other pairs"});
}

// An image is a solve up to rounding only.
TEST_F(MirroredDatabase, GivesOnlyItsSolvedRaysToOtherDatabases) {
  auto h = symmetric_header();
  h.physics_hash = physics_hash(stored_scene(h));
  h.mesh_hash = mesh_hash(h.mesh);
  DatabaseWriter::create(file, h, false);
  append(h, 0, 43, 0);
  DatabaseWriter::pack(file, h);
  auto solved = MirroredRays(h).solved();
  auto alone = h;
  alone.sets.mirror.reset();
  EXPECT_EQ(Database::rays_for(file, alone), solved);
  EXPECT_EQ(coverage(h, alone), Coverage::other);
  alone.sets.active = {2, 3};  // node 2 is the image of node 1
  solved.erase(solved.begin(), solved.begin() + 26);
  EXPECT_EQ(Database::rays_for(file, alone), solved);
}

TEST_F(MirroredDatabase, IsMergedFromShardsOfTheSolvedRays) {
  auto h = symmetric_header();
  DatabaseWriter::create(file, h, false);
  append(h, 0, 43, 0);
  DatabaseWriter::pack(file, h);
  const auto one_run = bytes_of(file);
  constexpr int count = 3;
  const MirroredRays mirrored(h);
  const auto owners = shards_of_rays(mirrored.solved(), h.directions.size(), count);
  const auto rays = all_rays(h);
  const std::size_t lost = 26 + 26 + 3;  // a solved ray of the node on the plane
  ASSERT_TRUE(mirrored.is_solved(2, 3));
  std::vector<fs::path> shards;
  for (int index = 0; index < count; ++index) {
    h.shard = Shard{index, count};
    shards.push_back(shard_file(file, *h.shard));
    DatabaseWriter::create(shards.back(), h, false);
    DatabaseWriter writer(shards.back(), h, 0);
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (owners[i] == index && i != lost) writer.append(rays[i]);
    writer.close();
    const auto progress = database_progress(shards.back());
    EXPECT_EQ(progress.rays_total, std::count(owners.begin(), owners.end(), index));
    EXPECT_EQ(progress.rays_logged, progress.rays_total - (owners[lost] == index));
  }
  const auto merged = folder() / "merged.h5";
  const auto early = merge_shards(shards, merged);
  EXPECT_EQ(early.rays_total, 43);
  ASSERT_EQ(early.missing.size(), 1u);  // its mirror image is not asked for
  EXPECT_EQ(early.missing[0].node, 3);
  EXPECT_EQ(early.missing[0].direction, 3);
  EXPECT_EQ(early.missing[0].owner, (Shard{owners[lost], count}));
  h.shard = early.missing[0].owner;
  {
    DatabaseWriter writer(shards[static_cast<std::size_t>(owners[lost])], h, 1);
    writer.append(rays[lost]);
    writer.close();
  }
  EXPECT_TRUE(merge_shards(shards, merged).missing.empty());
  EXPECT_EQ(bytes_of(merged), one_run);
}

TEST_F(MirroredDatabase, WithAWrongPairingIsRefused) {
  auto h = symmetric_header();
  h.sets.mirror->image = {0, 2, 0, 3, 4, 5, 6};
  expect_contains(refusal([&] { DatabaseWriter::create(file, h, false); }), {"pair the nodes"});
  h.sets.mirror->image = {0, 2, 1, 3, 4, 5};
  expect_contains(refusal([&] { DatabaseWriter::create(file, h, false); }), {"6 images of 7 nodes"});
}

}  // namespace
}  // namespace phynness::test
