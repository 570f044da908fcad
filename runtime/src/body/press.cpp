// The C interface of phynness_body.h: equilibrium of a reduced body under tools.
#include "body/elements.hpp"
#include "core/evaluate.hpp"

using namespace PHN_RUNTIME;

namespace {

constexpr std::int32_t most_tools = PHN_MOST_COUPLED;
/// Steps are at an end where the next one, in the norm of the energy, is smaller than the deformation by this factor.
constexpr double settled = 1e-7;
/// From here on the forces are not those of an equilibrium.
constexpr double unsettled = 1e-3;
/// A step that shrinks less than by this factor calls for a new stiffness.
constexpr double slow = 0.3;
/// Part of the decrease of energy that a step promises and must bring (Armijo 1966, doi 10.2140/pjm.1966.16.1).
constexpr double sufficient = 1e-4;
constexpr int most_halvings = 20;

struct Tools {
  std::int32_t n_rows;
  double wanted[3 * most_tools];
};

void means_of_modes(const phn_body& body, const ToolScratch& scratch, std::int32_t n, double* rows) {
  set_zero(rows, 3 * static_cast<std::size_t>(body.stride));
  for (std::int32_t t = 0; t < n; ++t) {
    const std::int32_t node = scratch.touched[t];
    const float* modes = body.modes + 3 * static_cast<std::int64_t>(node) * body.stride;
    for (std::int32_t m = 0; m < 3 * body.stride; ++m) rows[m] += scratch.weight[node] * modes[m];
    scratch.weight[node] = 0;
  }
}

double product(const double* a, const double* b, std::int32_t n) {
  double sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Steps of Newton's method for the energy with the mean displacements under the tools prescribed.
class Equilibrium {
 public:
  Equilibrium(phn_body_state& state, const Tools& tools)
      : _s(state), _body(*state.body), _tools(tools), _n(state.body->info.n_modes), _stride(state.body->stride) {}

  /// @return false if there is no step
  bool step(phn_body_pressed& pressed) {
    if (_s.is_stale || !_has_factor()) {
      if (!renew_stiffness(_s)) return false;
      ++pressed.renewed;
      _s.is_stale = false;
      _moved = false;
      _last = 0;
    }
    if (!_moved) move_rows();
    const double size = direction();
    pressed.unbalanced = size;
    if (size <= settled) return false;
    const bool fresh = pressed.renewed > 0 && _last == 0;
    if (_last > 0 && size > slow * _last) _s.is_stale = true;
    _last = size;
    const bool whole = search();
    if (!whole && !fresh) _s.is_stale = true;
    return true;
  }

  void copy_forces(double* forces) const {
    for (std::int32_t r = 0; r < _tools.n_rows; ++r) forces[r] = _force[r];
  }

 private:
  bool _has_factor() const { return _s.stiffness[0] > 0; }
  double* row(double* of, std::int32_t r) const { return of + static_cast<std::int64_t>(r) * _stride; }

  /// Compliance of the tools: rows K^-1 rows^T, factorized as L L^T.
  void move_rows() {
    for (std::int32_t r = 0; r < _tools.n_rows; ++r) {
      for (std::int32_t m = 0; m < _stride; ++m) row(_s.moved, r)[m] = row(_s.rows, r)[m];
      _s.kernels->solve(_s.stiffness, _n, _stride, row(_s.moved, r));
    }
    const std::int32_t n = _tools.n_rows;
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k) _compliance[r][k] = product(row(_s.rows, r), row(_s.moved, k), _n);
    for (std::int32_t r = 0; r < n; ++r) {
      for (std::int32_t k = 0; k < r; ++k)
        _compliance[r][k] = (_compliance[r][k] - product(_compliance[r], _compliance[k], k)) / _compliance[k][k];
      const double pivot = _compliance[r][r] - product(_compliance[r], _compliance[r], r);
      // Tools at one place hold the same point; the second one follows the first.
      _compliance[r][r] = pivot > 1e-12 * _compliance[r][r] ? std::sqrt(pivot) : HUGE_VAL;
    }
    _moved = true;
  }

  /// _s.step, and the forces of the tools. @return unbalanced
  double direction() {
    for (std::int32_t m = 0; m < _stride; ++m) _s.alone[m] = m < _n ? _s.forces[m] : 0;
    _s.kernels->solve(_s.stiffness, _n, _stride, _s.alone);
    const std::int32_t n = _tools.n_rows;
    for (std::int32_t r = 0; r < n; ++r)
      _force[r] = _tools.wanted[r] - product(row(_s.rows, r), _s.q, _n) + product(row(_s.rows, r), _s.alone, _n);
    for (std::int32_t r = 0; r < n; ++r)
      _force[r] = (_force[r] - product(_compliance[r], _force, r)) / _compliance[r][r];
    for (std::int32_t r = n - 1; r >= 0; --r) {
      for (std::int32_t k = r + 1; k < n; ++k) _force[r] -= _compliance[k][r] * _force[k];
      _force[r] /= _compliance[r][r];
    }
    for (std::int32_t m = 0; m < _stride; ++m) {
      _s.step[m] = -_s.alone[m];
      for (std::int32_t r = 0; r < n; ++r) _s.step[m] += _force[r] * row(_s.moved, r)[m];
    }
    // K step = rows^T force - forces; force . rows K^-1 rows^T . force is the square of what the tools hold.
    double held = 0;
    _decrease = 0;
    for (std::int32_t m = 0; m < _n; ++m) {
      double of_tools = 0, moved = 0;
      for (std::int32_t r = 0; r < n; ++r) {
        of_tools += _force[r] * row(_s.rows, r)[m];
        moved += _force[r] * row(_s.moved, r)[m];
      }
      _decrease += _s.step[m] * (of_tools - _s.forces[m]);
      held += of_tools * moved;
    }
    const double whole = held + 2 * _s.energy;
    return whole > 0 ? std::sqrt(std::fmax(_decrease, 0) / whole) : 0;
  }

  /// The part of the step after which energy - forces . means is lower. @return whether it is the whole step
  bool search() {
    double at_start = _s.energy;
    for (std::int32_t r = 0; r < _tools.n_rows; ++r) at_start -= _force[r] * product(row(_s.rows, r), _s.q, _n);
    double part = 1;
    for (int halving = 0; halving < most_halvings; ++halving, part /= 2) {
      for (std::int32_t m = 0; m < _stride; ++m) _s.trial[m] = _s.q[m] + part * _s.step[m];
      double energy;
      if (!evaluate_body(_s, _s.trial, energy, _s.trial_forces)) continue;
      double here = energy;
      for (std::int32_t r = 0; r < _tools.n_rows; ++r) here -= _force[r] * product(row(_s.rows, r), _s.trial, _n);
      // Differences of energies are rounded.
      const double rounding = 1e-13 * (std::fabs(at_start) + std::fabs(here) + energy);
      if (here > at_start - sufficient * part * _decrease + rounding) continue;
      double* q = _s.q;
      double* forces = _s.forces;
      _s.q = _s.trial;
      _s.forces = _s.trial_forces;
      _s.trial = q;
      _s.trial_forces = forces;
      _s.energy = energy;
      return part == 1;
    }
    _s.is_stale = true;
    return false;
  }

  phn_body_state& _s;
  const phn_body& _body;
  const Tools& _tools;
  std::int32_t _n, _stride;
  double _compliance[3 * most_tools][3 * most_tools], _force[3 * most_tools] = {};
  double _decrease = 0, _last = 0;
  bool _moved = false;
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
    s.scratch = {arena.take<double>(nodes), arena.take<std::int32_t>(nodes), arena.take<std::int32_t>(triangles),
                 arena.take<char>(triangles)};
    take(arena, 1, stride, s.q, s.forces, s.trial, s.trial_forces, s.alone, s.step);
    take(arena, 9, cells, s.strain, s.stress, s.bulk_slope);
    take(arena, 1, cells, s.change, s.pressure_at);
    s.pressure_sums = arena.take<double>(static_cast<std::size_t>(body.pressure_stride));
    take(arena, 3 * static_cast<std::size_t>(max_tools), stride, s.rows, s.moved);
    s.stiffness = arena.take<float>(stride, stride);
    s.panel = arena.take<float>(9 * cells_of_panel, stride);
    s.turned = arena.take<float>(stride);
    s.bulk_rows = arena.take<float>(static_cast<std::size_t>(body.info.n_pressures), stride);
    if (state == nullptr || arena.overflow()) return;
    set_zero(s.scratch.weight, nodes);
    for (std::size_t t = 0; t < triangles; ++t) s.scratch.taken[t] = 0;
    zero(stride, s.q, s.forces, s.trial, s.trial_forces, s.alone, s.step);
    s.stiffness[0] = 0;
    *state = s;
  }
};

bool are_tools(std::int32_t n) { return n >= 1 && n <= most_tools; }

}  // namespace

extern "C" {

int phn_body_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte) {
  Arena arena;
  const phn_body* none = nullptr;
  std::size_t wrong = 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(bytes, sizeof *bytes, wrong_byte, sizeof *wrong_byte)) {
    status = PHN_ERROR_OVERLAP;
  } else if (text != nullptr && bytes != nullptr) {
    status = load_body(text, length, arena, &none, wrong);
    if (arena.overflow()) status = PHN_ERROR_TOO_LARGE;
  }
  if (bytes != nullptr) *bytes = status == PHN_OK ? arena.needed() : 0;
  if (wrong_byte != nullptr) *wrong_byte = wrong;
  return status;
}

int phn_body_init(void* memory, size_t bytes, const char* text, size_t length, const phn_body** body,
                  size_t* wrong_byte) {
  const phn_body* loaded = nullptr;
  std::size_t wrong = 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, text, length) || overlap(memory, bytes, body, sizeof *body) ||
      overlap(memory, bytes, wrong_byte, sizeof *wrong_byte) ||
      overlap(body, sizeof *body, wrong_byte, sizeof *wrong_byte)) {
    status = PHN_ERROR_OVERLAP;
  } else if (memory != nullptr && text != nullptr && body != nullptr) {
    Arena arena(memory, bytes);
    status = load_body(text, length, arena, &loaded, wrong);
  }
  if (body != nullptr) *body = loaded;
  if (wrong_byte != nullptr) *wrong_byte = wrong;
  return status;
}

int phn_body_describe(const phn_body* body, phn_body_info* info) {
  if (info == nullptr) return PHN_ERROR_ARGUMENT;
  *info = {};
  if (body == nullptr) return PHN_ERROR_ARGUMENT;
  *info = body->info;
  return PHN_OK;
}

int phn_body_state_size(const phn_body* body, int32_t max_tools, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (body == nullptr || !are_tools(max_tools)) return PHN_ERROR_ARGUMENT;
  Arena arena;
  Layout(arena, *body, max_tools);
  if (arena.overflow()) return PHN_ERROR_TOO_LARGE;
  *bytes = arena.needed();
  return PHN_OK;
}

int phn_body_state_init(void* memory, size_t bytes, const phn_body* body, int32_t max_tools, phn_body_state** state) {
  if (state == nullptr) return PHN_ERROR_ARGUMENT;
  *state = nullptr;
  if (memory == nullptr || body == nullptr || !are_tools(max_tools)) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, state, sizeof *state)) return PHN_ERROR_OVERLAP;
  Arena arena(memory, bytes);
  const Layout layout(arena, *body, max_tools);
  if (layout.state == nullptr || arena.overflow()) return PHN_ERROR_BUFFER;
  // The laws are defined at rest; a body of which the cells are not is no body.
  if (!evaluate_body(*layout.state, layout.state->q, layout.state->energy, layout.state->forces))
    return PHN_ERROR_RANGE;
  *state = layout.state;
  return PHN_OK;
}

int phn_body_press(const phn_body* body, phn_body_state* state, int32_t n_tools, const phn_tool* tools, int32_t steps,
                   double* forces, phn_body_pressed* pressed) {
  const auto n = static_cast<std::size_t>(n_tools > 0 ? n_tools : 0);
  phn_body_pressed made = {};
  if (pressed != nullptr) *pressed = made;
  if (body == nullptr || state == nullptr || state->body != body || n_tools < 0 || steps < 1 ||
      (n_tools > 0 && (tools == nullptr || forces == nullptr)))
    return PHN_ERROR_ARGUMENT;
  if (n_tools > PHN_MOST_COUPLED) return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > state->max_tools) return PHN_ERROR_TOOLS;
  if (overlap(forces, 3 * n * sizeof(double), pressed, sizeof *pressed)) return PHN_ERROR_OVERLAP;
  int status = PHN_OK;
  Tools held = {};
  for (std::int32_t t = 0; t < n_tools; ++t) {
    std::int32_t n_touched = 0;
    const int of_tool = tool_weights(*body, tools[t], state->scratch, n_touched);
    if (of_tool >= 0) {
      status |= of_tool;
      if (!(length(tools[t].displacement) <= body->info.max_displacement_m * depth_slack<double>))
        status |= PHN_WARNING_OUTSIDE;
    }
    means_of_modes(*body, state->scratch, n_touched, state->rows + 3 * static_cast<std::int64_t>(t) * body->stride);
    if (of_tool < 0) {
      set_zero(forces, 3 * n);
      return of_tool;
    }
    for (int k = 0; k < 3; ++k) held.wanted[held.n_rows++] = tools[t].displacement[k];
  }
  Equilibrium equilibrium(*state, held);
  while (made.steps < steps && equilibrium.step(made)) ++made.steps;
  equilibrium.copy_forces(forces);
  made.energy = state->energy;
  for (std::int32_t t = 0; t < n_tools; ++t) {
    double behind[3];
    for (int k = 0; k < 3; ++k)
      behind[k] =
          tools[t].displacement[k] -
          product(state->rows + (3 * static_cast<std::int64_t>(t) + k) * body->stride, state->q, body->info.n_modes);
    made.behind_m = std::fmax(made.behind_m, length(behind));
  }
  if (!(made.unbalanced <= unsettled) || !(made.behind_m <= unsettled * body->info.max_displacement_m))
    status |= PHN_WARNING_UNSETTLED;
  if (pressed != nullptr) *pressed = made;
  return status;
}

int phn_body_deform(const phn_body* body, const phn_body_state* state, double* out) {
  if (body == nullptr || state == nullptr || state->body != body || out == nullptr) return PHN_ERROR_ARGUMENT;
  state->kernels->times(body->modes, 3 * static_cast<std::int64_t>(body->info.n_nodes), body->stride, state->q, out);
  return PHN_OK;
}

}  // extern "C"
