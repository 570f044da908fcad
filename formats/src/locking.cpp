#include <phynness/formats/locking.hpp>

#include <algorithm>
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

std::string fixed(double value, int decimals) { return number_text(value, std::chars_format::fixed, decimals); }

/// Logarithm of the ratio of a row, interpolated over the logarithm of |d|, without extrapolation.
double log_ratio(const ForceRatio& row, ProbeKind kind, double probe) {
  if (kind == ProbeKind::node) return std::log(row.node);
  const double t = std::log(probe / shallow_probe) / std::log(deep_probe / shallow_probe);
  return std::log(row.shallow) + std::clamp(t, 0.0, 1.0) * std::log(row.deep / row.shallow);
}

}  // namespace

double expected_force_ratio(const Scene& scene, double mean_edge_m) {
  const auto rows = scene.solver.element->force_ratios;
  if (rows.empty()) return 1;
  const double depth = mean_edge_m > 0 ? scene.probe.max_displacement_m / mean_edge_m : deep_probe;
  const double probe = scene.material.law->linear ? shallow_probe : depth;
  const double K_mu = scene.material.bulk_to_shear();
  const auto log_of = [&](const ForceRatio& row) { return log_ratio(row, scene.probe.kind, probe); };
  if (K_mu < rows.front().bulk_to_shear) return 1;  // not measured; P1 at 0.29: 1.03
  std::size_t i = 1;
  while (i + 1 < rows.size() && rows[i].bulk_to_shear < K_mu) ++i;
  const auto &low = rows[i - 1], &high = rows[i];
  // Beyond the last row the line is extrapolated, because the force of a locked element is proportional to K.
  const double t = std::log(K_mu / low.bulk_to_shear) / std::log(high.bulk_to_shear / low.bulk_to_shear);
  return std::exp(log_of(low) + t * (log_of(high) - log_of(low)));
}

std::string ratio_in_words(double ratio) {
  // The table that was measured ends at K/mu = 200.
  if (ratio > 100) return "more than 100 times too large";
  if (ratio >= 1.995) return fixed(ratio, ratio < 9.95 ? 1 : 0) + " times too large";
  if (ratio > 1.05) return fixed(100 * (ratio - 1), 0) + " % too large";
  if (ratio < 0.95) return fixed(100 * (1 - ratio), 0) + " % too small";
  return "right within 5 %";
}

namespace {
std::string in_words(const std::string& reference, const std::string& element) {
  return reference == reference_names[2] ? element + " elements of half the size"
                                         : reference + " elements on the same mesh";
}
}  // namespace

std::string ModelBound::from() const {
  return reference == 0 ? "" : " from " + in_words(reference_names.at(static_cast<std::size_t>(reference)), "the same");
}

std::string FinerDistance::sentence() const {
  const auto percent = [](double error) { return fixed(100 * error, error < 0.0995 ? 1 : 0) + " %"; };
  const auto finer = in_words(reference, element);
  if (probes == 0) return "at no probe was there a finer solution (" + finer + ")";
  return percent(mean) + " (p95 " + percent(p95) + ") from a finer solution (" + finer + ") at " +
         std::to_string(probes) + (probes == 1 ? " probe" : " probes") + " of a round tool of " +
         fixed(1e3 * tool_radius_m, 1) + " mm radius";
}

}  // namespace phynness
