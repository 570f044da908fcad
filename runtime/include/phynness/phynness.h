/* phynness: reaction force and deformation of a trained object in real time. This header is the core of the runtime.
 * Further headers: phynness_body.h (several round tools), phynness_tools.h (several node probes), phynness_contact.h
 * (spheres that touch, slide and grasp), phynness_surface.h (a finer surface for drawing), phynness_image.h (models in
 * flash memory), phynness_loop.h (between a haptic device and a body).
 *
 * Start-up: phn_model_size, phn_model_init, phn_data_size, phn_data_init. The caller provides the memory. No function
 * allocates memory, prints or reads a file, and nothing has to be released. A phn_model is constant and may be shared
 * between threads. A phn_data is working memory of one thread.
 *
 * Memory of an object must not move, and stays the caller's: in a language that moves objects (C#, Java) it is pinned
 * or native memory, as are arrays during a call. Bindings check, before all else, that phn_abi_version is the one for
 * which they were written, and that phn_sizeof of every struct that they use is the size of theirs. Reserved words are
 * 0.
 *
 * Units are SI. Vectors have the components x, y, z in the right-handed frame of the mesh; no axis has a meaning. A
 * left-handed host (Unity, Unreal) negates one component of every position, displacement and force, both ways, and
 * swaps two corners of every triangle; energies and depths stay the same. Displacements d are measured from the
 * undeformed state. Nodes have the numbers of the mesh, starting with 0. A force is the force that must be applied to
 * the object to hold a displacement; a haptic device renders its negative.
 *
 * Functions that return int return a status. 0: success. > 0: a sum of PHN_WARNING_*; the outputs are defined, but the
 * model is used outside of its range. < 0: PHN_ERROR_*; the call is refused and the outputs are zeros, but bounds of
 * errors are PHN_NO_BOUND, because 0 would say that the force is exact. No output is ever NaN or infinite. An output
 * may overlap an input in memory. Two outputs must not overlap, nor may an object overlap the memory from which it is
 * made. Equation numbers are those of the paper.
 *
 * Cost [us], medians on one core of an AMD EPYC, demo: modal model of 47 points, body of 160 modes and 400 cells
 *   phn_force at a node; with energy and stiffness                   0.12; 0.23
 *   phn_force of a round tool between nodes                          1.1
 *   phn_deform at a node, prepared                                   1.6
 *   phn_body_force, one step, 1, 2, 4, 8 tools that move             350, 400, 480, 730 */
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
  PHN_WARNING_OUTSIDE = 1,        /* a displacement is larger than trained, or the place was not trained */
  PHN_WARNING_INCOMPLETE = 2,     /* some direction of a touched node was not trained to the full depth */
  PHN_WARNING_UNSETTLED = 4,      /* tools are not followed: too close together, or faster than the body settles */
  PHN_WARNING_NEAR = 8,           /* springs join near tools of a body: their forces may be off by a third and more */
  PHN_WARNING_RELAXATION = 16,    /* the place moves or the tool has left: a relaxing force is approximate */
  PHN_ERROR_ARGUMENT = -1,        /* a null pointer, a number out of range, or data of another model */
  PHN_ERROR_NOT_ACTIVE = -2,      /* the node, or all that the tool touches, cannot be touched */
  PHN_ERROR_NOT_FINITE = -3,      /* a displacement, position or size is NaN or infinite */
  PHN_ERROR_BUFFER = -4,          /* the memory is smaller than the _size function returned */
  PHN_ERROR_TOOLS = -5,           /* more tools than the phn_data or phn_contact was made for (phynness_tools.h) */
  PHN_ERROR_ROUND_TOOLS = -6,     /* two round tools on a model, which answers one; a body answers several */
  PHN_ERROR_UNDEFINED = -7,       /* the model or the node has no such response, e.g. no energy or no bound */
  PHN_ERROR_CLOCK = -8,           /* the time of a step is not later than that of the step before (phynness_loop.h) */
  PHN_ERROR_NOT_A_MODEL = -9,     /* the text is not a model.txt, or the bytes are not an image */
  PHN_ERROR_VERSION = -10,        /* the model, or a struct with reserved words that are not 0, is of another version */
  PHN_ERROR_TRUNCATED = -11,      /* the model is incomplete at its end */
  PHN_ERROR_CHECKSUM = -12,       /* the checksum of the model is wrong: the model is damaged */
  PHN_ERROR_SYNTAX = -13,         /* a number or word of the model is malformed */
  PHN_ERROR_RANGE = -14,          /* a count, index or value of the model is out of range */
  PHN_ERROR_FAMILY = -15,         /* this version does not know the model's family */
  PHN_ERROR_OVERLAP = -16,        /* an output overlaps another output or a large input in memory */
  PHN_ERROR_TOO_LARGE = -17,      /* the result has more bytes or numbers than size_t or int32_t can count */
  PHN_ERROR_GEOMETRY = -18,       /* a triangle has equal corners, or coordinates are too large for contact */
  PHN_ERROR_TOO_MANY_TOOLS = -19, /* more than PHN_MOST_COUPLED, or a body's n_modes / 9 */
  PHN_ERROR_IMAGE_OF_FLOATS = -20,  /* but the code is for images of doubles: export without --float */
  PHN_ERROR_IMAGE_OF_DOUBLES = -21, /* but the code is for images of floats: phynness export --float */
  PHN_ERROR_SETTING = -100          /* and below: of a loop, a setting is out of its range (phn_loop_init) */
};
enum { PHN_MOST_COUPLED = 8, PHN_MOST_FIELDS = 8, PHN_MOST_RELAXING = 8 };

/* The version of this library, "major.minor.patch". */
PHN_API const char* phn_version(void);

/* Rises with every change of a function or a struct that programs compiled before would not survive. */
#define PHN_ABI_VERSION 1
PHN_API int32_t phn_abi_version(void);
/* Bytes of a struct of the headers in this library, for example of "phn_tool"; 0: there is none of this name. */
PHN_API int32_t phn_sizeof(const char* struct_name);

/* The meaning of a status in one sentence; never null. */
PHN_API const char* phn_status_message(int status);

/* Checks the text of a model.txt (`length` bytes, not necessarily followed by a 0) and gives the size of its model in
 * memory [bytes]. `wrong_byte` may be null; it becomes the position of the first error in a refused text, counted from
 * 1, or 0 for a valid text. */
PHN_API int phn_model_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte);

/* Builds the model in `memory` (any alignment). The text may be released afterwards; the memory must be kept while the
 * model is used. On failure *model is null. */
PHN_API int phn_model_init(void* memory, size_t bytes, const char* text, size_t length, const phn_model** model,
                           size_t* wrong_byte);

/* Where a model comes from; no answer depends on it. Strings are never null. "" and 0: not recorded, as in models
 * that were not trained on a database.
 *
 * Forces scale with the stiffness of the body: if all moduli are s times those of the training, with the same ratios to
 * each other, force, energy, stiffness and bound at the same displacement are s times those of the model, and the
 * deformation is the same. A controller that learns the shear modulus of a patient multiplies forces by this modulus
 * over shear_modulus_Pa. */
typedef struct phn_provenance {
  const char *mesh_hash, *physics_hash; /* of the mesh and of all that decided the solves, 16 hexadecimal digits */
  const char* element;                  /* of the finite elements, "p1-p1" */
  const char* reference;                /* of the distance: "taylor-hood", elements on the same mesh; "half-size" */
  double shear_modulus_Pa;              /* at rest, of the body that was trained */
  double finer_mean, finer_p95;         /* distance of the finite elements' forces from those of the reference, */
  double finer_tool_radius_m;           /* over those of the reference, with a round tool */
  int32_t finer_probes;                 /* that both solve; 0: no distance is known */
  int32_t finer_nodes;                  /* of the mesh of the reference */
  int32_t bound_reference;              /* of the bounds; 0: these finite elements, 1: taylor-hood, 2: half-size */
  int32_t reserved PHN_ZEROS;
} phn_provenance;

/* How a body relaxes: its shear modulus falls by the shares g in the times tau_s after a sudden strain (Prony series).
 */
typedef struct phn_relaxation {
  double g[PHN_MOST_RELAXING], tau_s[PHN_MOST_RELAXING]; /* g > 0, sum below 1; tau_s > 0 */
  double length_m;                                       /* radius of the tool; 0: node probes */
  int32_t n_terms;                                       /* 0: elastic */
  int32_t reserved PHN_ZEROS;
} phn_relaxation;

/* Contents of a model. The pointers refer to memory of the model. Lists of nodes are in ascending order. Points are
 * n x 3, row by row, in the undeformed state [m]. */
typedef struct phn_info {
  const char *family, *title, *mesh_hash; /* family: "rbfn", "modal" or "linear" */
  double max_displacement_m;              /* largest displacement of the training data */
  const int32_t* active_nodes;            /* n_active: nodes that can be touched */
  const int32_t* output_nodes;            /* n_output: nodes whose displacement is modelled */
  const int32_t* fixed_nodes;             /* n_fixed: nodes of the surface that never move */
  const double *output_points, *fixed_points;
  const int32_t* triangles; /* n_triangles x 3, normals outward; 0 ... n_output - 1: output nodes; then fixed nodes */
  const char *field_names[PHN_MOST_FIELDS], *field_units[PHN_MOST_FIELDS]; /* "von-mises-stress", "Pa"; unused: null */
  int32_t n_nodes;                                                         /* of the mesh */
  int32_t n_active, n_output, n_fixed, n_triangles, n_fields;
  int32_t n_levels;   /* 1 or more: phn_level_info */
  int32_t has_energy; /* 1, or 0 in family rbfn */
  phn_provenance provenance;
  phn_relaxation relaxation;
  int32_t reserved[4] PHN_ZEROS;
} phn_info;
PHN_API int phn_model_info(const phn_model* model, phn_info* info);

/* Working memory for `max_tools` (>= 1) simultaneous tools, of which 8 can be coupled; with node probes it grows with
 * the square of these. The model must outlive it. */
PHN_API int phn_data_size(const phn_model* model, int32_t max_tools, size_t* bytes);
PHN_API int phn_data_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools, phn_data** data);

/* A tool: a place of the surface, which it holds, and the displacement of this place. A place is up to three nodes of
 * one triangle with barycentric weights, which are >= 0 and have the sum 1. Each node is active, fixed, or covered:
 * answered from up to three points around it, active nodes or, where the model is linear, others. In a model of round
 * tools (patch probes that move a mean; model.txt says `mean` at each node) the tool is the round one whose middle is
 * the place. Another struct of the headers has its own reserved words. */
typedef struct phn_tool {
  int32_t nodes[3]; /* -1: unused */
  double weights[3];
  double displacement[3];        /* of the place, from rest [m] */
  int32_t reserved[2] PHN_ZEROS; /* 0; PHN_ERROR_VERSION otherwise */
} phn_tool;

/* The tool at a node, displaced by d [m]. */
static inline phn_tool phn_tool_at(int32_t node, const double d[3]) {
  const phn_tool tool = {{node, -1, -1}, {1, 0, 0}, {d[0], d[1], d[2]}, {0, 0}};
  return tool;
}

/* The tool, with displacement 0, at that place of the undeformed surface which is nearest to x [m] among those that
 * phn_force answers (at a fixed edge a twentieth of a triangle away), its point, and the distance of x from it [m], < 0
 * inside of the body; both may be null. (x - point) / distance is the outward normal, but on the surface and beyond the
 * part that can be touched. Below the middle of a thin body the other side is nearest: keep the place that was touched
 * first. Components of x are clamped to 1e60 m. PHN_ERROR_UNDEFINED: no triangle can be touched. */
PHN_API int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3], double* distance);

/* The force [N] that holds a tool, the stored energy [J], which is 0 at rest, and the stiffness [N/m], 3 x 3 and
 * symmetric. Outputs that are not needed may be null; what is asked for together has the same bits as alone. In the
 * families linear and modal the force is the gradient of the energy and the stiffness is the derivative of the force,
 * so that closed paths do no work. The family rbfn has forces only; for energy or stiffness it returns
 * PHN_ERROR_UNDEFINED. At a node, components of the displacement are clamped to 1e6 max_displacement_m (linear: 1e100
 * m), between nodes to 1000 max_displacement_m.
 *
 * A round tool between nodes has a mean of the energies of the tools at the nodes around it for the same displacement
 * (docs/theory.md, (x)); force and stiffness are its derivatives. Family rbfn has the same mean of the forces. They are
 * continuous where the tool slides over edges and nodes. Fixed nodes of the triangle do not count; where their weights
 * exceed 1e-5, the tool is PHN_WARNING_OUTSIDE at any displacement. So it is, but in family linear, where points have a
 * part that were not probed and answer as the body at rest. A warning of any active node of the triangle, or around its
 * covered nodes, with more than 1e-5 of the weight is one of the tool. Cost: about 12 forces.
 * Node probes between nodes are coupled, as by phn_couple of one tool (phynness_tools.h); they have no stiffness
 * (PHN_ERROR_UNDEFINED).
 *
 * Cost in family modal, 78 centers, AVX2 or AVX-512: a force with stiffness takes 1.5 times a force (without AVX2 2.1
 * times), with the energy as well 1.6 times. A force with energy takes no longer than a force.
 *
 * The stiffness may be indefinite inside the trained range: in the demo's model in 2 % of all directions at 10 mm and
 * in 15 % at 20 mm, with eigenvalues down to -4 N/m. That is the body, not an error of the model: finite elements have
 * the same eigenvalue (-1.82 N/m in both where they were compared). A Newton step with the stiffness alone may
 * therefore leave the balance. Either couple the tool by a spring that is stiffer than the most negative eigenvalue is
 * negative, so that the sum of both stiffnesses is positive definite, or damp the step: replace eigenvalues below a
 * positive bound by this bound. */
PHN_API int phn_force(const phn_model* model, phn_data* data, const phn_tool* tool, double force[3], double* energy,
                      double stiffness[9]);

/* Displacements [m] of all output nodes, n_output x 3, with ONE tool. A touched node moves by exactly its displacement;
 * under a round tool (a patch probe) the mean of the surface does, and its middle by a fifth more and farther. The
 * field of a round tool between nodes is the mean of its nodes' fields; node probes between nodes are coupled. */
PHN_API int phn_deform(const phn_model* model, phn_data* data, const phn_tool* tool, double* out);

/* Values of a scalar field at all output nodes, n_output numbers >= 0, with one tool as in phn_deform. They are 0 at
 * rest. `field` is an index of phn_info.field_names. PHN_ERROR_UNDEFINED: also between nodes of node probes. */
PHN_API int phn_field(const phn_model* model, phn_data* data, const phn_tool* tool, int32_t field, double* out);

/* Computes the quantities that all deformations of a place have in common (0.03 to 0.4 ms for each of its nodes).
 * Without this call the first deformation computes them. Forces do not use them. `data` keeps them for the nodes
 * touched last, three nodes for each tool. Results are bitwise the same with and without this call. */
PHN_API int phn_prepare(const phn_model* model, phn_data* data, const phn_tool* tool);

/* Depth [m] of the trained range of a tool in the direction of its displacement, the smallest of its nodes; at rest the
 * smallest of all directions. A displacement longer than that gives PHN_WARNING_OUTSIDE here and in phn_force. 0 where
 * fixed nodes make a round tool PHN_WARNING_OUTSIDE. PHN_ERROR_UNDEFINED: between nodes of node probes. */
PHN_API int phn_depth(const phn_model* model, const phn_tool* tool, double* depth);

/* A bound [N] of the error of phn_force, |force - finite element force|, of the full level; half of the time of a
 * force. `phynness calibrate` adds the bounds to a model. For random displacements inside the trained range, of random
 * places, the error is below the bound with the probability that formats/model.md calls coverage (0.95). A single
 * place, or a hand that chooses its path, may do worse: the bound is a statistical one and no guarantee. Outside of the
 * trained range (PHN_WARNING_OUTSIDE), and between nodes where calibration had too few tools there, nothing is known,
 * and the bound is PHN_NO_BOUND; so it is after every error. PHN_ERROR_UNDEFINED: the model has no bounds. At rest the
 * bound at a node is the size of phn_force there: 0 in family modal, whose force is exact at rest; in family rbfn the
 * networks have a small force.
 */
#define PHN_NO_BOUND 1e300
PHN_API int phn_bound(const phn_model* model, const phn_tool* tool, double* bound);

/* What one tool has of its past. Begin with {0}, and set `outward` if the tool only pushes. */
typedef struct phn_relaxing {
  double relaxed[PHN_MOST_RELAXING][3]; /* force that each term has lost [N] */
  double elastic[3];                    /* elastic force of the last step [N] */
  double place[3];                      /* of the last step [m] */
  double outward[3]; /* of a tool that lies on the body without sticking: the outward normal; zeros: it is held */
  double moved;      /* how much of the history is of other places, 0 ... 1 */
  int32_t n_steps;   /* 0: none; 1: there were steps */
  int32_t reserved PHN_ZEROS;
} phn_relaxing;

/* The force [N] of a body that relaxes, from the elastic one of a tool (of phn_force, phn_body_force, or an image):
 *   F = F_e - sum r_i,  dr_i/dt = (g_i F_e - r_i) / tau_i
 * which is the convolution of F_e with 1 - sum g_i (1 - exp(-t / tau_i)). The recursion is exact for any dt_s if F_e is
 * linear in time within the step, and otherwise of second order in dt_s. It takes under 0.1 us a term and has the same
 * bits on every machine. Without terms the force is F_e, bit by bit. docs/theory.md, Relaxation: when it is exact, and
 * the error.
 *
 * `place` is the point of the undeformed surface [m], as of phn_nearest, or null for one that stays. Where it moves,
 * r_i falls by exp(-distance / length_m), because the tool comes to fresh tissue (length_m 0: to zero); while more than
 * a twentieth of the history is of other places, the status is PHN_WARNING_RELAXATION. With `outward` the force never
 * pulls: when it would, the tool has left the body, which recovers freely (force 0, PHN_WARNING_RELAXATION) until the
 * tool meets it again.
 * PHN_ERROR_CLOCK: dt_s <= 0. PHN_ERROR_RANGE: numbers of `terms`. After an error the history stays. */
PHN_API int phn_relax(const phn_relaxation* terms, phn_relaxing* history, const double elastic[3],
                      const double place[3], double dt_s, double force[3]);

/* Levels of a model are smaller networks that take less time.
 * A model trained with `levels` in [training] contains smaller networks beside the full one. Each level uses the first
 * centers and modes of the full network, and its coefficients are fitted to the data separately. Level 0 is the
 * smallest; level phn_info.n_levels - 1 is the full model. Every level has the properties of its family: in family
 * modal, for example, its force is the gradient of its own energy.
 *
 * Sizes are the largest of all nodes. Errors are those stored in the model: leave-one-out errors at the displacements
 * of the training data, as a fraction of a node's largest force or displacement, averaged over the displacements, for
 * the median node. They are estimates inside the trained range only (docs/decisions/levels.md); 0: no estimate. */
typedef struct phn_level {
  int32_t force_centers;       /* centers of a force; in family rbfn neurons of a force network */
  int32_t deformation_centers; /* centers of the amplitudes; in family rbfn neurons of a deformation network */
  int32_t modes;               /* of a node; 0 in other families than modal */
  double error_force, error_displacement;
  int32_t reserved[2] PHN_ZEROS;
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
