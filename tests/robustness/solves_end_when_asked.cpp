// Claims: a solve checks between its iterations whether it is to be interrupted, and then ends within seconds,
// independent of its length. Its ray is not recorded, and a resumed run is identical to one without interruption. A ray
// whose displacements are too small to be halved ends.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <optional>
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
