#include <phynness/validation/locking.hpp>

#include <algorithm>
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

std::string fixed(double value, int decimals) { return number_text(value, std::chars_format::fixed, decimals); }

}  // namespace

const Material& most_locked(const Scene& scene) {
  const auto all = materials(scene);
  return **std::ranges::max_element(all, {}, [](const Material* m) { return m->bulk_to_shear(); });
}

double expected_force_ratio(const Scene& scene) {
  const auto rows = scene.solver.element->force_ratios;
  if (rows.empty()) return 1;
  const double K_mu = most_locked(scene).bulk_to_shear();
  const auto log_of = [&](const ForceRatio& row) {
    return std::log(scene.probe.kind == ProbeKind::node ? row.node : row.patch);
  };
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
  return "within 5 %";
}

std::vector<std::string> scene_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const Material& m = most_locked(scene);
  const ProbeSpec& probe = scene.probe;
  if (const double ratio = expected_force_ratio(scene); ratio > warned_force_ratio) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << std::setprecision(4) << m.where.str() << ": the forces of a tool are estimated to be "
         << ratio_in_words(ratio) << " at K/mu = " << m.bulk_to_shear() << ", because " << name(scene.solver.element)
         << " tetrahedra lock (mean of four bodies; single forces 0.5 to 2.2 times as much): use "
         << (probe.kind == ProbeKind::patch ? "es-p1-p1" : "p1-p1")
         << " or taylor-hood, and see what phynness check measures in this scene";
    warnings.push_back(text.str());
  }
  if (m.law->linear && (probe.directions != Directions::three || probe.increments != 1)) {
    const auto n_solves = exploratory_directions(probe.directions).size() * static_cast<std::size_t>(probe.increments);
    warnings.push_back(probe.where.str() + ": the law is linear, so that three solves per node suffice instead of " +
                       std::to_string(n_solves) +
                       "; directions = 3, increments = 1 and family = \"linear\" give an exact model");
  }
  return warnings;
}

}  // namespace phynness
