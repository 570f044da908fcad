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
  using Place = typename Image<Real>::Place;
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
      Real d[3];
      for (int k = 0; k < 3; ++k) {
        d[k] = Real(0.8 * body.model.max_displacement_m * numbers.next());
        tool.displacement[k] = double(d[k]);
      }
      double force[3], energy = 0, stiffness[9] = {}, bound = 0;
      const int status = phn_couple(body.loaded.model, body.loaded.data, 1, &tool, force, nullptr);
      ASSERT_GE(status, 0);
      if (tool.nodes[2] < 0) continue;  // of a triangle that is not touched as a whole, which images do not hold
      ++n;
      n_warned += status != 0;
      typename TestFixture::Place place;
      typename TestFixture::Point nearest;
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &place, nearest.data()), PHN_OK);
      EXPECT_LT(this->distance(nearest, {Real(found[0]), Real(found[1]), Real(found[2])}), 1e-7);
      Real got[3], got_energy = 0, got_stiffness[9] = {}, got_bound = 0;
      ASSERT_EQ(Image<Real>::force_at(body.image, &place, d, got), status);
      const auto compare = [&](std::size_t what, const double* expected, const Real* value, int size) {
        for (int k = 0; k < size; ++k) {
          largest[what] = std::max(largest[what], std::abs(expected[k]));
          difference[what] = std::max(difference[what], std::abs(expected[k] - double(value[k])));
        }
      };
      compare(0, force, got, 3);
      const int expected = has_energy ? status : PHN_ERROR_UNDEFINED;
      ASSERT_EQ(Image<Real>::energy_at(body.image, &place, d, &got_energy), expected);
      ASSERT_EQ(Image<Real>::stiffness_at(body.image, &place, d, got_stiffness), expected);
      if (has_energy) {
        phn_force(body.loaded.model, body.loaded.data, &tool, nullptr, &energy, stiffness);
        compare(1, &energy, &got_energy, 1);
        compare(2, stiffness, got_stiffness, 9);
      }
      if (!has_bounds) {
        EXPECT_EQ(Image<Real>::bound_at(body.image, &place, d, &got_bound), PHN_ERROR_UNDEFINED);
        continue;
      }
      ASSERT_EQ(phn_bound(body.loaded.model, &tool, &bound), status);
      ASSERT_EQ(Image<Real>::bound_at(body.image, &place, d, &got_bound), status);
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

// Claim: at an active node force, energy, stiffness, warnings and bound are those of the node, to the bit.
TYPED_TEST(BetweenNodes, AreTheNodesAtNodes) {
  using Real = TypeParam;
  for (const auto& body : this->bodies()) {
    const auto* nodes = Image<Real>::active_nodes(body.image);
    std::int32_t n = 0;
    for (std::int32_t i = 0; i < body.opened.n_active(); ++i) {
      const auto node = nodes[i];
      const Vec3& at = body.model.nodes[static_cast<std::size_t>(i)].point;
      const Real x[3] = {Real(at[0]), Real(at[1]), Real(at[2])};
      typename TestFixture::Place place;
      typename TestFixture::Point point;
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x, &place, point.data()), PHN_OK);
      if (this->distance(point, {x[0], x[1], x[2]}) > 0)
        continue;  // in no triangle of which all corners can be touched
      ++n;
      for (const double share : {0.0, 0.1, 0.5, 1.2}) {
        const auto size = Real(share * body.model.max_displacement_m);
        const Real d[3] = {size / 2, -size / 3, -size};
        Real at_node[10] = {}, at_place[10] = {}, bound = 0;
        const int status = Image<Real>::force(body.image, node, d, at_node);
        ASSERT_EQ(Image<Real>::force_at(body.image, &place, d, at_place), status) << node;
        EXPECT_EQ(Image<Real>::energy(body.image, node, d, at_node + 3),
                  Image<Real>::energy_at(body.image, &place, d, at_place + 3));
        for (int k = 0; k < 4; ++k) EXPECT_EQ(at_place[k], at_node[k]) << node;
        Image<Real>::stiffness(body.image, node, d, at_node);
        Image<Real>::stiffness_at(body.image, &place, d, at_place);
        for (int k = 0; k < 9; ++k) EXPECT_EQ(at_place[k], at_node[k]) << node;
        if (Image<Real>::bound_at(body.image, &place, d, &bound) < 0) continue;
        double expected = 0;
        const double moved[3] = {double(d[0]), double(d[1]), double(d[2])};
        ASSERT_GE(phn_bound(body.loaded.model, AtNode(node, moved), &expected), 0);
        if (expected == PHN_NO_BOUND) expected = PHN_IMAGE_NO_BOUND;
        // At rest it is the network's force there, of floats with their rounding.
        EXPECT_NEAR(double(bound), expected, (sizeof(Real) == 4 ? 1e-4 : 1e-12) * std::max(expected, 0.01));
      }
    }
    EXPECT_GT(2 * n, body.opened.n_active());
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
    typename TestFixture::Place place, searched;
    typename TestFixture::Point at = body.point(numbers), point;
    const bool small = body.model.surface.rows() < 10;  // of arbitrary points: tools jump over folds
    int n_nearest = 0;
    ASSERT_EQ(Image<Real>::nearest(body.image, -1, at.data(), &place, at.data()), PHN_OK);
    for (int i = 0; i < 3000 && !small; ++i) {
      typename TestFixture::Point x;
      for (std::size_t k = 0; k < 3; ++k) x[k] = at[k] + Real(0.002 * numbers.next());
      ASSERT_EQ(Image<Real>::nearest(body.image, place.triangle, x.data(), &place, at.data()), PHN_OK);
      ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &searched, point.data()), PHN_OK);
      n_nearest += this->distance(x, at) < this->distance(x, point) + 1e-7;
    }
    EXPECT_GE(n_nearest, small ? 0 : 2900);
    for (int i = 0; i < 300; ++i) {
      const auto x = body.point(numbers);
      int status = PHN_WARNING_UNSETTLED;
      double before = std::numeric_limits<double>::infinity();
      for (int calls = 0; status != PHN_OK; ++calls) {
        ASSERT_LT(calls, body.model.surface.rows());
        status = Image<Real>::nearest(body.image, place.triangle, x.data(), &place, at.data());
        ASSERT_GE(status, 0);
        ASSERT_LE(this->distance(x, at), before + 1e-7);
        before = this->distance(x, at);
      }
      typename TestFixture::Place again;
      ASSERT_EQ(Image<Real>::nearest(body.image, place.triangle, x.data(), &again, point.data()), PHN_OK);
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
    typename TestFixture::Place place;
    typename TestFixture::Point point;
    ASSERT_EQ(Image<Real>::nearest(body.image, -1, x.data(), &place, point.data()), PHN_OK);
    EXPECT_GT(this->distance(x, point), 0.5);
    EXPECT_EQ(place.weights[0] + place.weights[1] + place.weights[2], 1);
    for (const Real p : point) EXPECT_LT(std::abs(p), Real(1));
  }
}

// Claim: bad questions, and questions to images without a surface, are refused with zeros.
TYPED_TEST(BetweenNodes, RefuseBadQuestions) {
  using Real = TypeParam;
  const typename TestFixture::Body body(small_round_model(Family::modal));
  const Real nan = std::numeric_limits<Real>::quiet_NaN(), x[3] = {0, 0, 0}, d[3] = {0, 0, Real(0.001)};
  typename TestFixture::Place good = {{Real(0.5), Real(0.25), Real(0.25)}, 0};
  Real force[3] = {1, 1, 1}, bound = 1;
  ASSERT_GE(Image<Real>::force_at(body.image, &good, d, force), 0);
  const auto refused = [&](const auto* image, const typename TestFixture::Place* at, const Real* moved, int status) {
    force[0] = bound = 1;
    EXPECT_EQ(Image<Real>::force_at(image, at, moved, force), status);
    EXPECT_EQ(Image<Real>::bound_at(image, at, moved, &bound), status);
    EXPECT_EQ(force[0], 0);
    EXPECT_EQ(bound, 0);
  };
  for (const std::int32_t triangle : {-1, 1000, std::numeric_limits<std::int32_t>::max()}) {
    const typename TestFixture::Place at = {{1, 0, 0}, triangle};
    refused(body.image, &at, d, PHN_ERROR_ARGUMENT);
  }
  for (const auto& [a, b] : {std::pair<Real, Real>{nan, 1}, {Real(0.7), Real(0.7)}, {Real(-0.1), Real(1.1)}, {0, 0}}) {
    const typename TestFixture::Place at = {{a, b, 0}, 0};
    refused(body.image, &at, d, PHN_ERROR_ARGUMENT);
  }
  const Real wild[3] = {0, nan, 0};
  refused(body.image, &good, wild, PHN_ERROR_NOT_FINITE);
  refused(body.image, nullptr, d, PHN_ERROR_ARGUMENT);
  const std::nullptr_t none = nullptr;
  EXPECT_EQ(Image<Real>::force_at(none, &good, d, force), PHN_ERROR_ARGUMENT);
  int n_fixed = 0;
  for (std::int32_t t = 0; t < 4; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      typename TestFixture::Place corner = {{0, 0, 0}, t};
      corner.weights[k] = 1;
      n_fixed += Image<Real>::force_at(body.image, &corner, d, force) == PHN_ERROR_NOT_ACTIVE;
    }
  }
  EXPECT_EQ(n_fixed, 3);  // one triangle has one fixed corner, another one two

  typename TestFixture::Place place = good;
  EXPECT_EQ(Image<Real>::nearest(body.image, 1000, x, &place, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(place.triangle, -1);
  EXPECT_EQ(Image<Real>::nearest(body.image, -1, wild, &place, nullptr), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(place.triangle, -1);
  const OpenedImage<Real> not_round(model_image(small_modal_model(), {true, sizeof(Real) == 4}));
  refused(not_round.image, &good, d, PHN_ERROR_UNDEFINED);
  EXPECT_EQ(Image<Real>::nearest(not_round.image, -1, x, &place, nullptr), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(place.triangle, -1);
  EXPECT_GE(Image<Real>::force(not_round.image, 3, d, force), 0);
}

}  // namespace
}  // namespace phynness::test
