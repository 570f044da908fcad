/* phynness: reaction force, energy, stiffness and deformation of a trained object, in real time.
 *
 * Sizes first, memory second: every object lives in memory that the caller owns, nothing here allocates, frees, prints or
 * reads a file. phn_model never changes after phn_model_init: share it between threads. phn_data is scratch: one per thread.
 * Objects need no clean-up; their memory may be released when no thread uses them any more.
 *
 * Status of every function that returns int: 0 good; < 0 refused, outputs hold zeros; > 0 outputs are defined, but look:
 * a sum of PHN_WARNING_*. phn_status_message says it in words. No output is ever NaN or infinite.
 *
 * Memory given twice: every function reads its inputs before it writes its outputs, so an output may be the memory of an
 * input, or overlap it anywhere: phn_force(model, data, node, v, v) replaces a displacement by its force. Refused with
 * PHN_ERROR_OVERLAP are outputs that overlap each other; memory for an object that overlaps the text or model from which
 * it is made, or the pointer to it; and field, scratch and output of phn_surface_deform, which are too large to be copied
 * first. The memory of an object must overlap nothing else while the object is used; this is not checked.
 *
 * Units are SI: m, N, J. Vectors are x, y, z in the frame of the mesh. Node numbers are those of the mesh (0-based).
 * Force is what must be applied to the object to hold a displacement: a push into it has force . displacement > 0.
 * A haptic device renders its negative. Equation numbers are those of the paper (doc: formats/model.md).
 */
#ifndef PHYNNESS_H
#define PHYNNESS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct phn_model phn_model;
typedef struct phn_data phn_data;

enum {
  PHN_OK = 0,
  PHN_WARNING_OUTSIDE = 1,      /* a displacement is longer than what was trained in its direction */
  PHN_WARNING_INCOMPLETE = 2,   /* some direction of a touched node stopped short of the full depth in training */
  PHN_WARNING_UNSETTLED = 4,    /* coupled tools too near each other to all be followed; forces are bounded */
  PHN_ERROR_ARGUMENT = -1,      /* null pointer, negative number, data of another model */
  PHN_ERROR_NOT_ACTIVE = -2,    /* the node cannot be touched in this model */
  PHN_ERROR_NOT_FINITE = -3,    /* a displacement, place or size is NaN or infinite */
  PHN_ERROR_BUFFER = -4,        /* memory smaller than the _size function asked for */
  PHN_ERROR_TOOLS = -5,         /* more tools than phn_data was made for */
  PHN_ERROR_SAME_NODE = -6,     /* two tools at one node */
  PHN_ERROR_UNDEFINED = -7,     /* the model does not define this: energy of networks, deformation of a node without */
  PHN_ERROR_BUDGET = -8,        /* not even the smallest level fits into the time */
  PHN_ERROR_CLOCK = -9,         /* a clock gives NaN, runs backwards or stands still */
  PHN_ERROR_NOT_A_MODEL = -10,  /* text is not a model.txt */
  PHN_ERROR_VERSION = -11,      /* model.txt of another version */
  PHN_ERROR_TRUNCATED = -12,    /* model.txt ends early */
  PHN_ERROR_CHECKSUM = -13,     /* model.txt was damaged */
  PHN_ERROR_SYNTAX = -14,       /* a number or word of model.txt is malformed */
  PHN_ERROR_RANGE = -15,        /* a count, index or value of model.txt is out of range */
  PHN_ERROR_FAMILY = -16,       /* model.txt holds a family that this version does not know */
  PHN_ERROR_OVERLAP = -17       /* an output lies in the memory of another output, or of a large input */
};

/* Version of this library, "major.minor.patch". */
const char *phn_version(void);

/* Bits of the numbers that the inner loops of forces compute in: 64 in the library phynness_runtime, 32 in
 * phynness_runtime_float, the same source (CMake: phynness::runtime, phynness::runtime_float; link one of them). In that one
 * forces of families rbfn and modal and deformations of family rbfn have the rounding of floats: 1e-7 of their largest
 * terms. A model.txt with weights beyond 1e25, or networks that could reach 1e37 m, is refused there
 * (PHN_ERROR_RANGE). */
int32_t phn_precision(void);

/* One sentence for a status; never null. */
const char *phn_status_message(int status);

/* Checks the whole text of a model.txt (`length` bytes, need not end with 0) and tells the bytes that its model takes.
 * Cost: one pass over the text, twice (checksum, structure); call it at start-up, not in a loop. */
int phn_model_size(const char *text, size_t length, size_t *bytes);

/* Builds the model in `memory` (any alignment). `text` may be released afterwards, `memory` not.
 * On failure *model is null. PHN_ERROR_OVERLAP: `memory` overlaps the text or `model` itself. */
int phn_model_init(void *memory, size_t bytes, const char *text, size_t length, const phn_model **model);

/* Scratch for up to `max_tools` tools (>= 1) at once. The model must outlive it. Sizes beyond what addresses of this
 * machine tell, which those of 32 bits may meet, are refused (PHN_ERROR_RANGE), here and by the other _size functions. */
int phn_data_size(const phn_model *model, int32_t max_tools, size_t *bytes);
int phn_data_init(void *memory, size_t bytes, const phn_model *model, int32_t max_tools, phn_data **data);

/* Numbers of nodes: of the mesh; active, those that can be touched; output, those whose displacement is modelled.
 * 0 for a null model. */
int32_t phn_n_nodes(const phn_model *model);
int32_t phn_n_active(const phn_model *model);
int32_t phn_n_output(const phn_model *model);

/* Mesh node numbers, ascending: n_active and n_output of them; owned by the model. */
const int32_t *phn_active_nodes(const phn_model *model);
const int32_t *phn_output_nodes(const phn_model *model);

/* Reference coordinates of the output nodes, n_output x 3, row by row [m]; owned by the model. */
const double *phn_output_points(const phn_model *model);

/* The surface: triangles, three vertices each, normals outward. Vertices below n_output are output nodes in their order,
 * those from n_output on fixed nodes, which never move. Reference coordinates of fixed nodes: n_fixed x 3 [m]. */
int32_t phn_n_triangles(const phn_model *model);
const int32_t *phn_triangles(const phn_model *model);
int32_t phn_n_fixed(const phn_model *model);
const int32_t *phn_fixed_nodes(const phn_model *model);
const double *phn_fixed_points(const phn_model *model);

/* Reaction force [N] at active node `node` displaced by d [m]. Cost: one exponential per force neuron, (11)-(12); in
 * linear models nine multiplications; in modal models one square root and one division per center. */
int phn_force(const phn_model *model, phn_data *data, int32_t node, const double d[3], double force[3]);

/* Energy [J] stored when active node `node` is displaced from rest to d [m], 0 at d = 0, and stiffness [N/m], 3 x 3,
 * symmetric to the last bit. Linear and modal models define them, and the force is the gradient of the energy, the
 * stiffness the derivative of the force: closed loops do no work. Networks (family rbfn) have no energy and give
 * PHN_ERROR_UNDEFINED. Linear models cut components of d at 1e100 m, modal ones at 1e6 times their largest trained
 * displacement. Cost: as phn_force, for the stiffness about twice that. */
int phn_energy(const phn_model *model, phn_data *data, int32_t node, const double d[3], double *energy);
int phn_stiffness(const phn_model *model, phn_data *data, int32_t node, const double d[3], double stiffness[9]);

/* Displacements [m] of all output nodes, out: n_output x 3 row by row, with tool t at active node nodes[t] displaced by
 * displacements[3 t ... 3 t + 2] [m]. Nodes differ from each other; n_tools = 0 gives zeros.
 * One tool: the network (11)-(12), in linear models the sum of three unit responses, in modal ones a sum of modes, in
 * float; nodes that the probe itself moved in training move by their weight times d, so the touched node moves by
 * exactly d. Several tools: the fields of
 * the tools are averaged with the weights (15)-(16), inverse distances in the reference configuration; these are
 * singular at the touched nodes, where each takes exactly its own displacement. The paper defines no force for several
 * tools: phn_force is that of one tool alone.
 * Cost: n_tools x 3 n_output x neurons multiplications, in modal models x own modes instead, and for a node that was not
 * touched lately once that of phn_prepare; family linear: n_tools x n_output x 9 multiplications.
 * A node of a modal model may have forces only: it gives PHN_ERROR_UNDEFINED. */
int phn_deform(const phn_model *model, phn_data *data, int32_t n_tools, const int32_t *nodes,
               const double *displacements, double *out);

/* Gets the deformations of a node ready: what does not depend on the displacement. Scratch keeps that of the 3 max_tools
 * nodes (at most 24) that were touched last: in modal models their modes with the shared ones summed, 3 n_output x own
 * modes floats each; in family rbfn n_output x neurons Gaussians, as doubles: 0.8 MB for 486 nodes and 200 neurons. The
 * first deformation of any other node makes it; this call, before a tool arrives, takes that off it; forces never do.
 * Results are the same to the last bit. Cost: 3 n_output x shared x own modes, for 486 output nodes, 64 and 16 modes some
 * 0.03 ms with AVX-512 and 0.1 ms with SSE2; n_output x neurons exponentials, for 486 and 200 0.08 to 0.35 ms; none if the
 * node is ready. Nothing to do, and PHN_OK, in linear models and for nodes that have as many modes as are shared, or
 * none. */
int phn_prepare(const phn_model *model, phn_data *data, int32_t node);

/* A tool that holds a point of the surface: up to three nodes of one triangle with barycentric weights, >= 0 and of sum
 * 1. A node alone: {node, -1, -1}, {1, 0, 0}. Nodes are active or fixed ones, by their number in the mesh. */
typedef struct phn_tool {
  int32_t nodes[3];       /* -1: none */
  double weights[3];
  double displacement[3]; /* of the point [m] */
} phn_tool;

/* The tool at the point of the undeformed surface nearest to x [m], displaced by 0; `point` [m] may be null. Cost: a
 * distance to every triangle. Components of x are cut at 1e60 m. PHN_ERROR_UNDEFINED if the model has no triangles. */
int phn_nearest(const phn_model *model, const double x[3], phn_tool *tool, double point[3]);

typedef struct phn_coupled {
  double residual; /* largest distance between a tool's point and where the tool holds it, in the field [m]: rounding, but
                    * where PHN_WARNING_UNSETTLED says that tools are too near each other */
  double energy;   /* [J]; 0 in networks, which have none */
} phn_coupled;

/* Forces [N] at up to 8 tools anywhere on the surface, n_tools x 3, from the responses of single nodes (docs/theory.md,
 * tools anywhere). Exact in a linear body; at a node that node's own answer; continuous where a tool slides over edges and
 * nodes. Forces are the gradient of an energy while the tools hold their points, in families that have one: no closed path
 * does work. The answer depends on these arguments alone, not on earlier calls. `result` may be null.
 * Tools within some half of an edge of each other that ask for different things give PHN_WARNING_UNSETTLED: each is given what
 * they ask for together and a part of what sets them against each other, the less the closer they are.
 * Cost, one tool between three nodes: 21 forces, 3 energies where the family has them, 21 sets of amplitudes and 9 with
 * their gradients, nothing to iterate. n tools: n^2 times that, but for n a set of amplitudes with gradients more for each
 * node, 6 forces of each node, what the vertices around each tool do under the others' nodes, and n passes over the
 * triangles. Of a model with 78 centers and 16 modes 1 tool between nodes takes some 32 us, 2 150, 4 550, 8 2,200; 2 at
 * nodes 35, 4 130, 8 540.
 * PHN_ERROR_NOT_ACTIVE: a node can neither be touched nor is fixed, or all of a tool's are fixed. PHN_ERROR_UNDEFINED: a
 * node has forces only. Components of displacements are cut at 1000 max_displacement_m. */
int phn_couple(const phn_model *model, phn_data *data, int32_t n_tools, const phn_tool *tools, double *forces,
               phn_coupled *result);

/* Displacements [m] of all output nodes, n_output x 3, under the tools of the last phn_couple with this data: the sum of
 * what its nodes do. Zeros before the first. Cost: that of 3 n_tools deformations, of several tools 1 + n_tools times as
 * many. */
int phn_coupled_deform(const phn_model *model, phn_data *data, double *out);

/* The surface subdivided `levels` times (0 ... 6) by Loop's scheme: each level makes four triangles of one and a vertex
 * on every edge, and moves the old vertices to weighted means of their neighbours. The scheme is linear, S(X + u) = S X +
 * S u, so a fine surface is drawn at points + displacements, whatever the model's family. A surface never changes after
 * phn_surface_init: share it between threads. It knows the model no longer: both may be released in any order.
 * The first vertices are those of phn_triangles under the same numbers, those without triangles included, which move
 * with their node. Loop's surface does not pass through the vertices that it is made of: it is smoother and a little
 * smaller than the triangles, and above a touched node it moves by a mean of what the node and its neighbours do.
 * Edges of one triangle (the rim of an open surface) or of more than two are creases, whose vertices know only the
 * crease; where more than two creases meet the vertex stays. A vertex where parts of the surface touch joins them smoothly.
 * Memory: some 90 bytes per vertex of the finest level, and more for open surfaces. Cost of init: that of some ten
 * phn_surface_deform. PHN_ERROR_UNDEFINED: no triangles. PHN_ERROR_RANGE: a triangle has equal corners, or counts
 * would leave 32 bits. */
typedef struct phn_surface phn_surface;
int phn_surface_size(const phn_model *model, int32_t levels, size_t *bytes);
int phn_surface_init(void *memory, size_t bytes, const phn_model *model, int32_t levels, const phn_surface **surface);

/* Vertices and triangles of the finest level; triangles: n_triangles x 3 vertices, orientation as in phn_triangles;
 * points: n_vertices x 3, the subdivided surface at rest [m], in float: a body 1 km from the origin is drawn to 0.1 mm.
 * 0 and null for a null surface. Owned by the surface. */
int32_t phn_surface_n_vertices(const phn_surface *surface);
int32_t phn_surface_n_triangles(const phn_surface *surface);
const int32_t *phn_surface_triangles(const phn_surface *surface);
const float *phn_surface_points(const phn_surface *surface);

/* Floats of scratch that phn_surface_deform needs; 0 for levels = 0. */
size_t phn_surface_scratch(const phn_surface *surface);

/* Displacements [m] of the fine surface, out: n_vertices x 3 row by row. `field`: n_output x 3 [m], from phn_deform or
 * phn_coupled_deform. `scratch`: one for each thread. PHN_ERROR_OVERLAP: two of `field`, `scratch` and `out` overlap.
 * Components are cut at 1e25 m. Cost: about
 * seven multiplications per vertex and component, none of them depending on family or size of the model. */
int phn_surface_deform(const phn_surface *surface, float *scratch, const double *field, float *out);

/* Scalar fields beside the deformation, such as the von Mises stress. A model has those that its database was given, in
 * family modal; most have none. phn_n_fields: their number, 0 for a null model. Name ("von-mises-stress") and unit ("Pa")
 * of field 0 ... n_fields - 1, owned by the model; null for any other number. */
int32_t phn_n_fields(const phn_model *model);
const char *phn_field_name(const phn_model *model, int32_t field);
const char *phn_field_unit(const phn_model *model, int32_t field);

/* Values of a field at all output nodes, out: n_output [unit of the field], 0 or greater, exactly 0 at d = 0, with one
 * tool at active node `node` displaced by d [m]. Fields of several tools are not defined. A field number that the model
 * does not have gives PHN_ERROR_ARGUMENT, a node without deformation PHN_ERROR_UNDEFINED.
 * Cost: the amplitudes, as in phn_deform, and n_output x shared modes: a third of the rest. */
int phn_field(const phn_model *model, phn_data *data, int32_t node, const double d[3], int32_t field, double *out);

/* How deep [m] `node` was trained in the exploratory direction nearest to d; for d = 0 the least of all directions that
 * were trained. Returns PHN_WARNING_OUTSIDE if |d| is beyond. Linear models are exact at any depth and have no outside:
 * they give that warning only for |d| > 1e100 m, where components are cut so that outputs stay finite. */
int phn_trained_depth(const phn_model *model, int32_t node, const double d[3], double *depth);

/* How far d is from what `node` was trained on: the distance [m] to the nearest displacement of its converged increments,
 * or to rest, and the same over the fill distance of these, the largest inside the trained range (in families rbfn and
 * modal; 0 in linear models, which are exact). So `relative` is 0 where the model was told the answer, about 1 in the
 * widest gap between directions, and grows without bound beyond the range. Continuous, and finite for every finite d. It
 * says where a model interpolates and where it extrapolates, not how large its error is (docs/decisions/levels.md).
 * Statuses as phn_trained_depth. Cost: a distance to every increment of every direction. */
int phn_trained_distance(const phn_model *model, int32_t node, const double d[3], double *distance, double *relative);

/* Levels: a model trained with [training] levels holds smaller networks beside its full one, each fitted to the data on
 * its own: the first of the centers and modes that the full one took, with coefficients of their own. Level 0 is the
 * smallest, level n_levels - 1 the full model; n_levels is 1 where training made none, 0 for a null model.
 * phn_level: the largest sizes of all nodes, and errors as the model tells them, fractions of a node's largest force or
 * displacement: the mean at trained displacements left out of the fit one by one, of the median node, inside the trained
 * range (docs/decisions/levels.md says what that is worth); 0 where nothing was estimated. */
typedef struct phn_level {
  int32_t force_centers;       /* centers of a force; in family rbfn its neurons */
  int32_t deformation_centers; /* centers of the amplitudes; in family rbfn neurons of a deformation */
  int32_t modes;               /* of a node; 0 in other families than modal */
  double error_force, error_displacement;
} phn_level;
int32_t phn_n_levels(const phn_model *model);
int phn_level_info(const phn_model *model, int32_t level, phn_level *info);

/* Sets the level of everything that is asked with this data from now on: forces, energies, stiffnesses, deformations,
 * fields and coupled tools; phn_coupled_deform keeps that of its phn_couple. Without it data have the full level. Costs
 * nothing, prepared nodes stay ready. Each level by itself is what the family promises: in family modal the gradient of
 * an energy of its own. Forces and energies jump at a switch, in the mean by about the error of the smaller level, at
 * worst by some ten times that (docs/decisions/levels.md): switch where nothing is touched, or blend forces over some
 * milliseconds, which costs both levels. */
int phn_set_level(const phn_model *model, phn_data *data, int32_t level);
/* 0 for null data. */
int32_t phn_level_of(const phn_data *data);

/* Time of one force and of one deformation of a node that is ready [us] at each level, n_levels of them, on the machine
 * and the thread that calls. The runtime has no clock: `clock_us` gives microseconds from any origin and is passed `user`.
 * Medians of seven batches of at least 20 us with warm caches: under a millisecond a level, and good to a factor of two if
 * the clock ticks in longer steps. Not for the loop. Leaves the level of the data as it was. PHN_ERROR_CLOCK: NaN,
 * infinite, backwards, or no step within 250,000 calls. Deformations of a model of forces only take 0. */
typedef struct phn_level_time {
  double force_us, deformation_us;
} phn_level_time;
int phn_calibrate(const phn_model *model, phn_data *data, double (*clock_us)(void *user), void *user,
                  phn_level_time *times);

/* The level of the smallest error of those that compute n_forces forces and n_deformations deformations within budget_us
 * by these times; the errors of force and displacement are added, those of what is asked for 0 times left out.
 * PHN_ERROR_BUDGET: not even the fastest does; level is 0, the smallest. */
int phn_budget(const phn_model *model, const phn_level_time *times, double n_forces, double n_deformations,
               double budget_us, int32_t *level);

#ifdef __cplusplus
}
#endif

#endif
