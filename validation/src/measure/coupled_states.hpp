// Random rays of one tool between nodes, and of one tool or several on a body, for the calibration of bounds.
#pragma once

#include <phynness/formats/scene.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/named_organ.hpp>
#include <random>

#include "tool_rays.hpp"

namespace phynness {

/// States that were drawn, and those that the runtime flags, which have no bound.
struct DrawnStates {
  double all = 0, flagged = 0, unsettled = 0;
};

struct DrawnRay : ToolRay {
  std::vector<CoupledState> states;  ///< of each part and tool, without the force of the finite elements
};

class CoupledRays {
 public:
  /// @param body  whose flags and depth count, where the model is trained; null: those of the model
  CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body = nullptr);
  /// Whether there are places for one tool between nodes, or for several.
  bool possible(CoupledKind kind) const;
  /// Draws rays until the runtime does not flag all states of one. The largest displacement of a state's tools has the
  /// distribution that independent depths of the tools have; one state is in its lower half and one in its upper half,
  /// because a part of the way costs little. Every second ray of several tools is at nodes, every third one of tools
  /// near to its first one if half of the draws find such places, and half of them are of three tools.
  /// @return the parts that are not flagged; none if none was found
  DrawnRay draw(std::mt19937_64& random, std::int32_t ray, CoupledKind kind, DrawnStates& drawn) const;

 private:
  phn_tool random_tool(std::mt19937_64& random, bool at_node) const;
  double trained_depth(const phn_tool& tool, const Vec3& direction) const;
  /// Draws a displacement inside the trained range. @return the part of the range; 0: nothing is trained there
  double displace(std::mt19937_64& random, phn_tool& tool) const;
  Eigen::RowVector3d place(const phn_tool& tool) const;
  /// Fewer tools if there is no such place.
  ToolRay draw_any(std::mt19937_64& random, std::int32_t n_tools, bool at_nodes, bool near) const;
  /// The parts of a ray that the runtime does not flag.
  DrawnRay unflagged(const ToolRay& ray, DrawnStates& drawn) const;

  const NamedOrgan& _model;
  const NamedOrgan* _body;
  int _increments;
  std::vector<Eigen::Index> _triangles;
  double _near_m;
};

}  // namespace phynness
