#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: grasping moves nothing at first; then the held point of the surface goes where the tool goes, out
// and in and sideways, pulled or pushed, until it is let go. Fields of modal models are floats: 1e-8 m.
TEST(Grasp, TheHeldPointFollowsTheTool) {
  for (const LoadedModel* loaded : {&linear_ball(), &bent_ball()}) {
    Touch touch(*loaded);
    Numbers numbers;
    for (int i = 0; i < 30; ++i) {
      const Vector3d out = random_direction(numbers), start = 0.053 * out;
      touch.step(tool_at(start, 0.004, PHN_TOOL_OFF));
      const auto first = touch.step(tool_at(start, 0.004, PHN_TOOL_GRASP));
      ASSERT_EQ(first.in_contact, 1);
      EXPECT_LT(vector(first.force).norm(), 1e-12);
      for (int k = 0; k < 20; ++k) {
        const Vector3d moved = 0.008 * numbers.vector();
        const auto state = touch.step(tool_at(start + moved, 0.004, PHN_TOOL_GRASP));
        ASSERT_EQ(state.in_contact, 1);
        ASSERT_TRUE(std::equal(state.held.weights, state.held.weights + 3, first.held.weights));
        ASSERT_LT((vector(state.held.displacement) - moved).norm(), 1e-15);
        ASSERT_LT((touch.moved(state.held) - moved).norm(), 1e-8);
        EXPECT_GT(vector(state.force).dot(moved), 0);
      }
      const auto pulled = touch.step(tool_at(start + 0.005 * out, 0.004, PHN_TOOL_GRASP));
      EXPECT_GT(vector(pulled.force).dot(out), 0);
      const auto released = touch.step(tool_at(start + 0.005 * out, 0.004, PHN_TOOL_PRESS));
      EXPECT_EQ(released.in_contact, 0);
      EXPECT_EQ(vector(released.force).norm(), 0);
    }
  }
}

// Claim: a tool that presses and then grasps keeps its point, its displacement and its force: nothing jumps.
TEST(Grasp, TakesWhatIsPressed) {
  Touch touch(bent_ball());
  const Vector3d c(0.002, 0.001, 0.05);
  touch.step(tool_at({0.002, 0.001, 0.06}, 0.004, PHN_TOOL_PRESS, 2));
  const auto pressed = touch.step(tool_at(c, 0.004, PHN_TOOL_PRESS, 2)),
             grasped = touch.step(tool_at(c, 0.004, PHN_TOOL_GRASP));
  EXPECT_EQ(pressed.unbalanced, 0);
  EXPECT_LT((vector(pressed.force) - vector(grasped.force)).norm(), 1e-12);
  EXPECT_TRUE(std::equal(pressed.held.weights, pressed.held.weights + 3, grasped.held.weights));
}

// Claim: a closing gripper beyond reach of the surface takes nothing until it touches, at any speed.
TEST(Grasp, TakesTheFirstPointThatItTouches) {
  Touch touch(bent_ball());
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.3}, 0.004, PHN_TOOL_GRASP)).in_contact, 0);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.2}, 0.004, PHN_TOOL_GRASP)).in_contact, 0);
  const auto state = touch.step(tool_at({0.0001, 0, 0.04}, 0.004, PHN_TOOL_GRASP));
  EXPECT_EQ(state.in_contact, 1);
  EXPECT_NEAR(state.held.displacement[2], -0.014, 1e-4);
}

}  // namespace
