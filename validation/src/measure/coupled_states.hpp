// Random rays of one tool between nodes, and of one tool or two on a body, for the calibration of bounds.
#pragma once

#include <phynness/formats/scene.hpp>
#include <phynness/validation/named_organ.hpp>
#include <random>

#include "tool_rays.hpp"

namespace phynness {

/// States that were drawn, and those that the runtime flags, which have no bound.
struct DrawnStates {
  double all = 0, flagged = 0;
};

class CoupledRays {
 public:
  /// @param body  whose flags and depth count, where the model is trained; null: those of the model
  CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body = nullptr);
  /// Whether there are places for one tool between nodes, or for two.
  bool possible(int n_tools) const;
  /// Draws rays of one state until one is not flagged. Of pairs every second one is at nodes, and every third one near
  /// if half of the draws find such a pair. @return without parts: none was found
  ToolRay draw(std::mt19937_64& random, std::int32_t ray, std::int32_t n_tools, DrawnStates& drawn) const;

 private:
  phn_tool random_tool(std::mt19937_64& random, bool at_node) const;
  bool is_flagged(const std::vector<phn_tool>& tools) const;
  double trained_depth(const phn_tool& tool, const Vec3& direction) const;
  /// Draws a displacement inside the trained range. @return false: nothing is trained there
  bool displace(std::mt19937_64& random, phn_tool& tool) const;
  Eigen::RowVector3d place(const phn_tool& tool) const;
  /// Fewer tools if there is no such place.
  ToolRay draw_any(std::mt19937_64& random, std::int32_t n_tools, bool at_nodes, bool near) const;

  const NamedOrgan& _model;
  const NamedOrgan* _body;
  int _increments;
  std::vector<Eigen::Index> _triangles;
  double _near_m;
};

}  // namespace phynness
