// The rays of a scene in rounds: with [probe] target_error, the further directions of a node are solved only if its
// rays so far ask for them.
#pragma once

#include <phynness/formats/ray_tasks.hpp>
#include <phynness/precompute/precompute.hpp>
#include <vector>

namespace phynness {

class DirectionRounds {
 public:
  /// @param requested  n_active x n_directions flags, of requested_rays()
  /// @param predict    PrecomputeTarget::predict; empty: all requested rays are in one round
  DirectionRounds(const Scene& scene, const DatabaseHeader& header, std::vector<char> requested,
                  ErrorPrediction predict);

  /// The rays of the rounds so far that are not yet logged.
  std::vector<RayIndex> left(const std::vector<char>& logged) const;
  /// Collective: predicts errors from the logged rays of the rounds so far, and adds rays where they are too large. The
  /// answer depends on these rays only, so that a resumed run repeats it.
  /// @return whether rays were added
  bool next(const SolverSession& session, const std::filesystem::path& file);
  /// On rank 0, after the last next(): a ray that is not solved. Where it is left out, its end_depth is the smaller
  /// depth of the two nearest directions that are not.
  Ray left_out(const RayIndex& ray) const;
  /// Sets the figures.
  void report(PrecomputeReport& report) const;

 private:
  std::size_t index(std::int32_t active, std::size_t direction) const {
    return static_cast<std::size_t>(active) * _header.directions.size() + direction;
  }
  /// Whether a ray is in the rounds so far of its node.
  bool is_wanted(std::int32_t active, std::size_t direction) const;
  /// Error of a node's rays so far; infinite if some end early and further directions may show where.
  double predicted(std::int32_t active) const;
  void read(const SolverSession& session, const std::filesystem::path& file);

  const DatabaseHeader& _header;
  std::vector<char> _requested;
  ErrorPrediction _predict;
  double _target = 0;
  std::vector<int> _rounds;       ///< per active node: its last round
  std::vector<double> _errors;    ///< per active node, of its last round
  std::vector<Status> _statuses;  ///< of the logged rays, [active][direction][increment]
  std::vector<double> _forces;    ///< x 3
  std::vector<double> _depths_m;  ///< [active][direction], on rank 0
};

}  // namespace phynness
