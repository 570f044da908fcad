/* phynness: the surface of a model, subdivided by Loop's scheme, to be drawn.
 *
 * Each level makes four triangles of one and a vertex on every edge, and moves the old vertices to weighted means of
 * their neighbours. The scheme is linear, S(X + u) = S X + S u: a fine surface is drawn at points + displacements,
 * whatever the model's family. The first vertices are those of phn_info.triangles under the same numbers; those without
 * triangles are among them and move with their node. Loop's surface does not pass through the vertices that it is made
 * of. It is smoother and a little smaller than the triangles, and above a touched node it moves by a mean of what the
 * node and its neighbours do. Edges of one triangle (the rim of an open surface) or of more than two are creases: their
 * vertices depend on the crease alone. Where more than two creases meet the vertex stays. A vertex where parts of the
 * surface touch joins them smoothly.
 *
 * Memory, statuses, units and frames: as in phynness.h.
 */
#ifndef PHYNNESS_SURFACE_H
#define PHYNNESS_SURFACE_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Never changes after phn_surface_init: share it between threads. It does not need the model any more. */
typedef struct phn_surface phn_surface;

/* The surface subdivided `levels` times (0 ... 6). Memory: some 90 bytes per vertex of the finest level, more for open
 * surfaces. Cost of init: that of some ten phn_surface_deform. PHN_ERROR_UNDEFINED: the model has no triangles.
 * PHN_ERROR_GEOMETRY: a triangle has equal corners. PHN_ERROR_TOO_LARGE: counts would leave 32 bits. */
PHN_API int phn_surface_size(const phn_model* model, int32_t levels, size_t* bytes);
PHN_API int phn_surface_init(void* memory, size_t bytes, const phn_model* model, int32_t levels,
                             const phn_surface** surface);

/* Vertices and triangles of the finest level. triangles: n_triangles x 3 vertices, orientation as in the model. points:
 * n_vertices x 3, at rest [m], in float: a body 1 km from the origin is drawn to 0.1 mm. 0 and null for a null surface.
 * Owned by the surface. */
PHN_API int32_t phn_surface_n_vertices(const phn_surface* surface);
PHN_API int32_t phn_surface_n_triangles(const phn_surface* surface);
PHN_API const int32_t* phn_surface_triangles(const phn_surface* surface);
PHN_API const float* phn_surface_points(const phn_surface* surface);

/* Bytes of scratch that phn_surface_deform needs, aligned to 4, one for each thread; 0 for levels = 0. */
PHN_API size_t phn_surface_scratch_size(const phn_surface* surface);

/* Displacements [m] of the fine surface, out: n_vertices x 3. `field`: n_output x 3 [m], from phn_deform or
 * phn_coupled_deform; its components are cut at 1e25 m. PHN_ERROR_OVERLAP: two of `field`, `scratch` and `out` overlap;
 * they are too large to be copied first. Cost: about seven multiplications per vertex and component. */
PHN_API int phn_surface_deform(const phn_surface* surface, float* scratch, const double* field, float* out);

#ifdef __cplusplus
}
#endif

#endif
