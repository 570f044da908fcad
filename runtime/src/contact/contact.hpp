// State of tools in contact: where each touches, and the quantities that the force balance of a step needs.
#pragma once

#include <phynness/phynness_body.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_tools.h>

#include "contact/bounding_volumes.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Largest number of tools.
inline constexpr std::int32_t most_touching = PHN_MOST_COUPLED;

/// What contact asks of the object that tools touch: a body, a model of a round tool, or a model of nodes. No function
/// is pure, because the library links none for C++.
class Touched {
 public:
  bool has_energy = false;
  double max_displacement_m = 0;
  double near_m = 0;  ///< distance from which on tools of a body do not matter to each other
  /// Newton's steps that are left for a step on a body, whose responses go on from the last one. -1: a
  /// model, whose responses depend on the tools alone.
  std::int32_t steps = -1;
  double unbalanced = 0;  ///< of the last hold()

  bool is_body() const { return steps >= 0; }
  /// Forces [N] that hold the first n of n_all tools, n x 3. The others are only near to them, of a body, at heights
  /// over the surface [m]. @return a status of phynness.h
  virtual int hold(std::int32_t, std::int32_t, const phn_tool*, const double*, double*, phn_coupled&) {
    return PHN_ERROR_UNDEFINED;
  }
  /// Of a model: of a tool of the last hold(), at rest with the others held [N/m].
  virtual Matrix stiffness(std::int32_t) const { return {}; }
  /// Of a body: of the n tools of the last hold(), also those that are only near, n x n [m/N]. @return whether it is
  /// known
  virtual bool compliance(std::int32_t, Matrix*) const { return false; }
  /// Where a body, and the springs of other tools, put a tool of the last hold() that is only near [m].
  virtual Vector displacement(std::int32_t) const { return {}; }
};

/// Input of a tool in this step, clamped so that no later computation overflows.
struct ToolInput {
  double center[3], radius, friction;
  std::int32_t mode;
};

struct ToolContact {
  bool known;     ///< it had a position in the last step
  bool anchored;  ///< it has a proxy: in contact, or inside a surface that other tools have pushed away
  bool felt;      ///< in contact
  std::int32_t mode;
  double radius, place[3];  ///< of the last step; a free tool is outside there, or has been inside since it appeared
  SurfacePoint at;          ///< the proxy
  double grip[3];           ///< mode grasp: from the touched point to the centre [m]
  double displacement[3];   ///< of the touched point [m]
  double moved[3];          ///< in the last step [m]
  double given[3];          ///< the last force [N]
  double scale;             ///< factor of the force that limits the returned work; 0: not in contact
  bool loose;               ///< anchored without a force in the last step
  std::int32_t order;       ///< on a body: 1 + its number among the tools of the last response; 0: none of them
  bool is_new;              ///< it was none before
  // Quantities of one step.
  bool active;
  double normal[3], force[3];
  double unbalanced;        ///< removed part of the force [N]
  SurfacePoint first;       ///< the proxy before all slides
  SurfacePoint before;      ///< the proxy before the latest slide
  double slide[3], excess;  ///< that slide [m]; force in excess of the cone before it [N], -1: no slide yet
  std::int32_t n_shortened, n_fallen;
  bool pulls;    ///< and should be left out
  bool stopped;  ///< by an edge, on a body
};

}  // namespace PHN_RUNTIME

struct phn_contact {
  std::int32_t max_tools;
  double taken;  ///< work done by all tools since one of them is in contact [J]
  double scale;  ///< of the forces of tools that press; 0: none is in contact
  /// Forces of the body's last step, which had n_before tools with these forces [N] at these places [m].
  bool is_known;
  std::int32_t n_before, n_held;  ///< of which n_held were held
  PHN_RUNTIME::Vector held_by[PHN_RUNTIME::most_touching], held_at[PHN_RUNTIME::most_touching];
  PHN_RUNTIME::ContactSurface surface;
  PHN_RUNTIME::BoundingVolumes volumes;
  PHN_RUNTIME::ToolContact tool[PHN_RUNTIME::most_touching];
  phn_data* data;         ///< of contact with a model, or null
  phn_body_state* state;  ///< of contact with a body, or null
  std::int32_t steps;     ///< of Newton's method, at most, that a step makes on the body
  double* field;          ///< 3 surface.n_field; null: of one tool only
  std::int32_t n_tools;   ///< of the last step
  bool is_displaced;      ///< surface.placed
};

namespace PHN_RUNTIME {

/// A sweep may start this far inside the surface, in sizes of the body, and still count as outside: far more than
/// rounding errors.
inline constexpr double sweep_slack = 1e-9;

/// Determines whether and where a tool touches, before forces are known.
void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool);

/// Moves a free tool beside the surface with the surface, after a refit. @param from  position of `at` before the refit
void carry(const phn_contact& contact, const SurfacePoint& at, const double* from, ToolContact& tool);

/// The place of a tool and its displacement.
phn_tool held_by(const phn_contact& contact, const ToolContact& tool);

/// Scales the forces of tools that press, so that all tools together do not get back more work than they did, and a
/// credit. Work is the mean of two successive forces times the motion between them. It is less than the energy of the
/// body where a tool slides uphill, as one that enters does. Forces are scaled where the work falls below a part of the
/// energy; on the way back they then vanish before the work is returned, however small that part, and on the way in
/// they grow back. What the next step may return is covered, too. Without an energy they are kept.
/// @param energy   of the body [J]
void guard(phn_contact& contact, const Touched& touched, std::int32_t n_tools, const ToolInput* inputs, double energy);

/// Computes the forces of all anchored tools: lets points slide, and ends contacts that would pull.
/// @return a status of phynness.h
int balance(phn_contact& contact, Touched& touched, std::int32_t n_tools, const ToolInput* inputs, phn_coupled& result);

/// The triangles of a model or a body, and its vertices, of which the first n_field have rows in fields.
struct WholeSurface {
  std::int32_t n_vertices, n_field, n_triangles;
  const std::int32_t* triangles;
};
struct ContactParts {
  phn_contact* contact;
  phn_data* data = nullptr;
  phn_body_state* state = nullptr;
  double* field;
  ContactSurface surface;
  BoundingVolumes volumes;
  TouchableEdge* scratch;
};
/// @return a status of phynness.h, as those below
int lay_out_contact(Arena& arena, const WholeSurface& whole, std::int32_t max_tools, ContactParts& parts);
/// @param status  of the layout, by an arena that counts
int size_of_contact(const Arena& arena, int status, std::size_t* bytes);
/// @param parts  rest, node and active of the surface's vertices are set
int build_contact(const WholeSurface& whole, std::int32_t max_tools, std::int32_t steps, ContactParts& parts,
                  phn_contact** contact);
/// A step without its outputs.
/// @param report  must not overlap the states
int step_contact(phn_contact& contact, Touched& touched, std::int32_t n_tools, const phn_contact_tool* tools,
                 const phn_contact_state* states, const phn_contact_report* report, phn_coupled& coupled);
/// The same, for a model or a body.
int step_on_model(phn_contact& contact, std::int32_t n_tools, const phn_contact_tool* tools,
                  const phn_contact_state* states, const phn_contact_report* report, phn_contact_report& made);
int step_on_body(phn_contact& contact, std::int32_t n_tools, const phn_contact_tool* tools,
                 const phn_contact_state* states, const phn_contact_report* report, phn_contact_report& made);
/// The field of the last step. @param out  3 surface.n_field
int field_of_contact(const phn_contact& contact, double* out);

}  // namespace PHN_RUNTIME
