// Tools in contact: where each touches, and what the balance of a step needs.
#pragma once

#include <phynness/phynness_contact.h>

#include "bounding_volumes.hpp"
#include "coupled.hpp"

namespace PHN_RUNTIME {

/// What a tool does in this step, cut to what numbers can bear.
struct ToolInput {
  double center[3], radius, friction;
  std::int32_t mode;
  bool guarded;
};

struct ToolContact {
  bool known;     ///< it has been somewhere before
  bool anchored;  ///< it has a proxy: in contact, or inside a surface that others have pushed away
  bool felt;      ///< in contact
  std::int32_t mode;
  double radius, place[3];  ///< of the last step; free tools are outside there, or inside since they came to be
  SurfacePoint at;          ///< the proxy
  double grip[3];           ///< mode grasp: from the touched point to the centre [m]
  double displacement[3];   ///< of the touched point [m]
  double moved[3];          ///< in the last step [m]
  double given[3];          ///< the last force [N]
  double taken;             ///< mode press: work of the tool since it touched [J]
  double scale;             ///< of the force: what of the energy the tool may have back; 0: not in contact
  bool alone;               ///< and only then the energy is this tool's
  // Of a step.
  bool active;
  double normal[3], force[3];
  double unbalanced;        ///< what was cut off the force [N]
  SurfacePoint before;      ///< of the latest slide
  double slide[3], excess;  ///< that slide [m]; what the force had beyond the cone before [N], -1: none yet
  std::int32_t n_shortened, n_pulling;
};

}  // namespace PHN_RUNTIME

struct phn_contact {
  const phn_model* model;
  std::int32_t max_tools;
  PHN_RUNTIME::ContactSurface surface;
  PHN_RUNTIME::BoundingVolumes volumes;
  PHN_RUNTIME::ToolContact tool[PHN_RUNTIME::most_coupled];
};

namespace PHN_RUNTIME {

/// How far inside a start of a sweep may be and still be outside, in sizes of the body: far above rounding.
inline constexpr double sweep_slack = 1e-9;

/// Whether and where a tool touches, before forces are known.
void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool);

/// After refit, a free tool beside the surface goes with it. @param from  the place of `at` before
void carry(const phn_contact& contact, const SurfacePoint& at, const double* from, ToolContact& tool);

/// What phn_couple is asked for.
phn_tool held_by(const phn_contact& contact, const ToolContact& tool);

/// Forces of all anchored tools: slides, and lets go what would pull. @return a status of phynness.h
int balance(phn_contact& contact, phn_data& data, std::int32_t n_tools, const ToolInput* inputs, phn_coupled* result);

}  // namespace PHN_RUNTIME
