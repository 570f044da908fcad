#include "../runtime/fine_surface.hpp"
#include "contact/contact.hpp"
#include "tools/triangle.hpp"
#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

std::array<Vector3d, 3> corners(const runtime::ContactSurface& s, int triangle, double radius) {
  std::array<Vector3d, 3> x;
  for (int k = 0; k < 3; ++k) {
    const int v = s.triangle[3 * triangle + k];
    x[static_cast<std::size_t>(k)] = vector(s.placed + 3 * v) + radius * vector(s.offset + 3 * v);
  }
  return x;
}

/// The first front that the way crosses, triangle by triangle, by solving for the crossing point; -1: none.
double plain_sweep(const runtime::ContactSurface& s, double radius, const Vector3d& from, const Vector3d& to) {
  double first = 2;
  for (int t = 0; t < s.n_triangles; ++t) {
    const auto [a, b, c] = corners(s, t, radius);
    Eigen::Matrix3d m;
    m << b - a, c - a, from - to;
    if ((b - a).cross(c - a).dot(to - from) >= 0) continue;
    const Vector3d x = m.fullPivLu().solve(from - a);
    if (x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] >= 0 && x[2] <= 1) first = std::min(first, x[2]);
  }
  return first <= 1 ? first : -1;
}

Skin tangle(int n_points, int n_triangles) {
  const Body body = soup(n_points, n_triangles);
  Skin s;
  for (const auto& x : body.points) s.points.push_back(0.05 * x.transpose());
  s.triangles.assign(body.triangles.begin(), body.triangles.end());
  return s;
}

class Hierarchy : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Bodies, Hierarchy, testing::Range(0, 4));

// Claim: 10^4 random sweeps and nearest points, at rest and displaced, for several radii, give what a loop
// over all triangles gives: on a ball, one with fixed nodes, a plate and triangles at random. Rounding, 1e-12
// of the way; a way that grazes an edge may be told apart by it: one in a thousand.
TEST_P(Hierarchy, AgreesWithTheLoopOverAllTriangles) {
  const Skin skins[] = {ball(), held_ball(), plate(0.004), tangle(40, 70)};
  const Skin& shape = skins[GetParam()];
  const LoadedModel loaded(write_model_text(linear_model(shape)));
  Touch touch(loaded);
  const runtime::ContactSurface& surface = touch.contact->surface;
  Numbers numbers;
  Points field(info_of(loaded.model).n_output, 3);
  int n_hits = 0, n_grazing = 0;
  for (int i = 0; i < 10000; ++i) {
    if (i % 1000 == 500) {
      for (double& u : field.reshaped()) u = 0.004 * numbers.next();
      ASSERT_EQ(phn_contact_refit(touch.contact, field.data()), PHN_OK);
    }
    const double radius = i % 3 == 0 ? 0 : 0.003 * (1 + numbers.next());
    const auto point = [&] { return Vector3d(0.08 * numbers.vector()); };
    const Vector3d from = point(), to = i % 4 == 0 ? point() : Vector3d(from + 0.1 * point());
    runtime::SurfacePoint at = {};
    const double part = runtime::sweep(surface, touch.contact->volumes, radius, from.data(), to.data(), 0, at),
                 plain = plain_sweep(surface, radius, from, to);
    n_hits += plain >= 0;
    if (std::abs(part - plain) > 1e-9) {
      // Beside a fixed edge there is nothing to cross, which the loop does not know.
      n_grazing += GetParam() != 1;
    } else if (part >= 0) {
      Vector3d y;
      runtime::point_at(surface, surface.placed, at, radius, y.data());
      ASSERT_LT((y - from - part * (to - from)).norm(), 1e-12);
    }
    double least = 1;
    for (int t = 0; t < surface.n_triangles; ++t) {
      const auto x = corners(surface, t, radius);
      const double* const corner[3] = {x[0].data(), x[1].data(), x[2].data()};
      double weight[3], nearest[3], distance = 0;
      runtime::nearest_on_triangle(corner, from.data(), weight, nearest, distance);
      least = std::min(least, distance);
    }
    ASSERT_NEAR(runtime::nearest(surface, touch.contact->volumes, radius, from.data(), at), least, 1e-15);
  }
  EXPECT_GT(n_hits, 500);
  EXPECT_LE(n_grazing, 10);
}

// Claim: at rest phn_contact_nearest finds what phn_nearest finds, where everything can be touched.
TEST(Hierarchy, FindsWhatPhnNearestFinds) {
  Touch touch(linear_ball());
  Numbers numbers;
  for (int i = 0; i < 10000; ++i) {
    const Vector3d x = 0.1 * numbers.vector();
    phn_tool a, b;
    Vector3d p, q;
    ASSERT_EQ(phn_contact_nearest(touch.contact, x.data(), &a, p.data()), PHN_OK);
    ASSERT_EQ(phn_nearest(touch.loaded.model, x.data(), &b, q.data()), PHN_OK);
    ASSERT_NEAR((p - x).norm(), (q - x).norm(), 1e-15);
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
