// Selection of the new probes of a validation: nodes, directions and magnitudes from one seed.
#pragma once

#include <cstdint>
#include <phynness/validation/named_organ.hpp>
#include <random>
#include <vector>

namespace phynness {

/// Uniform in [0, 1). It is the same on every platform, which the distributions of the standard library are not.
double uniform(std::mt19937_64& random);
/// Uniform on the unit sphere.
Vec3 on_sphere(std::mt19937_64& random);

/// Barycentric weights, uniform by area.
std::array<double, 3> point_of_triangle(std::mt19937_64& random);
/// Triangles of the surface, by how many of their corners are probed_nodes().
std::array<std::vector<Eigen::Index>, 4> triangles_by_corners(const NamedOrgan& model);

/// A ray with the depths of its probes; 0: no such probe.
struct ProbePair {
  Vec3 direction{};
  double inside_m = 0, outside_m = 0;         ///< inside and outside the trained range
  double to_range_m = 0, beyond_range_m = 0;  ///< up to the scene's R and beyond it, whatever was trained
};

struct NodePlan {
  std::int32_t node = 0;
  bool beside_fixed = false;    ///< chosen among the active nodes that are nearest to the fixed ones, however far
  double fixed_distance_m = 0;  ///< to the nearest fixed node
  double weight =
      1;  ///< number of active nodes for which the node stands: those beside fixed nodes are probed more often
  std::vector<ProbePair> pairs;
};

/// `probes` in total, distributed evenly over inside and outside and over the nodes. For these two, directions without
/// a trained depth are drawn again; for probes to `range_m` the first direction counts and gets a ray of its own. One
/// random number is the fraction of the trained depth and of `range_m`: probes inside and to `range_m` are the same
/// where both depths are, and those inside do not depend on `range_m`.
/// @param nodes  number of probed nodes; 0: a twentieth of the probes, at least ten
/// @param range_m  R of the scene; 0: only probes inside and outside
/// @throws Error (input) if `probes` is less than 1, or if `range_m` is 0 and no direction of a node was trained
std::vector<NodePlan> plan_probes(const NamedOrgan& model, Directions directions, std::int64_t probes,
                                  std::uint64_t seed, std::int64_t nodes = 0, double range_m = 0);

}  // namespace phynness
