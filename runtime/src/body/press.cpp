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

/// Steps are at an end where the next one, in the norm of the energy, is smaller than the deformation by this factor.
constexpr double settled = 1e-7;
/// From here on the forces are not those of an equilibrium.
constexpr double unsettled = 1e-2;
/// Where a step shrinks less than by this factor, or was cut, more of the stiffness is renewed.
constexpr double slow = 0.3;
constexpr std::int32_t many_panels = 4;
/// Part of the decrease of energy that a step promises and must bring (Armijo 1966, doi 10.2140/pjm.1966.16.1).
constexpr double sufficient = 1e-4;
/// A step that does not bring it is tried again with a smaller part, in the next call if need be. A step that brings it
/// is followed by one with a larger part.
constexpr double cut = 4, growth = 2, least_part = 1e-6;
/// Part of a displacement that springs take from which on there is a warning.
constexpr double much_stretched = 0.1;
/// In a step a tool moves by at most so many depths.
constexpr double longest_motion = 0.5;
/// After so many steps far from balance the body starts from rest again, with smaller motions and more steps.
constexpr std::int32_t most_far = 20, most_halved = 3;
/// Components of displacements are clamped to so many times the depth.
constexpr double most_depths = 1000;

/// Steps of Newton's method for the energy with the mean displacements under the tools prescribed.
class Equilibrium {
 public:
  explicit Equilibrium(phn_body_state& state)
      : _s(state), _body(*state.body), _n(state.body->info.n_modes), _stride(state.body->stride) {
    memcpy(_force, state.solved, sizeof _force);
  }

  void settle(std::int32_t steps, phn_body_report& pressed) {
    double last = HUGE_VAL;
    bool is_new = true;  // the state, for its stiffness
    while (true) {
      if (is_new && pressed.steps < steps) {
        const bool much = _s.part < 1 || pressed.unbalanced > slow * last;
        if (!renew_stiffness(_s, (much ? many_panels : 1) * cells_of_panel)) {
          pressed.unbalanced = 1;
          return;
        }
        ++pressed.renewed;
        _compliance.set(_s, _s.factor);
      }
      if (is_new) {
        last = pressed.steps > 0 ? pressed.unbalanced : HUGE_VAL;
        pressed.unbalanced = direction();
      }
      if ((pressed.unbalanced <= settled && !_is_shortened) || pressed.steps >= steps) return;
      is_new = step();
      ++pressed.steps;
    }
  }

  void copy_forces(double* forces) const {
    for (std::int32_t r = 0; r < _s.n_rows; ++r)
      forces[r] = _force[r] - _s.held[r] * (_behind[r] - stretched(_s, r, _force));
  }

 private:
  double* row(double* of, std::int32_t r) const { return of + static_cast<std::int64_t>(r) * _stride; }

  /// _s.step, and the forces of the tools. @return unbalanced
  double direction() {
    for (std::int32_t m = 0; m < _stride; ++m) _s.alone[m] = m < _n ? _s.at.forces[m] : 0;
    _s.kernels->solve(_s.factor, _n, _stride, _s.alone);
    const std::int32_t n = _s.n_rows;
    double pulled[3 * most_body_tools];
    for (std::int32_t r = 0; r < n; ++r) _behind[r] = _s.wanted[r] - product(row(_s.rows, r), _s.at.q, _n);
    shorten_motions();
    for (std::int32_t r = 0; r < n; ++r) pulled[r] = _s.held[r] * _behind[r];
    for (std::int32_t r = 0; r < n; ++r)
      _force[r] = _behind[r] + stretched(_s, r, pulled) + product(row(_s.rows, r), _s.alone, _n);
    _compliance.solve(n, _force);
    for (std::int32_t m = 0; m < _stride; ++m) {
      _s.step[m] = -_s.alone[m];
      for (std::int32_t r = 0; r < n; ++r) _s.step[m] += _force[r] * row(_s.moved, r)[m];
    }
    // K step = rows^T force - forces; force . rows K^-1 rows^T . force is the square of what the tools hold.
    double held = 0;
    for (std::int32_t r = 0; r < n; ++r) held += _force[r] * stretched(_s, r, _force);
    _decrease = 0;
    for (std::int32_t m = 0; m < _n; ++m) {
      double of_tools = 0, moved = 0;
      for (std::int32_t r = 0; r < n; ++r) {
        of_tools += _force[r] * row(_s.rows, r)[m];
        moved += _force[r] * row(_s.moved, r)[m];
      }
      _decrease += _s.step[m] * (of_tools - _s.at.forces[m]);
      held += of_tools * moved;
    }
    return std::sqrt(std::fmax(_decrease, 0) / (held + 2 * std::fmax(_s.at.energy, _s.rounding)));
  }

  /// Tools that moved far are followed in substeps of their displacements. _force is still that of the step before.
  /// Where that is far from balance it may stretch springs by more than the tools are apart, which must not be
  /// followed.
  void shorten_motions() {
    const double longest = longest_motion / (1 << _s.n_restarts) * _body.info.max_displacement_m;
    double farthest = 0;
    for (std::int32_t t = 0; t < _s.n_rows; t += 3) farthest = std::fmax(farthest, 2 * length(_s.wanted + t));
    _is_shortened = false;
    for (std::int32_t t = 0; t < _s.n_rows; t += 3) {
      double motion[3];
      for (int k = 0; k < 3; ++k) motion[k] = stretched(_s, t + k, _force);
      const double stretch = length(motion), kept = stretch > farthest ? farthest / stretch : 1;
      for (int k = 0; k < 3; ++k) motion[k] = _behind[t + k] - kept * motion[k];
      const double size = length(motion);
      if (!(size > longest)) continue;
      _is_shortened = true;
      for (int k = 0; k < 3; ++k) _behind[t + k] -= (1 - longest / size) * motion[k];
    }
  }

  /// What a step has to lower: the energy less the work of the tools.
  double merit(const phn_body_state::Point& point) const {
    double merit = point.energy;
    for (std::int32_t r = 0; r < _s.n_rows; ++r) merit -= _force[r] * product(row(_s.rows, r), point.q, _n);
    return merit;
  }

  /// Goes a part of the step, if that lowers it enough; otherwise the next part is smaller. @return whether it went
  bool step() {
    const double part = _s.part;
    for (std::int32_t m = 0; m < _stride; ++m) _s.trial.q[m] = _s.at.q[m] + part * _s.step[m];
    bool is_lower = evaluate_body(_s, _s.trial);
    if (is_lower) {
      const double start = merit(_s.at), here = merit(_s.trial);
      // Differences of energies are rounded.
      const double rounding =
          1e-13 * (std::fabs(start) + std::fabs(here) + _s.at.energy + _s.trial.energy) + _s.rounding;
      is_lower = here <= start - sufficient * part * _decrease + rounding;
    }
    _s.part = is_lower ? std::fmin(growth * part, 1) : std::fmax(part / cut, least_part);
    if (!is_lower) return false;
    const std::int32_t n_pressures = _body.info.n_pressures;
    _s.kernels->times(_s.bulk_rows, n_pressures, _stride, _s.step, _s.expected);
    for (std::int32_t k = 0; k < n_pressures; ++k) _s.expected[k] = _s.at.sums[k] + part * _s.expected[k];
    const auto before = _s.at;
    _s.at = _s.trial;
    _s.trial = before;
    return true;
  }

  phn_body_state& _s;
  const phn_body& _body;
  std::int32_t _n, _stride;
  Compliance _compliance;
  double _force[3 * most_body_tools] = {}, _behind[3 * most_body_tools] = {};
  double _decrease = 0;
  bool _is_shortened = false;
};

template <class... Array>
void take(Arena& arena, std::size_t n, std::size_t per, Array&... arrays) {
  ((arrays = arena.take<double>(n, per)), ...);
}
template <class... Array>
void zero(std::size_t n, Array... arrays) {
  (set_zero(arrays, n), ...);
}

struct Layout {
  phn_body_state* state;
  explicit Layout(Arena& arena, const phn_body& body, std::int32_t max_tools) {
    const auto stride = static_cast<std::size_t>(body.stride), cells = static_cast<std::size_t>(body.info.n_cells);
    const auto nodes = static_cast<std::size_t>(body.info.n_nodes),
               triangles = static_cast<std::size_t>(body.info.n_triangles);
    state = arena.take<phn_body_state>(1);
    phn_body_state s = {};
    s.body = &body;
    s.kernels = &best_body_kernels();
    s.max_tools = max_tools;
    s.near = near_distance(body);
    s.part = 1;
    s.is_at_rest = true;
    s.scratch = {arena.take<double>(nodes), arena.take<std::int32_t>(nodes), arena.take<std::int32_t>(triangles),
                 arena.take<char>(triangles)};
    take(arena, 1, stride, s.at.q, s.at.forces, s.trial.q, s.trial.forces, s.alone, s.step, s.of_cells, s.lacking);
    take(arena, 9, cells, s.at.strain, s.trial.strain);
    take(arena, 1, cells, s.changed, s.pressure_at, s.size_of_rows);
    s.at.changes = arena.take<float>(static_cast<std::size_t>(body.n_pressed), stride);
    s.trial.changes = arena.take<float>(static_cast<std::size_t>(body.n_pressed), stride);
    s.cells = arena.take<phn_body_state::Cell>(cells);
    take(arena, 1, static_cast<std::size_t>(body.pressure_stride), s.at.sums, s.trial.sums, s.expected);
    take(arena, 3 * static_cast<std::size_t>(max_tools), stride, s.rows, s.moved);
    s.factor = arena.take<float>(stride, stride);
    s.factor_at_rest = arena.take<float>(stride, stride);
    s.sum = arena.take<float>(stride, stride);
    s.sum_at_rest = arena.take<float>(stride, stride);
    s.bulk_rows = arena.take<float>(static_cast<std::size_t>(body.pressure_stride), stride);
    s.panel = arena.take<float>(2 * 9 * cells_of_panel, stride);
    if (state == nullptr || arena.overflow()) return;
    set_zero(s.scratch.weight, nodes);
    for (std::size_t t = 0; t < triangles; ++t) s.scratch.taken[t] = 0;
    zero(stride, s.trial.q, s.alone, s.step);
    *state = s;
  }
};

bool start_at_rest(phn_body_state& state) {
  const auto stride = static_cast<std::size_t>(state.body->stride);
  set_zero(state.at.q, stride);
  set_zero(state.expected, static_cast<std::size_t>(state.body->pressure_stride));
  return evaluate_body(state, state.at);
}

void release(phn_body_state& state) {
  if (state.is_at_rest) return;
  state.is_at_rest = true;
  start_at_rest(state);
  release_stiffness(state);
  state.part = 1;
  state.n_far = 0;
  set_zero(state.solved, 3 * most_body_tools);
}

/// Tools that stayed, which are near their places before, keep the forces of the call before, whatever others came or
/// went. A force goes to one tool only. Where the number of tools is the same, those that are near the place of the
/// same number are the same tools; the others are matched by their distances, the nearest first.
void keep_forces(phn_body_state& state, const BodyPlace* before, std::int32_t n_before) {
  const std::int32_t n = state.n_rows / 3;
  double kept[2][3 * most_body_tools] = {};
  bool is_found[most_body_tools] = {}, was_found[most_body_tools] = {};
  const auto apart = [&](std::int32_t t, std::int32_t s) {
    double x[3];
    for (int k = 0; k < 3; ++k) x[k] = state.places[t].x[k] - before[s].x[k];
    return length(x);
  };
  const auto keep = [&](std::int32_t t, std::int32_t s) {
    is_found[t] = was_found[s] = true;
    memcpy(kept[0] + 3 * t, state.force + 3 * s, 3 * sizeof(double));
    memcpy(kept[1] + 3 * t, state.solved + 3 * s, 3 * sizeof(double));
  };
  for (std::int32_t t = 0; t < n && n == n_before; ++t)
    if (apart(t, t) < state.near) keep(t, t);
  for (bool goes_on = true; goes_on;) {
    std::int32_t stayed = -1, was = -1;
    double nearest = state.near;
    for (std::int32_t t = 0; t < n; ++t)
      for (std::int32_t s = 0; s < n_before; ++s) {
        if (is_found[t] || was_found[s] || !(apart(t, s) < nearest)) continue;
        nearest = apart(t, s);
        stayed = t;
        was = s;
      }
    goes_on = stayed >= 0;
    if (goes_on) keep(stayed, was);
  }
  memcpy(state.force, kept[0], sizeof kept[0]);
  memcpy(state.solved, kept[1], sizeof kept[1]);
}

}  // namespace

phn_body_state* PHN_RUNTIME::lay_out_state(Arena& arena, const phn_body& body, std::int32_t max_tools) {
  return Layout(arena, body, max_tools).state;
}

int PHN_RUNTIME::start_state(phn_body_state& state) {
  // Where the law is not defined at rest, or nothing resists, the numbers are not those of a body.
  return find_rounding(state) && start_at_rest(state) && start_stiffness(state) ? PHN_OK : PHN_ERROR_RANGE;
}

int PHN_RUNTIME::press_body(phn_body_state& s, std::int32_t n_held, std::int32_t n_tools, const phn_tool* tools,
                            const double* heights, std::int32_t steps, double* held_by, phn_body_report& made) {
  phn_body_state* const state = &s;
  const phn_body* const body = s.body;
  if (n_tools > most_body_tools || schema::least_body_modes(n_held) > body->info.n_modes)
    return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > state->max_tools) return PHN_ERROR_TOOLS;
  const double depth = body->info.max_displacement_m, farthest = most_depths * depth;
  int status = PHN_OK;
  const std::int32_t n_before = state->n_rows / 3;
  BodyPlace before[most_body_tools];
  memcpy(before, state->places, sizeof before);
  // A refused call changes nothing.
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int of_tool =
        means_of_modes(*state, tools[t], state->moved + 3 * static_cast<std::int64_t>(t) * body->stride);
    if (of_tool < 0) return of_tool;
    if (t < n_held) status |= of_tool;
  }
  memcpy(state->rows, state->moved, 3 * static_cast<std::size_t>(n_tools * body->stride) * sizeof(double));
  for (std::int32_t t = 0; t < n_held; ++t) {
    if (!(length(tools[t].displacement) <= depth * depth_slack<double>)) status |= PHN_WARNING_OUTSIDE;
    for (int k = 0; k < 3; ++k)
      state->wanted[3 * t + k] = std::fmin(std::fmax(tools[t].displacement[k], -farthest), farthest);
  }
  state->n_rows = 3 * n_held;
  state->n_all_rows = 3 * n_tools;
  set_springs(*state, n_tools, tools, heights);
  keep_forces(*state, before, n_before);
  if (n_held == 0) {
    release(*state);
    state->n_restarts = 0;
    state->status = PHN_OK;
    return PHN_OK;
  }
  if (state->n_far >= most_far << state->n_restarts) {
    release(*state);
    if (state->n_restarts < most_halved) ++state->n_restarts;
  }
  state->is_at_rest = false;
  Equilibrium equilibrium(*state);
  equilibrium.settle(steps, made);
  equilibrium.copy_forces(held_by);
  memcpy(state->solved, held_by, sizeof state->solved);
  made.energy = state->at.energy;
  for (std::int32_t t = 0; t < n_held; ++t) {
    double behind[3], stretch[3];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t r = 3 * t + k;
      const double* row = state->rows + static_cast<std::int64_t>(r) * body->stride;
      stretch[k] = stretched(*state, r, held_by);
      behind[k] = state->wanted[r] - product(row, state->at.q, body->info.n_modes) - stretch[k];
      made.energy += held_by[r] * stretch[k] / 2;
    }
    made.residual_m = std::fmax(made.residual_m, length(behind));
    double near[3];
    for (int k = 0; k < 3; ++k) near[k] = product(state->near_springs[3 * t + k], held_by, state->n_rows);
    if (length(near) > much_stretched * length(state->wanted + 3 * t)) status |= PHN_WARNING_NEAR;
  }
  if (!all_finite(held_by, 3 * most_body_tools) || !all_finite(&made.unbalanced, 1)) {
    set_zero(held_by, 3 * most_body_tools);
    set_zero(state->solved, 3 * most_body_tools);
    made.unbalanced = 1;
  }
  if (made.unbalanced > unsettled || !(made.residual_m <= unsettled * depth)) status |= PHN_WARNING_UNSETTLED;
  // Far from balance the solution of the linearized problem says nothing of the forces; those before are kept.
  const bool is_far = made.unbalanced > far_from_balance;
  if (is_far) memcpy(held_by, state->force, sizeof state->force);
  state->n_far = is_far ? state->n_far + made.steps : 0;
  memcpy(state->force, held_by, sizeof state->force);
  if ((status & PHN_WARNING_UNSETTLED) == 0) state->n_restarts = 0;
  state->status = status;
  return status;
}

namespace {

/// Of the second half of the modes alone, with the stiffness of the shape at rest: a basis that is too small for the
/// state has much in its last modes.
double energy_of_last_modes(const phn_body_state& state) {
  const std::int32_t n = state.body->info.n_modes, stride = state.body->stride;
  double energy = 0;
  for (std::int32_t i = n / 2; i < n; ++i) {
    const float* row =
        state.sum_at_rest + static_cast<std::int64_t>(i) * stride;  // of which the upper triangle is known
    double sum = row[i] * state.at.q[i] / 2;
    for (std::int32_t j = i + 1; j < n; ++j) sum += row[j] * state.at.q[j];
    energy += state.at.q[i] * sum;
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
              return is_touchable(*body, v)                                ? Hold::moves
                     : body->kinds[v] == phynness::schema::body_node_fixed ? Hold::fixed
                                                                           : Hold::none;
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
                   double* forces, phn_body_report* pressed) {
  double held_by[3 * most_body_tools] = {};
  phn_body_report made = {};
  const std::size_t n = forces != nullptr && n_tools > 0 ? 3 * static_cast<std::size_t>(n_tools) : 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(forces, n * sizeof(double), pressed, sizeof *pressed)) {
    status = PHN_ERROR_OVERLAP;
  } else if (body != nullptr && state != nullptr && state->body == body && n_tools >= 0 && steps >= 1 &&
             (n_tools == 0 || (tools != nullptr && forces != nullptr))) {
    status = press_body(*state, n_tools, n_tools, tools, nullptr, steps, held_by, made);
  }
  // The tools have been read; the outputs may overlap them.
  for (std::size_t r = 0; r < n; ++r) forces[r] = status < 0 ? 0 : held_by[r];
  if (pressed != nullptr) *pressed = made;
  return status;
}

int phn_body_bound_terms(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* terms) {
  for (std::int32_t i = 0; i < 3 * n_tools && terms != nullptr; ++i) terms[i] = 0;
  if (body == nullptr || state == nullptr || state->body != body || terms == nullptr) return PHN_ERROR_ARGUMENT;
  const std::int32_t n = state->n_rows;
  if (n_tools != n / 3) return PHN_ERROR_ARGUMENT;
  if (n == 0) return PHN_ERROR_UNDEFINED;
  Compliance at_rest;
  at_rest.set(*state, state->factor_at_rest);
  double linear[3 * most_body_tools];
  memcpy(linear, state->wanted, sizeof linear);
  at_rest.solve(n, linear);
  const double displaced = std::sqrt(product(state->wanted, state->wanted, n));
  const auto per_displacement = [&](double energy) { return displaced > 0 ? std::fmax(energy, 0) / displaced : 0; };
  const double last = per_displacement(energy_of_last_modes(*state)), all = per_displacement(state->at.energy);
  for (std::int32_t r = 0; r < n; r += 3) {
    double curved[3];
    for (int k = 0; k < 3; ++k) curved[k] = state->force[r + k] - linear[r + k];
    terms[r] = last;
    terms[r + 1] = length(curved);
    terms[r + 2] = all;
  }
  return state->status;
}

int phn_body_bound(const phn_body* body, const phn_body_state* state, int32_t n_tools, double* bounds) {
  for (std::int32_t t = 0; t < n_tools && bounds != nullptr; ++t) bounds[t] = 0;
  if (bounds == nullptr || n_tools > most_body_tools) return PHN_ERROR_ARGUMENT;
  double terms[3 * most_body_tools];
  const int status = phn_body_bound_terms(body, state, n_tools, terms);
  if (status < 0) return status;
  if (body->bounds == nullptr) return PHN_ERROR_UNDEFINED;
  const double* c = body->bounds + (n_tools > 1 ? phynness::schema::n_coupled_terms : 0);
  for (std::int32_t t = 0; t < n_tools; ++t)
    bounds[t] = (status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED | PHN_WARNING_NEAR)) != 0
                    ? PHN_NO_BOUND
                    : coupled_bound(c, terms + 3 * t, PHN_NO_BOUND);
  return status;
}

int phn_body_deform(const phn_body* body, const phn_body_state* state, double* out) {
  if (body == nullptr || state == nullptr || state->body != body || out == nullptr) return PHN_ERROR_ARGUMENT;
  state->kernels->times(body->modes, 3 * static_cast<std::int64_t>(body->info.n_nodes), body->stride, state->at.q, out);
  for (std::int32_t i = 0; i < body->info.n_nodes && body->lacking != nullptr; ++i)
    add_lacking(*state, place_of(*body, i), out + 3 * static_cast<std::size_t>(i));
  return PHN_OK;
}

}  // extern "C"
