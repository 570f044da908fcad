// What element and cell size do to the forces of a scene: a few probes against Taylor-Hood elements on the same mesh,
// and against the scene's own element on cells of half the size.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness {

/// The scene itself, and what it is compared with.
enum class Variant : std::size_t { scene, taylor_hood, half_size };
inline constexpr std::array<Variant, 3> variants{Variant::scene, Variant::taylor_hood, Variant::half_size};
const char* name(Variant);  ///< for JSON: "scene", "taylor-hood", "half-size"

struct VariantForces {
  std::vector<Status> status;   ///< per depth; empty: not solved
  std::vector<double> force_N;  ///< size of the force per depth, where it converged
  bool converged(std::size_t depth) const { return depth < status.size() && status[depth] == Status::converged; }
};

struct CheckedProbe {
  std::int32_t node = 0;
  Vec3 direction{};
  double inward = 0;  ///< cosine between the direction and the inward normal
  std::array<VariantForces, 3> forces;
  const VariantForces& of(Variant v) const { return forces[static_cast<std::size_t>(v)]; }
  /// Size of the scene's force divided by that of `other`; none unless both converged.
  std::optional<double> ratio(Variant other, std::size_t depth) const;
};

/// Of one comparison at one depth, over the probes that have a ratio.
struct RatioStatistics {
  double median = 0, min = 0, max = 0;
  std::int64_t n = 0;
};

struct VariantCost {
  bool possible = true;      ///< false: `left_out` says why the scene has no such variant
  std::string left_out;      ///< why some or all probes were not solved; empty: all of them were
  double predicted_s = 0;    ///< of one probe, where it was left out for its time
  double seconds = 0;        ///< wall time spent
  std::int32_t n_nodes = 0;  ///< of the mesh
};

struct DiscretizationReport {
  double tool_radius_m = 0;
  bool patch_for_node = false;  ///< the scene displaces nodes, and patches of tool_radius_m were held in their place
  double mean_edge_m = 0;
  std::vector<double> depth_m;  ///< ascending; the last is the scene's largest displacement
  std::vector<CheckedProbe> probes;
  std::array<VariantCost, 3> costs;
  double seconds = 0;
  bool interrupted = false;

  const VariantCost& cost(Variant v) const { return costs[static_cast<std::size_t>(v)]; }
  RatioStatistics ratios(Variant other, std::size_t depth) const;
};

struct DiscretizationOptions {
  int probes = 6;
  double seconds = 60;  ///< no solve is begun that is predicted to end later
};

/// Radius of the patch that stands for a node in a check. The force at a node depends on the element even where none is
/// too stiff: P1 holds a node, P2 the middles of its edges with it (docs/theory.md, What a probe is).
double patch_radius_for_node(double mean_edge_m, double max_displacement_m);

/// Which rays are solved: `wanted` active nodes, far from each other and from the fixed ones; their directions are in
/// turn the one most inward, most sideways and most outward of those that the scene requests.
/// @return pairs (index of the active node, index of the direction)
std::vector<std::pair<std::int32_t, std::int32_t>> choose_checked_rays(const DatabaseHeader& header,
                                                                       const std::vector<char>& requested, int wanted);

/// Solves the probes, each with all variants before the next, until the time is over. In one process.
/// @param progress  rays done, in all
/// @throws Error if the scene cannot be solved at all
DiscretizationReport check_discretization(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                          const DiscretizationOptions& options,
                                          const std::function<void(std::int64_t, std::int64_t)>& progress = {},
                                          const std::function<bool()>& stop = {});

}  // namespace phynness
