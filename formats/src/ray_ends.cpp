#include "ray_ends.hpp"

#include <algorithm>
#include <cmath>

namespace phynness {

RayEnd end_of(const std::vector<Status>& statuses, const std::vector<double>& magnitudes_m) {
  RayEnd end;
  const auto stop = std::find_if(statuses.begin(), statuses.end(), [](Status s) { return s != Status::converged; });
  if (stop != statuses.begin()) end.depth_m = magnitudes_m[static_cast<std::size_t>(stop - statuses.begin()) - 1];
  if (stop == statuses.end()) return end;
  if (static_cast<int>(*stop) < 0) end.reason = EndReason::solver;
  if (*stop == Status::not_requested) end.reason = EndReason::not_requested;
  return end;
}

double EndSummary::share_of_rays() const {
  std::int64_t n = 0;
  for (const auto& [reason, count] : reasons)
    if (RayEnd{reason}.is_early()) n += count;
  return rays == 0 ? 0 : static_cast<double>(n) / static_cast<double>(rays);
}

double EndSummary::share_of_volume() const {
  double share = 0;
  for (const auto& [reason, part] : volume) share += part;
  return share;
}

double part_of_volume(double depth_m, double range_m) { return std::pow(std::min(1.0, depth_m / range_m), 3); }

EndSummary summarize_ends(const DatabaseHeader& header, const std::vector<RayEnd>& ends) {
  EndSummary summary;
  const double full = header.magnitudes_m.back();
  const std::size_t n_directions = header.directions.size();
  // A model is trained up to the last increment before the end; the depths of both may differ by roundings.
  const auto trained_m = [&](double depth_m) {
    const auto beyond = std::upper_bound(header.magnitudes_m.begin(), header.magnitudes_m.end(), depth_m * (1 + 1e-9));
    return beyond == header.magnitudes_m.begin() ? 0.0 : *(beyond - 1);
  };
  for (std::size_t first = 0; first < ends.size(); first += n_directions) {
    double reached = 0;
    std::int32_t requested = 0, early = 0;
    for (std::size_t i = first; i < first + n_directions; ++i) {
      const RayEnd& end = ends[i];
      if (end.reason == EndReason::not_requested) continue;
      ++requested;
      ++summary.reasons[end.reason];
      summary.folds += end.fold_depth_m > 0;
      if (end.fold_depth_m > 0) summary.largest_loss_J = std::max(summary.largest_loss_J, std::abs(end.energy_lost_J));
      summary.is_recorded &= end.reason != EndReason::not_recorded;
      const double part = end.is_early() ? part_of_volume(trained_m(end.depth_m), full) : 1.0;
      if (end.is_early()) summary.volume[end.reason] += 1 - part;
      early += end.is_early();
      reached += part;
    }
    summary.rays += requested;
    summary.early.push_back(early);
    summary.reached.push_back(requested > 0 ? reached / requested : 1.0);
  }
  for (auto& entry : summary.volume) entry.second /= static_cast<double>(summary.rays);
  return summary;
}

EndSummary summarize_ends(const Database& database) { return summarize_ends(database.header(), database.ends()); }

}  // namespace phynness
