// A body that answers for the coupled tools of a model.
#include "body/compliance.hpp"
#include "core/evaluate.hpp"
#include "core/lookup.hpp"
#include "tools/coupled.hpp"

using namespace PHN_RUNTIME;

namespace {

int deform(const AttachedBody& attached, std::int32_t n, const std::int32_t* nodes, double* out) {
  const phn_body& body = *attached.body;
  const phn_body_state& state = *attached.state;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int64_t row = 3 * find_sorted(body.info.nodes, body.info.n_nodes, nodes[i]);
    state.kernels->times(body.modes + row * body.stride, 3, body.stride, state.at.q, out + 3 * i);
  }
  return state.status;
}

void displacement(const AttachedBody& attached, const phn_tool& tool, double* mean) {
  mean_displacement(*attached.state, tool, mean);
}

/// @pre the compliance of the last factor is that of the last press
Matrix stiffness(const AttachedBody& attached, std::int32_t tool) {
  const phn_body_state& state = *attached.state;
  Compliance compliance;
  compliance.take(state, 0, state.n_rows);
  Matrix result;
  for (int k = 0; k < 3; ++k) {
    double forces[3 * most_body_tools] = {};
    forces[3 * tool + k] = 1;
    compliance.solve(state.n_rows, forces);
    forces[3 * tool + k] -= state.held[3 * tool + k];
    for (int j = 0; j < 3; ++j) result(j, k) = forces[3 * tool + j];
  }
  return result;
}

/// Models of older versions do not say which solves they come from.
bool is_same(const char* recorded, const char* of_body) { return *recorded == 0 || strcmp(recorded, of_body) == 0; }

}  // namespace

extern "C" int phn_body_attach(phn_data* data, const phn_body* body, phn_body_state* state, int32_t steps) {
  if (data == nullptr) return PHN_ERROR_ARGUMENT;
  if (data->coupling == nullptr) return PHN_ERROR_TOOLS;
  AttachedBody attached = {};
  if (body != nullptr) {
    const phn_model& model = *data->model;
    if (state == nullptr || state->body != body || steps < 1 ||
        !is_same(model.provenance.mesh_hash, body->info.mesh_hash) ||
        !is_same(model.provenance.physics_hash, body->info.physics_hash))
      return PHN_ERROR_ARGUMENT;
    if (state->max_tools < data->coupling->max_tools) return PHN_ERROR_TOOLS;
    for (std::int32_t i = 0; i < model.n_output; ++i)
      if (find_sorted(body->info.nodes, body->info.n_nodes, model.output_nodes[i]) < 0) return PHN_ERROR_UNDEFINED;
    attached = {body, state, steps, 0, phn_body_press, phn_body_bound, deform, displacement, stiffness};
  }
  data->coupling->attached = attached;
  data->coupling->n_tools = 0;
  return PHN_OK;
}
