#include "body/elements.hpp"

#include <cfloat>
#include <cstring>

namespace PHN_RUNTIME {
namespace {

/// A diagonal is at most raised to this many times itself.
constexpr float largest_shift = 1e9f;
/// Second derivatives of a cell count as at most this many times those at rest, so that the rounding of a sum of which
/// they were a part does not matter.
constexpr double stiffest = 1e3;

double pressure_of(const phn_body_state& state, std::int32_t cell) {
  const std::int32_t row = state.body->pressed_row[cell];
  return row >= 0 ? state.pressure_at[row] : 0;
}

void gradient_at(const double* strain, double F[9]) {
  for (int k = 0; k < 9; ++k) F[k] = strain[k] + (k % 4 == 0 ? 1 : 0);
}

/// The second derivatives of a cell at its strain and pressure, with its weights; where the law is not defined they
/// stay.
void find_tangent(const phn_body_state& state, std::int32_t c, phn_body_state::Cell& cell) {
  const phn_body& body = *state.body;
  const BodyMaterial& material = body.material(c);
  double F[9], value, stress[9], A[81];
  gradient_at(cell.strain, F);
  if (!body.law->shape(F, material.parameters, value, stress, A)) return;
  for (double& a : A) a *= body.shear[c];
  const double bulk = body.shear[c] * material.bulk;
  if (bulk > 0 || body.pressed_row[c] >= 0) {
    double slope[9], second[81];
    if (!body.law->volumetric(F, material.parameters, value, slope, second)) return;
    const double p = bulk * value + body.bulk_of_cell[c] * cell.pressure;
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < 9; ++l) A[9 * k + l] += bulk * slope[k] * slope[l] + p * second[9 * k + l];
  }
  double largest = 0;
  for (const double a : A) largest = std::fmax(largest, std::fabs(a));
  const double most = stiffest * state.modulus * body.shear[c], factor = largest > most ? most / largest : 1;
  for (int k = 0; k < 81; ++k) cell.tangent[k] = static_cast<float>(factor * A[k]);
}

/// Puts the present state of cells into the stiffness, in place of what it has of them.
void replace(phn_body_state& state, const std::int32_t* cells, std::int32_t n) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride;
  float* const products = state.panel + static_cast<std::int64_t>(9 * cells_of_panel) * stride;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t c = cells[i];
    phn_body_state::Cell now = state.cells[c];
    memcpy(now.strain, state.at.strain + 9 * static_cast<std::int64_t>(c), sizeof now.strain);
    now.pressure = pressure_of(state, c);
    find_tangent(state, c, now);
    float change[81];
    for (int k = 0; k < 81; ++k) change[k] = now.tangent[k] - state.cells[c].tangent[k];
    state.cells[c] = now;
    const float* rows = body.gradients + static_cast<std::int64_t>(9 * c) * stride;
    memcpy(state.panel + 9 * i * stride, rows, 9 * static_cast<std::size_t>(stride) * sizeof(float));
    for (int k = 0; k < 9; ++k) state.kernels->mix(rows, stride, change + 9 * k, products + (9 * i + k) * stride);
  }
  state.kernels->add_products(state.panel, products, 9 * n, stride, state.sum);
}

/// Adds a multiple of the squares of the displacements under the tools, which does not change where the energy is
/// stationary with these prescribed, and makes the sum definite where the body is stable under the tools only. Springs
/// are in series with it: (H^-1 + S)^-1 = H^1/2 (1 + H^1/2 S H^1/2)^-1 H^1/2.
void hold_tools(phn_body_state& state) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride, n = state.n_rows;
  constexpr double stiff = 30;  // over the stiffness that the modes alone have under a tool
  double root[3 * PHN_MOST_COUPLED], lower[3 * PHN_MOST_COUPLED][3 * PHN_MOST_COUPLED] = {};
  for (std::int32_t r = 0; r < n; ++r) {
    const double* row = state.rows + static_cast<std::int64_t>(r) * stride;
    double compliance = 0;
    for (std::int32_t m = 0; m < body.info.n_modes; ++m) {
      const double diagonal = state.factor[static_cast<std::int64_t>(m) * (stride + 1)];
      if (diagonal > 0) compliance += row[m] * row[m] / diagonal;
    }
    state.held[r] = compliance > 0 ? stiff / compliance : 0;
    root[r] = std::sqrt(state.held[r]);
  }
  for (std::int32_t r = 0; r < n && state.has_springs; ++r)
    for (std::int32_t k = 0; k <= r; ++k) {
      double sum = (k == r ? 1 : 0) + root[r] * state.springs[r][k] * root[k];
      for (std::int32_t i = 0; i < k; ++i) sum -= lower[r][i] * lower[k][i];
      lower[r][k] = k == r ? std::sqrt(sum) : sum / lower[k][k];
    }
  for (std::int32_t m = 0; m < stride; ++m) {
    double column[3 * PHN_MOST_COUPLED];
    for (std::int32_t r = 0; r < n; ++r) {
      column[r] = root[r] * state.rows[static_cast<std::int64_t>(r) * stride + m];
      for (std::int32_t k = 0; k < r && state.has_springs; ++k) column[r] -= lower[r][k] * column[k];
      if (state.has_springs) column[r] /= lower[r][r];
      state.panel[static_cast<std::int64_t>(r) * stride + m] = static_cast<float>(column[r]);
    }
  }
  state.kernels->add_products(state.panel, state.panel, n, stride, state.factor);
}

bool factorize(phn_body_state& state) {
  const std::int32_t n = state.body->info.n_modes, stride = state.body->stride;
  for (float shift = 0; shift <= largest_shift; shift = shift > 0 ? 4 * shift : 1e-3f) {
    memcpy(state.factor, state.sum, static_cast<std::size_t>(stride) * static_cast<std::size_t>(n) * sizeof(float));
    state.kernels->add_products(state.bulk_rows, state.bulk_rows, state.body->info.n_pressures, stride, state.factor);
    hold_tools(state);
    for (std::int32_t i = 0; i < n; ++i) {
      float& diagonal = state.factor[static_cast<std::int64_t>(i) * (stride + 1)];
      diagonal += shift * (diagonal > 0 ? diagonal : -diagonal);
    }
    if (state.kernels->factorize(state.factor, n, stride)) return true;
  }
  return false;
}

/// Multiplies the energy of the cells by the ratio that makes it that of all elements in a linear body.
void scale_as_linear(phn_body_state& state, phn_body_state::Point& point) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_modes;
  if (body.cells_at_rest == nullptr) return;
  state.kernels->times(body.cells_at_rest, n, body.stride, point.q, state.of_cells);
  state.kernels->times(body.lack_at_rest, n, body.stride, point.q, state.lacking);
  double of_cells = 0, lacking = 0;
  for (std::int32_t m = 0; m < n; ++m) {
    of_cells += point.q[m] * state.of_cells[m];
    lacking += point.q[m] * state.lacking[m];
  }
  if (!(of_cells > 0)) return;
  const double more = lacking / of_cells, slope = 2 * point.energy / of_cells;
  for (std::int32_t m = 0; m < n; ++m)
    point.forces[m] += more * point.forces[m] + slope * (state.lacking[m] - more * state.of_cells[m]);
  point.energy += more * point.energy;
}

}  // namespace

bool evaluate_body(phn_body_state& state, phn_body_state::Point& point) {
  const phn_body& body = *state.body;
  const BodyKernels& kernels = *state.kernels;
  const std::int32_t n = body.info.n_cells, stride = body.stride;
  point.energy = 0;
  set_zero(point.forces, static_cast<std::size_t>(stride));
  // Rows of a few cells stay in the cache while they are used.
  constexpr std::int32_t several = 4;
  for (std::int32_t first = 0; first < n; first += several) {
    const std::int32_t end = first + several < n ? first + several : n;
    const float* rows = body.gradients + static_cast<std::int64_t>(9 * first) * stride;
    double *strain = point.strain + 9 * static_cast<std::int64_t>(first), stress[9 * several];
    kernels.times(rows, 9 * (end - first), stride, point.q, strain);
    for (std::int32_t c = first; c < end; ++c) {
      const std::int32_t i = 9 * (c - first), pressed = body.pressed_row[c];
      const BodyMaterial& material = body.material(c);
      double F[9], shape, change = 0, slope[9] = {};
      gradient_at(strain + i, F);
      if (!body.law->shape(F, material.parameters, shape, stress + i, nullptr)) return false;
      if ((material.bulk > 0 || pressed >= 0) && !body.law->volumetric(F, material.parameters, change, slope, nullptr))
        return false;
      point.energy += body.shear[c] * (shape + material.bulk / 2 * change * change);
      for (int k = 0; k < 9; ++k) stress[i + k] = body.shear[c] * (stress[i + k] + material.bulk * change * slope[k]);
      if (pressed < 0) continue;
      state.pressure_at[pressed] = body.bulk_of_cell[c] * change;
      float factor[9];
      for (int k = 0; k < 9; ++k) factor[k] = static_cast<float>(body.bulk_of_cell[c] * slope[k]);
      kernels.mix(rows + i * stride, stride, factor, point.changes + static_cast<std::int64_t>(pressed) * stride);
    }
    kernels.add(rows, 9 * (end - first), stride, stress, point.forces);
  }
  scale_as_linear(state, point);
  set_zero(point.sums, static_cast<std::size_t>(body.pressure_stride));
  kernels.add(body.pressures, body.n_pressed, body.pressure_stride, state.pressure_at, point.sums);
  for (std::int32_t k = 0; k < body.info.n_pressures; ++k) point.energy += point.sums[k] * point.sums[k] / 2;
  kernels.times(body.pressures, body.n_pressed, body.pressure_stride, point.sums, state.pressure_at);
  kernels.add(point.changes, body.n_pressed, stride, state.pressure_at, point.forces);
  return std::isfinite(point.energy) && all_finite(point.forces, static_cast<std::size_t>(body.info.n_modes));
}

bool find_rounding(phn_body_state& state) {
  const phn_body& body = *state.body;
  double volume = 0, &modulus = state.modulus = 0;
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) volume += body.shear[c];
  for (std::int32_t m = 0; m < body.n_materials; ++m) {
    if (!(body.materials[m].modulus > 0)) return false;
    modulus = std::fmax(modulus, body.materials[m].modulus);
  }
  state.rounding = DBL_EPSILON * volume * modulus;  // a law is a difference of numbers near 3 times its modulus
  return state.rounding > 0 && state.rounding <= DBL_MAX;
}

bool renew_stiffness(phn_body_state& state, std::int32_t n_cells) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_cells;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(body.pressure_stride) * body.stride; ++i)
    state.bulk_rows[i] = 0;
  state.kernels->multiply(body.pressures, body.pressure_stride, state.at.changes, body.n_pressed, body.stride,
                          state.bulk_rows);
  state.kernels->times(body.pressures, body.n_pressed, body.pressure_stride, state.expected, state.pressure_at);
  for (std::int32_t c = 0; c < n; ++c) {
    const phn_body_state::Cell& cell = state.cells[c];
    double square = 0;
    for (int k = 0; k < 9; ++k) {
      const double d = state.at.strain[9 * c + k] - cell.strain[k];
      square += d * d;
    }
    state.changed[c] = (body.shear[c] * body.material(c).modulus * std::sqrt(square) +
                        body.bulk_of_cell[c] * std::fabs(pressure_of(state, c) - cell.pressure)) *
                       state.size_of_rows[c];
  }
  std::int32_t cells[cells_of_panel];
  for (std::int32_t done = 0; done < n_cells && done < n;) {
    std::int32_t i = 0;
    for (; i < cells_of_panel && done < n_cells && done < n; ++i, ++done) {
      cells[i] = 0;
      for (std::int32_t c = 1; c < n; ++c)
        if (state.changed[c] > state.changed[cells[i]]) cells[i] = c;
      state.changed[cells[i]] = -1;
    }
    replace(state, cells, i);
  }
  return factorize(state);
}

bool start_stiffness(phn_body_state& state) {
  const phn_body& body = *state.body;
  const auto stride = static_cast<std::size_t>(body.stride);
  for (std::size_t i = 0; i < stride * stride; ++i) state.sum[i] = 0;
  if (body.cells_at_rest != nullptr)
    memcpy(state.sum, body.lack_at_rest, static_cast<std::size_t>(body.info.n_modes) * stride * sizeof(float));
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) {
    state.cells[c] = {};
    state.size_of_rows[c] = 0;
    const float* rows = body.gradients + static_cast<std::int64_t>(9 * c) * body.stride;
    for (std::size_t m = 0; m < 9 * stride; ++m) state.size_of_rows[c] += static_cast<double>(rows[m]) * rows[m];
  }
  if (!renew_stiffness(state, body.info.n_cells)) return false;
  memcpy(state.sum_at_rest, state.sum, stride * stride * sizeof(float));
  memcpy(state.factor_at_rest, state.factor, stride * stride * sizeof(float));
  return true;
}

void release_stiffness(phn_body_state& state) {
  const auto stride = static_cast<std::size_t>(state.body->stride);
  memcpy(state.sum, state.sum_at_rest, stride * stride * sizeof(float));
  for (std::int32_t c = 0; c < state.body->info.n_cells; ++c) {
    set_zero(state.cells[c].strain, 9);
    state.cells[c].pressure = 0;
    find_tangent(state, c, state.cells[c]);
  }
}

}  // namespace PHN_RUNTIME
