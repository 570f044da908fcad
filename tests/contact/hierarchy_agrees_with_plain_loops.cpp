#include "contact/contact.hpp"
#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: at rest the hierarchy finds a point as near as phn_nearest does, where everything can be touched.
TEST(Hierarchy, FindsWhatPhnNearestFinds) {
  Touch touch(linear_ball());
  Numbers numbers;
  for (int i = 0; i < 10000; ++i) {
    const Vector3d x = 0.1 * numbers.vector();
    phn_tool tool;
    double distance = -1;
    runtime::SurfacePoint at = {};
    ASSERT_EQ(phn_nearest(touch.loaded.model, x.data(), &tool, nullptr, &distance), PHN_OK);
    ASSERT_NEAR(runtime::nearest(touch.contact->surface, touch.contact->volumes, 0, x.data(), at), distance, 1e-15);
  }
}

// Claim: on smooth and on right-angled bodies an offset surface is as far out as the radius says: a ball of 5
// cm under a tool of 1 cm begins at 6 cm but for the triangles, a plate's offset keeps its faces flat but for
// the series of the angles.
TEST(Hierarchy, OffsetsAreTheRadius) {
  Touch touch(linear_ball());
  Numbers numbers;
  const auto& s = touch.contact->surface;
  for (int i = 0; i < 100; ++i) {
    runtime::SurfacePoint at = {};
    const Vector3d out = random_direction(numbers), from = 0.1 * out, to = 0.02 * out;
    const double surface = runtime::sweep(s, touch.contact->volumes, 0, from.data(), to.data(), 0, at),
                 offset = runtime::sweep(s, touch.contact->volumes, 0.01, from.data(), to.data(), 0, at);
    EXPECT_NEAR(0.08 * (surface - offset), 0.01, 2e-4);
  }
  const LoadedModel flat(write_model_text(linear_model(plate(0.01))));
  Touch on_plate(flat);
  const auto& p = on_plate.contact->surface;
  for (int v = 0; v < p.n_vertices; ++v) {
    for (int k = 0; k < 3; ++k) {
      const double x = p.rest[3 * v + k], half = k == 2 ? 0.005 : 0.05;
      if (std::abs(std::abs(x) - half) < 1e-9) {
        EXPECT_NEAR(p.offset[3 * v + k], x > 0 ? 1 : -1, 0.01);
      }
    }
  }
}

}  // namespace
