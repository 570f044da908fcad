// Claim: phynness info tells of every ray that stopped short its node, direction, last good depth, failed depth and
// reason, as they are in the database, explains the reasons, and names the cell that the solver's log names.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class FailedRays : public CommandLine {};

TEST_F(FailedRays, AreListedWithDepthAndReason) {
  // St. Venant-Kirchhoff bodies fold under compression; 30 mm is more than half of this one.
  auto scene = small_scene("P1", 4);
  scene.replace(scene.find("neo-hookean"), 11, "st-venant-kirchhoff");
  // Without these limits the solver fails, which is listed; with them the rays end before.
  scene.replace(scene.find("0.008"), 5, "0.030\nmin_jacobian = 0\nstop_at_fold = false");
  write_file(folder / "scene.toml", scene);
  succeed("precompute scene.toml -o d.h5");
  const auto listed = succeed("info d.h5 --failed --json info.json");
  const auto failed = json("info.json").at("failed_rays");

  const auto database = Database::open(folder / "d.h5");
  const auto& header = database.header();
  const auto log = read_file(folder / "d.h5.solver.log");
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
        const std::string cell = told.at("cell");
        EXPECT_EQ(cell.rfind("J = ", 0), 0U) << cell;
        expect_names(cell, {" mm in cell ", ": quality "});
        expect_names(log, {"node " + std::to_string(header.sets.active[active]) + ", direction " +
                           std::to_string(ray.direction) + ": " + name(ray.status[i]) + ": " + cell});
        expect_names(listed.out, {name(ray.status[i]), meaning(ray.status[i])});
        break;
      }
  EXPECT_EQ(expected, failed.size());
  EXPECT_GT(expected, 0U);

  be_refused("info scene.toml --failed");
  const auto counted = phynness("info d.h5");
  expect_names(counted.out, {"--failed"});

  // With a limit of J all of these are crushed instead. The log is that of the new database alone.
  const auto no_limit = scene.find("min_jacobian = 0\n");
  write_file(folder / "scene.toml", scene.replace(no_limit, 16, "min_jacobian = 0.2"));
  std::filesystem::remove(folder / "d.h5");
  succeed("precompute scene.toml -o d.h5");
  const auto list = unbroken(succeed("info d.h5 --failed --json info.json").out);
  const auto crushed = json("info.json").at("crushed_rays");
  EXPECT_GT(crushed.size(), 0U);
  EXPECT_EQ(crushed.size(), json("info.json").at("ends").at("reasons").at("crushed").at("rays"));
  for (const auto& ray : crushed) {
    const std::string cell = ray.at("cell");
    EXPECT_LT(std::stod(cell.substr(4)), 0.2) << cell;
    expect_names(list, {"crushed: " + cell});
  }
  EXPECT_EQ(read_file(folder / "d.h5.solver.log").find(": inverted: "), std::string::npos) << "of the first database";
  // Whatever is in the place of the log, the list is printed.
  const auto log_file = folder / "d.h5.solver.log";
  const auto node = crushed.at(0).at("node").get<int>(), direction = crushed.at(0).at("direction").get<int>();
  write_file(log_file, "node: J = \nnode " + std::to_string(node) + ", direction " + std::to_string(direction) +
                           ": J = \xff\x1b");
  succeed("info d.h5 --failed --json info.json");
  EXPECT_EQ(json("info.json").at("crushed_rays").at(0).at("cell"), "J = \\xff\\x1b");
  std::filesystem::remove(log_file);
  shell("mkfifo d.h5.solver.log");
  succeed("info d.h5 --failed --json info.json");
  EXPECT_EQ(json("info.json").at("crushed_rays").at(0).at("cell"), "");
  std::filesystem::remove(log_file);
  // A database without such rays has no log, and its list no cells.
  write_file(folder / "scene.toml", scene.replace(scene.find("0.030"), 5, "0.002"));
  std::filesystem::remove(folder / "d.h5");
  succeed("precompute scene.toml -o d.h5");
  EXPECT_FALSE(std::filesystem::exists(folder / "d.h5.solver.log"));
}

}  // namespace
}  // namespace phynness::test
