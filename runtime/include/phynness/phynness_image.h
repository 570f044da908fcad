/* phynness images: models that a device evaluates in flash memory without loading them, in float or double.
 *
 * `phynness export` converts a model directory to an image, as C source or as a binary file. Nothing is parsed, copied
 * or allocated: phn_image_open checks the bytes and returns the same address. An image is constant and may be shared
 * between threads. Numbers are doubles or, where PHYNNESS_IMAGE_FLOAT is defined for phynness_image.cpp and for every
 * file that includes this header, floats (phynness export --float); CMake's targets phynness::image and
 * phynness::image_float do that. Functions of floats are other symbols, so that mixing both is an error of the linker.
 * The functions use no library; the only exception is sqrt of doubles on processors without double precision. The same
 * image gives bitwise the same results on every machine with IEEE 754 arithmetic. Layout: formats/image.md.
 *
 * Units, signs, frames and statuses are those of phynness.h: after a status < 0 outputs are zeros, a status > 0 is a
 * sum of PHN_WARNING_*, and no output of an opened image is ever NaN or infinite. Components of displacements are
 * clamped to 1e6 times the largest trained displacement R. Only phynness.h has several tools, fields, and deformations
 * under a tool between nodes. Inputs are read before outputs are written, so a force may overlap its displacement.
 */
#ifndef PHYNNESS_IMAGE_H
#define PHYNNESS_IMAGE_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifdef PHYNNESS_IMAGE_FLOAT
#define phn_real phn_realf
#define phn_image phn_imagef
#define phn_image_place phn_imagef_place
#define phn_image_open phn_imagef_open
#define phn_image_n_active phn_imagef_n_active
#define phn_image_active_nodes phn_imagef_active_nodes
#define phn_image_active_points phn_imagef_active_points
#define phn_image_provenance phn_imagef_provenance
#define phn_image_n_output phn_imagef_n_output
#define phn_image_output_nodes phn_imagef_output_nodes
#define phn_image_output_points phn_imagef_output_points
#define phn_image_force phn_imagef_force
#define phn_image_energy phn_imagef_energy
#define phn_image_stiffness phn_imagef_stiffness
#define phn_image_trained_depth phn_imagef_trained_depth
#define phn_image_scratch_size phn_imagef_scratch_size
#define phn_image_deform phn_imagef_deform
#define phn_image_nearest phn_imagef_nearest
#define phn_image_force_at phn_imagef_force_at
#define phn_image_energy_at phn_imagef_energy_at
#define phn_image_stiffness_at phn_imagef_stiffness_at
#define phn_image_bound_at phn_imagef_bound_at
typedef float phn_real;
#else
typedef double phn_real;
#endif
typedef struct phn_image phn_image;

/* Checks the `bytes` bytes at `memory` and gives the image. The alignment is 8, for images of floats 4. Further bytes
 * may follow. Every byte is read once, which takes about ten instructions for four bytes. The memory must not change
 * while the image is used. PHN_ERROR_NOT_A_MODEL: not an image, or one of the other byte order. PHN_ERROR_VERSION:
 * another version, or the other kind of number. PHN_ERROR_TRUNCATED, PHN_ERROR_CHECKSUM: the image is damaged.
 * PHN_ERROR_FAMILY, PHN_ERROR_RANGE: sizes or indices are inconsistent, or a number is NaN, infinite, too large or a
 * negative depth.
 * PHN_ERROR_ARGUMENT: a null pointer, or wrong alignment. PHN_ERROR_OVERLAP: `image` itself lies in the bytes. On
 * failure *image is null. */
PHN_API int phn_image_open(const void* memory, size_t bytes, const phn_image** image);

/* Active nodes: their numbers in the mesh, in ascending order, and undeformed coordinates, n_active x 3 [m]. The arrays
 * belong to the image. */
PHN_API int32_t phn_image_n_active(const phn_image* image);
PHN_API const int32_t* phn_image_active_nodes(const phn_image* image);
PHN_API const phn_real* phn_image_active_points(const phn_image* image);

/* Where the model of the image comes from, as in phynness.h; the strings belong to the image. PHN_ERROR_ARGUMENT: a
 * null pointer; *provenance is then as if nothing was recorded. PHN_ERROR_OVERLAP: `provenance` lies in the image. */
PHN_API int phn_image_provenance(const phn_image* image, phn_provenance* provenance);

/* Output nodes, whose displacements are modelled; none if the image was exported with --force-only. */
PHN_API int32_t phn_image_n_output(const phn_image* image);
PHN_API const int32_t* phn_image_output_nodes(const phn_image* image);
PHN_API const phn_real* phn_image_output_points(const phn_image* image);

/* Reaction force [N] at active node `node` displaced by d [m], as in phn_force; it needs no working memory. */
PHN_API int phn_image_force(const phn_image* image, int32_t node, const phn_real d[3], phn_real force[3]);

/* Energy [J] and stiffness [N/m], 3 x 3 and bitwise symmetric, as in phn_force. At d = 0 the energy is exactly 0.
 * PHN_ERROR_UNDEFINED in family rbfn. */
PHN_API int phn_image_energy(const phn_image* image, int32_t node, const phn_real d[3], phn_real* energy);
PHN_API int phn_image_stiffness(const phn_image* image, int32_t node, const phn_real d[3], phn_real stiffness[9]);

/* Depth [m] of the trained range of `node` in the direction of d, as in phn_depth. */
PHN_API int phn_image_trained_depth(const phn_image* image, int32_t node, const phn_real d[3], phn_real* depth);

/* Bytes of working memory for a deformation, with the alignment of its numbers; may be 0. */
PHN_API size_t phn_image_scratch_size(const phn_image* image);

/* Displacements [m] of all output nodes, n_output x 3, with one tool at `node` displaced by d [m], as in phn_deform.
 * `scratch`: working memory, one for each thread, outside of the image. Cost for family modal: 3 n_output x shared
 * modes products with 16-bit integers. PHN_ERROR_OVERLAP: `scratch` and `out` overlap. PHN_ERROR_UNDEFINED: the image
 * or the node has forces only. */
PHN_API int phn_image_deform(const phn_image* image, phn_real* scratch, int32_t node, const phn_real d[3],
                             phn_real* out);

/* A place on the surface: a triangle of the image and barycentric weights of its corners, >= 0 and with the sum 1. */
typedef struct phn_image_place {
  phn_real weights[3];
  int32_t triangle;
} phn_image_place;

/* The place nearest to x [m] on that part of the undeformed surface where round tools can be, and its point [m], which
 * may be null. At a fixed edge the place is a twentieth of a triangle away from it. A place at the border of this part
 * is also returned for an x far beyond it, so compare x and the point. `from` < 0: all triangles are searched.
 * Otherwise a walk from triangle `from` over neighbouring triangles comes nearer to x until none is nearer: it stays on
 * its side of a thin body. It crosses 32 triangles at most, then PHN_WARNING_UNSETTLED says that it must go on from the
 * returned place. PHN_ERROR_UNDEFINED: the image has no surface: its tools are not round (phynness_tools.h).
 * PHN_ERROR_OVERLAP: `place` and `point` overlap. After an error the triangle is -1. */
PHN_API int phn_image_nearest(const phn_image* image, int32_t from, const phn_real x[3], phn_image_place* place,
                              phn_real point[3]);

/* Force [N], energy [J] and stiffness [N/m] of one round tool at a place, displaced by d [m], as in phn_force; a
 * place at an active node has the force of the node. Cost: forces of about 12 nodes between nodes. PHN_ERROR_UNDEFINED:
 * no surface; no energy in family rbfn. PHN_ERROR_ARGUMENT: no such triangle or weights. PHN_ERROR_NOT_ACTIVE: all
 * corners with weights are fixed. */
PHN_API int phn_image_force_at(const phn_image* image, const phn_image_place* place, const phn_real d[3],
                               phn_real force[3]);
PHN_API int phn_image_energy_at(const phn_image* image, const phn_image_place* place, const phn_real d[3],
                                phn_real* energy);
PHN_API int phn_image_stiffness_at(const phn_image* image, const phn_image_place* place, const phn_real d[3],
                                   phn_real stiffness[9]);

/* The bound [N] of the error of that force, as in phn_bound. PHN_IMAGE_NO_BOUND: nothing is known there, above all
 * with PHN_WARNING_OUTSIDE. PHN_ERROR_UNDEFINED: no surface, or the model was not calibrated. Cost: forces and trained
 * depths of the active nodes around the place, mostly three. */
#define PHN_IMAGE_NO_BOUND 1e30f
PHN_API int phn_image_bound_at(const phn_image* image, const phn_image_place* place, const phn_real d[3],
                               phn_real* bound);

#ifdef __cplusplus
}
#endif

#endif
