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
 * Units, signs, frames and statuses are those of phynness.h: after a status < 0 outputs are zeros, but bounds
 * PHN_IMAGE_NO_BOUND; a status > 0 is a sum of PHN_WARNING_*, and no output of an opened image is ever NaN or infinite.
 * Inputs are read before outputs are written, so an output may overlap its tool. Only phynness.h has several tools,
 * fields, and deformations between nodes.
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
#define phn_image_contents phn_imagef_contents
#define phn_image_tool phn_imagef_tool
#define phn_image_tool_at phn_imagef_tool_at
#define phn_image_open phn_imagef_open
#define phn_image_info phn_imagef_info
#define phn_image_nearest phn_imagef_nearest
#define phn_image_force phn_imagef_force
#define phn_image_energy phn_imagef_energy
#define phn_image_stiffness phn_imagef_stiffness
#define phn_image_depth phn_imagef_depth
#define phn_image_bound phn_imagef_bound
#define phn_image_deform phn_imagef_deform
typedef float phn_real;
#else
typedef double phn_real;
#endif
typedef struct phn_image phn_image;

/* Checks the `bytes` bytes at `memory` and gives the image. The alignment is 8, for images of floats 4. Further bytes
 * may follow. Every byte is read once, which takes about ten instructions for four bytes. The memory must not change
 * while the image is used. PHN_ERROR_NOT_A_MODEL: not an image, or one of the other byte order. PHN_ERROR_VERSION:
 * another version. PHN_ERROR_IMAGE_OF_FLOATS, PHN_ERROR_IMAGE_OF_DOUBLES: this code is for the other.
 * PHN_ERROR_TRUNCATED, PHN_ERROR_CHECKSUM: the image is damaged. PHN_ERROR_FAMILY, PHN_ERROR_RANGE: sizes or indices
 * are inconsistent, or a number is NaN, infinite, too large or a negative depth. PHN_ERROR_ARGUMENT: a null pointer, or
 * wrong alignment. PHN_ERROR_OVERLAP: `image` itself lies in the bytes. On failure *image is null. */
PHN_API int phn_image_open(const void* memory, size_t bytes, const phn_image** image);

/* The arrays and strings belong to the image. Nodes are numbers in the mesh, in ascending order; points are n x 3,
 * undeformed [m]. */
typedef struct phn_image_contents {
  double max_displacement_m;   /* R: largest displacement of the training data */
  const int32_t* active_nodes; /* n_active: nodes that can be touched */
  const int32_t* output_nodes; /* n_output: nodes whose displacement is modelled; 0 after export --force-only */
  const phn_real *active_points, *output_points;
  size_t scratch_bytes; /* of phn_image_deform, aligned as phn_real; may be 0 */
  int32_t n_active, n_output;
  int32_t n_triangles;            /* where tools can be between nodes; 0: at nodes only */
  int32_t has_energy, has_bounds; /* 0 or 1 */
  phn_provenance provenance;
  phn_relaxation relaxation; /* for phn_relax, which the libraries of images have, too */
  int32_t reserved[3] PHN_ZEROS;
} phn_image_contents;
PHN_API int phn_image_info(const phn_image* image, phn_image_contents* contents);

/* A tool: a place of the surface and the displacement of this place. The place is an active node, or a point of a
 * triangle of the image with barycentric weights of its corners, which are >= 0 and have the sum 1. */
typedef struct phn_image_tool {
  int32_t node;     /* number in the mesh; -1: the tool is on the triangle */
  int32_t triangle; /* 0 ... n_triangles - 1; unused at a node, as are the weights */
  phn_real weights[3];
  phn_real displacement[3];      /* of the place, from rest [m]; components are clamped to 1e6 R */
  int32_t reserved[2] PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_image_tool;

/* The tool at a node, displaced by d [m]. */
static inline phn_image_tool phn_image_tool_at(int32_t node, const phn_real d[3]) {
  const phn_image_tool tool = {node, -1, {0, 0, 0}, {d[0], d[1], d[2]}, {0, 0}};
  return tool;
}

/* As phn_nearest: the tool, with displacement 0, at the place nearest to x [m] on that part of the undeformed surface
 * where round tools can be, its point, and the distance of x [m], negative below the surface but not at its border,
 * beyond which it is large; both may be null. Components of x are clamped to 1e12 m (doubles: 1e100 m). `from` < 0: all
 * triangles are searched. Otherwise a walk from triangle `from`, that of the tool before, over neighbouring triangles
 * comes nearer to x until none is nearer: it stays on its side of a thin body. It crosses 32 triangles at most, then
 * PHN_WARNING_UNSETTLED says that it must go on from the returned triangle. PHN_ERROR_UNDEFINED: the image has no
 * triangles. After an error the triangle is -1. */
PHN_API int phn_image_nearest(const phn_image* image, int32_t from, const phn_real x[3], phn_image_tool* tool,
                              phn_real point[3], phn_real* distance);

/* The force [N] that holds a tool, its energy [J], exactly 0 at rest, and its stiffness [N/m], 3 x 3 and bitwise
 * symmetric, as in phn_force. They are separate functions so that a device links only what it calls, and need no memory
 * but the stack. Between nodes they cost about 12 times as much as at a node. PHN_ERROR_ARGUMENT: no such triangle or
 * weights. PHN_ERROR_NOT_ACTIVE: not an active node, or only fixed corners have weights. PHN_ERROR_UNDEFINED: no
 * triangles; energy and stiffness in family rbfn. */
PHN_API int phn_image_force(const phn_image* image, const phn_image_tool* tool, phn_real force[3]);
PHN_API int phn_image_energy(const phn_image* image, const phn_image_tool* tool, phn_real* energy);
PHN_API int phn_image_stiffness(const phn_image* image, const phn_image_tool* tool, phn_real stiffness[9]);

/* Depth [m] of the trained range, as phn_depth. */
PHN_API int phn_image_depth(const phn_image* image, const phn_image_tool* tool, phn_real* depth);

/* The bound [N] of the error of the force, as phn_bound; PHN_IMAGE_NO_BOUND: nothing is known, above all with
 * PHN_WARNING_OUTSIDE and after an error. PHN_ERROR_UNDEFINED: has_bounds is 0. Cost: a force and a bound of each
 * active node at the place, mostly three. */
#define PHN_IMAGE_NO_BOUND 1e30f
PHN_API int phn_image_bound(const phn_image* image, const phn_image_tool* tool, phn_real* bound);

/* Displacements [m] of all output nodes, n_output x 3, as phn_deform, with a tool at an active node or between one and
 * fixed nodes. `scratch`: working memory, one for each thread, outside of the image. Cost for family modal: 3 n_output
 * x shared modes products with 16-bit integers. PHN_ERROR_OVERLAP: `scratch` and `out` overlap. PHN_ERROR_UNDEFINED: a
 * tool elsewhere, or the image or the node has forces only. */
PHN_API int phn_image_deform(const phn_image* image, phn_real* scratch, const phn_image_tool* tool, phn_real* out);

#ifdef __cplusplus
}
#endif

#endif
