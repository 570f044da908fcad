/* Evaluates every golden query with the model in flash, compares with the host in double, counts instructions.
 * Prints one figure per line, NAME VALUE, and exits with 0 if all agree.
 *
 * In a device the loop is one call of phn_image_force, before it phn_image_nearest for a tool that slides. Only open is
 * called before, and only the stack is used as memory.
 */
#include <phynness/phynness_image.h>
#include <stdint.h>

#include "board.h"
#include "model.h"
#include "model_golden.h"

#if (MODEL_REAL_BYTES == 4) != defined(PHYNNESS_IMAGE_FLOAT)
#error link phynness::image_float for a model that was exported with --float, else phynness::image
#endif
#if MODEL_REAL_BYTES == 4
/* Relative to the largest response. Weights of wide Gaussians cancel by up to 1e4, which multiplies the rounding of
 * floats; phynness export measures it. */
#define FORCE_TOLERANCE 1e-3
#define DEFORMATION_TOLERANCE 1e-3
#else
#define FORCE_TOLERANCE 1e-11
#define DEFORMATION_TOLERANCE 1e-6 /* the runtime sums shared modes in float */
#endif

static const phn_image* model;

static double absolute(double value) { return value < 0 ? -value : value; }
static double larger(double a, double b) { return a > b ? a : b; }

static void set(const double* from, phn_real* to) {
  for (int k = 0; k < 3; ++k) to[k] = (phn_real)from[k];
}

static void report(const char* name, uint32_t value) {
  board_print(name);
  board_print(" ");
  board_print_number(value);
  board_print("\n");
}

/* Comparison of device and host: with the runtime in double, and bit for bit with the same image. */
struct agreement {
  double largest, difference;
  uint32_t other_bits;
};

static void compare(struct agreement* agreement, const double* runtime, const double* image, const phn_real* got) {
  for (int k = 0; k < 3; ++k) {
    agreement->largest = larger(agreement->largest, absolute(runtime[k]));
    agreement->difference = larger(agreement->difference, absolute(runtime[k] - (double)got[k]));
    if (image[k] != (double)got[k]) ++agreement->other_bits;
  }
}

static int agrees(const struct agreement* agreement, const char* what, double tolerance) {
  const double size = agreement->largest > 0 ? agreement->largest : 1, relative = agreement->difference / size;
  board_print(what);
  report("_deviation_1e-9", (uint32_t)(1e9 * (relative < 4 ? relative : 4) + 0.5));
  board_print(what);
  report("_other_bits", agreement->other_bits);
  return relative <= tolerance && agreement->other_bits == 0;
}

/* Instructions and stack of one call: on average, and the most of any. */
struct cost {
  uint32_t n, sum, most, stack;
};

static void measured(struct cost* cost, uint32_t times) {
  const uint32_t once = board_instructions() / times, stack = board_used_stack();
  ++cost->n;
  cost->sum += once;
  if (once > cost->most) cost->most = once;
  if (stack > cost->stack) cost->stack = stack;
}

#define MEASURE(cost, times, call)                               \
  do {                                                           \
    board_mark_stack();                                          \
    board_start_counting();                                      \
    for (int repeated = 0; repeated < (times); ++repeated) call; \
    measured(cost, times);                                       \
  } while (0)

static void report_cost(const char* name, const struct cost* cost) {
  if (cost->n == 0) return;
  board_print(name);
  report("_instructions", cost->sum / cost->n);
  board_print(name);
  report("_instructions_at_most", cost->most);
  board_print(name);
  report("_stack", cost->stack);
}

/* Of all queries; index 0: of tools at nodes, 1: between nodes. */
struct results {
  struct cost force[2], bound[2], search, walk, deformation;
  struct agreement forces, deformations;
  uint32_t other_statuses, other_places, other_bounds;
};

#if MODEL_TRIANGLES > 0
/* The place by a search of all triangles, and a walk after it slid by a tenth of its displacement. */
static void find_place(struct results* results, const struct model_query* query, phn_image_tool* tool) {
  phn_image_tool next;
  phn_real x[3];
  set(query->point, x);
  MEASURE(&results->search, 10, phn_image_nearest(model, -1, x, tool, 0, 0));
  set(query->displacement, tool->displacement);
  if (tool->triangle != query->triangle) ++results->other_places;
  for (int k = 0; k < 3; ++k) {
    if ((double)tool->weights[k] != query->weights[k]) ++results->other_places;
    x[k] += tool->displacement[k] / 10;
  }
  MEASURE(&results->walk, 10, phn_image_nearest(model, tool->triangle, x, &next, 0, 0));
}

static void check_bound(struct results* results, const struct model_query* query, const phn_image_tool* tool) {
  phn_real bound = PHN_IMAGE_NO_BOUND;
  int status;
  MEASURE(&results->bound[query->node < 0], 10, status = phn_image_bound(model, tool, &bound));
  if (status < 0) bound = PHN_IMAGE_NO_BOUND;
  if ((double)bound != query->image_bound) ++results->other_bounds;
}
#endif

#if MODEL_OUTPUT > 0
static void check_deformation(struct results* results, const struct model_query* query, const phn_image_tool* tool) {
  static phn_real scratch[MODEL_SCRATCH > 0 ? MODEL_SCRATCH : 1], field[MODEL_FIELD];
  MEASURE(&results->deformation, 1, phn_image_deform(model, scratch, tool, field));
  compare(&results->deformations, query->deformation, query->image_deformation, &field[3 * query->output]);
}
#endif

static void check(struct results* results, const struct model_query* query) {
  phn_real d[3], force[3];
  int status;
  set(query->displacement, d);
  phn_image_tool tool = phn_image_tool_at(query->node, d);
#if MODEL_TRIANGLES > 0
  if (query->node < 0) find_place(results, query, &tool);
  check_bound(results, query, &tool);
#endif
  MEASURE(&results->force[query->node < 0], 10, status = phn_image_force(model, &tool, force));
  if (status != query->status) ++results->other_statuses;
  compare(&results->forces, query->force, query->image_force, force);
#if MODEL_OUTPUT > 0
  if (query->node >= 0 && results->deformation.n < 32) check_deformation(results, query, &tool);
#endif
}

int main(void) {
  board_start_counting();
  const int status = phn_image_open(model_image, sizeof model_image, &model);
  report("instructions_of_open", board_instructions());
  if (status != PHN_OK) {
    board_print("the image is not valid\n");
    return 1;
  }
  struct results results = {0};
  for (uint32_t i = 0; i < MODEL_GOLDEN; ++i) check(&results, &model_golden[i]);
  report_cost("force_at_node", &results.force[0]);
  report_cost("force_between", &results.force[1]);
  report_cost("bound_at_node", &results.bound[0]);
  report_cost("bound_between", &results.bound[1]);
  report_cost("search", &results.search);
  report_cost("walk", &results.walk);
  report_cost("deformation", &results.deformation);
  report("other_statuses", results.other_statuses);
  report("other_places", results.other_places);
  report("other_bounds", results.other_bounds);
  const int forces = agrees(&results.forces, "force", FORCE_TOLERANCE);
  const int deformations = agrees(&results.deformations, "deformation", DEFORMATION_TOLERANCE);
  const int agree =
      forces && deformations && results.other_statuses == 0 && results.other_places == 0 && results.other_bounds == 0;
  report("agree", (uint32_t)agree);
  return agree ? 0 : 1;
}
