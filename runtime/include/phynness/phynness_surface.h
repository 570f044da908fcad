/* phynness: the surface of a model, subdivided by Loop's scheme, for drawing.
 *
 * Each level inserts a vertex on every edge, splits every triangle into four, and moves the old vertices to weighted
 * means of their neighbours. The scheme is linear, S(X + u) = S X + S u, so that a fine surface is drawn at points +
 * displacements for every family. The first vertices are those of phn_info.triangles with the same numbers; a vertex
 * without triangles moves with its node. Loop's surface does not pass through the original vertices: it is smoother and
 * slightly smaller than the triangles, and at a touched node its displacement is a mean of the displacements of the
 * node and its neighbours. Edges of one triangle (the boundary of an open surface) or of more than two are creases,
 * whose vertices depend on the crease only. A vertex where more than two creases meet does not move. A vertex at which
 * parts of the surface touch joins them smoothly.
 *
 * Memory, statuses, units and frames: as in phynness.h.
 */
#ifndef PHYNNESS_SURFACE_H
#define PHYNNESS_SURFACE_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Constant after phn_surface_init; it may be shared between threads. It does not use the model afterwards. */
typedef struct phn_surface phn_surface;

/* The surface subdivided `levels` times (0 ... 6). Memory: about 90 bytes per vertex of the finest level, more for open
 * surfaces. Cost of init: about that of ten phn_surface_deform. PHN_ERROR_UNDEFINED: the model has no triangles.
 * PHN_ERROR_GEOMETRY: a triangle has equal corners. PHN_ERROR_TOO_LARGE: a count exceeds 32 bits. */
PHN_API int phn_surface_size(const phn_model* model, int32_t levels, size_t* bytes);
PHN_API int phn_surface_init(void* memory, size_t bytes, const phn_model* model, int32_t levels,
                             const phn_surface** surface);

/* Vertices and triangles of the finest level. The arrays belong to the surface. */
typedef struct phn_surface_contents {
  int32_t n_vertices, n_triangles;
  const int32_t* triangles; /* n_triangles x 3 vertices, oriented as in the model */
  const float* points;      /* n_vertices x 3, undeformed [m]; a float resolves 0.1 mm at 1 km from the origin */
  size_t scratch_bytes;     /* of phn_surface_deform, aligned to 4, separate for each thread; 0 for levels = 0 */
  int32_t reserved[2] PHN_ZEROS;
} phn_surface_contents;
PHN_API int phn_surface_info(const phn_surface* surface, phn_surface_contents* contents);

/* Displacements [m] of the fine surface, out: n_vertices x 3. `field`: n_output x 3 [m], from phn_deform or
 * phn_coupled_deform; its components are clamped to 1e25 m. PHN_ERROR_OVERLAP: two of `field`, `scratch` and `out`
 * overlap in memory. Cost: about seven multiplications per vertex and component. */
PHN_API int phn_surface_deform(const phn_surface* surface, float* scratch, const double* field, float* out);

#ifdef __cplusplus
}
#endif

#endif
