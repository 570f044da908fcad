// Random rays of one tool between nodes, and of one tool or several on a body, for the calibration of bounds.
#pragma once

#include <phynness/formats/scene.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/named_organ.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <random>

#include "tool_rays.hpp"

namespace phynness {

/// Numbers of drawn states, and of those that the runtime flags, which have no bound.
struct DrawnStates {
  double all = 0, flagged = 0, unsettled = 0;
};

struct DrawnRay : ToolRay {
  std::vector<CoupledState> states;  ///< states per fraction and tool, without the finite element forces
};

class CoupledRays {
 public:
  /// @param body  that answers, wherever it does without a warning; null: the model, where three corners were probed
  CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body = nullptr);
  /// Whether there are places for one tool between nodes, or for several.
  bool is_possible(CoupledKind kind) const;
  /// Draws rays until some state of a ray is not flagged. The largest displacement of a state has the distribution of
  /// the maximum of independent depths; one state is in its lower half and one in its upper half. Of the rays of
  /// several tools every third one has tools near the first one if they are found, and half have three tools.
  /// @return the ray with the unflagged fractions; without fractions if none was found
  DrawnRay draw(std::mt19937_64& random, std::int32_t ray, CoupledKind kind, DrawnStates& drawn) const;

 private:
  double trained_depth(const phn_tool& tool, const Vec3& direction) const;
  /// Draws a displacement: of a body up to its depth, of a model inside of the trained range. @return its fraction of
  /// the range; 0 if nothing is trained there
  double draw_displacement(std::mt19937_64& random, const SurfacePoint& place, phn_tool& tool) const;
  /// Draws a ray with its flagged states; it has fewer tools if a place is not found.
  ToolRay draw_candidate(std::mt19937_64& random, std::int32_t n_tools, bool near) const;
  /// The ray without the fractions that the runtime flags.
  DrawnRay without_flagged(const ToolRay& ray, DrawnStates& drawn) const;

  const NamedOrgan& _model;
  const NamedOrgan* _body;
  RandomPlaces _places;
  ProbeSpec _probe;
};

}  // namespace phynness
