// (17) over test points: differences, and the largest response by which they are divided.
#pragma once

#include <algorithm>
#include <cstddef>
#include <phynness/studies/measurements.hpp>
#include <vector>

namespace phynness::study {

class Errors {
 public:
  void add(double difference, double response) {
    _differences.push_back(difference);
    _largest = std::max(_largest, response);
  }
  bool empty() const { return _differences.empty() || !(_largest > 0); }
  double mean() const {
    double sum = 0;
    for (const double d : _differences) sum += d;
    return empty() ? 0 : sum / (static_cast<double>(_differences.size()) * _largest);
  }
  double max() const { return empty() ? 0 : *std::max_element(_differences.begin(), _differences.end()) / _largest; }
  Histogram histogram() const {
    Histogram counts(n_error_bins, 0);
    if (empty()) return counts;
    for (const double d : _differences) {
      const double bin = std::min<double>(d / _largest / error_bin, n_error_bins - 1);
      ++counts[static_cast<std::size_t>(bin)];
    }
    return counts;
  }

 private:
  std::vector<double> _differences;
  double _largest = 0;
};

}  // namespace phynness::study
