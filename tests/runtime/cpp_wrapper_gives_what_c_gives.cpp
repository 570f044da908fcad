// Claims: phynness.hpp gives the bits and statuses of phynness.h, owns its memory or uses that of the caller, can be
// moved, takes vectors of Eigen, and refuses arrays of a wrong length.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <phynness/phynness.hpp>
#include <phynness/phynness_contact.hpp>
#include <phynness/phynness_surface.hpp>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace phynness::test {
namespace {

template <class To, class From>
constexpr bool takes = std::is_convertible_v<From, To>;
static_assert(takes<rt::In3, const double (&)[3]> && takes<rt::In3, double (&)[3]>);
static_assert(takes<rt::In3, const std::array<double, 3>&> && takes<rt::Out3, std::array<double, 3>&>);
static_assert(takes<rt::In3, const Eigen::Vector3d&> && takes<rt::Out3, Eigen::Vector3d&>);
static_assert(takes<rt::Out9, Eigen::Matrix3d&> && takes<rt::Out3, Eigen::Map<Eigen::Vector3d>&>);
static_assert(!takes<rt::In3, const double (&)[2]> && !takes<rt::In3, const double (&)[4]>);
static_assert(!takes<rt::In3, const std::array<double, 2>&> && !takes<rt::In3, const std::array<float, 3>&>);
static_assert(!takes<rt::Out3, const double (&)[3]> && !takes<rt::Out3, const std::array<double, 3>&>);
static_assert(!takes<rt::In3, const Eigen::VectorXd&> && !takes<rt::Out9, Eigen::Vector3d&>);
static_assert(!takes<rt::Out3, Eigen::Map<Eigen::Vector3d, 0, Eigen::InnerStride<2>>&>);
static_assert(!std::is_copy_constructible_v<rt::Model> && !std::is_copy_constructible_v<rt::Data>);
static_assert(std::is_nothrow_move_constructible_v<rt::Model> && sizeof(rt::Status) == sizeof(int));

class Wrapper : public ::testing::TestWithParam<Family> {
 protected:
  std::string text = write_model_text(GetParam() == Family::linear ? small_linear_model()
                                                                   : with_bound_between(small_model_of(GetParam())));
  LoadedModel c{text};
};
INSTANTIATE_TEST_SUITE_P(Families, Wrapper, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Wrapper, GivesTheSameBits) {
  const rt::Model model(text);
  ASSERT_TRUE(model && model.status() == PHN_OK);
  rt::Data data(model, 4);
  ASSERT_TRUE(data);
  EXPECT_EQ(model.n_output(), info_of(c.model).n_output);
  const Model written = small_model_of(GetParam());
  EXPECT_EQ(model.info().family, std::string(name(GetParam())));
  EXPECT_EQ(model.info().title, written.title);
  EXPECT_EQ(model.info().mesh_hash, written.mesh_hash);
  EXPECT_EQ(model.info().max_displacement_m, written.max_displacement_m);
  EXPECT_EQ(model.info().has_energy, GetParam() == Family::rbfn ? 0 : 1);
  EXPECT_EQ(model.active_nodes().size(), 4u);
  EXPECT_EQ(model.triangles().size(), 12u);
  using Array = std::array<double, 3>;
  const Array outside = {0.1, -0.2, 0.3}, nan = {0, NAN, 0}, inside = {0.001, -0.002, 0.003};
  for (const std::int32_t node : {3, 5, 8, 15, 4, -1}) {
    for (const Array& at : {inside, outside, nan}) {
      const double* d = at.data();
      double expected[9], got[9];
      Array force;
      EXPECT_EQ(data.force(node, at, force), phn_force(c.model, c.data, node, d, expected, nullptr, nullptr));
      EXPECT_EQ(std::memcmp(force.data(), expected, 24), 0);
      EXPECT_EQ(data.energy(node, at, *got), phn_force(c.model, c.data, node, d, nullptr, expected, nullptr));
      EXPECT_EQ(std::memcmp(got, expected, 8), 0);
      EXPECT_EQ(data.stiffness(node, at, got), phn_force(c.model, c.data, node, d, nullptr, nullptr, expected));
      EXPECT_EQ(std::memcmp(got, expected, 72), 0);
      double energy = 1;
      double at_once[3] = {}, energy_at_once = 1;
      EXPECT_EQ(data.force(node, at, force, energy, got),
                phn_force(c.model, c.data, node, d, at_once, &energy_at_once, expected));
      EXPECT_EQ(std::memcmp(force.data(), at_once, 24), 0);
      EXPECT_EQ(energy, energy_at_once);
      EXPECT_EQ(std::memcmp(got, expected, 72), 0);
      const Trained expected_trained(c.model, node, d);
      double depth = -2;
      EXPECT_EQ(model.trained_depth(node, at, depth), expected_trained.status);
      EXPECT_EQ(depth, expected_trained.depth);
      double bound = -1, expected_bound = -2;
      EXPECT_EQ(model.bound(node, at, bound), phn_bound(c.model, node, d, &expected_bound));
      EXPECT_EQ(bound, expected_bound);
      EXPECT_EQ(data.prepare(node), phn_prepare(c.model, c.data, node));
      std::vector<double> field(36, 1), expected_field(36, 2);
      EXPECT_EQ(data.deform(node, at, field), phn_deform(c.model, c.data, node, d, expected_field.data()));
      EXPECT_EQ(field, expected_field);
    }
  }
  const std::vector<std::int32_t> nodes{3, 8};
  const std::vector<double> d{0.001, 0, 0, 0, 0.002, 0};
  std::vector<double> field(36), expected(36);
  EXPECT_EQ(data.blend_paper(nodes, d, field),
            phn_blend_paper(c.model, c.data, 2, nodes.data(), d.data(), expected.data()));
  EXPECT_EQ(field, expected);

  phn_tool tools[2];
  double point[3];
  EXPECT_EQ(model.nearest(inside, tools[0], point), PHN_OK);
  EXPECT_EQ(model.nearest(outside, tools[1]), PHN_OK);
  tools[0].displacement[1] = tools[1].displacement[2] = 0.002;
  double forces[6], expected_forces[6];
  phn_coupled result, expected_result;
  EXPECT_EQ(data.couple(tools, forces, &result),
            phn_couple(c.model, c.data, 2, tools, expected_forces, &expected_result));
  EXPECT_EQ(std::memcmp(forces, expected_forces, sizeof forces), 0);
  EXPECT_EQ(result.energy, expected_result.energy);
  EXPECT_EQ(data.coupled_deform(field), phn_coupled_deform(c.model, c.data, expected.data()));
  EXPECT_EQ(field, expected);
  phn_tool at_node = {{8, -1, -1}, {1, 0, 0}, {0.001, 0.002, -0.003}};
  EXPECT_EQ(data.force(at_node, point), phn_force_at(c.model, c.data, &at_node, expected_forces, nullptr, nullptr));
  EXPECT_EQ(std::memcmp(point, expected_forces, 24), 0);
  double energy = 1, expected_energy = 2, stiffness[9] = {}, expected_stiffness[9] = {}, bound = 1, expected_bound = 2;
  EXPECT_EQ(data.force(at_node, point, energy, stiffness),
            phn_force_at(c.model, c.data, &at_node, expected_forces, &expected_energy, expected_stiffness));
  EXPECT_EQ(energy, expected_energy);
  EXPECT_EQ(std::memcmp(stiffness, expected_stiffness, 72), 0);
  EXPECT_EQ(model.trained_depth(at_node, bound), phn_trained_depth_at(c.model, &at_node, &expected_bound));
  EXPECT_EQ(bound, expected_bound);
  EXPECT_EQ(model.bound(at_node, bound), phn_bound_at(c.model, &at_node, &expected_bound));
  EXPECT_EQ(bound, expected_bound);
  EXPECT_EQ(data.couple(tools[0], point), phn_couple(c.model, c.data, 1, tools, expected_forces, nullptr));
  EXPECT_EQ(std::memcmp(point, expected_forces, sizeof point), 0);

  std::size_t n_bytes = 0;
  const rt::Surface surface(model, 2);
  ASSERT_TRUE(surface);
  std::vector<float> scratch(surface.n_scratch()), fine(3 * static_cast<std::size_t>(surface.n_vertices()));
  EXPECT_EQ(surface.deform(scratch, field, fine), PHN_OK);
  EXPECT_EQ(surface.points().size(), fine.size());

  rt::Contact contact(model, 1);
  ASSERT_EQ(contact.status(), phn_contact_size(c.model, 1, &n_bytes));
  std::vector<char> memory(n_bytes);
  phn_contact* expected_contact = nullptr;
  ASSERT_EQ(phn_contact_init(memory.data(), n_bytes, c.model, 1, &expected_contact), PHN_OK);
  for (const double z : {2.0, 1.0, 0.5, 0.4}) {
    const phn_contact_tool sphere{{0.3, 0.2, z}, 0.1, 0, PHN_TOOL_PRESS};
    phn_contact_state state, expected_state;
    EXPECT_EQ(contact.step(data, sphere, state),
              phn_contact_step(expected_contact, c.data, 1, &sphere, &expected_state, nullptr));
    EXPECT_EQ(std::memcmp(&state, &expected_state, sizeof state), 0);
  }
}

TEST_P(Wrapper, MovesAndUsesMemoryOfItsUser) {
  std::vector<std::byte> own(rt::Model::bytes_for(text));
  rt::Model model(text, own);
  ASSERT_TRUE(model);
  const auto* at = reinterpret_cast<const std::byte*>(model.get());
  EXPECT_TRUE(at >= own.data() && at < own.data() + own.size());
  EXPECT_EQ(rt::Model(text, rt::Span<std::byte>(own.data(), own.size() / 2)).status(), PHN_ERROR_BUFFER);
  model = rt::Model(text);
  std::vector<std::byte> scratch(rt::Data::bytes_for(model, 2));
  rt::Data data(model, 2, scratch);
  ASSERT_TRUE(data);
  const rt::Model moved = std::move(model);
  rt::Data moved_data = std::move(data);
  EXPECT_FALSE(model);  // NOLINT(bugprone-use-after-move): what a move leaves is the claim
  EXPECT_FALSE(data);   // NOLINT(bugprone-use-after-move)
  const double d[3] = {0.001, 0, 0};
  double force[3];
  EXPECT_GE(moved_data.force(3, d, force), 0);
  EXPECT_EQ(data.force(3, d, force), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(force[0], 0);
}

TEST_P(Wrapper, MisuseHasAStatus) {
  const rt::Model none, bad("solid liver"), model(text);
  EXPECT_EQ(none.status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(bad.status(), PHN_ERROR_NOT_A_MODEL);
  EXPECT_STREQ(bad.status().message(), phn_status_message(PHN_ERROR_NOT_A_MODEL));
  EXPECT_EQ(rt::Model::read("/no/such/model.txt").status(), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(rt::Data(bad, 1).status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(rt::Data(model, 0).status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(rt::Surface(bad, 1).status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(bad.n_output(), 0);
  EXPECT_EQ(bad.active_nodes().size(), 0u);
  rt::Data data(model, 1);
  const double d[3] = {0.001, 0, 0};
  std::vector<double> shorter(35, 7);
  EXPECT_EQ(data.deform(3, d, shorter), PHN_ERROR_BUFFER);
  EXPECT_EQ(data.coupled_deform(shorter), PHN_ERROR_BUFFER);
  EXPECT_EQ(data.field(3, d, 0, rt::Span<double>(shorter.data(), 11)), PHN_ERROR_BUFFER);
  EXPECT_EQ(shorter, std::vector<double>(35, 7));
  std::vector<double> field(36);
  const std::vector<std::int32_t> two{3, 5};
  EXPECT_EQ(data.blend_paper(two, rt::Span<const double>(d, 3), field), PHN_ERROR_BUFFER);
  EXPECT_EQ(data.blend_paper(two, field, field), PHN_ERROR_TOOLS);
  const phn_tool tools[2] = {};
  EXPECT_EQ(data.couple(tools, rt::Span<double>(field.data(), 5)), PHN_ERROR_BUFFER);
  rt::Status status(PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE);
  EXPECT_TRUE(status.ok() && status.outside() && status.incomplete() && !status.unsettled());
  status = PHN_ERROR_ARGUMENT;
  EXPECT_FALSE(status.ok() || status.outside() || status.incomplete());
}

}  // namespace
}  // namespace phynness::test
