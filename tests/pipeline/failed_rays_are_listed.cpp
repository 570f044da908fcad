// Claim: phynness info tells of every ray that stopped short its node, direction, last good depth, failed depth and
// reason, as they are in the database, and explains the reasons.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class FailedRays : public CommandLine {};

TEST_F(FailedRays, AreListedWithDepthAndReason) {
  // St. Venant-Kirchhoff bodies fold under compression; 30 mm is more than half of this one.
  const auto scene = changed(small_scene("P1", 4), "neo-hookean", "st-venant-kirchhoff");
  // Without these limits the solver fails, which is listed; with them the rays end before.
  write_file(folder / "scene.toml", changed(scene, "0.008", "0.030\nmin_jacobian = 0\nstop_at_fold = false"));
  succeed("precompute scene.toml -o d.h5");
  const auto listed = succeed("info d.h5 --failed --json info.json");
  const auto failed = json("info.json").at("failed_rays");

  const auto database = Database::open(folder / "d.h5");
  const auto& header = database.header();
  std::size_t expected = 0;
  for (std::size_t active = 0; active < header.sets.active.size(); ++active)
    for (const auto& ray : database.rays(static_cast<std::int32_t>(active)))
      for (std::size_t i = 0; i < ray.status.size(); ++i) {
        if (static_cast<int>(ray.status[i]) >= 0) continue;
        ASSERT_LT(expected, failed.size());
        const auto& told = failed.at(expected++);
        EXPECT_EQ(told.at("node"), header.sets.active[active]);
        EXPECT_EQ(told.at("direction"), ray.direction);
        EXPECT_EQ(told.at("reached_m").get<double>(), i > 0 ? header.magnitudes_m[i - 1] : 0.0);
        EXPECT_EQ(told.at("failed_at_m").get<double>(), header.magnitudes_m[i]);
        EXPECT_EQ(told.at("reason"), name(ray.status[i]));
        expect_names(listed.out, {name(ray.status[i]), meaning(ray.status[i])});
        break;
      }
  EXPECT_EQ(expected, failed.size());
  EXPECT_GT(expected, 0U);

  be_refused("info scene.toml --failed");
  const auto counted = phynness("info d.h5");
  expect_names(counted.out, {"--failed"});

  // With a limit of J all of these are crushed instead.
  write_file(folder / "scene.toml", changed(scene, "0.008", "0.030\nmin_jacobian = 0.2\nstop_at_fold = false"));
  std::filesystem::remove(folder / "d.h5");
  succeed("precompute scene.toml -o d.h5");
  succeed("info d.h5 --json info.json");
  EXPECT_TRUE(json("info.json").at("failed_rays").empty());
  EXPECT_GT(json("info.json").at("ends").at("reasons").at("crushed").at("rays"), 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "d.h5.solver.log"));  // it has messages of libraries only
}

}  // namespace
}  // namespace phynness::test
