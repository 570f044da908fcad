// Comparison of relaxing forces with finite elements whose stress relaxes, along motions in time.
#pragma once

#include <phynness/formats/described.hpp>
#include <phynness/formats/progress.hpp>
#include <phynness/validation/named_organ.hpp>
#include <string>
#include <vector>

namespace phynness {

class SolverSession;

/// Of one motion at all places. Errors are means over its steps of the difference of the forces over their largest size
/// in the finite elements.
struct MotionErrors {
  std::int64_t places = 0, failed = 0;         ///< that were solved; that were not
  double mean = undefined, worst = undefined;  ///< over the places
  /// The finite elements' own elastic force, convolved: what is left if the model were exact; at worst.
  double convolved_mean = undefined, convolved_worst = undefined;
  double elastic = undefined;  ///< of the model without relaxation, mean over the places
  /// Of the second cycle of the sine: error of the area of the loop over this area, mean and largest of the places.
  double area_mean = undefined, area_worst = undefined;
  double warned = 0;  ///< share of the steps with a warning of the relaxation
  PHYNNESS_FIGURES(places, failed, mean, worst, convolved_mean, convolved_worst, elastic, area_mean, area_worst, warned)
};

struct MotionReport {
  std::int64_t places = 0, finished = 0;  ///< requested; fewer finished if it was interrupted
  double seconds = 0;
  ByName<MotionErrors> motions;  ///< "sine, 5 mm", "palpation, 20 mm, two tools", ...
  bool interrupted() const { return finished < places; }
  PHYNNESS_FIGURES(places, finished, seconds, motions)
  /// The table, with a row of headings.
  std::vector<std::vector<std::string>> cells() const;
};

/// Motions that press at random active nodes to 5 mm and to the full depth, within 30 degrees of the inward normal:
/// step and hold, ramp, sine of 0.1 to 5 Hz (each place has one), palpation (press, hold, release), and a slide by a
/// radius, at which the forces of finite elements are those of a tool that holds one place after the other. With a body
/// also sine and palpation of two tools. Collective; complete on rank 0 and the same for any number of ranks.
/// @param body  of the same mesh and physics; null: none
/// @throws Error (input) if the model does not relax, or its scene's element is not one of ProbeSolver::begin_motion()
MotionReport validate_motions(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                              const NamedOrgan* body, std::int64_t places, std::uint64_t seed,
                              const OnProgress& progress = {}, const ShouldStop& stop = {});

}  // namespace phynness
