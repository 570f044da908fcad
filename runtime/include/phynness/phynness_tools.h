/* phynness: one tool between nodes, or several tools of node probes, with the forces of one problem.
 *
 * Memory, statuses, units, frames, overlap and the sign of the force are those of phynness.h.
 */
#ifndef PHYNNESS_TOOLS_H
#define PHYNNESS_TOOLS_H

#include <phynness/phynness.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A tool that holds a point of the surface: up to three nodes of one triangle, with barycentric weights, which are >= 0
 * and have the sum 1. Each node is active, fixed, or covered: answered from up to three active nodes around it. A tool
 * at a node: {node, -1, -1}, {1, 0, 0}. In a model of round tools (patch probes that move a mean; model.txt says `mean`
 * at each node) it is the round tool whose middle is the point. Models of node probes couple the nodes of the point. */
typedef struct phn_tool {
  int32_t nodes[3]; /* -1: unused */
  double weights[3];
  double displacement[3]; /* of the point [m] */
} phn_tool;
typedef struct phn_coupled {
  double residual; /* largest distance [m] of a tool from the point that it holds; rounding unless _UNSETTLED */
  double energy;   /* [J]; 0 in family rbfn */
} phn_coupled;

/* phn_force, phn_trained_depth and phn_bound of one tool at a point. A round tool
 * between nodes has a mean of the energies of the tools at the nodes around it for the same displacement
 * (docs/theory.md, (x)); force and stiffness are its derivatives. Family rbfn has the same mean of the forces. They are
 * continuous where the tool slides over edges and nodes, and at a node they are those of the node. Fixed nodes of the
 * triangle do not count; where their weights exceed 0.3, the tool is PHN_WARNING_OUTSIDE, with the trained depth 0, at
 * any displacement. A warning of any active node of the triangle, or around its covered nodes, is one of the tool. The
 * trained depth is the smallest of these nodes. PHN_ERROR_UNDEFINED: the point
 * is between nodes of a model without round tools; use phn_couple. Cost: about 12 forces between nodes.
 * The bound is that of the full level, also of the force of phn_couple between nodes of node probes. It holds for
 * random places and displacements as phn_bound does (formats/model.md, Bounds), and is PHN_NO_BOUND with
 * PHN_WARNING_OUTSIDE and where calibration had too few tools between nodes. */
PHN_API int phn_force_at(const phn_model* model, phn_data* data, const phn_tool* tool, double force[3], double* energy,
                         double stiffness[9]);
PHN_API int phn_trained_depth_at(const phn_model* model, const phn_tool* tool, double* depth);
PHN_API int phn_bound_at(const phn_model* model, const phn_tool* tool, double* bound);

/* Forces [N] of tools anywhere on the surface, n_tools x 3. One tool at a node has the force of phn_force, and one
 * round tool that of phn_force_at. A model of round tools answers no more than one (PHN_ERROR_ROUND_TOOLS); a reduced
 * body does (phynness_body.h). Up to 8 tools of node probes are coupled: every held point follows its tool, and forces
 * are exact for a linear body. Forces are continuous where tools slide over edges and nodes, and in families with an
 * energy its gradient while the tools hold their points. They depend on these arguments only. _UNSETTLED: tools within
 * half an edge length pull apart, and their points follow them only in part. PHN_ERROR_TOOLS: more tools than `data`
 * holds. PHN_ERROR_UNDEFINED: a node of coupled tools is no output node or has
 * no deformation. `result` may be null. Displacements are clamped to 1000 max_displacement_m. */
PHN_API int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
                       phn_coupled* result);

/* Displacements [m] of all output nodes, n_output x 3, under the tools of the last phn_couple with this data; zeros
 * before the first phn_couple. The field of one round tool between nodes is the mean of its nodes' fields. */
PHN_API int phn_coupled_deform(const phn_model* model, phn_data* data, double* out);

/* The tool at that point of the undeformed surface which is nearest to x [m], with displacement 0. `point` [m] may be
 * null. */
PHN_API int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3]);

/* The paper's blending of several tools, for comparison with the paper. Applications should use phn_couple instead:
 * here displacements between tools have errors of 12 to 18 %, and no force is defined.
 * Displacements [m] of all output nodes, out: n_output x 3, with tool t at active node nodes[t] displaced by
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
