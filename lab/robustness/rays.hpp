// Rays of a sample of nodes, and their outcomes.
#pragma once

#include <map>
#include <phynness/formats/database.hpp>

#include "bodies.hpp"

namespace phynness::robustness {

/// The end of a ray that did not reach its full depth.
struct Failure {
  std::int32_t node = 0;
  Vec3 direction{};
  double depth_m = 0;  ///< of the increment that failed
  Status reason = Status::converged;
};

struct Tally {
  int rays = 0;
  std::vector<int> reached;       ///< per increment: rays of which all increments up to this one converged
  std::map<Status, int> reasons;  ///< of the rays that did not reach full depth
  std::vector<Failure> failures;
  int upright = 0;  ///< rays that reach full depth with J > 0 in every state; the linear law also allows J <= 0
  int states = 0, indefinite = 0, cutbacks = 0, increments_cut = 0, iterations = 0;
  double min_jacobian = 1, cpu_ms = 0;

  int full() const { return reached.empty() ? 0 : reached.back(); }
};

/// Solves every direction of the scene at each of `nodes` ("hemisphere": directions that push in or slide).
Tally follow_rays(const Body& body, const std::vector<std::int32_t>& nodes);

/// "K/mu 200  P1", followed by the figures of the tally. `depths` are names of the increments whose fractions are
/// printed.
void print_header(const char* what, const std::vector<std::string>& depths);
void print_row(const std::string& what, const Tally& tally, const std::vector<std::size_t>& depths);
/// Prints one line for each ray that did not reach full depth.
void print_failures(const Tally& tally);

}  // namespace phynness::robustness
