#include <limits>

#include "../runtime/fine_surface.hpp"
#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN(),
                 tiny = std::numeric_limits<double>::denorm_min(), huge = std::numeric_limits<double>::max();

bool finite(const phn_contact_state& s) {
  bool all = std::isfinite(s.unbalanced) && std::isfinite(s.scale);
  for (int k = 0; k < 3; ++k)
    for (const double x : {s.force[k], s.proxy[k], s.normal[k], s.held.weights[k], s.held.displacement[k]})
      all = all && std::isfinite(x);
  return all;
}

class EveryFamily : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Contact, EveryFamily, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

// Claim: whatever comes, in whatever order, the answer is finite; what is not a number is refused with zeros.
// Models whose nodes contradict each other included.
TEST_P(EveryFamily, AnswersAreFinite) {
  const LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  Touch touch(loaded);
  Numbers numbers;
  const double odd[] = {nan, inf, -inf, huge, -huge, 1e30, -1e30, 1e300, tiny, -tiny, 0, 1, -1, 1e-300};
  const auto draw = [&](double common) {
    const int i = static_cast<int>(1e6 * (numbers.next() + 1));
    return i % 7 == 0 ? odd[static_cast<std::size_t>(i / 7) % std::size(odd)] : common * numbers.next();
  };
  int n_contacts = 0, n_refused = 0;
  Points field(info_of(loaded.model).n_output, 3);
  for (int i = 0; i < 20000; ++i) {
    std::vector<phn_contact_tool> tools(static_cast<std::size_t>(i % 5));
    bool good = true;
    for (auto& tool : tools) {
      tool = {{draw(0.06), draw(0.06), draw(0.06)}, std::abs(draw(0.01)), std::abs(draw(1)), (i * 7 + i / 3) % 3};
      for (const double x : {tool.center[0], tool.center[1], tool.center[2], tool.radius, tool.friction})
        good = good && std::isfinite(x);
    }
    std::vector<phn_contact_state> states(tools.size());
    phn_contact_report report = {nan, nan, nan, 0};
    const int status =
        phn_contact_step(touch.contact, static_cast<int>(tools.size()), tools.data(), states.data(), &report);
    ASSERT_EQ(status, good ? std::max(status, 0) : PHN_ERROR_NOT_FINITE);
    ASSERT_TRUE(std::isfinite(report.energy) && std::isfinite(report.residual_m));
    for (std::size_t t = 0; t < tools.size(); ++t) {
      const phn_contact_state& s = states[t];
      ASSERT_TRUE(finite(s));
      n_contacts += s.in_contact;
      if (tools[t].mode != PHN_TOOL_PRESS) continue;
      ASSERT_LE(vector(s.force).dot(vector(s.normal)), 0);
    }
    n_refused += status < 0;
    ASSERT_GE(phn_contact_deform(touch.contact, field.data()), 0);
    ASSERT_TRUE(field.allFinite());
  }
  EXPECT_GT(n_contacts, 500);
  EXPECT_GT(n_refused, 500);
}

// Claim: a tool of no size, of denormal size, and one larger than the body touch as any other; a coefficient
// of 1e30 sticks.
TEST(Contact, ExtremeToolsTouch) {
  for (const double radius : {0.0, tiny, 1e-300, 1e-9, 0.3, 1e30})
    for (const double mu : {0.0, tiny, 1e30}) {
      Touch touch(bent_ball());
      const double size = touch.contact == nullptr ? 0 : std::min(radius, 0.1 * std::sqrt(3.0));
      touch.step(tool_at({0, 0, 1}, radius, PHN_TOOL_PRESS, mu));
      const auto state = touch.step(tool_at({0, 0, 0.045 + size}, radius, PHN_TOOL_PRESS, mu));
      EXPECT_EQ(state.in_contact, 1) << radius;
      EXPECT_TRUE(finite(state));
      EXPECT_LT(state.force[2], -0.05);
    }
}

// Claim: ten thousand tools are refused, with zeros for every one of them; so is other misuse, by name.
TEST(Contact, MisuseIsNamed) {
  Touch touch(linear_ball(), 2);
  const phn_model* model = touch.loaded.model;
  const std::vector<phn_contact_tool> tools(10000, tool_at({0, 0, 0.04}, 0.004));
  std::vector<phn_contact_state> states(10000);
  for (auto& s : states) s.force[0] = s.proxy[1] = nan;
  EXPECT_EQ(phn_contact_step(touch.contact, 10000, tools.data(), states.data(), nullptr), PHN_ERROR_TOOLS);
  for (const auto& s : states) ASSERT_TRUE(finite(s) && s.force[0] == 0 && s.held.nodes[0] == -1);
  EXPECT_EQ(phn_contact_step(touch.contact, 3, tools.data(), states.data(), nullptr), PHN_ERROR_TOOLS);
  EXPECT_EQ(phn_contact_step(touch.contact, -1, tools.data(), states.data(), nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_step(touch.contact, 1, nullptr, states.data(), nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_step(touch.contact, 1, tools.data(), nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_step(nullptr, 1, tools.data(), states.data(), nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_step(touch.contact, 0, nullptr, nullptr, nullptr), PHN_OK);
  for (const phn_contact_tool& bad : {tool_at({0, 0, 0}, -1), tool_at({0, 0, 0}, 1, 3), tool_at({0, 0, 0}, 1, -1),
                                      tool_at({0, 0, 0}, 1, PHN_TOOL_PRESS, -0.1)})
    EXPECT_EQ(phn_contact_step(touch.contact, 1, &bad, states.data(), nullptr), PHN_ERROR_ARGUMENT);
  std::size_t bytes = 1;
  phn_contact* contact = nullptr;
  std::vector<char> memory(1 << 20);
  EXPECT_EQ(phn_contact_size(model, 0, &bytes), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(bytes, 0u);
  EXPECT_EQ(phn_contact_size(model, 10000, &bytes), PHN_ERROR_TOO_MANY_TOOLS);
  EXPECT_EQ(phn_contact_size(nullptr, 1, &bytes), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_size(model, 1, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_init(memory.data(), memory.size(), model, 9, &contact), PHN_ERROR_TOO_MANY_TOOLS);
  EXPECT_EQ(phn_contact_init(nullptr, 1, model, 1, &contact), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_init(memory.data(), 100, model, 1, &contact), PHN_ERROR_BUFFER);
  EXPECT_EQ(phn_contact_init(memory.data(), 100, model, 1, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(contact, nullptr);
  EXPECT_EQ(phn_contact_reset(nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_deform(nullptr, &states[0].scale), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_contact_deform(touch.contact, nullptr), PHN_ERROR_ARGUMENT);
  phn_contact_tool other = tool_at({0, 0, 0.06}, 0.004);
  other.reserved = 1;
  EXPECT_EQ(phn_contact_step(touch.contact, 1, &other, states.data(), nullptr), PHN_ERROR_VERSION);
  // A refused call leaves the tools where they were.
  Touch pressed(linear_ball());
  const auto good = tool_at({0, 0, 0.05}, 0.004);
  pressed.step(tool_at({0, 0, 0.06}, 0.004));
  pressed.step(good);
  const auto wrong = tool_at({nan, 0, 0}, 0.004);
  EXPECT_EQ(phn_contact_step(pressed.contact, 1, &wrong, states.data(), nullptr), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(pressed.step(good).in_contact, 1);
}

// Claim: surfaces of which nothing can be touched are named, others are searched, whatever they look like;
// the stated size suffices at any alignment.
TEST(Contact, AnySurfaceIsSearchedOrRefused) {
  Model bare = small_linear_model();
  bare.surface.resize(0, 3);
  Model far = linear_model(ball());
  far.output_points *= 1e31;  // as far as a model may be: 1e30 m
  for (auto& node : far.nodes)
    for (double& x : node.point) x *= 1e31;
  std::size_t bytes = 0;
  const LoadedModel without(write_model_text(bare)), wide(write_model_text(far));
  phn_contact* contact = nullptr;
  const auto init = [&](const phn_model* model) {
    EXPECT_EQ(phn_contact_size(model, 1, &bytes), PHN_OK);
    std::vector<char> memory(bytes);
    return phn_contact_init(memory.data(), bytes, model, 1, &contact);
  };
  EXPECT_EQ(init(without.model), PHN_ERROR_UNDEFINED);
  Touch distant(wide);
  for (const double x : {0.0, 1e28, 2e29, 4e29, -1e30, 0.001})
    EXPECT_TRUE(finite(distant.step(tool_at({x, 1e28, -x}, 1e27, 1, 0.3))));
  for (const Body& body : bodies()) {
    const LoadedModel untouched(text_of(body));  // no active nodes
    EXPECT_EQ(init(untouched.model), PHN_ERROR_UNDEFINED);
    Skin shape;
    for (const auto& x : body.points) shape.points.push_back(0.03 * x.transpose());
    shape.triangles.assign(body.triangles.begin(), body.triangles.end());
    shape.n_fixed = body.n_fixed;
    if (body.n_output() == 0) continue;
    const LoadedModel loaded(write_model_text(linear_model(shape)));
    ASSERT_EQ(phn_contact_size(loaded.model, 1, &bytes), PHN_OK);
    for (std::size_t shift = 0; shift < 64; shift += 7) {
      std::vector<char> exact(bytes + shift);
      ASSERT_EQ(phn_contact_init(exact.data() + shift, bytes, loaded.model, 1, &contact), PHN_OK);
      ASSERT_EQ(phn_contact_init(exact.data() + shift, bytes - 64, loaded.model, 1, &contact), PHN_ERROR_BUFFER);
    }
    Touch touch(loaded);
    Numbers numbers;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d c = 0.05 * numbers.vector();
      ASSERT_TRUE(finite(touch.step(tool_at(c, i % 2 == 0 ? 0 : 0.01, 1 + i / 50 % 2, i % 3))));
    }
  }
}

// Claim: beside fixed edges forces stay finite and in the cone, and a tool that slides there stays on what
// can be touched.
TEST(Contact, FixedEdgesAreWalls) {
  const LoadedModel loaded(write_model_text(linear_model(held_ball())));
  Touch touch(loaded);
  int n_near = 0;
  for (int i = 0; i < 3000; ++i) {
    const double turn = 0.8 * std::sin(0.01 * i) + 2.0, depth = 0.002 * std::sin(0.013 * i);
    const Vector3d at(std::sin(turn), 0.2 * std::sin(0.004 * i), std::cos(turn));
    const double mu = i % 500 > 250 ? 0.2 : 0;
    const auto state = touch.step(tool_at((0.054 - depth) * at.normalized(), 0.004, PHN_TOOL_PRESS, mu));
    ASSERT_TRUE(finite(state));
    ASSERT_LE(vector(state.force).dot(vector(state.normal)), 0);
    if (!state.in_contact) continue;
    double moves = 0;
    for (int k = 0; k < 3; ++k)
      moves += state.held.nodes[k] < info_of(loaded.model).n_output ? state.held.weights[k] : 0;
    ASSERT_GE(moves, 0.05 - 1e-12);
    n_near += moves < 0.5;
  }
  EXPECT_GT(n_near, 50);
}

}  // namespace
