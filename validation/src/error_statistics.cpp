#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/validation/validation.hpp>

namespace phynness {

const char* name(Predictor p) {
  switch (p) {
    case Predictor::model:
      return "model";
    case Predictor::linear:
      return "linear";
    case Predictor::zero:
      break;
  }
  return "zero";
}

ErrorStatistics ErrorStatistics::of(std::vector<double> samples) {
  ErrorStatistics s;
  s.n = static_cast<std::int64_t>(samples.size());
  if (samples.empty()) return s;
  std::sort(samples.begin(), samples.end());
  s.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
  s.median = samples[(samples.size() - 1) / 2];
  // Nearest rank: the smallest sample that at least 95 % of the samples do not exceed.
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(samples.size())));
  s.p95 = samples[rank - 1];
  s.max = samples.back();
  return s;
}

}  // namespace phynness
