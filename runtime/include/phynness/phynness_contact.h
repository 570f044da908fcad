/* phynness: spherical tools that touch, slide on, press and grasp a trained object: a model, or a body.
 *
 * phn_contact_step is called once in each haptic cycle with the positions of the tools; it gives their forces. A tool
 * in contact has a proxy: the point of the undeformed surface that it touches. The model or the body gives the force
 * that holds this point at the position of the tool. The touched point follows the tool exactly. In a model of round
 * tools the mean of the surface around it does: exactly at a node, within a few per cent between nodes, less well
 * beside fixed ones.
 *
 * Memory, statuses, units, frames, overlap and the sign of the force are those of phynness.h; the states may overlap
 * the tools in memory. Each thread that moves tools has its own phn_contact; threads share only
 * the model or the body.
 *
 * For a sphere of radius r, each vertex of phn_info.triangles is moved outwards along its mean normal, so far that the
 * triangles around it move by r (at sharp corners at most by 2 r). Contact of the sphere is contact of its centre with
 * these offset triangles. Between vertices the offset vectors are interpolated. Their direction is called the outward
 * normal below. It belongs to the undeformed surface and is continuous over edges and nodes.
 */
#ifndef PHYNNESS_CONTACT_H
#define PHYNNESS_CONTACT_H

#include <phynness/phynness_body.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_contact phn_contact;

enum {
  PHN_TOOL_OFF = 0,   /* no contact */
  PHN_TOOL_PRESS = 1, /* pushes only, with Coulomb friction */
  PHN_TOOL_GRASP = 2  /* holds the first point that it touches until the mode changes; pushes and pulls */
};

typedef struct phn_contact_tool {
  double center[3];           /* of the sphere, at the position of the device [m]; clamped to 1000 sizes of the body */
  double radius;              /* >= 0 [m]; clamped to the size of the body, which is the diagonal of its bounding box */
  double friction;            /* coefficient >= 0 of mode press; 0: frictionless */
  int32_t mode;               /* PHN_TOOL_* */
  int32_t reserved PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_contact_tool;

typedef struct phn_contact_state {
  double force[3];    /* on the body [N]; a device renders its negative. Zeros without contact */
  double proxy[3];    /* centre of the sphere on the undeformed surface [m]; without contact the tool's position */
  double normal[3];   /* outward unit normal; zeros without contact */
  double scale;       /* factor of the force: 1, or less where tools would gain energy; 0 without contact */
  double unbalanced;  /* mode press: |force that holds the point - force / scale| [N], not yet relieved by sliding */
  phn_tool held;      /* the tool that holds the point, for a phn_data or phn_body_state of another thread, which draws;
                         nodes are -1 without contact */
  int32_t in_contact; /* 1 or 0 */
  int32_t reserved PHN_ZEROS;
} phn_contact_state;

/* Of all tools of a step. */
typedef struct phn_contact_report {
  double energy;     /* [J]; 0 in family rbfn */
  double residual_m; /* largest distance of a tool from the place that it holds */
  double unbalanced; /* of a body: as in phn_body_report; 0 of a model */
  int32_t steps;     /* of Newton's method that a body made or undid; 0 of a model */
  int32_t reserved PHN_ZEROS;
} phn_contact_report;

/* Contact of up to max_tools (1 ... 8) tools with a model, or with a body, for which a step makes at most `steps` (>=
 * 1) steps of Newton's method, and one more for each twentieth of max_displacement_m that a tool moves in it, up to
 * 20, so that a tool that jumps is felt at once. It has a phn_data or phn_body_state of its own. Memory: that, and
 * about 200 bytes for each triangle. Cost of init: a millisecond for 1,000 triangles. A triangle can be touched if its
 * corners are active, covered or fixed, of a body fixed or within the tool's radius of a probed point, and not all
 * fixed. Tools pass through other triangles, and through a strip of 1/20 of a triangle beside a fixed edge.
 * PHN_ERROR_UNDEFINED: no triangle can be touched. PHN_ERROR_TOO_MANY_TOOLS: max_tools > 8. PHN_ERROR_GEOMETRY:
 * coordinates are so large that squares of areas overflow. */
PHN_API int phn_contact_size(const phn_model* model, int32_t max_tools, size_t* bytes);
PHN_API int phn_contact_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools,
                             phn_contact** contact);
PHN_API int phn_body_contact_size(const phn_body* body, int32_t max_tools, size_t* bytes);
PHN_API int phn_body_contact_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools, int32_t steps,
                                  phn_contact** contact);

/* Moves tools 0 ... n_tools - 1 to their new positions and computes their states. Tool t is the same tool in every
 * call. A tool that is new, off, or beyond n_tools in a call has no contact at its position in that call. If this
 * position is inside the body, the tool leaves the body without a force.
 *
 * A tool without contact is swept along the straight line from its last position to the new one. It therefore cannot
 * pass through the surface from outside, at any speed and at any thin part. A tool in contact stays on its side of the
 * surface, however far it is pushed.
 *
 * Press: force . normal <= 0 and |tangential force| <= friction |force . normal| always hold. While the force that
 * holds the touched point is inside this friction cone, the touched point sticks. Otherwise the point slides over the
 * triangles until the force is within 1e-4 of the cone, in at most 8 steps per call (4 with two tools in contact, 2
 * with more). If these steps do not suffice, the force is projected onto the cone and `unbalanced` is the difference.
 * Contact ends where the force would pull. A tool that others have pushed the surface away from follows it without a
 * force. Of several tools that press at one point of a model, only the deepest has a force; on a body they share it.
 *
 * A tool that slides with little friction from soft to stiff tissue would return more work than was done on it, because
 * its force is normal and sideways motion does no work. In families with an energy, and of a body, the forces of
 * tools that press are therefore scaled down, continuously and by one factor, so that all tools together do not get
 * back more work than they did. The factor is below 1 only where they did less work than a third of the energy, and
 * grows back as they press on. It is late where a force itself jumps within a cycle: of
 * tools that squeeze a thin body, of a body that is _UNSETTLED, of motion by millimetres in a cycle
 * (docs/decisions/contact.md).
 *
 * Grasp: the tool holds its point, and the force is what that takes. A tool that starts to grasp holds the nearest
 * point if the surface is within its radius, and the point does not move. A tool in contact holds the touched point.
 *
 * Several tools: where one grasps, the others meet the surface that the step before has displaced, pushed in or pulled
 * out; offsets keep their undeformed directions. A surface that others push in is met late without that, and a tool
 * that hovers in a dent is caught by the surface that comes back.
 *
 * A body: forces and slides of all tools are predicted together before and after each of Newton's steps, and the forces
 * are the last predicted ones. _UNSETTLED: also where this moves a force by more than a twentieth of the largest. A
 * proxy slides by at most twice the motion of its tool and a hundredth of the tool's radius in a call.
 *
 * `report` may be null. A refused call does not move the tools. PHN_ERROR_NOT_FINITE: a centre, radius or friction is
 * NaN or infinite. _ROUND_TOOLS: several tools on a model of round tools. Cost: for each tool without contact a sweep,
 * less than a microsecond for 1,000 triangles; several tools, one field and a pass over vertices and boxes (25 us for
 * 1,000 triangles); for the tools in contact 1 phn_force or phn_couple if they stick and 2 to 4 while they slide, at
 * most 9 with one tool, 5 with two tools and 3 with more, and as many again for each tool that is left out; of a body
 * its steps. */
PHN_API int phn_contact_step(phn_contact* contact, int32_t n_tools, const phn_contact_tool* tools,
                             phn_contact_state* states, phn_contact_report* report);

/* Displacements [m] in the last step, zeros before: of a model's output nodes, n_output x 3, of a body's nodes,
 * n_nodes x 3. */
PHN_API int phn_contact_deform(phn_contact* contact, double* out);

/* Ends every contact and forgets all positions: in the next step all tools are new. */
PHN_API int phn_contact_reset(phn_contact* contact);

#ifdef __cplusplus
}
#endif

#endif
