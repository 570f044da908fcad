/* phynness: the paper's blending of several tools, for comparison with the paper. Applications should use phn_couple of
 * phynness_tools.h instead: here displacements between tools have errors of 12 to 18 %, and no force is defined.
 */
#ifndef PHYNNESS_PAPER_H
#define PHYNNESS_PAPER_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Displacements [m] of all output nodes, out: n_output x 3, with tool t at active node nodes[t] displaced by
 * displacements[3 t ... 3 t + 2] [m]. The fields of the tools are averaged with the weights of equations (15)-(16),
 * which are inverse distances in the undeformed state. These weights are singular at the touched nodes, where the
 * result is exactly the displacement of the tool. The nodes must differ (PHN_ERROR_SAME_NODE). One tool gives the
 * result of phn_deform, no tool gives zeros. Cost: that of n_tools phn_deform. */
PHN_API int phn_blend_paper(const phn_model* model, phn_data* data, int32_t n_tools, const int32_t* nodes,
                            const double* displacements, double* out);

#ifdef __cplusplus
}
#endif

#endif
