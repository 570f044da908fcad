// Comparison of two databases: all computed values agree exactly, except CPU times.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <phynness/formats/database.hpp>

namespace phynness::test {

inline void expect_same_results(const std::filesystem::path& one, const std::filesystem::path& other) {
  const auto a = Database::open(one), b = Database::open(other);
  ASSERT_EQ(a.header().mesh_hash, b.header().mesh_hash);
  ASSERT_EQ(a.header().physics_hash, b.header().physics_hash);
  ASSERT_EQ(a.header().sets.active, b.header().sets.active);
  ASSERT_EQ(a.header().directions, b.header().directions);
  ASSERT_FALSE(a.header().sets.active.empty());
  EXPECT_EQ(a.header().scene_text, b.header().scene_text);
  EXPECT_FALSE(b.header().shard);
  for (std::size_t i = 0; i < a.header().sets.active.size(); ++i) {
    const auto x = a.rays(static_cast<std::int32_t>(i)), y = b.rays(static_cast<std::int32_t>(i));
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t d = 0; d < x.size(); ++d) {
      const bool same = x[d].status == y[d].status && x[d].force == y[d].force && x[d].energy == y[d].energy &&
                        x[d].tangent == y[d].tangent && x[d].negative_pivots == y[d].negative_pivots &&
                        x[d].iterations == y[d].iterations && x[d].cutbacks == y[d].cutbacks &&
                        x[d].min_jacobian == y[d].min_jacobian && x[d].end.reason == y[d].end.reason &&
                        x[d].end.depth_m == y[d].end.depth_m && x[d].end.fold_depth_m == y[d].end.fold_depth_m &&
                        x[d].end.energy_lost_J == y[d].end.energy_lost_J && x[d].displacement == y[d].displacement;
      EXPECT_TRUE(same) << other << " differs at active node " << i << ", direction " << d;
    }
  }
}

}  // namespace phynness::test
