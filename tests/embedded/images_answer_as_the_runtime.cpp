// Claims: an image of doubles gives the forces, energies, stiffnesses, depths and deformations of the runtime up to
// rounding (1e-12 of the largest value of the model, because sums have another order and Gaussians are powers of two).
// An image of floats gives them up to 1e-6 of the largest value (weights of these models cancel by up to a hundred, and
// the rounding of a float is 6e-8). At rest those of conservative models are exactly 0.
#include <gtest/gtest.h>
#include <phynness/phynness_image.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <phynness/formats/image.hpp>
#include <phynness/image_layout.hpp>

#include "../messages.hpp"
#include "../runtime/loaded_model.hpp"
#include "../runtime/small_model.hpp"
#include "opened_image.hpp"

namespace phynness::test {
namespace {

/// Inside and a little beyond what was trained.
std::vector<Vec3> near_displacements() {
  std::vector<Vec3> all{{0, 0, 0}};
  for (std::size_t k = 0; k < 3; ++k)
    for (const double depth : {1e-12, -1e-12, 0.004, -0.007, 0.014, -0.02}) {
      Vec3 d{0, 0, 0};
      d[k] = depth;
      all.push_back(d);
    }
  Numbers numbers;
  for (int i = 0; i < 40; ++i) all.push_back({0.01 * numbers.next(), 0.01 * numbers.next(), 0.01 * numbers.next()});
  return all;
}

/// Far beyond, where other numbers are large.
std::vector<Vec3> far_displacements() { return {{10, -20, 5}, {0, 0.1, 0}, {0, 0, -1000}}; }

template <class Real>
class Answers : public ::testing::Test {};
using Reals = ::testing::Types<double, float>;
TYPED_TEST_SUITE(Answers, Reals);

template <class Real>
constexpr double tolerance = sizeof(Real) == 8 ? 1e-12 : 1e-6;

/// The largest difference over the largest value.
class Difference {
 public:
  template <class Real>
  void add(const double* expected, const Real* got, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_TRUE(std::isfinite(got[i]));
      _largest = std::max(_largest, std::fabs(expected[i]));
      _difference = std::max(_difference, std::fabs(expected[i] - static_cast<double>(got[i])));
    }
  }
  double relative() const { return _largest > 0 ? _difference / _largest : _difference; }

 private:
  double _largest = 0, _difference = 0;
};

template <class Real>
void answers_are_the_runtimes(const std::vector<Vec3>& displacements) {
  for (const Model& model :
       {small_model(), small_linear_model(), small_modal_model(), small_modal_model(3, 70, 6, 20)}) {
    const Family family = model.family;
    const LoadedModel loaded(write_model_text(model));
    const OpenedImage<Real> opened(model_image(model, {false, sizeof(Real) == 4}));
    const auto* image = opened.image;
    ASSERT_EQ(opened.contents.n_active, info_of(loaded.model).n_active);
    ASSERT_EQ(opened.contents.n_output, info_of(loaded.model).n_output);
    EXPECT_EQ(opened.contents.has_energy, info_of(loaded.model).has_energy);
    EXPECT_EQ(Real(opened.contents.max_displacement_m), Real(model.max_displacement_m));
    Difference force, energy, stiffness, depth, field;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const std::int32_t node = opened.contents.active_nodes[i];
      ASSERT_EQ(node, model.nodes[i].node);
      for (const Vec3& d : displacements) {
        const Real at[3] = {static_cast<Real>(d[0]), static_cast<Real>(d[1]), static_cast<Real>(d[2])};
        const auto tool = Image<Real>::tool_at(node, at);
        const double rounded[3] = {at[0], at[1], at[2]};
        double expected[9];
        Real got[9];
        const int status = phn_force(loaded.model, loaded.data, AtNode(node, rounded), expected, nullptr, nullptr);
        ASSERT_EQ(Image<Real>::force(image, &tool, got), status) << name(family);
        force.add(expected, got, 3);
        if (family != Family::rbfn) {
          phn_force(loaded.model, loaded.data, AtNode(node, rounded), nullptr, expected, nullptr);
          ASSERT_EQ(Image<Real>::energy(image, &tool, got), status);
          energy.add(expected, got, 1);
          phn_force(loaded.model, loaded.data, AtNode(node, rounded), nullptr, nullptr, expected);
          ASSERT_EQ(Image<Real>::stiffness(image, &tool, got), status);
          stiffness.add(expected, got, 9);
        } else {
          ASSERT_EQ(Image<Real>::energy(image, &tool, got), PHN_ERROR_UNDEFINED);
          ASSERT_EQ(Image<Real>::stiffness(image, &tool, got), PHN_ERROR_UNDEFINED);
        }
        const Trained trained(loaded.model, node, rounded);
        ASSERT_EQ(Image<Real>::depth(image, &tool, got), trained.status);
        depth.add(&trained.depth, got, 1);
        std::vector<double> u(opened.n_field());
        std::vector<Real> v(opened.n_field()), scratch(opened.n_scratch());
        phn_deform(loaded.model, loaded.data, AtNode(node, rounded), u.data());
        ASSERT_EQ(Image<Real>::deform(image, scratch.data(), &tool, v.data()), status);
        field.add(u.data(), v.data(), v.size());
        if (family == Family::rbfn || d != Vec3{0, 0, 0}) continue;
        Image<Real>::force(image, &tool, got);
        Image<Real>::energy(image, &tool, got + 3);
        EXPECT_EQ(std::count(got, got + 4, Real(0)), 4);
        EXPECT_EQ(std::count(v.begin(), v.end(), Real(0)), std::ssize(v));
      }
    }
    for (const auto& difference : {force, energy, stiffness, depth})
      EXPECT_LT(difference.relative(), tolerance<Real>) << name(family);
    EXPECT_LT(field.relative(), std::max(family == Family::modal ? 1e-6 : 0.0, tolerance<Real>)) << name(family);
  }
}

TYPED_TEST(Answers, AreTheRuntimesInside) { answers_are_the_runtimes<TypeParam>(near_displacements()); }
TYPED_TEST(Answers, AreTheRuntimesFarBeyond) { answers_are_the_runtimes<TypeParam>(far_displacements()); }

std::vector<std::string> words_of(const phn_provenance& p) {
  std::vector<std::string> words{p.mesh_hash, p.physics_hash, p.element, p.reference};
  for (const double number : {p.shear_modulus_Pa, p.finer_mean, p.finer_p95, p.finer_tool_radius_m,
                              double(p.finer_probes), double(p.finer_nodes), double(p.bound_reference)})
    words.push_back(std::to_string(number));
  return words;
}

/// The provenance of a model, recorded or not, is the same in its image and in the runtime.
TYPED_TEST(Answers, SayWhereTheModelComesFrom) {
  using Real = TypeParam;
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    Model model = small_model_of(family);
    for (const bool recorded : {false, true}) {
      if (recorded) {
        model.solved = {true, "es-p1-p1", 1e3 / 3};
        model.relaxation.terms.resize(2, 2);
        model.relaxation.terms << 0.3, 2, 1.0 / 3, 20;
        model.relaxation.length_m = 0.03;
        model.finer = {true, "es-p1-p1", "taylor-hood", 11, 0.03, 0.04, 1.0 / 11, 300, 12};
        if (family != Family::linear) {
          model = with_bound_between(model);
          model.bounds[0].reference = 2;
        }
      }
      const LoadedModel loaded(write_model_text(model));
      OpenedImage<Real> opened(model_image(model, {false, sizeof(Real) == 4}));
      const phn_provenance& said = opened.contents.provenance;
      const auto& of_runtime = info_of(loaded.model).provenance;
      EXPECT_EQ(words_of(said), words_of(of_runtime));
      EXPECT_EQ(said.mesh_hash, model.mesh_hash);
      const auto relaxation = info_of(loaded.model).relaxation;
      EXPECT_EQ(relaxation.n_terms, recorded ? 2 : 0);
      EXPECT_EQ(std::memcmp(&opened.contents.relaxation, &relaxation, sizeof relaxation), 0);
      EXPECT_EQ(said.physics_hash, model.physics_hash);
      EXPECT_STREQ(said.element, recorded ? "es-p1-p1" : "");
      EXPECT_EQ(said.shear_modulus_Pa, recorded ? 1e3 / 3 : 0);
      EXPECT_EQ(said.finer_p95, recorded ? 1.0 / 11 : 0);
      EXPECT_EQ(said.finer_nodes, recorded ? 300 : 0);
      EXPECT_EQ(said.bound_reference, recorded && family != Family::linear ? 2 : 0);
    }
  }
  typename Image<Real>::Contents said;
  said.n_active = 7;
  EXPECT_EQ(Image<Real>::info(nullptr, &said), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(said.n_active, 0);
  EXPECT_STREQ(said.provenance.element, "");
  EXPECT_EQ(Image<Real>::info(nullptr, nullptr), PHN_ERROR_ARGUMENT);
}

TYPED_TEST(Answers, ToBadQuestionsAreZeros) {
  using Real = TypeParam;
  const Model model = small_model_of(Family::modal);
  const OpenedImage<Real> opened(model_image(model, {true, sizeof(Real) == 4}));
  EXPECT_EQ(opened.contents.n_output, 0);
  EXPECT_EQ(opened.n_scratch(), 0U);
  const Real d[3] = {0, 0, Real(-0.01)}, huge = std::numeric_limits<Real>::max();
  const auto good = Image<Real>::tool_at(3, d);
  Real out[9];
  const auto refused = [&](const auto* image, const auto* tool, int status) {
    const auto check = [&](auto function, std::ptrdiff_t n, Real value = 0) {
      std::fill(out, out + n, Real(1));
      EXPECT_EQ(function(image, tool, out), status);
      EXPECT_EQ(std::count(out, out + n, value), n);
    };
    check(Image<Real>::force, 3);
    check(Image<Real>::energy, 1);
    check(Image<Real>::stiffness, 9);
    check(Image<Real>::depth, 1);
    check(Image<Real>::bound, 1, PHN_IMAGE_NO_BOUND);
  };
  for (const std::int32_t node : {4, 0, -2, std::numeric_limits<std::int32_t>::min()}) {
    const auto elsewhere = Image<Real>::tool_at(node, d);
    refused(opened.image, &elsewhere, PHN_ERROR_NOT_ACTIVE);
  }
  const auto nowhere = Image<Real>::tool_at(-1, d);
  refused(opened.image, &nowhere, PHN_ERROR_UNDEFINED);
  for (const Real bad : {std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::quiet_NaN()}) {
    auto tool = good;
    tool.displacement[1] = bad;
    refused(opened.image, &tool, PHN_ERROR_NOT_FINITE);
  }
  for (int word = 0; word < 2; ++word) {
    auto tool = good;
    tool.reserved[word] = 1;
    refused(opened.image, &tool, PHN_ERROR_VERSION);
  }
  const std::nullptr_t none = nullptr;
  refused(static_cast<const typename Image<Real>::Type*>(none), &good, PHN_ERROR_ARGUMENT);
  refused(opened.image, static_cast<const typename Image<Real>::Tool*>(none), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(Image<Real>::force(opened.image, &good, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(Image<Real>::bound(opened.image, &good, out), PHN_ERROR_UNDEFINED);  // of a model of node probes
  EXPECT_EQ(Image<Real>::deform(opened.image, nullptr, &good, out), PHN_ERROR_UNDEFINED);
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    const OpenedImage<Real> other(model_image(small_model_of(family), {true, sizeof(Real) == 4}));
    const Real away[3] = {huge, -huge, huge};
    const auto tool = Image<Real>::tool_at(3, away);
    EXPECT_EQ(Image<Real>::force(other.image, &tool, out), PHN_WARNING_OUTSIDE);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(out[k])) << name(family);
    Image<Real>::energy(other.image, &tool, out);
    EXPECT_TRUE(std::isfinite(out[0]));
  }
}

// Claim: inputs are read before outputs are written over them; a deformation over its working memory is refused.
TYPED_TEST(Answers, MayOverlapTheirQuestions) {
  using Real = TypeParam;
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    const OpenedImage<Real> opened(model_image(small_model_of(family), {false, sizeof(Real) == 4}));
    const auto n = opened.n_field();
    const Real d[3] = {Real(0.002), Real(-0.001), Real(0.003)};
    const auto tool = Image<Real>::tool_at(8, d);
    std::vector<Real> scratch(opened.n_scratch()), field(n), over(n + sizeof tool / sizeof(Real));
    auto in_place = tool;
    Real force[3];
    EXPECT_EQ(Image<Real>::force(opened.image, &tool, force),
              Image<Real>::force(opened.image, &in_place, in_place.displacement));
    EXPECT_TRUE(std::equal(force, force + 3, in_place.displacement));
    std::memcpy(over.data(), &tool, sizeof tool);
    EXPECT_EQ(Image<Real>::deform(opened.image, scratch.data(), &tool, field.data()),
              Image<Real>::deform(opened.image, scratch.data(),
                                  reinterpret_cast<const typename Image<Real>::Tool*>(over.data()), over.data()));
    EXPECT_TRUE(std::equal(field.begin(), field.end(), over.begin()));
    if (scratch.empty()) continue;
    EXPECT_EQ(Image<Real>::deform(opened.image, over.data(), &tool, over.data()), PHN_ERROR_OVERLAP);
    EXPECT_EQ(over[1], 0);
  }
}

// Claim: of a model with levels an image holds the full one, byte by byte.
TEST(ModelImage, HoldsTheFullLevel) {
  const Model model = small_modal_model();
  EXPECT_EQ(model_image(with_levels(model), {false, false}).bytes, model_image(model, {false, false}).bytes);
}

/// Why an image cannot be made; empty if it can.
std::string refusal(const Model& model, bool floats) {
  return error_of([&] { model_image(model, {false, floats}); });
}

/// Claim: what a float or an image cannot hold is refused in words that can be read, not cut.
TEST(ModelImage, RefusesWhatDoesNotFit) {
  Model model = small_linear_model();
  model.nodes[1].linear.stiffness(0, 0) = 1e13;
  EXPECT_NO_THROW(model_image(model, {false, false}));
  EXPECT_THROW(model_image(model, {false, true}), Error);
  model = small_model();
  model.max_displacement_m = 1e7;
  EXPECT_NO_THROW(model_image(model, {false, false}));
  EXPECT_THROW(model_image(model, {false, true}), Error);
  EXPECT_EQ(refusal(model, true),
            "the model does not fit an image of floats: the largest displacement [m] is out of range: 1e+07\n"
            "  remedy: export it without --float");
  model.max_displacement_m = 1e300;
  EXPECT_EQ(refusal(model, false),
            "the model does not fit an image of doubles: the largest displacement [m] is out of range: 1e+300\n"
            "  remedy: train it in metres and newtons");
  model = small_modal_model();
  model.displacements *= 1.1e6;
  EXPECT_NE(refusal(model, false).find("a displacement over the largest one"), std::string::npos);
  model = small_model();
  model.displacements.conservativeResize(65536, 3);
  model.displacements.bottomRows(65528).setZero();
  EXPECT_THROW(model_image(model, {false, false}), Error);
}

}  // namespace
}  // namespace phynness::test
