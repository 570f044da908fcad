// How far apart the points of a round tool may be: points of a database are left out, and their rays are the truth.
#pragma once

#include <filesystem>
#include <phynness/formats/described.hpp>
#include <phynness/tuning/tuning.hpp>

namespace phynness {

struct SpacingRow {
  double spacing_m = 0;
  std::int64_t points = 0;           ///< that the model has
  std::int64_t left_out = 0;         ///< nodes with rays, on which it is measured
  std::int64_t unanswered = 0;       ///< of these, nodes between whose neighbours the model does not answer
  ErrorStatistics between, nearest;  ///< forces of the model there; of the nearest point. Over the largest of the node
  PHYNNESS_FIGURES(spacing_m, points, left_out, unanswered, between, nearest)
};

/// Trains the scene's model on fewer and fewer points of the database, spread evenly, and compares its forces at all
/// states of the points that are left out. Nothing is solved. The spacings are a quarter to the whole of the tool's
/// radius, as far as they leave points out.
/// @throws Error (input) if the scene has no round tools or no point can be left out
std::vector<SpacingRow> compare_spacings(const Scene& scene, const std::filesystem::path& database,
                                         const TuningProgress& progress);

/// The largest spacing with an error of at most `error` and at most 5 % of the nodes unanswered; null: none.
const SpacingRow* sparsest(const std::vector<SpacingRow>& rows, double error, ErrorStatistic statistic);

}  // namespace phynness
