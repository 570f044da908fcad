/* phynness: a reduced body, on which round tools act anywhere, several at once and near to each other.
 *
 * A model (phynness.h) knows what one tool does. A body has the elements of the training itself: their strain energy is
 * summed over a few cells and minimized in a few hundred modes of displacement (docs/theory.md, Reduced body). It needs
 * no model. `phynness run` with `[probe] tools` of 2 to 8, or `phynness reduce DATABASE`, makes a body.txt. It takes
 * 0.1 to 1 ms for a step on a processor of a desktop and is not meant for microcontrollers. Spheres touch it with
 * phn_body_contact_init (phynness_contact.h).
 *
 * Memory, statuses, units, frames, overlap, the sign of the force, and phn_tool are those of phynness.h. A tool is the
 * round tool of the training with its middle at the point; the mean displacement under it is prescribed. In a body of
 * node probes it is the point itself.
 */
#ifndef PHYNNESS_BODY_H
#define PHYNNESS_BODY_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_body phn_body;             /* constant; may be shared between threads */
typedef struct phn_body_state phn_body_state; /* the present deformation and working memory; of one thread */

/* As phn_model_size and phn_model_init, for the text of a body.txt. PHN_ERROR_FAMILY: this version does not know the
 * law. */
PHN_API int phn_body_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte);
PHN_API int phn_body_init(void* memory, size_t bytes, const char* text, size_t length, const phn_body** body,
                          size_t* wrong_byte);

/* The pointers refer to memory of the body. */
typedef struct phn_body_contents {
  const char *mesh_hash, *physics_hash, *law;
  phn_relaxation relaxation;
  double tool_radius_m;      /* 0: node probes */
  double max_displacement_m; /* largest displacement of the training data */
  const int32_t* nodes;      /* n_nodes numbers of the surface's nodes in the mesh, ascending */
  const double* points;      /* n_nodes x 3 [m] */
  const int32_t* triangles;  /* n_triangles x 3, positions among the nodes, normals outward */
  int32_t n_nodes, n_triangles, n_modes, n_pressures, n_cells;
  int32_t reserved PHN_ZEROS;
} phn_body_contents;
PHN_API int phn_body_info(const phn_body* body, phn_body_contents* info);

/* As phn_nearest; with [probe] elsewhere = "none" only within a tool's radius of a probed point. */
PHN_API int phn_body_nearest(const phn_body* body, const double x[3], phn_tool* tool, double point[3],
                             double* distance);

/* Working memory for up to `max_tools` (1 ... 8) tools, at rest. The body must outlive it. */
PHN_API int phn_body_state_size(const phn_body* body, int32_t max_tools, size_t* bytes);
PHN_API int phn_body_state_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools,
                                phn_body_state** state);

typedef struct phn_body_report {
  double energy;     /* [J] */
  double unbalanced; /* size of the next step over that of the deformation, in the norm of the energy */
  double residual_m; /* largest distance of a tool from the mean displacement that it holds */
  int32_t steps;     /* that were made or undone */
  int32_t renewed;   /* factors of the stiffness matrix that were computed */
  int32_t reserved[2] PHN_ZEROS;
} phn_body_report;

/* Forces [N] that hold the tools, n_tools x 3, after at most `steps` (>= 1) steps of Newton's method from the
 * deformation that the state has. Each step renews the stiffness matrix where the body changed most, and takes about
 * the same time; for tools that move by fractions of a millimetre one in each millisecond is enough. A step that does
 * not lower the energy is undone and tried again by a quarter, in the next call if it was the last. In a step a tool
 * moves by at most half of max_displacement_m, and larger motions take several; displacements are clamped to 1000
 * max_displacement_m. Unlike those of a model, forces depend on the motion before. _OUTSIDE: a displacement is larger
 * than trained, or no probed point is within a radius of the tool; all of the surface that is not fixed answers then,
 * with the stiffness at rest of the elements if the database had it (docs/theory.md, Elsewhere; else the body is too
 * stiff there, and neither phn_body_nearest nor contact finds places there). _UNSETTLED: `unbalanced` is above 0.01,
 * a tool is ahead, or the stiffness with held tools is not positive definite, so that the body may leave this state;
 * call again with the same tools to come closer. Where `unbalanced` is above 0.1 the forces are those
 * of the call before, or 0 for a tool that was not there; after 20 such steps the body starts again from rest, with
 * smaller motions in a step. _NEAR: tools nearer than half of their radius act through springs between them
 * (docs/theory.md, Near tools), and their forces may be off by a third and more; two with equal displacements at one
 * place share the force of one, opposed ones have five times that of each alone. PHN_ERROR_NOT_ACTIVE: all that the
 * tool touches is fixed. PHN_ERROR_TOO_MANY_TOOLS: also of fewer than 9 modes for each of several tools. With 0 tools
 * the body is at rest. `report` may be null.
 */
PHN_API int phn_body_force(const phn_body* body, phn_body_state* state, int32_t n_tools, const phn_tool* tools,
                           int32_t steps, double* forces, phn_body_report* report);

/* Bounds [N] of the errors of the forces of the last phn_body_force, one for each of its n_tools, from the finite
 * elements of the body (formats/body.md, Bounds); PHN_NO_BOUND where that gave a warning, and after an error.
 * PHN_ERROR_ARGUMENT: it had another number of tools. PHN_ERROR_UNDEFINED: a body without bounds (phynness calibrate
 * --body), or no tool.
 * @return its status otherwise */
PHN_API int phn_body_bound(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* bounds);

/* What these bounds are computed from, three numbers >= 0 [N] for each of the n_tools (x, y, z of formats/body.md,
 * Bounds), of a body with or without bounds: phynness calibrate fits them. @return as phn_body_bound */
PHN_API int phn_body_bound_terms(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* terms);

/* Displacements [m] of the surface's nodes, n_nodes x 3, after the last phn_body_force; zeros before. */
PHN_API int phn_body_deform(const phn_body* body, const phn_body_state* state, double* out);

#ifdef __cplusplus
}
#endif

#endif
