/* A program written from the headers alone: what a binding checks first, then a tool and a sphere on a model.
 * Usage: c_consumer MODEL_DIR/model.txt */
#include <math.h>
#include <phynness/phynness.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_image.h>
#include <phynness/phynness_loop.h>
#include <phynness/phynness_surface.h>
#include <phynness/phynness_tools.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;
static void expect(int is_true, const char* claim) {
  if (is_true) return;
  fprintf(stderr, "not true: %s\n", claim);
  ++failures;
}

static void refuse_what_is_no_model(void) {
  size_t bytes = 1, of_contact = 1, wrong_byte = 0;
  const double words[] = {1, 2, 3};
  const phn_image* image = NULL;
  const phn_image_tool tool = phn_image_tool_at(3, words);
  phn_real force[3] = {1, 1, 1};
  phn_info info;
  const int status = phn_model_size("hello", 5, &bytes, &wrong_byte);
  printf("phynness %s: %s\n", phn_version(), phn_status_message(status));
  expect(status == PHN_ERROR_NOT_A_MODEL && bytes == 0 && wrong_byte == 1, "a text that is no model is refused");
  expect(phn_image_open(words, sizeof words, &image) == PHN_ERROR_NOT_A_MODEL && image == NULL, "nor is it an image");
  expect(phn_image_force(image, &tool, force) == PHN_ERROR_ARGUMENT && force[0] == 0, "no image has no force");
  expect(phn_contact_size(NULL, 1, &of_contact) == PHN_ERROR_ARGUMENT && of_contact == 0, "contact needs a model");
  expect(phn_model_info(NULL, &info) == PHN_ERROR_ARGUMENT, "no model has no contents");
}

static void check_version(void) {
  expect(phn_abi_version() == PHN_ABI_VERSION, "header and library have one version");
  expect(phn_sizeof("phn_info") == (int32_t)sizeof(phn_info) && phn_sizeof("phn_tool") == (int32_t)sizeof(phn_tool) &&
             phn_sizeof("phn_image_tool") == (int32_t)sizeof(phn_image_tool) &&
             phn_sizeof("phn_contact_state") == (int32_t)sizeof(phn_contact_state) &&
             phn_sizeof("phn_loop_settings") == (int32_t)sizeof(phn_loop_settings),
         "structs have the sizes of the library");
}

static void touch(const phn_model* model, const phn_info* info) {
  size_t bytes = 0;
  phn_data* data = NULL;
  phn_contact* contact = NULL;
  phn_tool tool;
  phn_contact_tool sphere = {{0}, 0, 0, 0, 0};
  phn_contact_state state;
  double x[3], point[3], distance, force[3], bound;
  double* field = malloc(3 * sizeof *field * (size_t)info->n_output);
  int k, in_contact = 0, i, node;

  expect(phn_data_size(model, 1, &bytes) == PHN_OK, "a size");
  void* memory = malloc(bytes);
  expect(phn_data_init(memory, bytes, model, 1, &data) == PHN_OK, "working memory");
  for (k = 0; k < 3; ++k) x[k] = info->output_points[k] + 0.5;
  expect(phn_nearest(model, x, &tool, point, &distance) == PHN_OK, "a place that can be touched");
  expect(fabs(distance - sqrt(pow(x[0] - point[0], 2) + pow(x[1] - point[1], 2) + pow(x[2] - point[2], 2))) < 1e-12,
         "its distance");
  for (k = 0; k < 3; ++k) tool.displacement[k] = 1e-3 * (point[k] - x[k]) / distance;
  expect(phn_force(model, data, &tool, force, NULL, NULL) >= 0, "a force");
  expect(force[0] * tool.displacement[0] + force[1] * tool.displacement[1] + force[2] * tool.displacement[2] > 0,
         "that pushes into the object");
  expect(phn_deform(model, data, &tool, field) >= 0, "a field");
  expect(phn_bound(model, &tool, &bound) >= PHN_ERROR_UNDEFINED, "a bound, or none");
  tool.reserved[0] = 1;
  expect(phn_force(model, data, &tool, force, NULL, NULL) == PHN_ERROR_VERSION && force[0] == 0, "another version");

  expect(phn_contact_size(model, 1, &bytes) == PHN_OK, "a size of contact");
  void* of_contact = malloc(bytes);
  expect(phn_contact_init(of_contact, bytes, model, 1, &contact) == PHN_OK, "contact");
  sphere.radius = 0.002;
  sphere.mode = PHN_TOOL_PRESS;
  for (node = 0; node < info->n_output && !in_contact; ++node) { /* down to each node, where some is met from outside */
    expect(phn_contact_reset(contact) == PHN_OK, "a new tool");
    for (i = 0; i <= 10 && !in_contact; ++i) {
      for (k = 0; k < 3; ++k) sphere.center[k] = info->output_points[3 * node + k] + (k == 2 ? 0.01 * (10 - i) : 0);
      expect(phn_contact_step(contact, 1, &sphere, &state, NULL) >= 0, "a step");
      in_contact = state.in_contact;
    }
  }
  expect(in_contact &&
             state.force[0] * state.normal[0] + state.force[1] * state.normal[1] + state.force[2] * state.normal[2] < 0,
         "the sphere arrives and pushes");
  expect(phn_contact_deform(contact, field) >= 0, "what is drawn");
  free(of_contact);
  free(memory);
  free(field);
}

int main(int argc, char** argv) {
  const phn_model* model = NULL;
  phn_info info;
  size_t bytes = 0, length;
  refuse_what_is_no_model();
  check_version();
  if (argc > 1) {
    FILE* file = fopen(argv[1], "rb");
    char* text = malloc((size_t)1 << 26);
    if (file == NULL || text == NULL) return 2;
    length = fread(text, 1, (size_t)1 << 26, file);
    fclose(file);
    expect(phn_model_size(text, length, &bytes, NULL) == PHN_OK, "a model");
    void* memory = malloc(bytes);
    expect(phn_model_init(memory, bytes, text, length, &model, NULL) == PHN_OK, "that is read");
    free(text);
    expect(phn_model_info(model, &info) == PHN_OK, "and tells what it holds");
    touch(model, &info);
    free(memory);
  }
  return failures == 0 ? 0 : 1;
}
