/* A minimal program that evaluates force and deformation of a trained model.
 * Usage: minimal MODEL_DIR/model.txt NODE DX DY DZ      (metres; `phynness info MODEL_DIR --json FILE` lists the active
 * nodes)
 */
#include <math.h>
#include <phynness/phynness.h>
#include <stdio.h>
#include <stdlib.h>

static int stop(const char* what, int status) {
  fprintf(stderr, "%s: %s\n", what, phn_status_message(status));
  return 1;
}

/* The whole file in memory; null if it cannot be read. */
static char* read_file(const char* name, size_t* length) {
  char* text = NULL;
  FILE* file = fopen(name, "rb");
  long size = -1;
  if (file == NULL) return NULL;
  if (fseek(file, 0, SEEK_END) == 0) size = ftell(file);
  rewind(file);
  if (size > 0) text = malloc((size_t)size);
  if (text != NULL && fread(text, 1, (size_t)size, file) != (size_t)size) {
    free(text);
    text = NULL;
  }
  fclose(file);
  *length = (size_t)size;
  return text;
}

int main(int argc, char** argv) {
  const phn_model* model = NULL;
  phn_data* data = NULL;
  phn_info info;
  size_t length = 0, model_bytes = 0, data_bytes = 0, wrong_byte = 0;
  int status;

  if (argc != 6) {
    fprintf(stderr, "usage: minimal MODEL_DIR/model.txt NODE DX DY DZ (metres)\n");
    return 2;
  }
  char* text = read_file(argv[1], &length);
  if (text == NULL) {
    fprintf(stderr, "cannot read %s\n", argv[1]);
    return 1;
  }

  /* Start-up: query the size, provide the memory, load the model. A device would use static arrays here. */
  status = phn_model_size(text, length, &model_bytes, &wrong_byte);
  if (wrong_byte > 0) fprintf(stderr, "byte %lu of ", (unsigned long)wrong_byte);
  if (status < 0) return stop(argv[1], status);
  void* model_memory = malloc(model_bytes);
  status = phn_model_init(model_memory, model_bytes, text, length, &model, NULL);
  if (status < 0) return stop(argv[1], status);
  free(text); /* the model keeps nothing of it */

  /* Scratch for one tool at a time; each thread needs its own. */
  phn_model_info(model, &info);
  phn_data_size(model, 1, &data_bytes);
  void* data_memory = malloc(data_bytes);
  double* u = malloc((size_t)info.n_output * 3 * sizeof *u);
  status = phn_data_init(data_memory, data_bytes, model, 1, &data);
  if (status < 0 || u == NULL) return stop("scratch", status);

  /* In a device these two calls would be the loop. */
  const double d[3] = {strtod(argv[3], NULL), strtod(argv[4], NULL), strtod(argv[5], NULL)};
  const phn_tool tool = phn_tool_at((int32_t)strtol(argv[2], NULL, 10), d);
  double force[3], bound = 0;
  status = phn_force(model, data, &tool, force, NULL, NULL);
  if (status < 0) return stop("force", status);
  status = phn_deform(model, data, &tool, u);
  if (status < 0) return stop("deformation", status);
  if (status > 0) printf("warning: %s\n", phn_status_message(status));

  double largest = 0;
  for (int32_t i = 0; i < info.n_output; ++i) {
    largest = fmax(largest, sqrt(u[3 * i] * u[3 * i] + u[3 * i + 1] * u[3 * i + 1] + u[3 * i + 2] * u[3 * i + 2]));
  }
  printf("to hold it:      %9.5f %9.5f %9.5f N\n", force[0], force[1], force[2]);
  if (phn_bound(model, &tool, &bound) >= 0 && bound < PHN_NO_BOUND)
    printf("error: at most   %9.5f N, for 95 %% of random displacements\n", bound);
  printf("to be rendered:  %9.5f %9.5f %9.5f N\n", -force[0], -force[1], -force[2]);
  printf("largest displacement of the %d output nodes: %.6f m\n", (int)info.n_output, largest);

  free(u);
  free(data_memory);
  free(model_memory);
  return 0;
}
