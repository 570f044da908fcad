/* phynness: levels of a model, smaller networks for less time.
 *
 * A model trained with [training] levels holds smaller networks beside its full one. Each is fitted to the data on its
 * own: the first of the centers and modes that the full one took, with coefficients of their own. Level 0 is the
 * smallest, level phn_info.n_levels - 1 the full model. Each level by itself is what the family promises: in family
 * modal its force is the gradient of an energy of its own.
 *
 * Memory, statuses and units: as in phynness.h.
 */
#ifndef PHYNNESS_LEVELS_H
#define PHYNNESS_LEVELS_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The largest sizes of all nodes, and errors as the model tells them, fractions of a node's largest force or
 * displacement: the mean at trained displacements left out of the fit one by one, of the median node, inside the
 * trained range (docs/decisions/levels.md says what that is worth); 0 where nothing was estimated. */
typedef struct phn_level {
  int32_t force_centers;       /* centers of a force; in family rbfn its neurons */
  int32_t deformation_centers; /* centers of the amplitudes; in family rbfn neurons of a deformation */
  int32_t modes;               /* of a node; 0 in other families than modal */
  double error_force, error_displacement;
} phn_level;
PHN_API int phn_level_info(const phn_model* model, int32_t level, phn_level* info);

/* Sets the level of everything that is asked with this data from now on; phn_coupled_deform keeps that of its
 * phn_couple. Without this call data have the full level. It costs nothing, and prepared nodes stay ready. Forces and
 * energies jump at a switch, in the mean by about the error of the smaller level, at worst by some ten times that.
 * Switch where nothing is touched, or blend forces over some milliseconds, which costs both levels. */
PHN_API int phn_set_level(const phn_model* model, phn_data* data, int32_t level);

/* The level of the data; 0 for null data. */
PHN_API int32_t phn_level_of(const phn_data* data);

/* Time of one force and of one deformation of a node that is ready [us]. */
typedef struct phn_level_time {
  double force_us, deformation_us;
} phn_level_time;

/* Measures these times at each level, n_levels of them, on the machine and the thread that calls. The runtime has no
 * clock: `clock_us` gives microseconds from any origin and is passed `user`. Each time is the median of seven batches
 * of at least 20 us with warm caches: under a millisecond a level, and good to a factor of two if the clock ticks in
 * longer steps. Not for the loop. The level of the data stays as it was. PHN_ERROR_CLOCK: NaN, infinite, backwards, or
 * no step within 250,000 calls. Deformations of a model of forces only take 0. */
PHN_API int phn_calibrate(const phn_model* model, phn_data* data, double (*clock_us)(void* user), void* user,
                          phn_level_time* times);

/* The level of the smallest error of those that compute n_forces forces and n_deformations deformations within
 * budget_us by these times. The errors of force and displacement are added; those of what is asked for 0 times are left
 * out. PHN_ERROR_BUDGET: not even the fastest does; level is 0, the smallest. */
PHN_API int phn_budget(const phn_model* model, const phn_level_time* times, double n_forces, double n_deformations,
                       double budget_us, int32_t* level);

#ifdef __cplusplus
}
#endif

#endif
