/* phynness: spherical tools that touch, slide on, press and grasp a trained object.
 *
 * Once a haptic cycle: where the tools are, in; what they feel, out. A tool in contact has a proxy, the point of the
 * surface at rest that it touches; phn_couple says what it costs to hold that point where the tool is. The touched
 * point follows the tool exactly.
 *
 * Memory, statuses, units, frames and sign of the force: as in phynness.h, also what may overlap: states may lie in the
 * memory of the tools that they answer. One phn_contact for each thread that moves
 * tools, with a phn_data of the same thread; nothing is shared between them but the model.
 *
 * The surface that a sphere of radius r meets is the triangles of phn_info.triangles with each vertex moved out by r,
 * along its mean normal and so far that the triangles around it move by r (at most 2 r, at sharp corners); the sphere's
 * centre is a point against it. Between vertices these offsets are interpolated: their direction is the outward normal
 * that words below mean. It is continuous over edges and nodes, and that of the surface at rest.
 */
#ifndef PHYNNESS_CONTACT_H
#define PHYNNESS_CONTACT_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_contact phn_contact;

enum {
  PHN_TOOL_OFF = 0,   /* touches nothing */
  PHN_TOOL_PRESS = 1, /* pushes only; Coulomb friction */
  PHN_TOOL_GRASP = 2  /* holds the first point that it touches until the mode changes; pushes and pulls */
};

typedef struct phn_contact_tool {
  double center[3]; /* of the sphere, where the device is [m]; components are cut at 1000 sizes of the body */
  double radius;    /* >= 0 [m]; cut at the size of the body, the diagonal of its box */
  double friction;  /* coefficient, >= 0; 0: none. Read in mode press */
  int32_t mode;
  int32_t unguarded; /* mode press. 0: never gives back more work than it took; 1: the force of phn_couple as it is */
} phn_contact_tool;

typedef struct phn_contact_state {
  double force[3];    /* on the body [N]; a device renders its negative. Zeros without contact */
  double proxy[3];    /* centre of the sphere on the surface at rest [m]; without contact where the tool is */
  double normal[3];   /* outward, unit; zeros without contact */
  double scale;       /* of the force: 1, or less so that the tool does not gain; 0 without contact */
  double unbalanced;  /* mode press: |force of phn_couple - force / scale|, what sliding did not yet relieve [N] */
  phn_tool held;      /* what phn_couple was asked for; nodes are -1 without contact */
  int32_t in_contact; /* 1 or 0 */
} phn_contact_state;

/* For up to max_tools (1 ... 8) tools. Memory: some 200 bytes a triangle. Cost of init: a millisecond for 1,000
 * triangles. Triangles can be touched whose corners are active or fixed, not all of them fixed; tools pass through
 * others, and through the twentieth of a triangle beside a fixed edge. PHN_ERROR_UNDEFINED: there are none.
 * PHN_ERROR_TOO_MANY_TOOLS: max_tools is more than 8. PHN_ERROR_GEOMETRY: coordinates are too large for squares of
 * areas. */
PHN_API int phn_contact_size(const phn_model* model, int32_t max_tools, size_t* bytes);
PHN_API int phn_contact_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools,
                             phn_contact** contact);

/* Tools 0 ... n_tools - 1 at their new places; n_tools <= max_tools, and data was made for as many. Tool t is the same
 * tool in every call; one that is left out, or off, or new, is free where it is then: if that is inside the body it
 * leaves unfelt.
 *
 * Free tools are swept from their last place to the new one in a straight line: no speed and no thin part lets one
 * through from outside. In contact a tool stays on its side of the surface, however far it is pushed.
 *
 * Press: force . normal <= 0, and |tangential force| <= friction |force . normal|, always. While phn_couple's force is
 * inside this cone the touched point sticks. Otherwise it slides over the triangles until the force is within 1e-4 of
 * it, in at most 8 steps a call, 4 with two tools in contact and 2 with more; what these leave is cut off the force and
 * told in `unbalanced`. Contact ends where the force would pull. Of tools that press at one place the deepest is felt.
 * A tool that slides with little friction from soft to stiff tissue would give back more work than it took: its force
 * is normal, and moving it sideways costs none. Unless `unguarded`, force is scaled down to what was taken, in families
 * that have an energy, continuously; with several tools in contact scales stay what they were. With friction there is
 * seldom anything to scale (docs/decisions/contact.md).
 *
 * Grasp: the point keeps its place under the tool; the force is phn_couple's. A tool that grasps when the surface is
 * within its radius takes the nearest point, and nothing moves; one in contact takes the point that it touches.
 *
 * `result` may be null: that of the last phn_couple. `data` is left with it, so phn_coupled_deform is the deformation
 * of this cycle. Refused calls leave the tools where they were. PHN_ERROR_NOT_FINITE: a centre, radius or friction.
 * Cost: a sweep for each free tool, below a microsecond for 1,000 triangles. With tools in contact 1 phn_couple of them
 * if they stick, 2 to 4 while they slide; at most 10 of one tool, 6 of two, 4 of more. */
PHN_API int phn_contact_step(phn_contact* contact, phn_data* data, int32_t n_tools, const phn_contact_tool* tools,
                             phn_contact_state* states, phn_coupled* result);

/* All tools are new. */
PHN_API int phn_contact_reset(phn_contact* contact);

/* The surface that free tools meet, displaced by a field of phn_coupled_deform, n_output x 3 [m]; null: at rest, as
 * after init. Only wanted with several tools: a single one meets the surface at rest. Without it a tool feels nothing
 * until it reaches what others have pushed in, exactly; what others pushed or pulled outwards it reaches late. A free
 * tool beside a surface that moves is carried with it, so an old field costs no tunnelling, only a touch that is early
 * or late by what it is old. Offsets keep the directions that they have at rest. Components are cut at 1000 sizes of
 * the body. Cost: a pass over vertices and boxes, some 25 us for 1,000 triangles. */
PHN_API int phn_contact_refit(phn_contact* contact, const double* field);

/* The tools in contact at the last step, at most 8, in order: for phn_couple with the phn_data of another thread, which
 * draws. Returns their number. */
PHN_API int32_t phn_contact_held(const phn_contact* contact, phn_tool* tools);

/* As phn_nearest, by the hierarchy, on those triangles that can be touched, displaced as by the last refit. */
PHN_API int phn_contact_nearest(const phn_contact* contact, const double x[3], phn_tool* tool, double point[3]);

#ifdef __cplusplus
}
#endif

#endif
