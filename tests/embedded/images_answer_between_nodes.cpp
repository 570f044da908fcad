// Claims about one round tool anywhere on the surface of an image: it has the force, the warnings and the bound of
// phn_couple, and those of a node at the node; walks over the surface arrive where a search of it does.
#include <gtest/gtest.h>

#include <limits>
#include <list>

#include "../runtime/loaded_model.hpp"
#include "opened_image.hpp"
#include "round_models.hpp"
#include "round_sample.hpp"

namespace phynness::test {
namespace {

template <class Real>
class BetweenNodes : public ::testing::Test {
 protected:
  using Tool = typename Image<Real>::Tool;
  using Point = std::array<Real, 3>;

  struct Body {
    explicit Body(Model made)
        : model(std::move(made)),
          loaded(write_model_text(model)),
          opened(model_image(model, {true, sizeof(Real) == 4})),
          image(opened.image) {}
    /// A random point of the surface.
    Point point(Numbers& numbers) const {
      const auto n = static_cast<double>(model.surface.rows());
      const auto t = static_cast<Eigen::Index>(n / 2 * (1 + numbers.next()));
      Eigen::Vector3d w(1.05 + numbers.next(), 1.05 + numbers.next(), 1.05 + numbers.next());
      w /= w.sum();
      Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 3; ++k) x += w[k] * coordinates(model.surface(t, k));
      return {Real(x[0]), Real(x[1]), Real(x[2])};
    }
    Eigen::RowVector3d coordinates(std::int32_t node) const {
      const auto output = std::lower_bound(model.output.begin(), model.output.end(), node);
      if (output != model.output.end() && *output == node)
        return model.output_points.row(output - model.output.begin());
      return model.fixed_points.row(std::lower_bound(model.fixed.begin(), model.fixed.end(), node) -
                                    model.fixed.begin());
    }

    Model model;
    LoadedModel loaded;
    OpenedImage<Real> opened;
    const typename Image<Real>::Type* image;
  };

  static std::list<Body> bodies() {
    std::list<Body> all;
    for (const double spacing : {0.0, 0.025}) all.emplace_back(sample_of_round_tools(spacing));
    for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
      all.emplace_back(small_round_model(family));
      all.emplace_back(small_model_touched_anywhere(family));
    }
    return all;
  }
  static double distance(const Point& a, const Point& b) {
    return std::hypot(double(a[0] - b[0]), double(a[1] - b[1]), double(a[2] - b[2]));
  }
};
using Reals = ::testing::Types<double, float>;
TYPED_TEST_SUITE(BetweenNodes, Reals);

// Claim: at random points of the surface the place is that of phn_nearest, and force, energy, stiffness, warnings and
// bound are those of phn_couple, phn_force and phn_bound. In double 1e-10 of the largest value: rounding and
// another order of sums. In float 2e-4: forces at nodes are off by 5e-5 (terms cancel), and the weights of (x), some of
// which are negative, add up to less than 3. Bounds in float 2 %: they are powers of differences of these forces.
TYPED_TEST(BetweenNodes, AreTheRuntimes) {
  using Real = TypeParam;
  constexpr bool floats = sizeof(Real) == 4;
  for (const auto& body : this->bodies()) {
    Numbers numbers;
    const bool has_energy = body.model.family != Family::rbfn, has_bounds = body.model.family != Family::linear;
    double largest[3] = {0, 0, 0}, difference[3] = {0, 0, 0};
    int n = 0, n_warned = 0, n_bounds = 0;
    for (int i = 0; i < 400; ++i) {
      const auto x = body.point(numbers);
      const double at[3] = {double(x[0]), double(x[1]), double(x[2])};
      phn_tool tool;
      double found[3];
      ASSERT_EQ(phn_nearest(body.loaded.model, at, &tool, found, nullptr), PHN_OK);
      typename TestFixture::Tool asked;
      typename TestFixture::Point nearest;
      Real apart = 0;
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &asked, nearest.data(), &apart), PHN_OK);
      EXPECT_EQ(std::count(asked.displacement, asked.displacement + 3, Real(0)), 3);
      EXPECT_NEAR(std::abs(double(apart)), this->distance(x, nearest), 1e-7);
      for (int k = 0; k < 3; ++k) {
        asked.displacement[k] = Real(0.8 * body.model.max_displacement_m * numbers.next());
        tool.displacement[k] = double(asked.displacement[k]);
      }
      double force[3], energy = 0, stiffness[9] = {}, bound = 0;
      const int status = phn_couple(body.loaded.model, body.loaded.data, 1, &tool, force, nullptr);
      ASSERT_GE(status, 0);
      if (tool.nodes[2] < 0) continue;  // of a triangle that is not touched as a whole, which images do not hold
      ++n;
      n_warned += (status & PHN_WARNING_OUTSIDE) != 0;
      EXPECT_LT(this->distance(nearest, {Real(found[0]), Real(found[1]), Real(found[2])}), 1e-7);
      Real got[3], got_energy = 0, got_stiffness[9] = {}, got_bound = 0, got_depth = 0;
      ASSERT_EQ(Image<Real>::force(body.image, &asked, got), status);
      double depth = 0;
      ASSERT_EQ(Image<Real>::depth(body.image, &asked, &got_depth), phn_depth(body.loaded.model, &tool, &depth));
      EXPECT_NEAR(double(got_depth), depth, (floats ? 1e-5 : 1e-12) * body.model.max_displacement_m);
      const auto compare = [&](std::size_t what, const double* expected, const Real* value, int size) {
        for (int k = 0; k < size; ++k) {
          largest[what] = std::max(largest[what], std::abs(expected[k]));
          difference[what] = std::max(difference[what], std::abs(expected[k] - double(value[k])));
        }
      };
      compare(0, force, got, 3);
      const int expected = has_energy ? status : PHN_ERROR_UNDEFINED;
      ASSERT_EQ(Image<Real>::energy(body.image, &asked, &got_energy), expected);
      ASSERT_EQ(Image<Real>::stiffness(body.image, &asked, got_stiffness), expected);
      if (has_energy) {
        phn_force(body.loaded.model, body.loaded.data, &tool, nullptr, &energy, stiffness);
        compare(1, &energy, &got_energy, 1);
        compare(2, stiffness, got_stiffness, 9);
      }
      if (!has_bounds) {
        EXPECT_EQ(Image<Real>::bound(body.image, &asked, &got_bound), PHN_ERROR_UNDEFINED);
        continue;
      }
      ASSERT_EQ(phn_bound(body.loaded.model, &tool, &bound), status);
      ASSERT_EQ(Image<Real>::bound(body.image, &asked, &got_bound), status);
      ASSERT_EQ(bound == PHN_NO_BOUND, got_bound == Real(PHN_IMAGE_NO_BOUND));
      if (bound == PHN_NO_BOUND) continue;
      ++n_bounds;
      EXPECT_NEAR(double(got_bound), bound, (floats ? 0.02 : 1e-9) * bound) << i;
    }
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LE(difference[k], (floats ? 2e-4 : 1e-10) * largest[k]) << k;
    EXPECT_GT(n, 60);
    EXPECT_GT(n_warned, 10);
    EXPECT_LT(n_warned, n);
    EXPECT_EQ(n_bounds > 10, has_bounds);
  }
}

// Claim: at the place of an active node force, energy, stiffness, depth, warnings and bound are those of the node, to
// the bit, and the bound is that of phn_bound.
TYPED_TEST(BetweenNodes, AreTheNodesAtNodes) {
  using Real = TypeParam;
  for (const auto& body : this->bodies()) {
    const auto& contents = body.opened.contents;
    EXPECT_GT(contents.n_triangles, 0);
    std::int32_t n = 0;
    for (std::int32_t i = 0; i < contents.n_active; ++i) {
      const auto node = contents.active_nodes[i];
      const Real* x = contents.active_points + 3 * i;
      typename TestFixture::Tool place;
      Real apart = 1;
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x, &place, nullptr, &apart), PHN_OK);
      if (apart != 0) continue;  // in no triangle of which all corners can be touched
      ++n;
      for (const double share : {0.0, 0.1, 0.5, 1.2}) {
        const auto size = Real(share * body.model.max_displacement_m);
        const Real d[3] = {size / 2, -size / 3, -size};
        const auto at_node = Image<Real>::tool_at(node, d);
        std::copy_n(d, 3, place.displacement);
        const auto compare = [&](auto function, int size) {
          Real of_node[9] = {}, of_place[9] = {};
          EXPECT_EQ(function(body.image, &at_node, of_node), function(body.image, &place, of_place)) << node;
          for (int k = 0; k < size; ++k) EXPECT_EQ(of_place[k], of_node[k]) << node;
          return of_place[0];
        };
        compare(Image<Real>::force, 3);
        compare(Image<Real>::energy, 1);
        compare(Image<Real>::stiffness, 9);
        compare(Image<Real>::depth, 1);
        const Real bound = compare(Image<Real>::bound, 1);
        if (contents.has_bounds == 0) continue;
        double expected = 0;
        const double moved[3] = {double(d[0]), double(d[1]), double(d[2])};
        ASSERT_GE(phn_bound(body.loaded.model, AtNode(node, moved), &expected), 0);
        if (expected == PHN_NO_BOUND) expected = PHN_IMAGE_NO_BOUND;
        // At rest it is the network's force there, of floats with their rounding.
        EXPECT_NEAR(double(bound), expected, (sizeof(Real) == 4 ? 1e-4 : 1e-12) * std::max(expected, 0.01));
      }
    }
    EXPECT_GT(2 * n, contents.n_active);
  }
}

// Claim: a tool that slides in steps of 2 mm is followed by walks to a place as near as a search of the whole surface
// finds, in 29 of 30 steps; in the others the way to a nearer place leads over a border or a farther triangle. One that
// jumps across the surface is reached, or a place from which no neighbour is nearer, after some calls of which each is
// nearer than the one before.
TYPED_TEST(BetweenNodes, WalksArrive) {
  using Real = TypeParam;
  for (const auto& body : this->bodies()) {
    Numbers numbers;
    typename TestFixture::Tool place, searched;
    typename TestFixture::Point at = body.point(numbers), point;
    const bool small = body.model.surface.rows() < 10;  // of arbitrary points: tools jump over folds
    int n_nearest = 0;
    ASSERT_EQ(Image<Real>::nearest(body.image, -1, at.data(), &place, at.data(), nullptr), PHN_OK);
    for (int i = 0; i < 3000 && !small; ++i) {
      typename TestFixture::Point x;
      for (std::size_t k = 0; k < 3; ++k) x[k] = at[k] + Real(0.002 * numbers.next());
      ASSERT_EQ(Image<Real>::nearest(body.image, place.triangle, x.data(), &place, at.data(), nullptr), PHN_OK);
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &searched, point.data(), nullptr), PHN_OK);
      n_nearest += this->distance(x, at) < this->distance(x, point) + 1e-7;
    }
    EXPECT_GE(n_nearest, small ? 0 : 2900);
    for (int i = 0; i < 300; ++i) {
      const auto x = body.point(numbers);
      int status = PHN_WARNING_UNSETTLED;
      double before = std::numeric_limits<double>::infinity();
      for (int calls = 0; status != PHN_OK; ++calls) {
        ASSERT_LT(calls, body.model.surface.rows());
        status = Image<Real>::nearest(body.image, place.triangle, x.data(), &place, at.data(), nullptr);
        ASSERT_GE(status, 0);
        ASSERT_LE(this->distance(x, at), before + 1e-7);
        before = this->distance(x, at);
      }
      typename TestFixture::Tool again;
      ASSERT_EQ(Image<Real>::nearest(body.image, place.triangle, x.data(), &again, point.data(), nullptr), PHN_OK);
      EXPECT_EQ(again.triangle, place.triangle);
    }
  }
}

// Claim: a point far away has a place at the border of what can be touched, and `point` says how far it is.
TYPED_TEST(BetweenNodes, SayHowFarThePointIs) {
  using Real = TypeParam;
  const typename TestFixture::Body body(sample_of_round_tools(0));
  for (const Real far : {Real(1), Real(1e6), std::numeric_limits<Real>::max()}) {
    const typename TestFixture::Point x = {far, -far, far};
    typename TestFixture::Tool place;
    typename TestFixture::Point point;
    Real apart = 0;
    ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &place, point.data(), &apart), PHN_OK);
    EXPECT_GT(apart, Real(0.5));  // positive beyond the border
    EXPECT_TRUE(std::isfinite(apart));
    EXPECT_EQ(place.node, -1);
    EXPECT_EQ(place.weights[0] + place.weights[1] + place.weights[2], 1);
    for (const Real p : point) EXPECT_LT(std::abs(p), Real(1));
  }
}

// Claim: below the surface, where it has no border, the distance is negative, as that of phn_nearest; above it and at
// its border it is positive. Points nearer than 1e-5 m have no side in float.
TYPED_TEST(BetweenNodes, SayOnWhichSideThePointIs) {
  using Real = TypeParam;
  const typename TestFixture::Body body(sample_of_round_tools(0));
  Numbers numbers;
  int n_inside = 0, n_outside = 0;
  for (int i = 0; i < 2000; ++i) {
    auto x = body.point(numbers);
    for (Real& of_point : x) of_point += Real(0.01 * numbers.next());
    const double at[3] = {double(x[0]), double(x[1]), double(x[2])};
    typename TestFixture::Tool place;
    Real apart = 0;
    phn_tool tool;
    double expected = 0;
    ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &place, nullptr, &apart), PHN_OK);
    ASSERT_EQ(phn_nearest(body.loaded.model, at, &tool, nullptr, &expected), PHN_OK);
    if (std::abs(expected) < 1e-5 || std::abs(std::abs(apart) - std::abs(expected)) > 1e-6) continue;
    const bool in_triangle = place.weights[0] > 0 && place.weights[1] > 0 && place.weights[2] > 0;
    if (in_triangle || apart < 0) {
      ASSERT_EQ(apart < 0, expected < 0) << i;
    }
    n_inside += apart < 0;
    n_outside += expected > 0;
  }
  EXPECT_GT(n_inside, 100);
  EXPECT_GT(n_outside, 100);
}

// Claim: bad questions, and questions to images without a surface, are refused with zeros.
TYPED_TEST(BetweenNodes, RefuseBadQuestions) {
  using Real = TypeParam;
  const typename TestFixture::Body body(small_round_model(Family::modal));
  const Real nan = std::numeric_limits<Real>::quiet_NaN(), x[3] = {0, 0, 0};
  using Tool = typename TestFixture::Tool;
  const auto at = [](std::int32_t triangle, Real a, Real b, Real c) {
    return Tool{-1, triangle, {a, b, c}, {0, 0, Real(0.001)}, {}};
  };
  const Tool good = at(0, Real(0.5), Real(0.25), Real(0.25));
  Real force[3] = {1, 1, 1}, bound = 1;
  ASSERT_GE(Image<Real>::force(body.image, &good, force), 0);
  const auto refused = [&](const auto* image, const Tool& tool, int status) {
    force[0] = bound = 1;
    EXPECT_EQ(Image<Real>::force(image, &tool, force), status);
    EXPECT_EQ(Image<Real>::bound(image, &tool, &bound), status);
    EXPECT_EQ(force[0], 0);
    EXPECT_EQ(bound, Real(PHN_IMAGE_NO_BOUND));
  };
  for (const std::int32_t triangle : {-1, 1000, std::numeric_limits<std::int32_t>::max()})
    refused(body.image, at(triangle, 1, 0, 0), PHN_ERROR_ARGUMENT);
  for (const auto& [a, b] : {std::pair<Real, Real>{nan, 1}, {Real(0.7), Real(0.7)}, {Real(-0.1), Real(1.1)}, {0, 0}})
    refused(body.image, at(0, a, b, 0), PHN_ERROR_ARGUMENT);
  Tool wild = good;
  wild.displacement[1] = nan;
  refused(body.image, wild, PHN_ERROR_NOT_FINITE);
  int n_fixed = 0;
  for (std::int32_t t = 0; t < 4; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Tool corner = at(t, k == 0, k == 1, k == 2);
      n_fixed += Image<Real>::force(body.image, &corner, force) == PHN_ERROR_NOT_ACTIVE;
    }
  EXPECT_EQ(n_fixed, 3);  // one triangle has one fixed corner, another one two

  Tool place = good;
  Real apart = 1;
  const auto not_found = [&](const auto* image, std::int32_t from, const Real* near, int status) {
    place.triangle = 0;
    apart = 1;
    EXPECT_EQ(Image<Real>::nearest(image, from, near, &place, nullptr, &apart), status);
    EXPECT_EQ(place.triangle, -1);
    EXPECT_EQ(apart, 0);
  };
  not_found(body.image, 1000, x, PHN_ERROR_ARGUMENT);
  not_found(body.image, -1, wild.displacement, PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(Image<Real>::nearest(body.image, -1, x, &place, place.displacement, nullptr), PHN_ERROR_OVERLAP);
  const OpenedImage<Real> not_round(model_image(small_modal_model(), {true, sizeof(Real) == 4}));
  EXPECT_EQ(not_round.contents.n_triangles, 0);
  refused(not_round.image, good, PHN_ERROR_UNDEFINED);
  not_found(not_round.image, -1, x, PHN_ERROR_UNDEFINED);
}

// Claim: where one active node answers, at its place or beside fixed nodes, the deformation is that of phn_deform;
// between active nodes it is refused. In double 1e-6 of the largest displacement, because the runtime sums modes in
// float, in float 1e-5.
TYPED_TEST(BetweenNodes, DeformAsOneNode) {
  using Real = TypeParam;
  const typename TestFixture::Body body(small_round_model(Family::modal));
  const OpenedImage<Real> opened(model_image(body.model, {false, sizeof(Real) == 4}));
  std::vector<Real> scratch(opened.n_scratch()), field(opened.n_field());
  std::vector<double> expected(opened.n_field());
  Numbers numbers;
  int n_refused = 0, n_nodes = 0, n_beside_fixed = 0;
  for (std::int32_t i = 0; i < 200; ++i) {
    auto x = body.point(numbers);
    if (i < opened.contents.n_active) std::copy_n(opened.contents.active_points + 3 * i, 3, x.begin());
    const double at[3] = {double(x[0]), double(x[1]), double(x[2])};
    typename TestFixture::Tool tool;
    phn_tool asked;
    double apart = 1;
    ASSERT_EQ(Image<Real>::nearest(opened.image, -1, x.data(), &tool, nullptr, nullptr), PHN_OK);
    ASSERT_EQ(phn_nearest(body.loaded.model, at, &asked, nullptr, &apart), PHN_OK);
    if (std::abs(apart) > 1e-6) continue;
    for (int k = 0; k < 3; ++k) {
      tool.displacement[k] = Real(0.5 * body.model.max_displacement_m * numbers.next());
      asked.displacement[k] = double(tool.displacement[k]);
    }
    const int status = Image<Real>::deform(opened.image, scratch.data(), &tool, field.data());
    if (status == PHN_ERROR_UNDEFINED) {
      ++n_refused;
      EXPECT_EQ(std::count(field.begin(), field.end(), Real(0)), std::ssize(field));
      continue;
    }
    ASSERT_EQ(phn_deform(body.loaded.model, body.loaded.data, &asked, expected.data()), status);
    double largest = 0, difference = 0;
    for (std::size_t k = 0; k < field.size(); ++k) {
      largest = std::max(largest, std::abs(expected[k]));
      difference = std::max(difference, std::abs(expected[k] - double(field[k])));
    }
    EXPECT_LT(difference, (sizeof(Real) == 4 ? 1e-5 : 1e-6) * largest) << i;
    const bool at_node = std::count(tool.weights, tool.weights + 3, Real(1)) == 1;
    ++(at_node ? n_nodes : n_beside_fixed);
  }
  EXPECT_GT(n_refused, 10);
  EXPECT_GT(n_nodes, 0);
  EXPECT_GT(n_beside_fixed, 10);
}

}  // namespace
}  // namespace phynness::test
