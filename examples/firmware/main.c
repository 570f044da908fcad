/* Evaluates every golden query with the model in flash, compares with the host in double, counts instructions.
 * Prints one figure per line, NAME VALUE, and exits with 0 if all agree.
 *
 * In a device the loop is one call of phn_image_force. Only open is called before, and only the stack is used as
 * memory.
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

static int check_forces(void) {
  struct agreement agreement = {0, 0, 0};
  uint32_t other_statuses = 0;
  for (uint32_t i = 0; i < MODEL_GOLDEN; ++i) {
    const struct model_query* query = &model_golden[i];
    phn_real d[3], force[3];
    set(query->displacement, d);
    if (phn_image_force(model, query->node, d, force) != query->status) ++other_statuses;
    compare(&agreement, query->force, query->image_force, force);
  }
  report("other_statuses", other_statuses);
  return agrees(&agreement, "force", FORCE_TOLERANCE) && other_statuses == 0;
}

/* Instructions of all golden queries, minus those of the same loop without the call. */
static void count_forces(void) {
  uint32_t most = 0, spent[2];
  phn_real d[3], force[3] = {0, 0, 0};
  for (int called = 0; called < 2; ++called) {
    board_start_counting();
    for (uint32_t i = 0; i < MODEL_GOLDEN; ++i) {
      set(model_golden[i].displacement, d);
      __asm volatile("" ::: "memory");
      if (called) phn_image_force(model, model_golden[i].node, d, force);
    }
    spent[called] = board_instructions();
  }
  report("instructions_per_force", (spent[1] - spent[0]) / MODEL_GOLDEN);
  for (uint32_t i = 0; i < MODEL_GOLDEN; ++i) {
    set(model_golden[i].displacement, d);
    board_start_counting();
    for (int repeated = 0; repeated < 10; ++repeated) phn_image_force(model, model_golden[i].node, d, force);
    const uint32_t once = board_instructions() / 10;
    if (once > most) most = once;
  }
  report("instructions_per_force_at_most", most);
  board_mark_stack();
  phn_image_force(model, model_golden[MODEL_GOLDEN - 1].node, d, force);
  report("stack_of_force", board_used_stack());
}

#if MODEL_GOLDEN_AT > 0
/* Instructions and stack of one call on average, and the most of any. */
struct cost {
  uint32_t sum, most, stack;
};

static void begin(void) {
  board_mark_stack();
  board_start_counting();
}

static void end(struct cost* cost) {
  const uint32_t n = board_instructions(), stack = board_used_stack();
  cost->sum += n;
  if (n > cost->most) cost->most = n;
  if (stack > cost->stack) cost->stack = stack;
}

static void report_cost(const char* name, const struct cost* cost) {
  board_print(name);
  report("_instructions", cost->sum / MODEL_GOLDEN_AT);
  board_print(name);
  report("_instructions_at_most", cost->most);
  board_print(name);
  report("_stack", cost->stack);
}

/* A tool between nodes: the place by a search of all triangles, then by a walk after it slid by a tenth of its
 * displacement, force and bound there. */
static int check_places(void) {
  struct agreement agreement = {0, 0, 0};
  struct cost search = {0, 0, 0}, walk = {0, 0, 0}, force_cost = {0, 0, 0}, bound_cost = {0, 0, 0};
  uint32_t other_statuses = 0, other_bits = 0;
  for (uint32_t i = 0; i < MODEL_GOLDEN_AT; ++i) {
    const struct model_place* query = &model_golden_at[i];
    phn_image_place place, next;
    phn_real x[3], d[3], force[3], bound = PHN_IMAGE_NO_BOUND;
    set(query->point, x);
    set(query->displacement, d);
    begin();
    phn_image_nearest(model, -1, x, &place, 0);
    end(&search);
    begin();
    const int status = phn_image_force_at(model, &place, d, force);
    end(&force_cost);
    begin();
    if (phn_image_bound_at(model, &place, d, &bound) < 0) bound = PHN_IMAGE_NO_BOUND;
    end(&bound_cost);
    if (status != query->status) ++other_statuses;
    compare(&agreement, query->force, query->image_force, force);
    if (place.triangle != query->triangle || (double)bound != query->image_bound) ++other_bits;
    for (int k = 0; k < 3; ++k) {
      if ((double)place.weights[k] != query->weights[k]) ++other_bits;
      x[k] += d[k] / 10;
    }
    begin();
    phn_image_nearest(model, place.triangle, x, &next, 0);
    end(&walk);
  }
  report_cost("search", &search);
  report_cost("walk", &walk);
  report_cost("force_at", &force_cost);
  report_cost("bound_at", &bound_cost);
  report("place_other_bits", other_bits);
  return agrees(&agreement, "force_at", FORCE_TOLERANCE) && other_statuses == 0 && other_bits == 0;
}
#else
static int check_places(void) { return 1; }
#endif

#if MODEL_OUTPUT > 0
static phn_real scratch[MODEL_SCRATCH > 0 ? MODEL_SCRATCH : 1], field[MODEL_FIELD];

static int check_deformations(void) {
  struct agreement agreement = {0, 0, 0};
  const uint32_t n = MODEL_GOLDEN < 32 ? MODEL_GOLDEN : 32;
  uint32_t spent = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const struct model_query* query = &model_golden[i];
    phn_real d[3];
    set(query->displacement, d);
    board_start_counting();
    phn_image_deform(model, scratch, query->node, d, field);
    spent += board_instructions() / n;
    compare(&agreement, query->deformation, query->image_deformation, &field[3 * query->output]);
  }
  report("instructions_per_deformation", spent);
  return agrees(&agreement, "deformation", DEFORMATION_TOLERANCE);
}
#else
static int check_deformations(void) { return 1; }
#endif

int main(void) {
  board_start_counting();
  const int status = phn_image_open(model_image, sizeof model_image, &model);
  report("instructions_of_open", board_instructions());
  if (status != PHN_OK) {
    board_print("the image is not valid\n");
    return 1;
  }
  count_forces();
  const int forces = check_forces(), places = check_places(), deformations = check_deformations();
  board_print(forces && places && deformations ? "agree 1\n" : "agree 0\n");
  return forces && places && deformations ? 0 : 1;
}
