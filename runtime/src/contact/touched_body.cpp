// Contact with a reduced body.
#include "body/compliance.hpp"
#include "contact/contact.hpp"

using namespace PHN_RUNTIME;

namespace {

class TouchedBody final : public Touched {
 public:
  phn_body_pressed pressed = {};  ///< energy and distances after the last response; steps of all of them

  TouchedBody(phn_body_state& state, std::int32_t most_steps) : _state(state) {
    has_energy = true;
    max_displacement_m = state.body->info.max_displacement_m;
    steps = most_steps;
  }
  int hold(std::int32_t n, const phn_tool* tools, double* forces, phn_coupled& result) override {
    phn_body_pressed made;
    const int status = phn_body_press(_state.body, &_state, n, tools, steps, forces, &made);
    steps -= made.steps;
    made.steps += pressed.steps;
    made.renewed += pressed.renewed;
    pressed = made;
    result = {made.behind_m, made.energy};
    return status;
  }
  Matrix stiffness(std::int32_t tool) const override {
    Compliance compliance;
    const std::int32_t n = _state.n_rows;
    compliance.take(_state, 0, n, true);  // of the last factor, with which the forces were found
    Matrix result;
    for (int k = 0; k < 3; ++k) {
      double forces[3 * most_body_tools] = {}, held[3 * most_body_tools] = {};
      const std::int32_t own = 3 * tool + k;
      held[own] = _state.held[own];
      for (std::int32_t r = 0; r < n; ++r) forces[r] = stretched(_state, r, held);
      forces[own] += 1;
      compliance.solve(n, forces);
      for (std::int32_t r = 0; r < n; ++r)
        held[r] = _state.held[r] * ((r == own ? 1 : 0) - stretched(_state, r, forces));
      for (std::int32_t r = 0; r < n; ++r) forces[r] -= held[r];
      for (int j = 0; j < 3; ++j) result(j, k) = forces[3 * tool + j];
    }
    return result;
  }
  void displacement(const phn_tool& tool, double* mean) const override { mean_displacement(_state, tool, mean); }

 private:
  phn_body_state& _state;
};

WholeSurface surface_of(const phn_body& body) {
  return {body.info.n_nodes, body.info.n_nodes, body.info.n_triangles, body.info.triangles};
}

/// See ContactSurface::active. A round tool beside fixed nodes is not that of a single one.
std::int32_t active_of(const phn_body& body, std::int32_t vertex) {
  const std::int32_t kind = body.kinds[vertex];
  if (kind != phynness::schema::body_node_touchable) return kind == phynness::schema::body_node_fixed ? -1 : -2;
  return body.info.tool_radius_m > 0 ? several : vertex;
}

}  // namespace

extern "C" {

int phn_body_contact_size(const phn_body* body, int32_t max_tools, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  return body == nullptr ? PHN_ERROR_ARGUMENT : contact_size(surface_of(*body), max_tools, bytes);
}

int phn_body_contact_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools, phn_contact** contact) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  *contact = nullptr;
  if (memory == nullptr || body == nullptr) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, contact, sizeof *contact)) return PHN_ERROR_OVERLAP;
  const WholeSurface whole = surface_of(*body);
  Arena arena(memory, bytes);
  ContactParts parts;
  const int status = lay_out_contact(arena, whole, max_tools, parts);
  if (status != PHN_OK) return status;
  for (std::int32_t v = 0; v < whole.n_vertices; ++v) {
    for (int k = 0; k < 3; ++k) row(parts.surface.rest, v)[k] = row(body->info.points, v)[k];
    parts.surface.node[v] = body->info.nodes[v];
    parts.surface.active[v] = active_of(*body, v);
  }
  return build_contact(whole, body, max_tools, parts, contact);
}

int phn_body_contact_step(phn_contact* contact, phn_body_state* state, int32_t steps, int32_t n_tools,
                          const phn_contact_tool* tools, phn_contact_state* states, phn_body_pressed* pressed) {
  phn_body_pressed made = {};
  int status = PHN_ERROR_ARGUMENT;
  if (contact != nullptr && state != nullptr && state->body == contact->of && steps >= 1) {
    TouchedBody touched(*state, steps);
    phn_coupled coupled = {0, 0};
    status =
        step_contact(*contact, touched, state->max_tools, n_tools, tools, states, pressed, sizeof *pressed, coupled);
    made = touched.pressed;
  }
  write_states(contact, status, n_tools, states);
  if (pressed != nullptr) *pressed = made;
  return status;
}

}  // extern "C"
