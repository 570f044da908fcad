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
    ASSERT_NEAR(runtime::nearest(touch.contact->surface, touch.contact->volumes, 0, x.data(), at), std::abs(distance),
                1e-15);
  }
}

/// Whether x is inside of a closed surface: its triangles are seen under the solid angle 4 pi (van Oosterom & Strackee
/// 1983, doi 10.1109/TBME.1983.325207).
bool is_inside(const Skin& shape, const Vector3d& x) {
  double angle = 0;
  for (const auto& triangle : shape.triangles) {
    Vector3d r[3];
    for (std::size_t k = 0; k < 3; ++k) r[k] = shape.points[static_cast<std::size_t>(triangle[k])] - x;
    const double a = r[0].norm(), b = r[1].norm(), c = r[2].norm();
    angle += 2 * std::atan2(r[0].dot(r[1].cross(r[2])),
                            a * b * c + r[0].dot(r[1]) * c + r[1].dot(r[2]) * a + r[2].dot(r[0]) * b);
  }
  return angle > 2 * 3.14159265358979;
}

/// A flat double pyramid over a square, whose upper triangles are divided by lines from two of its corners, so that
/// these have 14 triangles above and two below.
Skin divided_pyramid() {
  constexpr int n = 6;
  Skin s;
  s.points = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 0.1}, {0, 0, -0.1}};
  for (int i = 0; i < 4; ++i) s.triangles.push_back({(i + 1) % 4, i, 5});
  for (const int side : {1, 3}) {
    const int before = side - 1, after = (side + 1) % 4, first = static_cast<int>(s.points.size());
    const auto on_edge = [&](int i) { return i == 0 ? side : i > n ? 4 : first + i - 1; };
    for (int i = 1; i <= n; ++i) {
      const double up = static_cast<double>(i) / (n + 1);
      s.points.push_back((1 - up) * s.points[static_cast<std::size_t>(side)] + up * s.points[4]);
    }
    for (int i = 0; i <= n; ++i) {
      s.triangles.push_back({before, on_edge(i), on_edge(i + 1)});
      s.triangles.push_back({after, on_edge(i + 1), on_edge(i)});
    }
  }
  for (Vector3d& x : s.points) x *= 0.05;
  return s;
}

// Claim: the distance of phn_nearest is negative exactly inside of the body, whose rims and tips are sharp: a ball that
// is flattened to a lens or stretched, one with deep dents and a spike, and a pyramid. Where the place is at an edge or
// a vertex the normal of one of its triangles, or their sum without the angles, gives the wrong sign. Points nearer
// than 1e-9 m have no side.
TEST(Nearest, HasTheSignOfTheSide) {
  Numbers numbers;
  std::vector<Skin> shapes;
  for (const Vector3d& stretch : {Vector3d(1, 1, 0.05), Vector3d(1, 0.1, 0.1), Vector3d(1, 1, 1)}) {
    shapes.push_back(ball(1));
    for (Vector3d& x : shapes.back().points) x = stretch.cwiseProduct(x);
  }
  // The first six points are the corners of the octahedron.
  for (std::size_t i = 0; i < 6; ++i) shapes.back().points[i] *= i == 0 ? 1.5 : 0.1;
  shapes.push_back(divided_pyramid());
  for (const Skin& shape : shapes) {
    const LoadedModel loaded(write_model_text(linear_model(shape)));
    Vector3d reach = Vector3d::Constant(0.002);
    for (const Vector3d& x : shape.points) reach = reach.cwiseMax(1.2 * x);
    int n_inside = 0, n_at_edges = 0;
    for (int i = 0; i < 10000; ++i) {
      const Vector3d x = reach.cwiseProduct(numbers.vector());
      phn_tool tool;
      double distance = 0;
      Vector3d point;
      ASSERT_EQ(phn_nearest(loaded.model, x.data(), &tool, point.data(), &distance), PHN_OK);
      ASSERT_NEAR(std::abs(distance), (x - point).norm(), 1e-15);
      if (std::abs(distance) < 1e-9) continue;
      const bool inside = is_inside(shape, x);
      ASSERT_EQ(distance < 0, inside) << x.transpose();
      n_inside += inside;
      n_at_edges += tool.weights[0] == 0 || tool.weights[1] == 0 || tool.weights[2] == 0;
    }
    EXPECT_GT(n_inside, 500);
    EXPECT_GT(n_at_edges, 500);
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
  for (int v = 0; v < p.n_vertices; ++v)
    for (int k = 0; k < 3; ++k) {
      const double x = p.rest[3 * v + k], half = k == 2 ? 0.005 : 0.05;
      if (std::abs(std::abs(x) - half) < 1e-9) {
        EXPECT_NEAR(p.offset[3 * v + k], x > 0 ? 1 : -1, 0.01);
      }
    }
}

}  // namespace
