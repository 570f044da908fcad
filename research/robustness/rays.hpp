// Rays of a sample of nodes, and what became of them.
#pragma once

#include <map>
#include <phynness/formats/database.hpp>

#include "bodies.hpp"

namespace phynness::robustness {

/// Where a ray stopped short.
struct Failure {
  std::int32_t node = 0;
  Vec3 direction{};
  double depth_m = 0;  ///< of the increment that failed
  Status reason = Status::converged;
};

struct Tally {
  int rays = 0;
  std::vector<int> reached;       ///< by increment: rays whose increments up to it all converged
  std::map<Status, int> reasons;  ///< of the rays that stopped short
  std::vector<Failure> failures;
  int upright = 0;  ///< rays that reach full depth with J > 0 in every state; the linear law allows others
  int states = 0, indefinite = 0, cutbacks = 0, increments_cut = 0, iterations = 0;
  double min_jacobian = 1, cpu_ms = 0;

  int full() const { return reached.empty() ? 0 : reached.back(); }
};

/// Every direction of the scene from each of `nodes` ("hemisphere": those that push in or slide).
Tally follow_rays(const Body& body, const std::vector<std::int32_t>& nodes);

/// "K/mu 200  P1", then the figures of the tally; `depths` are the increments whose share is printed.
void print_header(const char* what, const std::vector<std::string>& depths);
void print_row(const std::string& what, const Tally& tally, const std::vector<std::size_t>& depths);
/// One line for each ray that stopped short.
void print_failures(const Tally& tally);

}  // namespace phynness::robustness
