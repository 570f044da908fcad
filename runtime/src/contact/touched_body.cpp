// Contact with a reduced body.
#include "body/compliance.hpp"
#include "contact/contact.hpp"

using namespace PHN_RUNTIME;

namespace {

class TouchedBody final : public Touched {
 public:
  phn_body_report pressed = {};  ///< energy and distances after the last response; steps of all of them

  TouchedBody(phn_body_state& state, std::int32_t most_steps) : _state(state) {
    has_energy = true;
    max_displacement_m = state.body->info.max_displacement_m;
    near_m = state.near_m;
    steps = most_steps;
  }
  int hold(std::int32_t n, std::int32_t n_all, const phn_tool* tools, const double* heights, double* forces,
           phn_coupled& result) override {
    phn_body_report made = {};
    const int status = solve_body(_state, n, n_all, tools, heights, 1, forces, made);
    steps -= made.steps;
    made.steps += pressed.steps;
    made.renewed += pressed.renewed;
    pressed = made;
    unbalanced = made.unbalanced;
    result = {made.residual_m, made.energy};
    if (status >= 0) {
      const std::int32_t first = n == 0 ? 0 : _state.n_constraints;  // The last step has solved those before.
      Compliance::solve_rows(_state, n == 0 ? _state.factor_at_rest : _state.factor, first, 3 * n_all - first);
    }
    return status;
  }
  /// The inverse of the stiffness under the tools, from the factor of the last response. Where the body is unstable, a
  /// part of the penalty stays in the stiffness and makes it definite.
  bool compliance(const MatrixView<Matrix>& blocks) const override {
    const std::int32_t n = 3 * blocks.n_columns, n_held = _state.n_constraints;
    if (_state.n_all_constraints != n) return false;
    Compliance all, stiffness;
    all.assemble(_state, n, true);
    for (double part = 0; part <= 1; part = part > 0 ? 10 * part : 0.01) {
      for (std::int32_t c = 0; c < n; ++c) {
        double forces[3 * most_body_tools] = {}, penalty_force[3 * most_body_tools] = {};
        const double penalty = c < n_held ? _state.penalty[c] : 0;
        if (c < n_held) penalty_force[c] = penalty;
        for (std::int32_t r = 0; r < n; ++r) forces[r] = (r == c ? 1 : 0) + spring_extension(_state, r, penalty_force);
        all.solve(n, forces);
        for (std::int32_t r = c; r < n; ++r)
          stiffness.lower[r][c] =
              forces[r] - (r == c ? (1 - part) * penalty : 0) +
              (r < n_held ? _state.penalty[r] * product(_state.spring_compliance[r], forces, n) : 0);
      }
      if (stiffness.factorize(n)) break;
    }
    for (std::int32_t c = 0; c < n; ++c) {
      double column[3 * most_body_tools] = {};
      column[c] = 1;
      stiffness.solve(n, column);
      for (std::int32_t r = 0; r < n; ++r) blocks(r / 3, c / 3)(r % 3, c % 3) = column[r];
    }
    return true;
  }
  Vector displacement(std::int32_t tool) const override {
    Vector u;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t r = 3 * tool + k;
      u[k] = product(_state.constraint_row(r), _state.current.q, _state.body->info.n_modes) +
             spring_extension(_state, r, _state.force);
    }
    return u;
  }

 private:
  phn_body_state& _state;
};

WholeSurface surface_of(const phn_body& body) {
  return {body.info.n_nodes, body.info.n_nodes, body.info.n_triangles, body.info.triangles};
}

/// See ContactSurface::active. A round tool is never moved by a single node.
std::int32_t active_of(const phn_body& body, std::int32_t vertex) {
  if (!is_touchable(body, vertex)) return body.node_kinds[vertex] == phynness::schema::body_node_fixed ? -1 : -2;
  return body.info.tool_radius_m > 0 ? several : vertex;
}

int lay_out(Arena& arena, const phn_body& body, std::int32_t max_tools, ContactParts& parts) {
  const int refused = lay_out_contact(arena, surface_of(body), max_tools, parts);
  if (refused != PHN_OK) return refused;
  parts.made.state = lay_out_state(arena, body, max_tools);
  return arena.overflow() ? PHN_ERROR_BUFFER : PHN_OK;
}

}  // namespace

int PHN_RUNTIME::step_on_body(phn_contact& contact, std::int32_t n_tools, const phn_contact_tool* tools,
                              const phn_contact_state* states, const phn_contact_report* report,
                              phn_contact_report& made) {
  TouchedBody touched(*contact.state, contact.steps);
  phn_coupled coupled = {0, 0};
  const int status = step_contact(contact, touched, n_tools, tools, states, report, coupled);
  made = {touched.pressed.energy, touched.pressed.residual_m, touched.pressed.unbalanced, touched.pressed.steps};
  return status;
}

extern "C" {

int phn_body_contact_size(const phn_body* body, int32_t max_tools, size_t* bytes) {
  return size_of_contact(lay_out, body, max_tools, bytes);
}

int phn_body_contact_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools, int32_t steps,
                          phn_contact** contact) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  *contact = nullptr;
  if (memory == nullptr || body == nullptr || steps < 1) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, contact, sizeof *contact)) return PHN_ERROR_OVERLAP;
  const WholeSurface whole = surface_of(*body);
  Arena arena(memory, bytes);
  ContactParts parts;
  int status = lay_out(arena, *body, max_tools, parts);
  if (status == PHN_OK) status = start_state(*parts.made.state);
  if (status != PHN_OK) return status;
  parts.made.steps = steps;
  const ContactSurface& surface = parts.made.surface;
  for (std::int32_t v = 0; v < whole.n_vertices; ++v) {
    for (int k = 0; k < 3; ++k) row(surface.rest, v)[k] = row(body->info.points, v)[k];
    surface.node[v] = body->info.nodes[v];
    surface.active[v] = active_of(*body, v);
  }
  return build_contact(whole, parts, contact);
}

}  // extern "C"
