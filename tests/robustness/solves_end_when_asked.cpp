// Claims: a solve checks between its iterations whether it is to be interrupted, and then ends within seconds,
// independent of its length. Its ray is not recorded, and a resumed run is identical to one without interruption. A ray
// whose displacements are too small to be halved ends. Responses at rest are those of touched tools, by one
// factorization; where they are interrupted, rays are kept.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <thread>

#include "petsc_faults.hpp"
#include "probe_block.hpp"
#include "solver_test_session.hpp"

namespace phynness::test {
namespace {

using Clock = std::chrono::steady_clock;

/// Every substitution takes half a second, for the life of this object.
class SlowSolves {
 public:
  SlowSolves() {
    fault_hook = [](FaultSite site) {
      if (site == FaultSite::substitution) std::this_thread::sleep_for(std::chrono::milliseconds(500));
      return Fault::none;
    };
  }
  ~SlowSolves() { fault_hook = {}; }
  SlowSolves(const SlowSolves&) = delete;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

class Asked : public ::testing::TestWithParam<Element> {
 protected:
  ProbeBlock _block = probe_block({law_named("neo-hookean"), GetParam()}, 10, {2, 2, 2});
};

TEST_P(Asked, ASolveEndsWithinSecondsAndTheNextOneIsAsGoodAsEver) {
  auto solver = _block.touched();
  const auto before = solver.solve({{0, 0, -0.01}}, 50);
  {
    const SlowSolves slow;
    const auto start = Clock::now();
    solver.set_stop([] { return true; });
    EXPECT_THROW(solver.solve({{0, 0, -0.01}}, 50), Interrupted);
    EXPECT_GT(seconds_since(start), 1.5) << "a ray that is nearly finished is to be finished";
    EXPECT_LT(seconds_since(start), 20);
  }
  solver.set_stop({});
  const auto after = solver.solve({{0, 0, -0.01}}, 50);
  EXPECT_EQ(before.force_N, after.force_N);
}

TEST_P(Asked, ARunKeepsItsFinishedRaysAndGoesOnLater) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / ("asked-" + std::to_string(::getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  auto& scene = _block.scene;
  scene.probe.directions = Directions::three;
  scene.probe.increments = 50;
  scene.probe.max_displacement_m = 0.01;
  _block.sets.output = _block.sets.active;
  std::int64_t finished = 0;
  const auto run = [&](const char* name, bool resume, const std::function<bool()>& stop) {
    return precompute(
        solver_session(), scene, _block.mesh, _block.sets, {folder / name, resume, {}, {}},
        [&](std::int64_t done, std::int64_t) { finished = done; }, stop);
  };
  run("whole.h5", false, {});
  finished = 0;
  PrecomputeReport report;
  {
    // Not slow until the first ray is finished.
    std::optional<SlowSolves> slow;
    int asked = 0;
    report = run("part.h5", false, [&] {
      if (finished == 0) return false;
      if (!slow) slow.emplace();
      return ++asked > 1;  // not where the first ray has ended, but within the second
    });
  }
  EXPECT_TRUE(report.interrupted);
  EXPECT_EQ(report.rays, 1);
  EXPECT_EQ(database_progress(folder / "part.h5").rays_logged, 1);
  EXPECT_FALSE(run("part.h5", true, {}).interrupted);
  const auto whole = Database::open(folder / "whole.h5").rays(0), part = Database::open(folder / "part.h5").rays(0);
  for (std::size_t d = 0; d < whole.size(); ++d) EXPECT_EQ(whole[d].force, part[d].force) << d;
  std::filesystem::remove_all(folder);
}

TEST_P(Asked, ResponsesAtRestAreThoseOfATouchedToolAndEndToo) {
  auto& [scene, mesh, sets, top] = _block;
  scene.probe.kind = ProbeKind::patch;
  scene.probe.tool_radius_m = 0.03;
  scene.probe.directions = Directions::three;
  scene.probe.increments = 1;
  scene.probe.max_displacement_m = 0.001;
  for (const auto node : surface_nodes(mesh.surface))
    if (node != top && !std::ranges::binary_search(sets.fixed, node)) sets.linear.push_back(node);
  const auto n = std::ssize(sets.linear);
  sets.output = sets.active;
  sets.tools = sets.linear_tools = {};
  for (const auto node : sets.linear) sets.linear_tools.push_back({{node}, {1}, true});
  sets.tools = {sets.linear_tools.front()};
  auto solver = _block.solver();
  for (std::int32_t i = 0; i < n; i += 7) {
    const auto node = sets.linear[static_cast<std::size_t>(i)];
    solver.touch({node});
    const auto touched = solver.rest();
    const auto before = solver.counts().factorizations;
    solver.single_tool_at_rest(sets.linear.front());
    const auto alone = solver.single_tool_at_rest(node);
    EXPECT_EQ(solver.counts().factorizations, before + 1);
    // Rounding of the factors, whose condition number is about 1e4 times K/mu here.
    EXPECT_LT((alone.stiffness_N_per_m - touched.stiffness_N_per_m).norm(), 1e-9 * touched.stiffness_N_per_m.norm());
    EXPECT_LT((alone.sensitivity - touched.sensitivity).norm(), 1e-9 * touched.sensitivity.norm());
  }
  const auto file = std::filesystem::path(::testing::TempDir()) / ("at-rest-" + std::to_string(::getpid()) + ".h5");
  std::filesystem::remove(file);
  std::int64_t rays = 0, points = 0;
  const auto run = [&, &scene = scene, &mesh = mesh, &sets = sets](bool resume, std::int64_t most) {
    return precompute(
        solver_session(), scene, mesh, sets, {file, resume, {}, {}},
        [&](std::int64_t done, std::int64_t) { rays = done; }, [&] { return points >= most; }, {},
        [&](std::int64_t done, std::int64_t) { points = done; });
  };
  EXPECT_TRUE(run(false, 3).interrupted);
  EXPECT_EQ(rays, 3);
  EXPECT_EQ(points, 3);
  EXPECT_EQ(database_progress(file).rays_logged, 3);
  const auto report = run(true, n + 1);
  EXPECT_FALSE(report.interrupted);
  EXPECT_EQ(report.rays_resumed, 3);
  EXPECT_EQ(report.increments_of_run, 0);
  EXPECT_EQ(points, n);
  const auto database = Database::open(file);
  const auto last = solver.single_tool_at_rest(sets.linear.back());
  const auto stored = database.at_rest(static_cast<std::int32_t>(n) - 1);
  for (int i = 0; i < 9; ++i)
    EXPECT_EQ(stored.stiffness_N_per_m[static_cast<std::size_t>(i)], last.stiffness_N_per_m(i / 3, i % 3));
  EXPECT_EQ(stored.displacement[5], static_cast<float>(last.sensitivity(3 * top + 2, 1)));
  EXPECT_THROW(database.at_rest(static_cast<std::int32_t>(n)), Error);
  std::filesystem::remove(file);
}

TEST_P(Asked, ARayThatCannotBeHalvedEnds) {
  auto solver = _block.touched();
  std::vector<Status> outcomes;
  solver.follow({{0, 0, -1}}, {5e-324, 1e-323}, false, [&](std::size_t, const Response& response) {
    outcomes.push_back(response.status);
    return true;
  });
  EXPECT_EQ(outcomes.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Elements, Asked,
                         ::testing::Values(element_named("P1"), element_named("p1-p1"), element_named("es-p1-p1")),
                         [](const auto& info) {
                           return element_name({info.param, 0});
                         });

}  // namespace
}  // namespace phynness::test
