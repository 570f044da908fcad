#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

struct Path {
  double work = 0, least = 0, stored = 0;
};

/// Work of the tool along straight legs between corners, from outside to outside: mean force times way, step by step.
/// @param guarded  false: with the whole force, before the guard scaled it
Path follow(const LoadedModel& loaded, const std::vector<Vector3d>& corners, double mu, bool guarded, double step) {
  Touch touch(loaded);
  Path path;
  Vector3d c = corners.front(), f(0, 0, 0);
  phn_contact_tool tool;
  const auto step_to = [&](const Vector3d& x) {
    for (int k = 0; k < 3; ++k) tool.center[k] = x[k];
    tool.radius = 0.004;
    tool.friction = mu;
    tool.mode = PHN_TOOL_PRESS;
    return touch.step(tool);
  };
  step_to(c);
  for (std::size_t leg = 1; leg < corners.size(); ++leg) {
    const Vector3d from = c, way = corners[leg] - from;
    const int n = static_cast<int>(way.norm() / step) + 1;
    for (int i = 1; i <= n; ++i) {
      const Vector3d next = from + i * way / n;
      const auto state = step_to(next);
      const Vector3d force = vector(state.force) / (guarded || state.scale == 0 ? 1 : state.scale);
      path.work += (f + force).dot(next - c) / 2;
      path.least = std::min(path.least, path.work);
      path.stored = std::max(path.stored, touch.report.energy);
      f = force;
      c = next;
    }
  }
  EXPECT_EQ(f.norm(), 0);
  return path;
}

std::vector<Vector3d> there_and_back(Numbers& numbers) {
  const Vector3d at = random_direction(numbers);
  const Vector3d in = 0.049 * (at + 0.1 * random_direction(numbers)).normalized(),
                 aside = 0.05 * (at + 0.3 * random_direction(numbers)).normalized();
  return {0.06 * at, in, aside, in, 0.06 * at};
}

/// Pushes somewhere, slides over two corners, leaves elsewhere and comes back outside.
std::vector<Vector3d> round_trip(Numbers& numbers) {
  const Vector3d at = random_direction(numbers);
  std::vector<Vector3d> corners = {0.06 * at};
  for (int i = 0; i < 4; ++i) {
    const double depth = 0.002 + 0.002 * (1 + numbers.next());
    corners.push_back((0.054 - depth) * (at + 0.4 * random_direction(numbers)).normalized());
  }
  corners.push_back(0.07 * corners.back().normalized());
  return corners;
}

// Claim: pressed, slid and brought back the way it came, a frictionless tool has done no work: its force depends on
// where it is. Against what was stored: 1e-3, the tolerance of sliding and the corner at the touch in steps of 0.05 mm.
TEST(Energy, ThereAndBackWithoutFrictionIsNoWork) {
  Numbers numbers;
  for (const LoadedModel* loaded : {&linear_ball(), &bent_ball()})
    for (int i = 0; i < 8; ++i) {
      const Path path = follow(*loaded, there_and_back(numbers), 0, false, 5e-5);
      EXPECT_GT(path.stored, 1e-4);
      EXPECT_LT(std::abs(path.work), 1e-3 * path.stored) << i;
    }
}

// Claim: a tool that sticks stores in the body what it does, and gets it back: to what the trapezoidal rule leaves.
TEST(Energy, PressAndReleaseReturnsWhatWasStored) {
  Numbers numbers;
  for (int i = 0; i < 20; ++i) {
    const Vector3d at = random_direction(numbers);
    const Path path = follow(bent_ball(), {0.06 * at, 0.049 * at, 0.06 * at}, 10, false, 5e-5);
    EXPECT_LT(std::abs(path.work), 1e-4 * path.stored);
  }
}

// Claim: with or without friction, a tool never gains: at no time on any closed path has it given more than
// it took, to 1e-3 of what was stored, whatever it slides over. With friction it loses.
TEST(Energy, NoToolGains) {
  constexpr int n = 12;
  Numbers numbers;
  for (const double mu : {0.0, 0.05, 0.2, 0.5, 1.0}) {
    double lost = 0;
    for (int i = 0; i < n; ++i) {
      const Path path = follow(bent_ball(), round_trip(numbers), mu, true, 1e-4);
      EXPECT_GT(path.least, -1e-3 * path.stored) << i << " " << mu;
      lost += path.work / path.stored / n;
    }
    EXPECT_GT(lost, mu);
  }
}

// Claim: a tool that enters sideways over the surface, where its force is normal to the smooth surface and its way is
// not that of the triangles, has its whole force once it is deep: it is scaled only while hardly any work was done.
TEST(Energy, ToolsThatEnterSidewaysAreFelt) {
  Numbers numbers;
  for (const double friction : {0.0, 0.1, 0.2}) {
    int scaled = 0, deep = 0;
    for (int path = 0; path < 12; ++path) {
      Touch touch(bent_ball());
      const Vector3d at = random_direction(numbers), aside = at.cross(random_direction(numbers)).normalized();
      for (int i = 0; i <= 800; ++i) {
        const double depth = -0.0002 + 0.004 * i / 800;
        const Vector3d direction = (at + 1.2 * i / 800 * aside).normalized();
        const auto state = touch.step(tool_at((0.054 - depth) * direction, 0.004, PHN_TOOL_PRESS, friction));
        if (depth < 0.001) continue;
        ++deep;
        scaled += state.scale < 0.9;
      }
    }
    EXPECT_LE(scaled, 0.01 * deep) << friction;
  }
}

}  // namespace
