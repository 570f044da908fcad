// Selection of the new probes of a validation: nodes, directions and magnitudes from one seed.
#pragma once

#include <cstdint>
#include <phynness/validation/named_organ.hpp>
#include <random>
#include <vector>

namespace phynness {

/// Uniform in [0, 1). In contrast to the standard distributions it is the same on every platform.
double uniform(std::mt19937_64& random);
/// A uniform direction on the unit sphere.
Vec3 random_direction(std::mt19937_64& random);
/// The same, for a hemisphere on the half that points into the body. @param normal  outward
Vec3 random_direction(std::mt19937_64& random, Directions directions, const Eigen::Vector3d& normal);

/// A uniformly random element of a list.
template <class List>
const auto& random_element(const List& list, std::mt19937_64& random) {
  return list[static_cast<std::size_t>(uniform(random) * static_cast<double>(list.size()))];
}

/// Barycentric coordinates of a uniform point of a triangle.
std::array<double, 3> random_barycentric(std::mt19937_64& random);
/// The surface triangles with 0, 1, 2 and 3 corners that are probed_nodes().
std::array<std::vector<Eigen::Index>, 4> triangles_by_corners(const NamedOrgan& model);

/// Places of tools: uniform in triangles, each of which has the same probability, or nodes if there are no triangles.
class RandomPlaces {
 public:
  /// @param body  null, or answers tools at these places, of which those with a warning are not drawn
  RandomPlaces(const NamedOrgan& model, Triangles triangles, const NamedOrgan* body = nullptr);
  /// The triangles with three corners that the model has probed; with a body those where it answers without a warning.
  static RandomPlaces answered(const NamedOrgan& model, const NamedOrgan* body);

  bool at_nodes() const { return _triangles.rows() == 0; }
  SurfacePoint draw(std::mt19937_64& random) const;
  Vec3 draw_direction(std::mt19937_64& random, Directions directions, const SurfacePoint& place) const;

 private:
  bool is_beside_fixed(const SurfacePoint& place) const;

  const NamedOrgan& _model;
  const NamedOrgan* _body;
  Triangles _triangles;
  Points _normals;
};

/// A ray with the depths of its probes; a depth of 0 means that there is no such probe.
struct ProbePair {
  Vec3 direction{};
  double inside_m = 0, outside_m = 0;         ///< inside and outside the trained range
  double to_range_m = 0, beyond_range_m = 0;  ///< up to the scene's R and beyond it
};

struct NodePlan {
  std::int32_t node = 0;
  bool beside_fixed = false;    ///< chosen among the active nodes that are nearest to fixed nodes
  double fixed_distance_m = 0;  ///< to the nearest fixed node
  double weight = 1;  ///< number of active nodes that the node represents; nodes near fixed ones are probed more often
  std::vector<ProbePair> pairs;
};

/// Plans `probes` probes, half inside and half outside the trained range, evenly over the nodes. Their directions are
/// drawn again until the node has a trained depth. The probes up to `range_m` use the first direction, in a separate
/// ray if it has no trained depth. The same random number scales the trained depth and `range_m`, so that both probes
/// agree if the depths agree, and probes inside do not depend on `range_m`.
/// @param nodes  number of probed nodes; 0: a twentieth of the probes, at least ten
/// @param range_m  R of the scene; 0 plans no probes up to R
/// @throws Error (input) if `probes` is less than 1, or if `range_m` is 0 and no direction of a node was trained
std::vector<NodePlan> plan_probes(const NamedOrgan& model, Directions directions, std::int64_t probes,
                                  std::uint64_t seed, std::int64_t nodes = 0, double range_m = 0);

}  // namespace phynness
