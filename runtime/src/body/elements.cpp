#include "body/elements.hpp"

#include <cfloat>
#include <cstring>

namespace PHN_RUNTIME {
namespace {

/// A diagonal is at most raised to this many times itself.
constexpr float largest_shift = 1e9f;

void gradient_at(const double* strain, double F[9]) {
  for (int k = 0; k < 9; ++k) F[k] = strain[k] + (k % 4 == 0 ? 1 : 0);
}

bool changes_volume(const phn_body& body, std::int32_t cell) { return body.bulk > 0 || body.bulk_of_cell[cell] > 0; }

const float* pressures_of(const phn_body& body, std::int32_t cell) {
  return body.pressures + static_cast<std::int64_t>(cell) * body.pressure_stride;
}

/// dg/dq of a cell, times its weight, is added to the rows of its pressures.
void add_change(phn_body_state& state, std::int32_t cell, const double* slope) {
  const phn_body& body = *state.body;
  const float *rows = body.gradients + static_cast<std::int64_t>(9 * cell) * body.stride,
              *psi = pressures_of(body, cell);
  float* change = state.change_row;
  for (std::int32_t m = 0; m < body.stride; ++m) change[m] = 0;
  for (int k = 0; k < 9; ++k) {
    const auto factor = static_cast<float>(body.bulk_of_cell[cell] * slope[k]);
    for (std::int32_t m = 0; m < body.stride; ++m) change[m] += factor * rows[k * body.stride + m];
  }
  for (std::int32_t k = 0; k < body.info.n_pressures; ++k)
    for (std::int32_t m = 0; m < body.stride; ++m) state.next_bulk_rows[k * body.stride + m] += psi[k] * change[m];
}

/// Adds the second derivatives of cells to the next stiffness. @return false where a law is not defined
bool add_panel(phn_body_state& state, std::int32_t first, std::int32_t end) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride;
  const float* gradients = body.gradients + static_cast<std::int64_t>(9 * first) * stride;
  double strain[9 * cells_of_panel];
  state.kernels->times(gradients, 9 * (end - first), stride, state.next_q, strain);
  for (std::int32_t c = first; c < end; ++c, gradients += 9 * stride) {
    double F[9], value, stress[9], A[81];
    gradient_at(strain + 9 * (c - first), F);
    if (!body.law->shape(F, body.parameters, value, stress, A)) return false;
    for (double& a : A) a *= body.shear[c];
    if (changes_volume(body, c)) {
      double slope[9], second[81], pressure;
      if (!body.law->volumetric(F, body.parameters, value, slope, second)) return false;
      state.kernels->times(pressures_of(body, c), 1, body.pressure_stride, state.next_sums, &pressure);
      const double bulk = body.shear[c] * body.bulk, p = bulk * value + body.bulk_of_cell[c] * pressure;
      for (int i = 0; i < 9; ++i)
        for (int j = 0; j < 9; ++j) A[9 * i + j] += bulk * slope[i] * slope[j] + p * second[9 * i + j];
      if (body.bulk_of_cell[c] > 0) add_change(state, c, slope);
    }
    float* out = state.panel + static_cast<std::int64_t>(9 * (c - first)) * stride;
    for (int i = 0; i < 9; ++i, out += stride) {
      for (std::int32_t m = 0; m < stride; ++m) out[m] = 0;
      for (int j = 0; j < 9; ++j)
        for (std::int32_t m = 0; m < stride; ++m)
          out[m] += static_cast<float>(A[9 * i + j]) * gradients[j * stride + m];
    }
  }
  state.kernels->add_products(body.gradients + static_cast<std::int64_t>(9 * first) * stride, state.panel,
                              9 * (end - first), stride, state.next);
  return true;
}

/// Adds a multiple of the squares of the displacements under the tools, which does not change where the energy is
/// stationary with these prescribed, and makes the sum definite where the body is stable under the tools only.
void hold_tools(phn_body_state& state) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride;
  constexpr double stiff = 30;  // over the stiffness that the modes alone have under a tool
  for (std::int32_t r = 0; r < state.n_rows; ++r) {
    const double* row = state.rows + static_cast<std::int64_t>(r) * stride;
    double compliance = 0;
    for (std::int32_t m = 0; m < body.info.n_modes; ++m) {
      const double diagonal = state.next[static_cast<std::int64_t>(m) * (stride + 1)];
      if (diagonal > 0) compliance += row[m] * row[m] / diagonal;
    }
    state.held[r] = compliance > 0 ? stiff / compliance : 0;
    const double root = std::sqrt(state.held[r]);
    for (std::int32_t m = 0; m < stride; ++m) state.change_row[m] = static_cast<float>(root * row[m]);
    state.kernels->add_products(state.change_row, state.change_row, 1, stride, state.next);
  }
}

bool factorize(phn_body_state& state) {
  const std::int32_t n = state.body->info.n_modes, stride = state.body->stride;
  state.kernels->add_products(state.bulk_rows, state.bulk_rows, state.body->info.n_pressures, stride, state.next);
  set_zero(state.held, sizeof state.held / sizeof *state.held);
  float shift = 0;
  for (int attempt = 0; shift <= largest_shift; ++attempt) {
    memcpy(state.factor, state.next, static_cast<std::size_t>(stride) * static_cast<std::size_t>(n) * sizeof(float));
    for (std::int32_t i = 0; i < n; ++i) {
      float& diagonal = state.factor[static_cast<std::int64_t>(i) * (stride + 1)];
      diagonal += shift * (diagonal > 0 ? diagonal : -diagonal);
    }
    if (state.kernels->factorize(state.factor, n, stride)) return true;
    if (attempt == 0) hold_tools(state);
    if (attempt > 0) shift = shift > 0 ? 4 * shift : 1e-3f;
  }
  return false;
}

double product_of(const double* a, const double* b, std::int32_t n) {
  double sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// The energy of the shape over that of the cells, in a linear body.
double ratio_at_rest(phn_body_state& state, const double* q) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_modes;
  if (body.cells_at_rest == nullptr) return 1;
  state.kernels->times(body.cells_at_rest, n, body.stride, q, state.linear);
  state.kernels->times(body.lack_at_rest, n, body.stride, q, state.lacking);
  const double of_cells = product_of(q, state.linear, n);
  return of_cells > 0 ? 1 + product_of(q, state.lacking, n) / of_cells : 1;
}

}  // namespace

bool evaluate_body(phn_body_state& state, phn_body_state::Point& point) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_cells;
  state.kernels->times(body.gradients, 9 * static_cast<std::int64_t>(n), body.stride, point.q, state.strain);
  double energy = 0;
  const double ratio = ratio_at_rest(state, point.q);
  for (std::int32_t c = 0; c < n; ++c) {
    double F[9], shape;
    const std::size_t at = 9 * static_cast<std::size_t>(c);
    gradient_at(state.strain + at, F);
    double *stress = state.stress + at, *slope = state.bulk_slope + at, &change = state.change[c];
    if (!body.law->shape(F, body.parameters, shape, stress, nullptr)) return false;
    change = 0;
    if (changes_volume(body, c) && !body.law->volumetric(F, body.parameters, change, slope, nullptr)) return false;
    energy += body.shear[c] * (shape + body.bulk / 2 * change * change);
    state.pressure_at[c] = body.bulk_of_cell[c] * change;
  }
  set_zero(point.sums, static_cast<std::size_t>(body.pressure_stride));
  state.kernels->add(body.pressures, n, body.pressure_stride, state.pressure_at, point.sums);
  state.kernels->times(body.pressures, n, body.pressure_stride, point.sums, state.pressure_at);
  point.energy = ratio * energy;
  for (std::int32_t k = 0; k < body.info.n_pressures; ++k) point.energy += point.sums[k] * point.sums[k] / 2;
  for (std::int32_t c = 0; c < n; ++c) {
    const std::size_t at = 9 * static_cast<std::size_t>(c);
    const double shear = ratio * body.shear[c],
                 p = shear * body.bulk * state.change[c] + body.bulk_of_cell[c] * state.pressure_at[c];
    const bool changes = changes_volume(body, c);
    for (std::size_t k = at; k < at + 9; ++k)
      state.stress[k] = shear * state.stress[k] + (changes ? p * state.bulk_slope[k] : 0);
  }
  set_zero(point.forces, static_cast<std::size_t>(body.stride));
  state.kernels->add(body.gradients, 9 * static_cast<std::int64_t>(n), body.stride, state.stress, point.forces);
  if (ratio != 1) {
    const double size = product_of(point.q, state.linear, body.info.n_modes);
    for (std::int32_t m = 0; m < body.info.n_modes; ++m)
      point.forces[m] += 2 * energy / size * (state.lacking[m] - (ratio - 1) * state.linear[m]);
  }
  return std::isfinite(point.energy) && all_finite(point.forces, static_cast<std::size_t>(body.info.n_modes));
}

bool find_rounding(phn_body_state& state) {
  const phn_body& body = *state.body;
  const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double value, stress[9], A[81], volume = 0, modulus = 0;
  if (!body.law->shape(F, body.parameters, value, stress, A)) return false;
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) volume += body.shear[c];
  for (const double a : A) modulus = std::fmax(modulus, std::fabs(a));
  state.rounding = DBL_EPSILON * volume * modulus;  // a law is a difference of numbers near 3 times its modulus
  return state.rounding > 0 && state.rounding <= DBL_MAX;
}

bool renew_stiffness(phn_body_state& state, std::int32_t n_cells) {
  const phn_body& body = *state.body;
  const auto stride = static_cast<std::size_t>(body.stride);
  if (n_cells == 0) {
    state.next_cells = 0;
    n_cells = body.info.n_cells;
  }
  if (state.next_cells == 0) {
    memcpy(state.next_q, state.at.q, stride * sizeof(double));
    memcpy(state.next_sums, state.expected, static_cast<std::size_t>(body.pressure_stride) * sizeof(double));
    for (std::size_t i = 0; i < stride * stride; ++i) state.next[i] = 0;
    if (body.cells_at_rest != nullptr)
      memcpy(state.next, body.lack_at_rest, static_cast<std::size_t>(body.info.n_modes) * stride * sizeof(float));
    for (std::size_t i = 0; i < static_cast<std::size_t>(body.info.n_pressures) * stride; ++i)
      state.next_bulk_rows[i] = 0;
  }
  const auto cut_to_all = [&](std::int32_t c) { return c < body.info.n_cells ? c : body.info.n_cells; };
  for (const std::int32_t end = cut_to_all(state.next_cells + n_cells); state.next_cells < end;) {
    const std::int32_t first = state.next_cells;
    state.next_cells = cut_to_all(first + cells_of_panel);
    if (add_panel(state, first, state.next_cells)) continue;
    state.next_cells = 0;
    return false;
  }
  if (state.next_cells < body.info.n_cells) return true;
  state.next_cells = 0;
  state.is_stale = false;
  float* before = state.bulk_rows;
  state.bulk_rows = state.next_bulk_rows;
  state.next_bulk_rows = before;
  return factorize(state);
}

}  // namespace PHN_RUNTIME
