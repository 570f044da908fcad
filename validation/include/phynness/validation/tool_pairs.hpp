// Two tools at nodes: coupled responses of the model against finite element solves with both nodes
// prescribed.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <phynness/validation/validation.hpp>
#include <vector>

namespace phynness {

/// alone: force of each tool as if the other were not there, sum of the two fields. paper: the weights
/// (15)-(16), which have no force. linear: the undeformed body's responses to both tools at once.
enum class PairPredictor { coupled, alone, paper, linear };
inline constexpr std::array<PairPredictor, 4> pair_predictors{PairPredictor::coupled, PairPredictor::alone,
                                                              PairPredictor::paper, PairPredictor::linear};
const char* name(PairPredictor);

/// As fractions. The errors of force are those of the tool where they are larger.
struct PairErrors {
  double force = 0;             ///< difference over the larger of the two finite element forces
  double force_own = 0;         ///< difference over that tool's own finite element force
  double displacement = 0;      ///< as (17): mean difference over the largest displacement, touched nodes left out
  double field_l2 = 0;          ///< Euclidean norms over the same nodes
  double displacement_all = 0;  ///< mean difference over the largest displacement, touched nodes included
};

struct PairRecord {
  std::array<std::int32_t, 2> nodes{};
  std::array<Vec3, 2> displacement_m{};
  double distance_m = 0;  ///< of the nodes at rest
  bool solved = false;    ///< by the finite elements; what follows is 0 otherwise
  int status = 0;         ///< of phn_couple: warnings
  double residual_m = 0;
  /// Of the model's answers for each tool alone against a solve of it alone, the worse, over its finite
  /// element force; infinite where one was not solved. What the pair's error has of it is not that of
  /// coupling.
  double single_force = 0;
  std::array<PairErrors, pair_predictors.size()> errors;  ///< by PairPredictor
  const PairErrors& of(PairPredictor p) const { return errors[static_cast<std::size_t>(p)]; }
};

struct PairStatistics {
  ErrorStatistics force, force_own, displacement, field_l2, displacement_all;
};

/// Pairs of one kind: all, by distance, by whether the model settled.
struct PairGroup {
  std::int64_t pairs = 0;
  std::array<PairStatistics, pair_predictors.size()> errors;  ///< by PairPredictor
  const PairStatistics& of(PairPredictor p) const { return errors[static_cast<std::size_t>(p)]; }
};

struct PairReport {
  std::int64_t pairs = 0;                   ///< asked for
  std::int64_t finished = 0;                ///< fewer if it was interrupted
  std::int64_t failed = 0;                  ///< of these, not solved by the finite elements
  std::int64_t unsettled = 0, outside = 0;  ///< of the solved, where the model warns so
  double depth_m = 0, far_m = 0;
  double largest_residual_m = 0;
  PairGroup all, near, far;
  PairGroup right;  ///< where the model is right_alone about both tools
  ErrorStatistics single_force;
  std::vector<PairRecord> records;  ///< finished ones, in the order of the seed
  double seconds = 0;
  bool interrupted() const { return finished < pairs; }
};

/// Depth of both tools if none is asked for, as a fraction of the trained one: 12 mm of the paper's 28.
inline constexpr double pair_depth_fraction = 12.0 / 28;
/// Errors of force of a tool alone up to which what is left of a pair's error is that of coupling.
inline constexpr double right_alone = 0.02;
/// Tools farther apart than this fraction of the body's longest extent are called far.
inline constexpr double far_fraction = 0.3;

/// Random pairs of active nodes, none left out but, with patches, those that overlap; directions uniform on
/// the sphere, or the half of it that points inward in hemisphere scenes; both tools `depth_m` deep.
/// Collective; the result is the same for any number of ranks and complete on rank 0. Where `stop` says so it
/// ends with the pairs that are finished.
/// @throws Error if the model has fewer than two active nodes that can be touched together, or forces only
PairReport validate_pairs(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                          std::int64_t pairs, double depth_m, std::uint64_t seed,
                          const std::function<void(std::int64_t, std::int64_t)>& progress = {},
                          const std::function<bool()>& stop = {});

}  // namespace phynness
