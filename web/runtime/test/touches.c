/* Moves a sphere over the body with the native runtime and prints path and forces as JSON, for responses.test.ts.
 * Usage: touches model.txt */
#include <math.h>
#include <phynness/phynness_contact.h>
#include <stdio.h>
#include <stdlib.h>

static void check(int status, const char* what) {
  if (status >= 0) return;
  fprintf(stderr, "touches: %s: %s\n", what, phn_status_message(status));
  exit(1);
}

static char* read_file(const char* name, size_t* length) {
  FILE* file = fopen(name, "rb");
  char* text;
  if (!file || fseek(file, 0, SEEK_END) != 0) exit(1);
  *length = (size_t)ftell(file);
  rewind(file);
  text = malloc(*length + 1);
  if (!text || fread(text, 1, *length, file) != *length) exit(1);
  fclose(file);
  return text;
}

int main(int argc, char** argv) {
  enum { n_steps = 400 };
  size_t length = 0, bytes = 0;
  const phn_model* model = NULL;
  phn_data* data = NULL;
  phn_contact* contact = NULL;
  phn_info info;
  phn_contact_tool tool = {{0, 0, 0}, 0, 0.2, PHN_TOOL_PRESS};
  double middle[3] = {0, 0, 0}, start[3] = {0, 0, 0}, size = 0;
  static double centers[n_steps][3], forces[n_steps][3];
  int touching = 0, i, k;
  char* text;
  if (argc != 2) return 2;
  text = read_file(argv[1], &length);
  check(phn_model_size(text, length, &bytes, NULL), "model");
  check(phn_model_init(malloc(bytes), bytes, text, length, &model, NULL), "model");
  check(phn_tools_size(model, 1, &bytes), "data");
  check(phn_tools_init(malloc(bytes), bytes, model, 1, &data), "data");
  check(phn_contact_size(model, 1, &bytes), "contact");
  check(phn_contact_init(malloc(bytes), bytes, model, 1, &contact), "contact");
  check(phn_model_info(model, &info), "info");
  for (i = 0; i < info.n_output; ++i)
    for (k = 0; k < 3; ++k) middle[k] += info.output_points[3 * i + k] / info.n_output;
  for (i = 0; i < info.n_output && info.output_nodes[i] != info.active_nodes[0]; ++i) continue;
  for (k = 0; k < 3; ++k) start[k] = info.output_points[3 * i + k];
  for (k = 0; k < 3; ++k) size += (start[k] - middle[k]) * (start[k] - middle[k]);
  size = sqrt(size);
  tool.radius = 0.05 * size;
  /* From outside into the body beside its first active node, out again, with a sideways motion. */
  for (i = 0; i < n_steps; ++i) {
    const double turn = 6.283185307179586 * i / n_steps, out = 1 + 0.1 * cos(turn);
    phn_contact_state state;
    for (k = 0; k < 3; ++k)
      tool.center[k] = centers[i][k] = middle[k] + out * (start[k] - middle[k]) + 0.03 * size * sin(3 * turn + k);
    check(phn_contact_step(contact, data, 1, &tool, &state, NULL), "step");
    for (k = 0; k < 3; ++k) forces[i][k] = state.force[k];
    touching += state.in_contact;
  }
  printf("{\"radius\":%.17g,\"friction\":%.17g,\"touching\":%d,\"centers\":[", tool.radius, tool.friction, touching);
  for (i = 0; i < n_steps; ++i)
    printf("%s[%.17g,%.17g,%.17g]", i ? "," : "", centers[i][0], centers[i][1], centers[i][2]);
  printf("],\"forces\":[");
  for (i = 0; i < n_steps; ++i) printf("%s[%.17g,%.17g,%.17g]", i ? "," : "", forces[i][0], forces[i][1], forces[i][2]);
  printf("]}\n");
  return fflush(stdout) == 0 ? 0 : 1;
}
