// Database -> model, the paper's way (section 2.2): scaling, orthogonal least squares, one spread.
#pragma once

#include <functional>

#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>

namespace phynness {

struct TrainingReport {
  std::int32_t n_networks = 0;        ///< active nodes trained
  std::int32_t n_skipped = 0;         ///< active nodes with no converged increment
  double deformation_spread = 0, force_spread = 0;  ///< used, in scaled inputs
  double mean_deformation_mse = 0, mean_force_mse = 0;  ///< of scaled outputs, on the training points
  double seconds = 0;
};

/// Called as networks finish: (done, total). Return false to interrupt (an Error is thrown, nothing is written).
using TrainingProgress = std::function<bool(std::int64_t, std::int64_t)>;

/// @param spec      family, neurons, spreads, samples, seed
/// @param threads   0: as many as there are cores; the result does not depend on it
/// @throws Error    on a family not available, too few converged increments, ...
Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress = {}, int threads = 0);

}  // namespace phynness
