// Mean, median, 95th percentile and maximum of errors.
#pragma once

#include <cstdint>
#include <phynness/formats/described.hpp>
#include <type_traits>
#include <vector>

namespace phynness {

/// Statistics of fractions. All members are 0 without samples.
struct ErrorStatistics {
  double mean = 0, median = 0, p95 = 0, max = 0;
  std::int64_t n = 0;
  static ErrorStatistics of(std::vector<double> samples);
  static void describe(const auto& result, auto&& see) {
    const auto known = [&](double value) { return result.n > 0 ? value : undefined; };
    see("mean", known(result.mean), "mean");
    see("median", known(result.median), "median");
    see("p95", known(result.p95), "p95");
    see("max", known(result.max), "max");
    see("n", result.n);
  }
};

/// The quantile by nearest rank. @pre the values ascend, and there is at least one
double quantile(const std::vector<double>& ascending, double share);

/// The titled statistics of a result, for tables.
template <Described T>
ByName<ErrorStatistics> titled(const T& result) {
  ByName<ErrorStatistics> rows;
  T::describe(result, [&]<class Value>(const auto&, const Value& value, const char* title = nullptr) {
    if constexpr (std::is_same_v<Value, ErrorStatistics>)
      if (title != nullptr) rows.emplace_back(title, value);
  });
  return rows;
}

}  // namespace phynness
