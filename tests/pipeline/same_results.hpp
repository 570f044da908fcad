// Comparison of two databases: all computed values agree exactly, except CPU times, or up to rounding.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <phynness/formats/database.hpp>

namespace phynness::test {

/// @param rounding  relative difference of forces, energies and stresses that is allowed, because they were computed
///                  with other units; of those that are stored as float32 it is theirs at least
inline void expect_same_results(const std::filesystem::path& one, const std::filesystem::path& other,
                                double rounding = 0) {
  const auto a = Database::open(one), b = Database::open(other);
  ASSERT_EQ(a.header().mesh_hash, b.header().mesh_hash);
  ASSERT_EQ(a.header().physics_hash, b.header().physics_hash);
  ASSERT_EQ(a.header().sets.active, b.header().sets.active);
  ASSERT_EQ(a.header().directions, b.header().directions);
  ASSERT_EQ(a.header().magnitudes_m, b.header().magnitudes_m);
  ASSERT_EQ(a.header().fields, b.header().fields);
  ASSERT_FALSE(a.header().sets.active.empty());
  EXPECT_EQ(a.header().scene_text, b.header().scene_text);
  const auto close = [](const std::vector<double>& x, const std::vector<double>& y, double relative) {
    if (relative == 0) return x == y;
    const Eigen::Map<const Eigen::VectorXd> p(x.data(), std::ssize(x)), q(y.data(), std::ssize(y));
    return x.size() == y.size() && (x.empty() || (p - q).norm() <= relative * q.norm());
  };
  const double of_float = rounding > 0 ? std::max(rounding, 1e-7) : 0;
  for (std::size_t i = 0; i < a.header().sets.active.size(); ++i) {
    const auto x = a.rays(static_cast<std::int32_t>(i)), y = b.rays(static_cast<std::int32_t>(i));
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t d = 0; d < x.size(); ++d) {
      bool same = x[d].status == y[d].status && close(x[d].force, y[d].force, rounding) &&
                  close(x[d].energy, y[d].energy, rounding) && close(x[d].tangent, y[d].tangent, rounding) &&
                  x[d].negative_pivots == y[d].negative_pivots && x[d].iterations == y[d].iterations &&
                  x[d].cutbacks == y[d].cutbacks && close(x[d].min_jacobian, y[d].min_jacobian, rounding) &&
                  x[d].end.reason == y[d].end.reason && close({x[d].end.depth_m}, {y[d].end.depth_m}, rounding) &&
                  close({x[d].end.fold_depth_m}, {y[d].end.fold_depth_m}, rounding) &&
                  close({x[d].end.energy_lost_J}, {y[d].end.energy_lost_J}, rounding) &&
                  close(x[d].displacement, y[d].displacement, of_float);
      for (std::size_t f = 0; f < x[d].fields.size(); ++f)
        same = same && close(x[d].fields[f], y[d].fields[f], of_float);
      EXPECT_TRUE(same) << other << " differs at active node " << i << ", direction " << d;
    }
  }
}

}  // namespace phynness::test
