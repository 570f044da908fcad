#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_levels.h>
#include <phynness/phynness_paper.h>
#include <phynness/phynness_surface.h>

#include <cstdlib>
#include <new>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {
long n_allocations = 0;
}

// Replaces the allocator of this program: libstdc++'s operator new ends here, too.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* malloc(std::size_t bytes) {
  ++n_allocations;
  return __libc_malloc(bytes);
}
void* calloc(std::size_t n, std::size_t bytes) {
  ++n_allocations;
  return __libc_calloc(n, bytes);
}
}

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: from loading to evaluation with several tools and finer surfaces the library allocates nothing; the
// counter is shown to count.
class Memory : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Memory, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Memory, NothingIsAllocated) {
  const std::string text = write_model_text(small_model_of(GetParam()));
  const long at_start = n_allocations;
  std::vector<char> model_memory(1 << 20), data_memory(1 << 20);
  ASSERT_GT(n_allocations, at_start);
  std::size_t bytes = 0;
  const phn_model* model = nullptr;
  phn_data* data = nullptr;
  const std::int32_t tools[] = {3, 5, 8};
  const double d[] = {0.001, 0.002, 0.003, -0.001, 0, 0, 0.02, 0, 0};
  double out[36], energy = 0, stiffness[9];
  double depth;
  phn_info info;
  std::vector<char> surface_memory(1 << 20), contact_memory(1 << 20);
  std::vector<float> scratch(10000), fine(10000);
  const phn_surface* surface = nullptr;
  const int derivatives = GetParam() == Family::rbfn ? PHN_ERROR_UNDEFINED : PHN_OK;

  const long before = n_allocations;
  int worst = phn_model_size(text.data(), text.size(), &bytes, nullptr);
  worst = std::min(worst, phn_model_init(model_memory.data(), bytes, text.data(), text.size(), &model, nullptr));
  worst = std::min(worst, phn_data_size(model, 3, &bytes));
  worst = std::min(worst, phn_data_init(data_memory.data(), bytes, model, 3, &data));
  worst = std::min(worst, phn_force(model, data, 3, d, out, nullptr, nullptr));
  worst = std::min(worst, phn_deform(model, data, *tools, d, out));
  worst = std::min(worst, phn_blend_paper(model, data, 3, tools, d, out));
  worst = std::min(worst, phn_prepare(model, data, 8));
  worst = std::min(worst, phn_model_info(model, &info));
  worst = std::min(worst, phn_trained_depth(model, 3, d, &depth));
  const phn_tool held[] = {{{3, 5, 8}, {0.5, 0.25, 0.25}, {0.001, 0, 0}},
                           {{5, 3, 0}, {0.5, 0.25, 0.25}, {0, 0.001, 0}}};
  const double x[] = {0.01, 0, 0};
  phn_tool nearest;
  worst = std::min(worst, phn_couple(model, data, 2, held, out, nullptr));
  worst = std::min(worst, phn_coupled_deform(model, data, out));
  const phn_tool at_node = {{3, -1, -1}, {1, 0, 0}, {0.001, 0.002, 0.003}};
  worst = std::min(worst, phn_force_at(model, data, &at_node, out, nullptr, nullptr));
  worst = std::min(worst, phn_trained_depth_at(model, &at_node, &depth));
  worst = std::min(worst, phn_nearest(model, x, &nearest, nullptr));
  worst = std::min(worst, phn_surface_size(model, 3, &bytes));
  worst = std::min(worst, phn_surface_init(surface_memory.data(), bytes, model, 3, &surface));
  worst = std::min(worst, phn_surface_deform(surface, scratch.data(), out, fine.data()));
  phn_contact* contact = nullptr;
  const phn_contact_tool touching[] = {{{0.01, 0, 0}, 0.1, 0.3, PHN_TOOL_PRESS},
                                       {{0, 0.01, 0}, 0.1, 0, PHN_TOOL_GRASP}};
  phn_contact_state states[2];
  worst = std::min(worst, phn_contact_size(model, 2, &bytes));
  worst = std::min(worst, phn_contact_init(contact_memory.data(), bytes, model, 2, &contact));
  worst = std::min(worst, phn_contact_step(contact, data, 2, touching, states, nullptr));
  worst = std::min(worst, phn_contact_refit(contact, out));
  worst = std::min(worst, phn_contact_step(contact, data, 2, touching, states, nullptr));
  worst = std::min(worst, phn_contact_nearest(contact, x, &nearest, nullptr));
  const int energy_status = phn_force(model, data, 3, d, nullptr, &energy, nullptr);
  const int stiffness_status = phn_force(model, data, 3, d, nullptr, nullptr, stiffness);
  const long after = n_allocations;

  EXPECT_EQ(worst, 0);
  EXPECT_EQ(states[0].in_contact | states[1].in_contact, 1);
  EXPECT_LE(phn_surface_scratch_size(surface) / sizeof(float), scratch.size());
  EXPECT_LE(3 * phn_surface_n_vertices(surface), static_cast<std::int32_t>(fine.size()));
  EXPECT_EQ(energy_status, derivatives);
  EXPECT_EQ(stiffness_status, derivatives);
  EXPECT_EQ(after, before);
}

TEST(Memory, LevelsAllocateNothing) {
  for (const Family family : {Family::rbfn, Family::modal}) {
    const std::string text = write_model_text(with_bounds(with_levels(small_model_of(family))));
    std::vector<char> model_memory(1 << 20), data_memory(1 << 20);
    std::size_t bytes = 0;
    const phn_model* model = nullptr;
    phn_data* data = nullptr;
    const double d[] = {0.001, 0.002, 0.003};
    const std::int32_t node = 3;
    double out[36], now = 0;
    phn_level info;
    phn_info of_model;
    const long before = n_allocations;
    int worst = phn_model_size(text.data(), text.size(), &bytes, nullptr);
    worst = std::min(worst, phn_model_init(model_memory.data(), bytes, text.data(), text.size(), &model, nullptr));
    worst = std::min(worst, phn_data_size(model, 1, &bytes));
    worst = std::min(worst, phn_data_init(data_memory.data(), bytes, model, 1, &data));
    for (const std::int32_t level : {0, 2, 1}) {
      worst = std::min(worst, phn_set_level(model, data, level));
      worst = std::min(worst, phn_level_info(model, level, &info));
      worst = std::min(worst, phn_force(model, data, node, d, out, nullptr, nullptr));
      worst = std::min(worst, phn_deform(model, data, node, d, out));
    }
    worst = std::min(worst, phn_trained_depth(model, node, d, &now));
    worst = std::min(worst, phn_bound(model, node, d, &now));
    worst = std::min(worst, phn_model_info(model, &of_model));
    const long after = n_allocations;
    EXPECT_EQ(worst, 0);
    EXPECT_EQ(of_model.n_levels, 3);
    EXPECT_EQ(after, before);
  }
}

TEST(Memory, FieldsAllocateNothing) {
  const std::string text = write_model_text(small_field_model());
  std::vector<char> model_memory(1 << 20), data_memory(1 << 20);
  std::size_t bytes = 0;
  const phn_model* model = nullptr;
  phn_data* data = nullptr;
  const double d[] = {0.001, 0.002, 0.003};
  double out[12];
  const long before = n_allocations;
  int worst = phn_model_size(text.data(), text.size(), &bytes, nullptr);
  worst = std::min(worst, phn_model_init(model_memory.data(), bytes, text.data(), text.size(), &model, nullptr));
  worst = std::min(worst, phn_data_size(model, 1, &bytes));
  worst = std::min(worst, phn_data_init(data_memory.data(), bytes, model, 1, &data));
  for (const std::int32_t field : {0, 1}) worst = std::min(worst, phn_field(model, data, 3, d, field, out));
  const long after = n_allocations;
  EXPECT_EQ(worst, 0);
  EXPECT_EQ(info_of(model).n_fields, 2);
  EXPECT_EQ(after, before);
}

}  // namespace
