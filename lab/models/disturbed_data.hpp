// The responses of some active nodes in memory, and functions that disturb them.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <phynness/formats/tool.hpp>
#include <vector>

namespace phynness::study {

struct StudyNode {
  std::int32_t node = 0;
  Vec3 point{};
  TouchedNodes tool;
  std::vector<Ray> rays;  ///< one per direction; status, force and displacement only
};

struct StudyData {
  DatabaseHeader header;          ///< its directions and magnitudes are those of the rays
  std::vector<StudyNode> probed;  ///< nodes that are trained and compared with solves; ascending
  std::vector<StudyNode> others;  ///< further nodes from which, with the probed ones, the shared modes are computed
};

/// Reads the given mesh nodes and `n_others` further nodes, distributed evenly over the list of active nodes.
StudyData read_data(const Database& database, std::vector<std::int32_t> probed, int n_others, double tool_radius_m);

/// Only these increments, counted from 0, ascending.
StudyData with_increments(StudyData data, const std::vector<std::size_t>& kept);
/// Marks random rays of each node as failed. Values of failed increments are NaN, so that their use in training would
/// be detected.
StudyData with_failed_rays(StudyData data, double share, std::uint64_t seed);
/// Marks every ray as failed except the given ones.
StudyData with_rays(StudyData data, const std::vector<std::size_t>& kept);
/// Marks increments as failed from this one on, counted from 0.
StudyData failing_from(StudyData data, std::size_t increment);
/// Every direction twice, the second copy with noise of this level.
StudyData duplicated(StudyData data, double level, std::uint64_t seed);
/// Normal noise on each component of forces and displacements. Its standard deviation is `level` times the largest
/// force of the node, or the largest displacement of a node that the probe itself does not move.
StudyData with_noise(StudyData data, double level, std::uint64_t seed);

double largest_force_N(const std::vector<Ray>& rays);

}  // namespace phynness::study
