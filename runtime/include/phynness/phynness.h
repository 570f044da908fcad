/* phynness: reaction force and deformation of a trained object, in real time: the core. Beside it: phynness_surface.h
 * (a finer surface to draw), phynness_contact.h (spheres that touch, slide and grasp), phynness_levels.h (accuracy for
 * time), phynness_image.h (models in flash), phynness_paper.h (the paper's blending).
 *
 * Start-up: phn_model_size, phn_model_init, phn_data_size, phn_data_init, in memory of the caller. Nothing here
 * allocates, prints or reads a file; nothing needs a clean-up. A phn_model never changes: share it. A phn_data is
 * scratch of one thread.
 *
 * Units are SI. Vectors are x, y, z in the frame of the mesh, displacements d from rest, nodes numbers of the mesh,
 * from 0. Force is what must be applied to the object to hold a displacement; a haptic device renders its negative.
 *
 * Status of every int function: 0 good; > 0 outputs are defined, but look: a sum of PHN_WARNING_*; < 0 refused, outputs
 * are zeros. No output is ever NaN or infinite. An output may lie in the memory of an input. Two outputs, or an object
 * and what it is made from, may not overlap. Equation numbers are those of the paper.
 *
 * Cost [us], 486 output nodes, AVX-512         modal, 78 centers, 16 modes   rbfn, 100 and 200 neurons
 *   phn_force                                             0.13                        0.17
 *   phn_deform; phn_prepare before a node's first         1.6; 35                     8.4; 76
 *   phn_couple, 1, 2, 4, 8 tools between nodes            32, 150, 550, 2200          - */
#ifndef PHYNNESS_H
#define PHYNNESS_H

#include <phynness/phynness_api.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_model phn_model;
typedef struct phn_data phn_data;

enum {
  PHN_OK = 0,
  PHN_WARNING_OUTSIDE = 1,       /* a displacement is longer than what was trained in its direction */
  PHN_WARNING_INCOMPLETE = 2,    /* some direction of a touched node stopped short of the full depth in training */
  PHN_WARNING_UNSETTLED = 4,     /* tools are too near each other to all be followed; forces are bounded */
  PHN_ERROR_ARGUMENT = -1,       /* null pointer, number outside of what is counted, data of another model */
  PHN_ERROR_NOT_ACTIVE = -2,     /* the node cannot be touched in this model */
  PHN_ERROR_NOT_FINITE = -3,     /* a displacement, place or size is NaN or infinite */
  PHN_ERROR_BUFFER = -4,         /* memory smaller than the _size function asked for */
  PHN_ERROR_TOOLS = -5,          /* more tools than the phn_data or phn_contact was made for */
  PHN_ERROR_SAME_NODE = -6,      /* two tools at one node */
  PHN_ERROR_UNDEFINED = -7,      /* the model has no such response: energy of networks, deformation of a node without */
  PHN_ERROR_BUDGET = -8,         /* not even the smallest level fits into the time */
  PHN_ERROR_CLOCK = -9,          /* a clock gives NaN, runs backwards or stands still */
  PHN_ERROR_NOT_A_MODEL = -10,   /* the text is not a model.txt, the bytes are not an image */
  PHN_ERROR_VERSION = -11,       /* a model of another version */
  PHN_ERROR_TRUNCATED = -12,     /* the model ends early */
  PHN_ERROR_CHECKSUM = -13,      /* the model was damaged */
  PHN_ERROR_SYNTAX = -14,        /* a number or word of the model is malformed */
  PHN_ERROR_RANGE = -15,         /* a count, index or value of the model is out of range */
  PHN_ERROR_FAMILY = -16,        /* the model is of a family that this version does not know */
  PHN_ERROR_OVERLAP = -17,       /* an output lies in the memory of another output, or of a large input */
  PHN_ERROR_TOO_LARGE = -18,     /* what is asked for needs more bytes or numbers than this machine can count */
  PHN_ERROR_GEOMETRY = -19,      /* a triangle with equal corners, or coordinates too large for contact */
  PHN_ERROR_TOO_MANY_TOOLS = -20 /* more than PHN_MOST_COUPLED tools at once */
};
enum { PHN_MOST_COUPLED = 8, PHN_MOST_FIELDS = 8 };

/* Version of this library, "major.minor.patch". */
PHN_API const char* phn_version(void);

/* One sentence for a status; never null. */
PHN_API const char* phn_status_message(int status);

/* Checks the text of a model.txt (`length` bytes; no 0 at the end needed) and tells the bytes that its model takes.
 * `wrong_byte`, which may be null, tells where a refused text is wrong, counted from 1; 0 for a good one. */
PHN_API int phn_model_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte);

/* Builds the model in `memory` (any alignment). The text may be released afterwards, the memory not. On failure *model
 * is null. */
PHN_API int phn_model_init(void* memory, size_t bytes, const char* text, size_t length, const phn_model** model,
                           size_t* wrong_byte);

/* What a model holds. Pointers lead into the model. Node lists ascend; points are n x 3, row by row, at rest [m]. */
typedef struct phn_info {
  const char *family, *title, *mesh_hash; /* family: "rbfn", "modal" or "linear" */
  double max_displacement_m;              /* how deep training went */
  const int32_t* active_nodes;            /* n_active: those that can be touched */
  const int32_t* output_nodes;            /* n_output: those whose displacement is modelled */
  const int32_t* fixed_nodes;             /* n_fixed: those of the surface that never move */
  const double *output_points, *fixed_points;
  const int32_t* triangles; /* n_triangles x 3, normals outward: 0 ... n_output - 1 are output nodes, then fixed ones */
  const char *field_names[PHN_MOST_FIELDS], *field_units[PHN_MOST_FIELDS]; /* "von-mises-stress", "Pa"; null: none */
  int32_t n_nodes;                                                         /* of the mesh */
  int32_t n_active, n_output, n_fixed, n_triangles, n_fields;
  int32_t n_levels;       /* 1 or more: phynness_levels.h */
  int32_t has_energy;     /* 1, or 0 in family rbfn */
  int32_t precision_bits; /* of the inner loops: 64, or 32 in the library in float; told for a null model, too */
} phn_info;
PHN_API int phn_model_info(const phn_model* model, phn_info* info);

/* Scratch for up to `max_tools` tools (>= 1) at once. The model must outlive it. */
PHN_API int phn_data_size(const phn_model* model, int32_t max_tools, size_t* bytes);
PHN_API int phn_data_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools, phn_data** data);

/* With active node `node` displaced by d: the force [N] that holds it, the energy [J] stored, 0 at rest, and the
 * stiffness [N/m], 3 x 3 and symmetric. Pass null for what is not wanted. In families linear and modal the force is the
 * gradient of the energy and the stiffness its derivative: closed loops do no work. Family rbfn has forces only and
 * refuses the other two with PHN_ERROR_UNDEFINED. Displacements are cut at 1e6 max_displacement_m (linear: 1e100 m). */
PHN_API int phn_force(const phn_model* model, phn_data* data, int32_t node, const double d[3], double force[3],
                      double* energy, double stiffness[9]);

/* Displacements [m] of all output nodes, n_output x 3, with ONE tool at active node `node`. The touched node moves by
 * exactly d. For several tools, or a tool between nodes: phn_couple, then phn_coupled_deform. Adding or averaging the
 * fields of single tools is wrong by 10 % and more. */
PHN_API int phn_deform(const phn_model* model, phn_data* data, int32_t node, const double d[3], double* out);

/* Values of a field at all output nodes, n_output numbers >= 0, 0 at rest, with one tool as in phn_deform. */
PHN_API int phn_field(const phn_model* model, phn_data* data, int32_t node, const double d[3], int32_t field,
                      double* out);

/* Computes what deformations of a node share, 0.03 to 0.4 ms. The first deformation of a node does it otherwise; forces
 * never need it. Scratch keeps the nodes touched last, three for each tool. Results are the same to the last bit. */
PHN_API int phn_prepare(const phn_model* model, phn_data* data, int32_t node);

/* A tool that holds a point of the surface: up to three nodes of one triangle with barycentric weights, >= 0 and of
 * sum 1. A node alone: {node, -1, -1}, {1, 0, 0}. Nodes are active or fixed. */
typedef struct phn_tool {
  int32_t nodes[3]; /* -1: none */
  double weights[3];
  double displacement[3]; /* of the point [m] */
} phn_tool;
typedef struct phn_coupled {
  double residual; /* largest distance between a tool and the point that it holds [m]: rounding, unless UNSETTLED */
  double energy;   /* [J]; 0 in family rbfn */
} phn_coupled;

/* Forces [N] at up to 8 tools anywhere on the surface, n_tools x 3. Every point follows its tool; the force at a node
 * alone is phn_force's; exact in a linear body; continuous where a tool slides over edges and nodes; the gradient of an
 * energy, where the family has one, while the tools hold their points. Depends on these arguments alone, not on earlier
 * calls. Tools within half an edge of each other that pull apart are followed in part: PHN_WARNING_UNSETTLED.
 * PHN_ERROR_UNDEFINED: a touched node is no output node or has no deformation. `result` may be null. Displacements are
 * cut at 1000 max_displacement_m. */
PHN_API int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
                       phn_coupled* result);

/* Displacements [m] of all output nodes, n_output x 3, under the tools of the last phn_couple with this data; zeros
 * before the first. */
PHN_API int phn_coupled_deform(const phn_model* model, phn_data* data, double* out);

/* The tool at the point of the undeformed surface nearest to x [m], displaced by 0. `point` [m] may be null. */
PHN_API int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3]);

/* How far the model can be trusted at d: says where it interpolates, not how large its error is. */
typedef struct phn_trusted {
  double trained_depth; /* [m] in the exploratory direction nearest to d; at rest the least of all. Beyond: OUTSIDE */
  double distance;      /* [m] from d to the nearest displacement that the node was trained on; 0 in family linear */
  double relative; /* distance over the largest one inside the trained range: 0 known, 1 the widest gap, more: beyond */
  double reserved[5]; /* 0 */
} phn_trusted;
PHN_API int phn_trust(const phn_model* model, int32_t node, const double d[3], phn_trusted* trusted);

#ifdef __cplusplus
}
#endif

#endif
