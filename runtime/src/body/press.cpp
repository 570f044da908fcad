// The C interface of phynness_body.h: equilibrium of a reduced body under tools.
#include <cstring>

#include "body/compliance.hpp"
#include "body/elements.hpp"
#include "core/bound.hpp"
#include "core/evaluate.hpp"
#include "core/text_lines.hpp"
#include "tools/nearest.hpp"

using namespace PHN_RUNTIME;

namespace {

/// The iteration has converged where the next step, in the norm of the energy, is smaller than the deformation by this
/// factor.
constexpr double converged = 1e-7;
/// From this size of the next step on, the forces are not those of an equilibrium.
constexpr double unsettled = 1e-2;
/// More of the stiffness is updated where a step shrinks by less than this factor, or was cut.
constexpr double slow_convergence = 0.3;
constexpr std::int32_t many_panels = 4;
/// Part of the predicted decrease of the energy that a step must bring (Armijo 1966, doi 10.2140/pjm.1966.16.1).
constexpr double sufficient_decrease = 1e-4;
/// A step that does not decrease the energy enough is divided by `backtracking` and tried again, in the next call if
/// need be. After a step that does, the factor grows.
constexpr double backtracking = 4, growth = 2, smallest_step = 1e-6;
/// Largest motion of a tool in a step, in depths.
constexpr double largest_increment = 0.5;
/// After so many steps far from balance the body starts from rest again, with smaller increments and more steps.
constexpr std::int32_t most_unbalanced_steps = 20, most_halvings = 3;
/// Components of displacements are clamped to so many times the depth, so that no sum overflows.
constexpr double largest_depth = 1000;

/// Newton's method for the minimum of the energy where the tools prescribe mean displacements.
class Equilibrium {
 public:
  explicit Equilibrium(phn_body_state& state)
      : _s(state), _body(*state.body), _n(state.body->info.n_modes), _stride(state.body->stride) {
    memcpy(_force, state.newton_force, sizeof _force);
  }

  void iterate(std::int32_t steps, phn_body_report& report) {
    double last = HUGE_VAL;
    bool is_new = true;  // The stiffness does not yet contain the present state.
    while (true) {
      if (is_new && report.steps < steps) {
        const bool is_slow = _s.step_size < 1 || report.unbalanced > slow_convergence * last;
        if (!update_stiffness(_s, (is_slow ? many_panels : 1) * cells_of_panel)) {
          report.unbalanced = 1;
          return;
        }
        ++report.renewed;
        _compliance.set(_s, _s.factor);
      }
      if (is_new) {
        last = report.steps > 0 ? report.unbalanced : HUGE_VAL;
        report.unbalanced = newton_direction();
      }
      if ((report.unbalanced <= converged && !_is_limited) || report.steps >= steps) return;
      is_new = step();
      ++report.steps;
    }
  }

  void copy_forces(double* forces) const {
    for (std::int32_t r = 0; r < _s.n_constraints; ++r)
      forces[r] = _force[r] - _s.penalty[r] * (_residual[r] - spring_extension(_s, r, _force));
  }

 private:
  /// Sets _s.step, and the forces of the tools. @return size of the step over that of the deformation
  double newton_direction() {
    for (std::int32_t m = 0; m < _stride; ++m) _s.unconstrained_step[m] = m < _n ? _s.current.gradient[m] : 0;
    _s.kernels->solve(_s.factor, _n, _stride, _s.unconstrained_step);
    const std::int32_t n = _s.n_constraints;
    double penalty_force[3 * most_body_tools];
    for (std::int32_t r = 0; r < n; ++r)
      _residual[r] = _s.prescribed[r] - product(_s.constraint_row(r), _s.current.q, _n);
    limit_increments();
    for (std::int32_t r = 0; r < n; ++r) penalty_force[r] = _s.penalty[r] * _residual[r];
    for (std::int32_t r = 0; r < n; ++r)
      _force[r] = _residual[r] + spring_extension(_s, r, penalty_force) +
                  product(_s.constraint_row(r), _s.unconstrained_step, _n);
    _compliance.solve(n, _force);
    for (std::int32_t m = 0; m < _stride; ++m) {
      _s.step[m] = -_s.unconstrained_step[m];
      for (std::int32_t r = 0; r < n; ++r) _s.step[m] += _force[r] * _s.compliance_row(r)[m];
    }
    // K step = R^T f - gradient, and f . (R K^-1 R^T + S) f is the square of the deformation in the norm of the energy.
    double square = 0;
    for (std::int32_t r = 0; r < n; ++r) square += _force[r] * spring_extension(_s, r, _force);
    _predicted_decrease = 0;
    for (std::int32_t m = 0; m < _n; ++m) {
      double of_tools = 0, moved = 0;
      for (std::int32_t r = 0; r < n; ++r) {
        of_tools += _force[r] * _s.constraint_row(r)[m];
        moved += _force[r] * _s.compliance_row(r)[m];
      }
      _predicted_decrease += _s.step[m] * (of_tools - _s.current.gradient[m]);
      square += of_tools * moved;
    }
    return std::sqrt(std::fmax(_predicted_decrease, 0) /
                     (square + 2 * std::fmax(_s.current.energy, _s.energy_rounding)));
  }

  /// Limits the residuals, so that tools that moved far are followed in increments. _force is still that of the step
  /// before. Far from balance it may extend springs by more than the tools are apart; such an extension is limited,
  /// too.
  void limit_increments() {
    const double largest = largest_increment / (1 << _s.n_restarts) * _body.info.max_displacement_m;
    double farthest = 0;
    for (std::int32_t t = 0; t < _s.n_constraints; t += 3)
      farthest = std::fmax(farthest, 2 * length(_s.prescribed + t));
    _is_limited = false;
    for (std::int32_t t = 0; t < _s.n_constraints; t += 3) {
      double increment[3];
      for (int k = 0; k < 3; ++k) increment[k] = spring_extension(_s, t + k, _force);
      const double extension = length(increment), factor = extension > farthest ? farthest / extension : 1;
      for (int k = 0; k < 3; ++k) increment[k] = _residual[t + k] - factor * increment[k];
      const double size = length(increment);
      if (!(size > largest)) continue;
      _is_limited = true;
      for (int k = 0; k < 3; ++k) _residual[t + k] -= (1 - largest / size) * increment[k];
    }
  }

  /// The function that a step must decrease: the energy minus the work of the tools.
  double merit(const phn_body_state::Point& point) const {
    double merit = point.energy;
    for (std::int32_t r = 0; r < _s.n_constraints; ++r) merit -= _force[r] * product(_s.constraint_row(r), point.q, _n);
    return merit;
  }

  /// Takes a part of the step if the merit decreases enough. Otherwise the next part is smaller.
  /// @return whether the step was taken
  bool step() {
    const double size = _s.step_size;
    for (std::int32_t m = 0; m < _stride; ++m) _s.trial.q[m] = _s.current.q[m] + size * _s.step[m];
    bool is_accepted = evaluate_body(_s, _s.trial);
    if (is_accepted) {
      const double start = merit(_s.current), here = merit(_s.trial);
      // The difference of two energies has their rounding errors.
      const double rounding =
          1e-13 * (std::fabs(start) + std::fabs(here) + _s.current.energy + _s.trial.energy) + _s.energy_rounding;
      is_accepted = here <= start - sufficient_decrease * size * _predicted_decrease + rounding;
    }
    _s.step_size = is_accepted ? std::fmin(growth * size, 1) : std::fmax(size / backtracking, smallest_step);
    if (!is_accepted) return false;
    const std::int32_t n_pressures = _body.info.n_pressures;
    _s.kernels->multiply_vector({_s.pressure_jacobian, n_pressures, _stride}, _s.step, _s.predicted_pressures);
    for (std::int32_t k = 0; k < n_pressures; ++k)
      _s.predicted_pressures[k] = _s.current.pressures[k] + size * _s.predicted_pressures[k];
    const auto before = _s.current;
    _s.current = _s.trial;
    _s.trial = before;
    return true;
  }

  phn_body_state& _s;
  const phn_body& _body;
  std::int32_t _n, _stride;
  Compliance _compliance;
  double _force[3 * most_body_tools] = {}, _residual[3 * most_body_tools] = {};
  double _predicted_decrease = 0;
  bool _is_limited = false;
};

template <class... T>
void take(Arena& arena, std::size_t n, std::size_t per, T*&... arrays) {
  ((arrays = arena.take<T>(n, per)), ...);
}
bool start_at_rest(phn_body_state& state) {
  const auto stride = static_cast<std::size_t>(state.body->stride);
  set_zero(state.current.q, stride);
  set_zero(state.predicted_pressures, static_cast<std::size_t>(state.body->pressure_modes.stride));
  return evaluate_body(state, state.current);
}

void reset(phn_body_state& state) {
  if (state.is_at_rest) return;
  state.is_at_rest = true;
  start_at_rest(state);
  reset_stiffness(state);
  state.step_size = 1;
  state.n_unbalanced_steps = 0;
  set_zero(state.newton_force, 3 * most_body_tools);
}

/// Gives tools that stayed, which are near their places before, the forces of the call before, whatever other tools
/// came or went. Each force goes to one tool only. Where the number of tools is the same, a tool near the place of the
/// same number is the same tool; the others are matched by their distances, the nearest first.
void match_forces(phn_body_state& state, const BodyPlace* before, std::int32_t n_before) {
  const std::int32_t n = state.n_constraints / 3;
  double force[3 * most_body_tools] = {}, newton_force[3 * most_body_tools] = {};
  bool is_matched[most_body_tools] = {}, was_matched[most_body_tools] = {};
  const auto distance = [&](std::int32_t t, std::int32_t s) {
    double x[3];
    for (int k = 0; k < 3; ++k) x[k] = state.places[t].x[k] - before[s].x[k];
    return length(x);
  };
  const auto match = [&](std::int32_t t, std::int32_t s) {
    is_matched[t] = was_matched[s] = true;
    memcpy(force + 3 * t, state.force + 3 * s, 3 * sizeof(double));
    memcpy(newton_force + 3 * t, state.newton_force + 3 * s, 3 * sizeof(double));
  };
  for (std::int32_t t = 0; t < n && n == n_before; ++t)
    if (distance(t, t) < state.near_m) match(t, t);
  for (bool goes_on = true; goes_on;) {
    std::int32_t tool = -1, old_tool = -1;
    double nearest = state.near_m;
    for (std::int32_t t = 0; t < n; ++t)
      for (std::int32_t s = 0; s < n_before; ++s) {
        if (is_matched[t] || was_matched[s] || !(distance(t, s) < nearest)) continue;
        nearest = distance(t, s);
        tool = t;
        old_tool = s;
      }
    goes_on = tool >= 0;
    if (goes_on) match(tool, old_tool);
  }
  memcpy(state.force, force, sizeof force);
  memcpy(state.newton_force, newton_force, sizeof newton_force);
}

}  // namespace

phn_body_state* PHN_RUNTIME::lay_out_state(Arena& arena, const phn_body& body, std::int32_t max_tools) {
  const auto stride = static_cast<std::size_t>(body.stride), cells = static_cast<std::size_t>(body.info.n_cells);
  const auto nodes = static_cast<std::size_t>(body.info.n_nodes),
             triangles = static_cast<std::size_t>(body.info.n_triangles);
  auto* const state = arena.take<phn_body_state>(1);
  phn_body_state s = {};
  s.body = &body;
  s.kernels = &best_body_kernels();
  s.max_tools = max_tools;
  s.near_m = near_distance(body);
  s.step_size = 1;
  s.is_at_rest = true;
  s.scratch = {arena.take<double>(nodes), arena.take<std::int32_t>(nodes), arena.take<std::int32_t>(triangles),
               arena.take<char>(triangles)};
  take(arena, 1, stride, s.current.q, s.current.gradient, s.trial.q, s.trial.gradient, s.unconstrained_step, s.step,
       s.cells_gradient, s.lack_gradient);
  take(arena, 9, cells, s.current.displacement_gradient, s.trial.displacement_gradient);
  take(arena, 1, cells, s.stiffness_change, s.cell_pressures, s.squared_gradients);
  take(arena, static_cast<std::size_t>(body.pressure_modes.n_rows), stride, s.current.volume_gradients,
       s.trial.volume_gradients);
  s.cells = arena.take<phn_body_state::Cell>(cells);
  take(arena, 1, static_cast<std::size_t>(body.pressure_modes.stride), s.current.pressures, s.trial.pressures,
       s.predicted_pressures);
  take(arena, 3 * static_cast<std::size_t>(max_tools), stride, s.constraint_rows, s.compliance_rows);
  take(arena, stride, stride, s.factor, s.factor_at_rest, s.cell_stiffness, s.cell_stiffness_at_rest);
  s.pressure_jacobian = arena.take<float>(static_cast<std::size_t>(body.pressure_modes.stride), stride);
  s.panel = arena.take<float>(2 * 9 * cells_of_panel, stride);
  if (state == nullptr || arena.overflow()) return state;
  set_zero(s.scratch.weight, nodes);
  for (std::size_t t = 0; t < triangles; ++t) s.scratch.is_reached[t] = 0;
  set_zero(s.trial.q, stride);
  set_zero(s.unconstrained_step, stride);
  set_zero(s.step, stride);
  *state = s;
  return state;
}

int PHN_RUNTIME::start_state(phn_body_state& state) {
  // A text whose law is undefined at rest, or whose stiffness is singular, describes no body.
  return set_energy_rounding(state) && start_at_rest(state) && init_stiffness(state) ? PHN_OK : PHN_ERROR_RANGE;
}

int PHN_RUNTIME::solve_body(phn_body_state& state, std::int32_t n_held, std::int32_t n_tools, const phn_tool* tools,
                            const double* heights, std::int32_t steps, double* forces, phn_body_report& report) {
  const phn_body& body = *state.body;
  if (n_tools > most_body_tools || schema::least_body_modes(n_held) > body.info.n_modes)
    return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > state.max_tools) return PHN_ERROR_TOOLS;
  const double depth = body.info.max_displacement_m, largest = largest_depth * depth;
  int status = PHN_OK;
  const std::int32_t n_before = state.n_constraints / 3;
  BodyPlace before[most_body_tools];
  memcpy(before, state.places, sizeof before);
  // The new rows are first written to other memory, because a refused call changes nothing.
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int of_tool = set_constraint_rows(state, tools[t], state.compliance_row(3 * t));
    if (of_tool < 0) return of_tool;
    if (t < n_held) status |= of_tool;
  }
  memcpy(state.constraint_rows, state.compliance_rows,
         3 * static_cast<std::size_t>(n_tools * body.stride) * sizeof(double));
  for (std::int32_t t = 0; t < n_held; ++t) {
    if (!(length(tools[t].displacement) <= depth * depth_slack<double>)) status |= PHN_WARNING_OUTSIDE;
    for (int k = 0; k < 3; ++k)
      state.prescribed[3 * t + k] = std::fmin(std::fmax(tools[t].displacement[k], -largest), largest);
  }
  state.n_constraints = 3 * n_held;
  state.n_all_constraints = 3 * n_tools;
  set_springs(state, n_tools, tools, heights);
  match_forces(state, before, n_before);
  if (n_held == 0) {
    reset(state);
    state.n_restarts = 0;
    state.status = PHN_OK;
    return PHN_OK;
  }
  if (state.n_unbalanced_steps >= most_unbalanced_steps << state.n_restarts) {
    reset(state);
    if (state.n_restarts < most_halvings) ++state.n_restarts;
  }
  state.is_at_rest = false;
  Equilibrium equilibrium(state);
  equilibrium.iterate(steps, report);
  equilibrium.copy_forces(forces);
  memcpy(state.newton_force, forces, sizeof state.newton_force);
  report.energy = state.current.energy;
  for (std::int32_t t = 0; t < n_held; ++t) {
    double residual[3], extension[3];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t r = 3 * t + k;
      extension[k] = spring_extension(state, r, forces);
      residual[k] =
          state.prescribed[r] - product(state.constraint_row(r), state.current.q, body.info.n_modes) - extension[k];
      report.energy += forces[r] * extension[k] / 2;
    }
    report.residual_m = std::fmax(report.residual_m, length(residual));
    if (state.has_spring[t]) status |= PHN_WARNING_NEAR;
  }
  if (!all_finite(forces, 3 * most_body_tools) || !all_finite(&report.unbalanced, 1)) {
    set_zero(forces, 3 * most_body_tools);
    set_zero(state.newton_force, 3 * most_body_tools);
    report.unbalanced = 1;
  }
  if (!state.is_definite || report.unbalanced > unsettled || !(report.residual_m <= unsettled * depth))
    status |= PHN_WARNING_UNSETTLED;
  // Far from balance the linearized problem does not predict the forces. The last ones are then returned.
  const bool is_far = report.unbalanced > far_from_balance;
  if (is_far) memcpy(forces, state.force, sizeof state.force);
  state.n_unbalanced_steps = is_far ? state.n_unbalanced_steps + report.steps : 0;
  memcpy(state.force, forces, sizeof state.force);
  if ((status & PHN_WARNING_UNSETTLED) == 0) state.n_restarts = 0;
  state.status = status;
  return status;
}

namespace {

/// Energy of the second half of the modes alone, with the stiffness at rest. It is large where the basis is too small
/// for the state.
double energy_of_last_modes(const phn_body_state& state) {
  const std::int32_t n = state.body->info.n_modes, stride = state.body->stride;
  double energy = 0;
  for (std::int32_t i = n / 2; i < n; ++i) {
    const float* row =
        state.cell_stiffness_at_rest + static_cast<std::int64_t>(i) * stride;  // Its upper triangle is set.
    double sum = row[i] * state.current.q[i] / 2;
    for (std::int32_t j = i + 1; j < n; ++j) sum += row[j] * state.current.q[j];
    energy += state.current.q[i] * sum;
  }
  return energy;
}

/// @return a status of phynness.h
int check_tools(std::int32_t n) {
  return n < 1 ? PHN_ERROR_ARGUMENT : n > most_body_tools ? PHN_ERROR_TOO_MANY_TOOLS : PHN_OK;
}

}  // namespace

extern "C" {

int phn_body_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte) {
  return size_of_text<phn_body>(load_body, text, length, bytes, wrong_byte);
}

int phn_body_init(void* memory, size_t bytes, const char* text, size_t length, const phn_body** body,
                  size_t* wrong_byte) {
  return init_of_text<phn_body>(load_body, memory, bytes, text, length, body, wrong_byte);
}

int phn_body_info(const phn_body* body, phn_body_contents* info) {
  if (info == nullptr) return PHN_ERROR_ARGUMENT;
  *info = {};
  if (body == nullptr) return PHN_ERROR_ARGUMENT;
  *info = body->info;
  return PHN_OK;
}

int phn_body_nearest(const phn_body* body, const double x[3], phn_tool* tool, double point[3], double* distance) {
  return answer_nearest(
      body != nullptr, x, tool, point, distance,
      [&](const double* from) {
        return nearest_place(
            body->info.triangles, body->info.n_triangles, from,
            [&](std::int32_t v) { return body->info.points + 3 * static_cast<std::size_t>(v); },
            [&](std::int32_t v) {
              return is_touchable(*body, v)                                     ? VertexKind::movable
                     : body->node_kinds[v] == phynness::schema::body_node_fixed ? VertexKind::fixed
                                                                                : VertexKind::untouchable;
            });
      },
      [&](std::int32_t v) { return body->info.nodes[v]; });
}

int phn_body_state_size(const phn_body* body, int32_t max_tools, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (body == nullptr) return PHN_ERROR_ARGUMENT;
  if (const int refused = check_tools(max_tools); refused != PHN_OK) return refused;
  Arena arena;
  lay_out_state(arena, *body, max_tools);
  if (arena.overflow()) return PHN_ERROR_TOO_LARGE;
  *bytes = arena.needed();
  return PHN_OK;
}

int phn_body_state_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools, phn_body_state** state) {
  if (state == nullptr) return PHN_ERROR_ARGUMENT;
  *state = nullptr;
  if (memory == nullptr || body == nullptr) return PHN_ERROR_ARGUMENT;
  if (const int refused = check_tools(max_tools); refused != PHN_OK) return refused;
  if (overlap(memory, bytes, state, sizeof *state)) return PHN_ERROR_OVERLAP;
  Arena arena(memory, bytes);
  phn_body_state* const made = lay_out_state(arena, *body, max_tools);
  if (made == nullptr || arena.overflow()) return PHN_ERROR_BUFFER;
  const int status = start_state(*made);
  if (status != PHN_OK) return status;
  *state = made;
  return PHN_OK;
}

int phn_body_force(const phn_body* body, phn_body_state* state, int32_t n_tools, const phn_tool* tools, int32_t steps,
                   double* forces, phn_body_report* report) {
  double solved[3 * most_body_tools] = {};
  phn_body_report made = {};
  const std::size_t n = forces != nullptr && n_tools > 0 ? 3 * static_cast<std::size_t>(n_tools) : 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(forces, n * sizeof(double), report, sizeof *report)) {
    status = PHN_ERROR_OVERLAP;
  } else if (body != nullptr && state != nullptr && state->body == body && n_tools >= 0 && steps >= 1 &&
             (n_tools == 0 || (tools != nullptr && forces != nullptr))) {
    status = solve_body(*state, n_tools, n_tools, tools, nullptr, steps, solved, made);
  }
  // The tools have been read; the outputs may overlap them.
  for (std::size_t r = 0; r < n; ++r) forces[r] = status < 0 ? 0 : solved[r];
  if (report != nullptr) *report = made;
  return status;
}

int phn_body_bound_terms(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* terms) {
  for (std::int32_t i = 0; i < 3 * n_tools && terms != nullptr; ++i) terms[i] = 0;
  if (body == nullptr || state == nullptr || state->body != body || terms == nullptr) return PHN_ERROR_ARGUMENT;
  const std::int32_t n = state->n_constraints;
  if (n_tools != n / 3) return PHN_ERROR_ARGUMENT;
  if (n == 0) return PHN_ERROR_UNDEFINED;
  double linear[3 * most_body_tools] = {};
  if (n == 3) {
    Compliance at_rest;
    at_rest.set(*state, state->factor_at_rest);
    memcpy(linear, state->prescribed, sizeof linear);
    at_rest.solve(n, linear);
  }
  const double displaced = std::sqrt(product(state->prescribed, state->prescribed, n));
  const auto per_displacement = [&](double energy) { return displaced > 0 ? std::fmax(energy, 0) / displaced : 0; };
  const double last = per_displacement(energy_of_last_modes(*state)), all = per_displacement(state->current.energy);
  for (std::int32_t r = 0; r < n; r += 3) {
    double nonlinear[3];
    for (int k = 0; k < 3; ++k) nonlinear[k] = state->force[r + k] - linear[r + k];
    terms[r] = last;
    terms[r + 1] = length(nonlinear);
    terms[r + 2] = all;
  }
  return state->status;
}

int phn_body_bound(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* bounds) {
  for (std::int32_t t = 0; t < n_tools && bounds != nullptr; ++t) bounds[t] = PHN_NO_BOUND;
  if (bounds == nullptr || n_tools > most_body_tools) return PHN_ERROR_ARGUMENT;
  double terms[3 * most_body_tools];
  const int status = phn_body_bound_terms(body, state, n_tools, terms);
  if (status < 0) return status;
  if (body->bounds == nullptr) return PHN_ERROR_UNDEFINED;
  constexpr std::int32_t last_row = phynness::schema::n_coupled_kinds - 1;
  const double* c = body->bounds + phynness::schema::n_coupled_terms * (n_tools > last_row ? last_row : n_tools - 1);
  if ((status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED | PHN_WARNING_NEAR)) != 0) return status;
  for (std::int32_t t = 0; t < n_tools; ++t) bounds[t] = coupled_bound(c, terms + 3 * t, PHN_NO_BOUND);
  return status;
}

int phn_body_deform(const phn_body* body, const phn_body_state* state, double* out) {
  if (body == nullptr || state == nullptr || state->body != body || out == nullptr) return PHN_ERROR_ARGUMENT;
  state->kernels->multiply_vector(body->modes, state->current.q, out);
  for (std::int32_t i = 0; i < body->residual_compliance.n_rows; ++i)
    add_residual_displacement(*state, place_of(*body, i), out + 3 * static_cast<std::size_t>(i));
  return PHN_OK;
}

}  // extern "C"
