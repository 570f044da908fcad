/* phynness images: models that a device evaluates where they lie, in flash, in float or double.
 *
 * `phynness export` makes an image of a model directory, as C source or as a file. Nothing is parsed, copied or
 * allocated: phn_image_open checks the bytes and returns the same address. An image never changes: share it.
 * Functions with `f` take images of floats (phynness export --float), the others images of doubles. Whoever links only
 * one kind gets the code of that kind alone. They need no library, not even a C library's mathematics (doubles on a
 * processor without them: sqrt): the same image gives the same bits on every machine with IEEE 754 arithmetic. Layout:
 * formats/image.md.
 *
 * Units, signs, frames and statuses are those of phynness.h: status < 0 refused, outputs hold zeros; > 0 a sum of
 * PHN_WARNING_*; no output of an image that opens is ever NaN or infinite. Components of displacements are cut at 1e6
 * times the largest trained displacement R. Tools between nodes, several tools, surfaces and fields are the business of
 * phynness.h. Inputs are read before outputs are written: a force may lie in the memory of its displacement.
 */
#ifndef PHYNNESS_IMAGE_H
#define PHYNNESS_IMAGE_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_image phn_image;
typedef struct phn_imagef phn_imagef;

/* Checks the `bytes` bytes at `memory` (aligned to 8, of floats to 4; they may be followed by others) and gives the
 * image. It reads them once: some ten instructions for each four bytes. Memory must stay as it is as long as the image
 * is used. PHN_ERROR_NOT_A_MODEL: not an image, or one for the other order of bytes. PHN_ERROR_VERSION: of another
 * version, or of the other kind of number. PHN_ERROR_TRUNCATED, PHN_ERROR_CHECKSUM: damaged. PHN_ERROR_FAMILY,
 * PHN_ERROR_RANGE: its parts do not fit each other, or a number is NaN, infinite or too large. PHN_ERROR_ARGUMENT:
 * null, or not aligned. PHN_ERROR_OVERLAP: `image` itself lies in the bytes. On failure *image is null. */
PHN_API int phn_image_open(const void* memory, size_t bytes, const phn_image** image);
PHN_API int phn_imagef_open(const void* memory, size_t bytes, const phn_imagef** image);

/* Active nodes: their numbers in the mesh, ascending, and reference coordinates, n_active x 3 [m]; owned by the image.
 */
PHN_API int32_t phn_image_n_active(const phn_image* image);
PHN_API int32_t phn_imagef_n_active(const phn_imagef* image);
PHN_API const int32_t* phn_image_active_nodes(const phn_image* image);
PHN_API const int32_t* phn_imagef_active_nodes(const phn_imagef* image);
PHN_API const double* phn_image_active_points(const phn_image* image);
PHN_API const float* phn_imagef_active_points(const phn_imagef* image);

/* Output nodes, those whose displacement is modelled; none if the image was exported with --force-only. */
PHN_API int32_t phn_image_n_output(const phn_image* image);
PHN_API int32_t phn_imagef_n_output(const phn_imagef* image);
PHN_API const int32_t* phn_image_output_nodes(const phn_image* image);
PHN_API const int32_t* phn_imagef_output_nodes(const phn_imagef* image);
PHN_API const double* phn_image_output_points(const phn_image* image);
PHN_API const float* phn_imagef_output_points(const phn_imagef* image);

/* Reaction force [N] at active node `node` displaced by d [m], as phn_force. No scratch. */
PHN_API int phn_image_force(const phn_image* image, int32_t node, const double d[3], double force[3]);
PHN_API int phn_imagef_force(const phn_imagef* image, int32_t node, const float d[3], float force[3]);

/* Energy [J] and stiffness [N/m], 3 x 3, symmetric to the last bit, as in phn_force; 0 and the constant
 * at d = 0. PHN_ERROR_UNDEFINED in family rbfn. */
PHN_API int phn_image_energy(const phn_image* image, int32_t node, const double d[3], double* energy);
PHN_API int phn_imagef_energy(const phn_imagef* image, int32_t node, const float d[3], float* energy);
PHN_API int phn_image_stiffness(const phn_image* image, int32_t node, const double d[3], double stiffness[9]);
PHN_API int phn_imagef_stiffness(const phn_imagef* image, int32_t node, const float d[3], float stiffness[9]);

/* How deep [m] `node` was trained in the direction nearest to d, as phn_trust does. */
PHN_API int phn_image_trained_depth(const phn_image* image, int32_t node, const double d[3], double* depth);
PHN_API int phn_imagef_trained_depth(const phn_imagef* image, int32_t node, const float d[3], float* depth);

/* Bytes of scratch that a deformation needs, aligned as its numbers; it may be 0. */
PHN_API size_t phn_image_scratch_size(const phn_image* image);
PHN_API size_t phn_imagef_scratch_size(const phn_imagef* image);

/* Displacements [m] of all output nodes, n_output x 3, with one tool at `node` displaced by d [m], as phn_deform.
 * `scratch`: one for each thread, not inside the image. PHN_ERROR_OVERLAP: `scratch` and `out` overlap. Modal models
 * multiply their 16-bit tables as they lie in the image: 3 n_output x shared modes products. PHN_ERROR_UNDEFINED: the
 * image or the node has forces only. */
PHN_API int phn_image_deform(const phn_image* image, double* scratch, int32_t node, const double d[3], double* out);
PHN_API int phn_imagef_deform(const phn_imagef* image, float* scratch, int32_t node, const float d[3], float* out);

#ifdef __cplusplus
}
#endif

#endif
