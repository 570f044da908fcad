/* A haptic loop at 1 kHz around a trained model, with a simulated hand and device: docs/howto/haptic-loop.md.
 * Usage: haptic_loop MODEL_DIR/model.txt NODE [SECONDS]     (`phynness info MODEL_DIR` lists the active nodes)
 * Exit status: 0; 1: an error; 2: wrong usage; 3: the loop tripped (the last line says why)
 */
#include <math.h>
#include <phynness/phynness.h>
#include <phynness/phynness_loop.h>
#include <stdio.h>
#include <stdlib.h>

/* The device: replace these two functions, and the clock, by calls of the manufacturer's library. Here a hand, which is
 * a spring and a damper to the place where it wants to be, holds a mass with friction. */
enum { steps_per_cycle = 20 };
static double now_s, reach_m, at[3], velocity[3];

/* The newest position and the time of its measurement. Returns 0 if none arrived since the last call. */
static int device_position(double position_m[3], double* measured_s) {
  const double step_m = 2e-5;
  for (int k = 0; k < 3; ++k) position_m[k] = step_m * floor(at[k] / step_m + 0.5);
  *measured_s = now_s;
  return 1;
}

/* Applies a force until the next call. The simulation also lets a cycle pass. */
static void device_force(const double force_N[3]) {
  const double mass_kg = 0.08, friction = 0.5, hand_N_per_m = 250, hand_Ns_per_m = 4, dt = 1e-3 / steps_per_cycle;
  for (int i = 0; i < steps_per_cycle; ++i) {
    const double t = now_s + i * dt, press = 0.5 - 0.5 * cos(2.5 * t);
    const double wanted[3] = {0.3 * reach_m * press * cos(5.7 * t), 0.3 * reach_m * press * sin(5.7 * t),
                              -0.9 * reach_m * press};
    for (int k = 0; k < 3; ++k) {
      const double hand = hand_N_per_m * (wanted[k] - at[k]) - hand_Ns_per_m * velocity[k];
      velocity[k] += dt / mass_kg * (hand + force_N[k] - friction * velocity[k]);
      at[k] += dt * velocity[k];
    }
  }
  now_s += 1e-3;
}

static int stop(const char* what, int status) {
  fprintf(stderr, "%s: %s\n", what, phn_status_message(status));
  return 1;
}

/* The whole file in memory; null if it cannot be read. */
static char* read_file(const char* name, size_t* length) {
  char* text = NULL;
  FILE* file = fopen(name, "rb");
  if (file == NULL) return NULL;
  const long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
  rewind(file);
  if (size > 0) text = malloc((size_t)size);
  *length = text == NULL ? 0 : fread(text, 1, (size_t)size, file);
  fclose(file);
  return text;
}

/* The body: the tool holds one node, whose place at rest is the origin. */
static phn_loop_response response_at(const phn_model* model, phn_data* data, int32_t node, int has_energy,
                                     const double tool[3]) {
  phn_loop_response r = {0};
  r.in_contact = 1;
  r.has_stiffness = has_energy;
  r.energy = -1;
  for (int k = 0; k < 3; ++k) r.displacement[k] = tool[k];
  const phn_tool held = phn_tool_at(node, tool);
  r.status = phn_force(model, data, &held, r.force, has_energy ? &r.energy : NULL, has_energy ? r.stiffness : NULL);
  return r;
}

int main(int argc, char** argv) {
  const phn_model* model = NULL;
  phn_data* data = NULL;
  phn_loop* loop = NULL;
  phn_info info;
  phn_loop_settings settings;
  phn_loop_report report;
  size_t length = 0, model_bytes = 0, data_bytes = 0, loop_bytes = 0;
  double tool[3] = {0, 0, 0}, force[3], position[3], measured_s, largest_N = 0;

  if (argc < 3 || argc > 4) {
    fprintf(stderr, "usage: haptic_loop MODEL_DIR/model.txt NODE [SECONDS]\n");
    return 2;
  }
  const int32_t node = (int32_t)strtol(argv[2], NULL, 10);
  const long cycles = (long)(1e3 * (argc > 3 ? strtod(argv[3], NULL) : 10));

  /* All memory is taken before the loop. */
  char* text = read_file(argv[1], &length);
  if (text == NULL) {
    fprintf(stderr, "cannot read %s: give the model.txt that `phynness train` wrote\n", argv[1]);
    return 1;
  }
  int status = phn_model_size(text, length, &model_bytes, NULL);
  if (status < 0) return stop(argv[1], status);
  void* model_memory = malloc(model_bytes);
  status = phn_model_init(model_memory, model_bytes, text, length, &model, NULL);
  if (status < 0) return stop(argv[1], status);
  free(text);
  phn_model_info(model, &info);
  phn_data_size(model, 1, &data_bytes);
  void* data_memory = malloc(data_bytes);
  status = phn_data_init(data_memory, data_bytes, model, 1, &data);
  if (status < 0) return stop("scratch", status);
  status = response_at(model, data, node, info.has_energy, tool).status;
  if (status < 0) return stop(argv[2], status);

  phn_loop_defaults(&settings);
  settings.position_resolution_m = 2e-5;
  settings.reach_m = info.max_displacement_m;
  phn_loop_size(&loop_bytes);
  void* loop_memory = malloc(loop_bytes);
  status = phn_loop_init(loop_memory, loop_bytes, &settings, &loop);
  if (status < 0) return stop("settings of the loop", status);

  reach_m = 0.5 * info.max_displacement_m;
  phn_loop_engage(loop);
  for (long i = 0; i < cycles; ++i) {
    const int arrived = device_position(position, &measured_s);
    phn_loop_read(loop, arrived ? position : NULL, measured_s, now_s, tool);
    const phn_loop_response response = response_at(model, data, node, info.has_energy, tool);
    phn_loop_hold(loop, &response, now_s, force);
    device_force(force);
    largest_N = fmax(largest_N, sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]));
  }

  phn_loop_info(loop, &report);
  printf("%ld cycles, largest force %.3g N, controller active in %ld\n", cycles, largest_N, (long)report.limited);
  printf("energy taken from the hand %.4g mJ, most delivered %.3g mJ\n", 1e3 * report.work_J,
         1e3 * report.most_delivered_J);
  printf("%s\n", phn_loop_trip_message(report.trip));
  free(loop_memory);
  free(data_memory);
  free(model_memory);
  return report.trip == PHN_TRIP_NONE ? 0 : 3;
}
