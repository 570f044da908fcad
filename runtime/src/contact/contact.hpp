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

/// The object that tools touch: a body, a model of a round tool, or a model of nodes. No function is pure virtual,
/// because the library links none for C++.
class Touched {
 public:
  bool has_energy = false;
  double max_displacement_m = 0;
  double near_m = 0;  ///< distance from which on tools on a body are independent
  /// Newton's steps that remain for this step of contact on a body, whose responses continue from the last one; -1: a
  /// model, whose responses depend on the tools alone.
  std::int32_t steps = -1;
  double unbalanced = 0;  ///< of the last hold()

  bool is_body() const { return steps >= 0; }
  /// Forces [N] that hold the first n of n_all tools, n x 3. The others, of a body, are only near to them, at heights
  /// over the surface [m]. @return a status of phynness.h
  virtual int hold(std::int32_t, std::int32_t, const phn_tool*, const double*, double*, phn_coupled&) {
    return PHN_ERROR_UNDEFINED;
  }
  /// Stiffness at rest under a tool of the last hold() of a model, where the other tools are held [N/m].
  virtual Matrix stiffness(std::int32_t) const { return {}; }
  /// Compliance (tool, tool) between the tools of the last hold() of a body, including those that are only near [m/N].
  /// @return whether it is known
  virtual bool compliance(const MatrixView<Matrix>&) const { return false; }
  /// Displacement of a body, and of the springs of other tools, at a tool of the last hold() that is only near [m].
  virtual Vector displacement(std::int32_t) const { return {}; }
};

/// Input of a tool in this step, clamped so that no later computation overflows.
struct ToolInput {
  Vector center;
  double radius, friction;
  std::int32_t mode;
};

/// State of a tool. Its proxy is the point of the surface that it touches.
struct ToolContact {
  bool has_position;  ///< The tool was there in the last step.
  bool has_proxy;     ///< It is in contact, or inside of a surface that other tools have pushed away.
  bool in_contact;    ///< It has a force.
  std::int32_t mode;
  double radius;
  Vector position;  ///< of the last step; a free tool is outside, or has been inside since it appeared
  SurfacePoint proxy;
  Vector grasp_offset;          ///< mode grasp: from the touched point to the centre [m]
  Vector displacement;          ///< of the touched point [m]
  Vector motion;                ///< of the centre in the last step [m]
  Vector last_force;            ///< [N]
  double scale;                 ///< factor of the force that limits the returned work; 0: not in contact
  bool was_separated;           ///< It had a proxy without a force in the last step.
  std::int32_t response_index;  ///< on a body: 1 + its number among the tools of the last response; 0: none of them
  bool is_new;                  ///< It was in no response before.
  // Quantities of one step.
  bool active;
  Vector normal, force;
  double unbalanced;         ///< removed part of the force [N]
  SurfacePoint first_proxy;  ///< the proxy before all slides
  SurfacePoint last_proxy;   ///< the proxy before the latest slide
  Vector slide;              ///< that slide [m]
  double cone_excess;        ///< force outside of the friction cone before it [N]; -1: no slide
  std::int32_t n_cuts, n_projections;
  bool is_tensile;  ///< The surface would have to be pulled. The tool should be left out.
  bool is_at_edge;  ///< on a body: an edge stopped the proxy
};

}  // namespace PHN_RUNTIME

struct phn_contact {
  std::int32_t max_tools;
  double work;   ///< work done by all tools since one of them has been in contact [J]
  double scale;  ///< factor of the forces of tools that press; 0: none is in contact
  /// Forces [N] and displacements [m] of the n_response tools of the body's last step, of which n_held were held.
  bool has_response;
  std::int32_t n_response, n_held;
  PHN_RUNTIME::Vector response_force[PHN_RUNTIME::most_touching], response_displacement[PHN_RUNTIME::most_touching];
  PHN_RUNTIME::ContactSurface surface;
  PHN_RUNTIME::BoundingVolumes volumes;
  PHN_RUNTIME::ToolContact tool[PHN_RUNTIME::most_touching];
  phn_data* data;         ///< of contact with a model, or null
  phn_body_state* state;  ///< of contact with a body, or null
  std::int32_t steps;     ///< largest number of Newton's steps on the body in a step
  double* field;          ///< 3 surface.n_field; null: contact of one tool only
  std::int32_t n_tools;   ///< of the last step
  bool is_displaced;      ///< whether surface.placed is not the surface at rest
};

namespace PHN_RUNTIME {

/// The start of a sweep counts as outside up to this depth inside of the surface, in sizes of the body. It is far
/// larger than rounding errors.
inline constexpr double sweep_slack = 1e-9;

/// Determines whether and where a tool touches, before forces are known.
void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool);

/// Moves a free tool with the surface beside it, after a refit. @param from  position of `point` before the refit
void advect(const phn_contact& contact, const SurfacePoint& point, const Vector& from, ToolContact& tool);

/// The constraint of a tool: the place of its proxy and the displacement that it prescribes there.
phn_tool constraint_of(const phn_contact& contact, const ToolContact& tool);

/// Scales the forces of tools that press, so that the tools together do not get back more than the work that they did
/// and a credit. The work of a step is the mean of two successive forces times the motion between them. It is less than
/// the energy of the body where a tool slides uphill, as one that enters does. Forces are scaled where the work falls
/// below a part of the energy: on the way back they then vanish before the work is returned, however small that part,
/// and on the way in they grow back. The work that the next step may return is covered, too. Without an energy the
/// forces are unchanged.
/// @param energy   of the body [J]
void guard(phn_contact& contact, const Touched& touched, std::int32_t n_tools, const ToolInput* inputs, double energy);

/// Computes the forces of all tools with a proxy: proxies slide, and contacts with a tensile force end.
/// @return a status of phynness.h
int balance(phn_contact& contact, Touched& touched, std::int32_t n_tools, const ToolInput* inputs, phn_coupled& result);

/// The triangles of a model or a body, and its vertices, of which the first n_field have rows in fields.
struct WholeSurface {
  std::int32_t n_vertices, n_field, n_triangles;
  const std::int32_t* triangles;
};
struct ContactParts {
  phn_contact* contact;   ///< in the arena
  phn_contact made = {};  ///< its contents
  TouchableEdge* scratch;
};
/// @return a status of phynness.h, like the functions below
int lay_out_contact(Arena& arena, const WholeSurface& whole, std::int32_t max_tools, ContactParts& parts);
/// Answers phn_contact_size and phn_body_contact_size.
template <class Object>
int size_of_contact(int (*lay_out)(Arena&, const Object&, std::int32_t, ContactParts&), const Object* object,
                    std::int32_t max_tools, std::size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (object == nullptr) return PHN_ERROR_ARGUMENT;
  Arena arena;
  ContactParts parts;
  const int status = lay_out(arena, *object, max_tools, parts);
  if (status == PHN_OK) *bytes = arena.needed();
  return status == PHN_ERROR_BUFFER ? PHN_ERROR_TOO_LARGE : status;
}
/// @param parts  rest, node and active of the surface's vertices are set
int build_contact(const WholeSurface& whole, ContactParts& parts, phn_contact** contact);
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
