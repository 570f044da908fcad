/* phynness: several tools of node probes, with the forces of one problem.
 *
 * Memory, statuses, units, frames, overlap and the sign of the force are those of phynness.h.
 */
#ifndef PHYNNESS_TOOLS_H
#define PHYNNESS_TOOLS_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_coupled {
  double residual; /* largest distance [m] of a tool from the point that it holds; rounding unless _UNSETTLED */
  double energy;   /* [J]; 0 in family rbfn */
  int32_t reserved[2] PHN_ZEROS;
} phn_coupled;

/* Forces [N] of tools anywhere on the surface, n_tools x 3. One tool has the force of phn_force. A model of round tools
 * answers no more than one (PHN_ERROR_ROUND_TOOLS); a reduced body does (phynness_body.h). Up to 8 tools of node probes
 * are coupled: every held point follows its tool, and forces are exact for a linear body. Forces are continuous where
 * tools slide over edges and nodes, and in families with an energy its gradient while the tools hold their points. They
 * depend on these arguments only. _UNSETTLED: tools within half an edge length pull apart, and their points follow them
 * only in part; two with one displacement at one place share the force of one. PHN_ERROR_TOOLS: more tools than `data`
 * holds. PHN_ERROR_UNDEFINED: a node of coupled tools is no output node or has no deformation. `result` may be null.
 * Displacements are clamped to 1000 max_displacement_m. */
PHN_API int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
                       phn_coupled* result);

/* Displacements [m] of all output nodes, n_output x 3, under the tools of the last phn_couple with this data; zeros
 * before. A phn_force or phn_deform between nodes of node probes is a phn_couple of one tool. */
PHN_API int phn_coupled_deform(const phn_model* model, phn_data* data, double* out);

#ifdef __cplusplus
}
#endif

#endif
