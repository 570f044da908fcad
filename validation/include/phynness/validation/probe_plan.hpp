// Selection of the new probes of a validation: nodes, directions and magnitudes from one seed.
#pragma once

#include <cstdint>
#include <phynness/evaluation/loaded_model.hpp>
#include <random>
#include <vector>

namespace phynness {

/// Uniform in [0, 1). It is the same on every platform, which the distributions of the standard library are not.
double uniform(std::mt19937_64& random);
/// Uniform on the unit sphere.
Vec3 on_sphere(std::mt19937_64& random);

/// A ray that is solved for one probe inside the trained range and one outside; 0: no such probe.
struct ProbePair {
  Vec3 direction{};
  double inside_m = 0, outside_m = 0;
};

struct NodePlan {
  std::int32_t node = 0;
  bool beside_fixed = false;    ///< chosen among the active nodes that are nearest to the fixed ones, however far
  double fixed_distance_m = 0;  ///< to the nearest fixed node
  std::vector<ProbePair> pairs;
};

/// `probes` in total, distributed evenly over inside and outside and over the nodes. Directions without a trained depth
/// are drawn again.
/// @param nodes  number of probed nodes; 0: a twentieth of the probes, at least ten
/// @throws Error (input) if `probes` is less than 1
std::vector<NodePlan> plan_probes(const LoadedModel& model, Directions directions, std::int64_t probes,
                                  std::uint64_t seed, std::int64_t nodes = 0);

}  // namespace phynness
