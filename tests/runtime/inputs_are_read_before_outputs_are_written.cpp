// Claim: a function gives the same bits and status if its output overlaps its input at any offset. Outputs that overlap
// each other, and inputs that are too large to be copied, are refused with zeros as output.
#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_surface.h>

#include <cstring>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace phynness::test {
namespace {

class Overlap : public ::testing::TestWithParam<Family> {
 protected:
  const std::string text = write_model_text(
      GetParam() == Family::linear ? small_linear_model()
                                   : with_bounds(GetParam() == Family::modal ? small_field_model() : small_model()));
  const LoadedModel loaded{text};
  const phn_model* model = loaded.model;
  phn_data* data = loaded.data;
  const std::vector<double> d = {0.002, -0.001, 0.003};
  const std::size_t n_output = static_cast<std::size_t>(info_of(model).n_output);
};
INSTANTIATE_TEST_SUITE_P(Families, Overlap, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

/// Calls call(input, output) with n_out numbers of output behind the input, then everywhere over it.
template <class In, class Call>
void expect_same_over(const char* what, const std::vector<In>& input, std::size_t n_out, Call call) {
  const std::size_t in_bytes = sizeof(In) * input.size(), out_bytes = sizeof(double) * n_out;
  std::vector<double> memory((in_bytes + 2 * out_bytes) / sizeof(double) + 1), expected(n_out);
  auto* bytes = reinterpret_cast<char*>(memory.data());
  const auto status_at = [&](std::size_t offset) {
    std::memset(bytes, 0x25, memory.size() * sizeof(double));
    std::memcpy(bytes + out_bytes, input.data(), in_bytes);
    return call(reinterpret_cast<In*>(bytes + out_bytes), reinterpret_cast<double*>(bytes + offset));
  };
  const int status = status_at(0);
  EXPECT_GE(status, PHN_ERROR_UNDEFINED) << what;
  std::memcpy(expected.data(), bytes, out_bytes);
  const std::size_t end = (out_bytes + in_bytes) / sizeof(double);
  for (std::size_t at = 1; at <= end; at += 1 + end / 50) {
    EXPECT_EQ(status_at(sizeof(double) * at), status) << what << " " << at;
    EXPECT_EQ(std::memcmp(bytes + sizeof(double) * at, expected.data(), out_bytes), 0) << what << " " << at;
  }
}

TEST_P(Overlap, OfAnInputChangesNothing) {
  const auto row = [&](const char* what, std::size_t n, auto call) { expect_same_over(what, d, n, call); };
  row("force", 3, [&](double* x, double* out) { return phn_force(model, data, AtNode(8, x), out, nullptr, nullptr); });
  row("energy", 1, [&](double* x, double* out) { return phn_force(model, data, AtNode(8, x), nullptr, out, nullptr); });
  row("stiffness", 9,
      [&](double* x, double* out) { return phn_force(model, data, AtNode(8, x), nullptr, nullptr, out); });
  row("field", n_output, [&](double* x, double* out) { return phn_field(model, data, AtNode(8, x), 1, out); });
  row("deform", 3 * n_output, [&](double* x, double* out) { return phn_deform(model, data, AtNode(8, x), out); });
  row("depth", 1, [&](double* x, double* out) { return phn_depth(model, AtNode(8, x), out); });
  row("bound", 1, [&](double* x, double* out) { return phn_bound(model, AtNode(8, x), out); });
  row("nearest", 3, [&](double* x, double* out) {
    phn_tool tool;
    return phn_nearest(model, x, &tool, out, nullptr);
  });
  const std::vector<phn_tool> one = {{{8, -1, -1}, {1, 0, 0}, {0.001, 0.002, 0}}},
                              two = {one[0], {{3, 5, 8}, {0.5, 0.25, 0.25}, {0.001, -0.002, 0.001}}};
  expect_same_over("force at", one, 3,
                   [&](phn_tool* tool, double* out) { return phn_force(model, data, tool, out, nullptr, nullptr); });
  expect_same_over("depth at", one, 1, [&](phn_tool* tool, double* out) { return phn_depth(model, tool, out); });
  expect_same_over("bound at", one, 1, [&](phn_tool* tool, double* out) { return phn_bound(model, tool, out); });
  expect_same_over("couple", two, 6,
                   [&](phn_tool* tools, double* out) { return phn_couple(model, data, 2, tools, out, nullptr); });
}

TEST_P(Overlap, OfOutputsAndLargeInputsIsRefused) {
  std::vector<double> out(100, 1);
  EXPECT_EQ(phn_force(model, data, AtNode(8, d.data()), &out[0], &out[2], nullptr), PHN_ERROR_OVERLAP);
  EXPECT_EQ(out[0] + out[1] + out[2], 0);
  const std::vector<phn_tool> tools(1, {{8, -1, -1}, {1, 0, 0}, {0.001, 0.002, 0}});
  EXPECT_EQ(phn_force(model, data, tools.data(), &out[0], nullptr, &out[2]), PHN_ERROR_OVERLAP);
  auto* over = reinterpret_cast<phn_coupled*>(&out[1]);
  EXPECT_EQ(phn_couple(model, data, 1, tools.data(), &out[0], over), PHN_ERROR_OVERLAP);
  auto* tool = reinterpret_cast<phn_tool*>(&out[0]);
  EXPECT_EQ(phn_nearest(model, d.data(), tool, &out[1], nullptr), PHN_ERROR_OVERLAP);

  std::size_t bytes = 0;
  EXPECT_EQ(phn_model_size(text.data(), text.size(), &bytes, &bytes), PHN_ERROR_OVERLAP);
  std::vector<char> memory(text.begin(), text.end());
  memory.resize(1 << 20);
  const phn_model* other = nullptr;
  EXPECT_EQ(phn_model_init(memory.data(), memory.size(), memory.data(), text.size(), &other, nullptr),
            PHN_ERROR_OVERLAP);
  phn_data* made = nullptr;
  phn_contact* contact = nullptr;
  const phn_surface* surface = nullptr;
  LoadedModel own(text);
  char* const of_model = own.model_memory.data();
  EXPECT_EQ(phn_data_init(of_model, 1 << 20, own.model, 1, &made), PHN_ERROR_OVERLAP);
  EXPECT_EQ(phn_contact_init(of_model, 1 << 20, own.model, 1, &contact), PHN_ERROR_OVERLAP);
  EXPECT_EQ(phn_surface_init(of_model, 1 << 20, own.model, 1, &surface), PHN_ERROR_OVERLAP);
  EXPECT_TRUE(other == nullptr && made == nullptr && contact == nullptr && surface == nullptr);

  ASSERT_EQ(phn_contact_init(memory.data(), memory.size(), model, 1, &contact), PHN_OK);
  phn_contact_state state;
  const phn_contact_tool sphere = {{0.2, 0, 0}, 0.001, 0, PHN_TOOL_PRESS};
  EXPECT_EQ(phn_contact_step(contact, 1, &sphere, &state, reinterpret_cast<phn_contact_report*>(&state.proxy)),
            PHN_ERROR_OVERLAP);
  ASSERT_EQ(phn_surface_init(memory.data(), memory.size(), model, 1, &surface), PHN_OK);
  std::vector<double> field(3 * n_output + 10000);
  auto* fine = reinterpret_cast<float*>(field.data());
  EXPECT_EQ(phn_surface_deform(surface, fine + 10000, field.data(), fine), PHN_ERROR_OVERLAP);
}

}  // namespace
}  // namespace phynness::test
