// The responses of some active nodes in memory, and what may be wrong with them.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <phynness/formats/tool.hpp>
#include <vector>

namespace phynness::study {

struct StudyNode {
  std::int32_t node = 0;
  Vec3 point{};
  TouchedNodes prescribed;
  std::vector<Ray> rays;  ///< one per direction; status, force and displacement only
};

struct StudyData {
  DatabaseHeader header;          ///< its directions and magnitudes are those of the rays
  std::vector<StudyNode> probed;  ///< trained and measured; ascending
  std::vector<StudyNode> others;  ///< of these and the probed ones the shared modes are made
};

/// Reads the given mesh nodes and `n_others` more, spread over the list of active nodes.
StudyData read_data(const Database& database, std::vector<std::int32_t> probed, int n_others, double tool_radius_m);

/// Those increments alone, counted from 0, ascending.
StudyData with_increments(StudyData data, const std::vector<std::size_t>& kept);
/// Whole rays failed, drawn for each node. What a failed increment holds is NaN: training on it would show.
StudyData with_failed_rays(StudyData data, double share, std::uint64_t seed);
/// Every ray but the given ones failed.
StudyData with_rays(StudyData data, const std::vector<std::size_t>& kept);
/// Increments from this one on failed, counted from 0.
StudyData failing_from(StudyData data, std::size_t increment);
/// Every direction twice, the second copy with this noise.
StudyData duplicated(StudyData data, double level, std::uint64_t seed);
/// Normal noise on each component of forces and displacements; standard deviation: `level` of the node's
/// largest force, and of the largest displacement of a node that the probe does not move itself.
StudyData with_noise(StudyData data, double level, std::uint64_t seed);

double largest_force_N(const std::vector<Ray>& rays);

}  // namespace phynness::study
