// Comparison of relaxing forces with finite elements whose stress relaxes, along motions in time.
#pragma once

#include <phynness/formats/described.hpp>
#include <phynness/formats/progress.hpp>
#include <phynness/validation/named_organ.hpp>
#include <string>
#include <vector>

namespace phynness {

class SolverSession;

/// Errors of one motion at all places: means over the time steps of the force difference, relative to the largest
/// finite element force.
struct MotionErrors {
  std::int64_t places = 0, failed = 0;         ///< solved and unsolved places
  double mean = undefined, worst = undefined;  ///< mean and maximum over the places
  /// Mean and maximum error of the convolution of the exact elastic force: the error of an exact model.
  double convolved_mean = undefined, convolved_worst = undefined;
  double elastic = undefined;  ///< mean error of the model without relaxation
  /// Mean and maximum relative error of the area of the hysteresis loop in the second cycle of the sine.
  double area_mean = undefined, area_worst = undefined;
  double convolved_area = undefined;  ///< mean error of the area of the convolved exact force
  double warned = 0;                  ///< share of time steps with a relaxation warning
  PHYNNESS_FIGURES(places, failed, mean, worst, convolved_mean, convolved_worst, elastic, area_mean, area_worst,
                   convolved_area, warned)
};

struct MotionReport {
  std::int64_t places = 0, finished = 0;  ///< requested and finished places
  double seconds = 0;
  ByName<MotionErrors> motions;  ///< "sine, 5 mm", "palpation, 20 mm, two tools", ...
  bool interrupted() const { return finished < places; }
  PHYNNESS_FIGURES(places, finished, seconds, motions)
  /// The cells of the table, with a row of headings.
  std::vector<std::vector<std::string>> cells() const;
};

/// Solves motions at random active nodes to 5 mm and to the full depth, within 30 degrees of the inward normal: step
/// and hold, ramp, sine (one frequency from 0.1 to 5 Hz per place), palpation (press, hold, release), and a slide by a
/// radius, in which the finite element tool holds one place after another. With a body, two tools also make sine and
/// palpation. Collective; the result is complete on rank 0 and independent of the number of ranks.
/// @param body  of the same mesh and physics; null: none
/// @throws Error (input) if the model does not relax, or its scene's element is not one of ProbeSolver::begin_motion()
MotionReport validate_motions(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                              const NamedOrgan* body, std::int64_t places, std::uint64_t seed,
                              const OnProgress& progress = {}, const ShouldStop& stop = {});

}  // namespace phynness
