#include <gtest/gtest.h>
#include <phynness/phynness_surface.h>

#include <cmath>

#include "fine_surface.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: misuse and surfaces that have no subdivision are named.
TEST(Surfaces, MisuseIsNamed) {
  const FineSurface good(tetrahedron(), 2);
  const phn_model* model = good.loaded.model;
  std::size_t bytes = 1;
  const phn_surface* surface = good.surface;
  std::vector<char> memory(1 << 16);
  for (const int levels : {-1, 7}) {
    EXPECT_EQ(phn_surface_size(model, levels, &bytes), PHN_ERROR_ARGUMENT);
    EXPECT_EQ(phn_surface_init(memory.data(), memory.size(), model, levels, &surface), PHN_ERROR_ARGUMENT);
    EXPECT_EQ(surface, nullptr);
  }
  EXPECT_EQ(bytes, 0u);
  EXPECT_EQ(phn_surface_size(nullptr, 1, &bytes), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_size(model, 1, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_init(nullptr, 100, model, 1, &surface), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_init(memory.data(), 100, nullptr, 1, &surface), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_init(memory.data(), 100, model, 1, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(contents_of(nullptr).n_vertices, 0);
  EXPECT_EQ(contents_of(nullptr).points, nullptr);
  EXPECT_EQ(phn_surface_info(good.surface, nullptr), PHN_ERROR_ARGUMENT);

  std::vector<float> out(3 * static_cast<std::size_t>(good.n_vertices), 1),
      scratch(contents_of(good.surface).scratch_bytes / sizeof(float));
  const Points field = Points::Ones(4, 3);
  EXPECT_EQ(phn_surface_deform(nullptr, scratch.data(), field.data(), out.data()), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_deform(good.surface, nullptr, field.data(), out.data()), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(out[0], 0);
  EXPECT_EQ(phn_surface_deform(good.surface, scratch.data(), nullptr, out.data()), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_surface_deform(good.surface, scratch.data(), field.data(), nullptr), PHN_ERROR_ARGUMENT);

  Body equal = tetrahedron(), bare = tetrahedron(), vast = tetrahedron();
  equal.triangles.push_back({1, 2, 1});
  bare.triangles.clear();
  vast.triangles.assign(200000, {0, 1, 2});  // 8e8 triangles after six levels
  const LoadedModel with_equal(text_of(equal)), without(text_of(bare)), too_many(text_of(vast));
  EXPECT_EQ(phn_surface_size(with_equal.model, 1, &bytes), PHN_ERROR_GEOMETRY);
  EXPECT_EQ(phn_surface_size(without.model, 1, &bytes), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(phn_surface_size(too_many.model, 6, &bytes), PHN_ERROR_TOO_LARGE);
  EXPECT_EQ(phn_surface_init(memory.data(), 100, with_equal.model, 1, &surface), PHN_ERROR_GEOMETRY);
}

// Claim: the stated size suffices at any alignment, on surfaces where no two triangles share an edge, too;
// less is refused.
TEST(Surfaces, SizesSufficeAtAnyAlignment) {
  Body apart;
  for (int i = 0; i < 60; ++i) apart.points.push_back({std::cos(i), std::sin(2 * i), std::cos(3 * i)});
  for (int i = 0; i < 20; ++i) apart.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  for (const Body& body : {apart, tetrahedron()}) {
    const LoadedModel loaded(text_of(body));
    for (int levels = 0; levels <= 3; ++levels) {
      std::size_t bytes = 0;
      ASSERT_EQ(phn_surface_size(loaded.model, levels, &bytes), PHN_OK);
      for (std::size_t shift = 0; shift < 64; ++shift) {
        std::vector<char> memory(bytes + shift);
        const phn_surface* surface = nullptr;
        ASSERT_EQ(phn_surface_init(memory.data() + shift, bytes, loaded.model, levels, &surface), PHN_OK);
        ASSERT_EQ(phn_surface_init(memory.data() + shift, bytes - 64, loaded.model, levels, &surface),
                  PHN_ERROR_BUFFER);
        ASSERT_EQ(surface, nullptr);
      }
    }
  }
}

}  // namespace
