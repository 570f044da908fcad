/* phynness: the paper's blending of several tools, to reproduce and compare with it. Not for devices: displacements
 * between tools are wrong by 12 to 18 %, and no force is defined. phn_couple of phynness.h is the accurate way.
 */
#ifndef PHYNNESS_PAPER_H
#define PHYNNESS_PAPER_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Displacements [m] of all output nodes, out: n_output x 3, with tool t at active node nodes[t] displaced by
 * displacements[3 t ... 3 t + 2] [m]. The fields of the tools are averaged with the weights (15)-(16): inverse
 * distances at rest, which are singular at the touched nodes, where each takes exactly its own displacement. Nodes
 * differ from each other; one tool gives phn_deform, none gives zeros. Cost: that of n_tools phn_deform. */
PHN_API int phn_blend_paper(const phn_model* model, phn_data* data, int32_t n_tools, const int32_t* nodes,
                            const double* displacements, double* out);

#ifdef __cplusplus
}
#endif

#endif
