/* phynness: levels of a model, which are smaller networks that take less time.
 *
 * A model trained with `levels` in [training] contains smaller networks beside the full one. Each level uses the first
 * centers and modes of the full network, and its coefficients are fitted to the data separately. Level 0 is the
 * smallest; level phn_info.n_levels - 1 is the full model. Every level has the properties of its family: in family
 * modal, for example, its force is the gradient of its own energy.
 *
 * Memory, statuses and units: as in phynness.h.
 */
#ifndef PHYNNESS_LEVELS_H
#define PHYNNESS_LEVELS_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Sizes are the largest of all nodes. Errors are those stored in the model: leave-one-out errors at the displacements
 * of the training data, as a fraction of a node's largest force or displacement, averaged over the displacements, for
 * the median node. They are estimates inside the trained range only (docs/decisions/levels.md); 0: no estimate. */
typedef struct phn_level {
  int32_t force_centers;       /* centers of a force; in family rbfn neurons of a force network */
  int32_t deformation_centers; /* centers of the amplitudes; in family rbfn neurons of a deformation network */
  int32_t modes;               /* of a node; 0 in other families than modal */
  double error_force, error_displacement;
} phn_level;
PHN_API int phn_level_info(const phn_model* model, int32_t level, phn_level* info);

/* Sets the level of all later calls with this data, except that phn_coupled_deform uses the level of its phn_couple.
 * The initial level is the full one. The call takes no noticeable time, and prepared nodes remain prepared. Forces and
 * energies jump when the level changes: on average by about the error of the smaller level, at worst by about ten times
 * that. Change the level while no tool is in contact, or blend the forces of both levels over some milliseconds, which
 * takes the time of both. */
PHN_API int phn_set_level(const phn_model* model, phn_data* data, int32_t level);

#ifdef __cplusplus
}
#endif

#endif
