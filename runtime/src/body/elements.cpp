#include "body/elements.hpp"

#include <cfloat>
#include <cstring>

namespace PHN_RUNTIME {
namespace {

/// The diagonal of an indefinite stiffness is raised by at most this many times itself.
constexpr float largest_shift = 1e9f;
/// Second derivatives of a cell are limited to this many times those at rest. The rounding error that they leave in the
/// sum, once they are replaced, then does not matter.
constexpr double largest_tangent = 1e3;

double pressure_of(const phn_body_state& state, std::int32_t cell) {
  const std::int32_t row = state.body->pressure_row[cell];
  return row >= 0 ? state.cell_pressures[row] : 0;
}

void deformation_gradient(const double* displacement_gradient, double F[9]) {
  for (int k = 0; k < 9; ++k) F[k] = displacement_gradient[k] + (k % 4 == 0 ? 1 : 0);
}

/// Computes the second derivatives of the energy of a cell at its state. They are unchanged where the law is undefined.
void set_tangent(const phn_body_state& state, std::int32_t c, phn_body_state::Cell& cell) {
  const phn_body& body = *state.body;
  const BodyMaterial& material = body.material(c);
  double F[9], value, stress[9], A[81];
  deformation_gradient(cell.displacement_gradient, F);
  if (!body.law->shape(F, material.parameters, value, stress, A)) return;
  for (double& a : A) a *= body.cell_weights[c];
  const double bulk = body.cell_weights[c] * material.bulk;
  if (bulk > 0 || body.pressure_row[c] >= 0) {
    double slope[9], second[81];
    if (!body.law->volumetric(F, material.parameters, value, slope, second)) return;
    const double p = bulk * value + body.pressure_weights[c] * cell.pressure;
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < 9; ++l) A[9 * k + l] += bulk * slope[k] * slope[l] + p * second[9 * k + l];
  }
  double largest = 0;
  for (const double a : A) largest = std::fmax(largest, std::fabs(a));
  const double most = largest_tangent * state.largest_modulus * body.cell_weights[c],
               factor = largest > most ? most / largest : 1;
  for (int k = 0; k < 81; ++k) cell.tangent[k] = static_cast<float>(factor * A[k]);
}

/// Replaces the second derivatives of some cells in the stiffness by those at the present state.
void update_cells(phn_body_state& state, const std::int32_t* cells, std::int32_t n) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride;
  float* const products = state.panel + static_cast<std::int64_t>(9 * cells_of_panel) * stride;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t c = cells[i];
    phn_body_state::Cell now = state.cells[c];
    memcpy(now.displacement_gradient, state.current.displacement_gradient + 9 * static_cast<std::int64_t>(c),
           sizeof now.displacement_gradient);
    now.pressure = pressure_of(state, c);
    set_tangent(state, c, now);
    float change[81];
    for (int k = 0; k < 81; ++k) change[k] = now.tangent[k] - state.cells[c].tangent[k];
    state.cells[c] = now;
    const float* rows = body.mode_gradients[9 * c];
    memcpy(state.panel + 9 * i * stride, rows, 9 * static_cast<std::size_t>(stride) * sizeof(float));
    for (int k = 0; k < 9; ++k)
      state.kernels->combine_rows(rows, stride, change + 9 * k, products + (9 * i + k) * stride);
  }
  state.kernels->add_symmetric_product({state.panel, 9 * n, stride}, {products, 9 * n, stride}, state.cell_stiffness);
}

/// Adds R^T H R to the matrix that is factorized. The penalty does not change the solution, because R q is prescribed,
/// and it makes the matrix definite where only the tools keep the body stable. The springs S are in series with it:
/// (H^-1 + S)^-1 = H^1/2 (1 + H^1/2 S H^1/2)^-1 H^1/2.
void add_penalty(phn_body_state& state) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride, n = state.n_constraints;
  constexpr double stiff = 30;  // The penalty is this many times the stiffness of the modes under a tool.
  double root[3 * PHN_MOST_COUPLED], lower[3 * PHN_MOST_COUPLED][3 * PHN_MOST_COUPLED] = {};
  for (std::int32_t r = 0; r < n; ++r) {
    const double* row = state.constraint_row(r);
    double compliance = 0;
    for (std::int32_t m = 0; m < body.info.n_modes; ++m) {
      const double diagonal = state.factor[static_cast<std::int64_t>(m) * (stride + 1)];
      if (diagonal > 0) compliance += row[m] * row[m] / diagonal;
    }
    state.penalty[r] = compliance > 0 ? stiff / compliance : 0;
    root[r] = std::sqrt(state.penalty[r]);
  }
  for (std::int32_t r = 0; r < n && state.has_springs; ++r)
    for (std::int32_t k = 0; k <= r; ++k) {
      double sum = (k == r ? 1 : 0) + root[r] * state.spring_compliance[r][k] * root[k];
      for (std::int32_t i = 0; i < k; ++i) sum -= lower[r][i] * lower[k][i];
      lower[r][k] = k == r ? std::sqrt(sum) : sum / lower[k][k];
    }
  for (std::int32_t m = 0; m < stride; ++m) {
    double column[3 * PHN_MOST_COUPLED];
    for (std::int32_t r = 0; r < n; ++r) {
      column[r] = root[r] * state.constraint_row(r)[m];
      for (std::int32_t k = 0; k < r && state.has_springs; ++k) column[r] -= lower[r][k] * column[k];
      if (state.has_springs) column[r] /= lower[r][r];
      state.panel[static_cast<std::int64_t>(r) * stride + m] = static_cast<float>(column[r]);
    }
  }
  const RowMatrix rows = {state.panel, n, stride};
  state.kernels->add_symmetric_product(rows, rows, state.factor);
}

bool factorize(phn_body_state& state) {
  const std::int32_t n = state.body->info.n_modes, stride = state.body->stride;
  const RowMatrix jacobian = {state.pressure_jacobian, state.body->info.n_pressures, stride};
  for (float shift = 0; shift <= largest_shift; shift = shift > 0 ? 4 * shift : 1e-3f) {
    memcpy(state.factor, state.cell_stiffness,
           static_cast<std::size_t>(stride) * static_cast<std::size_t>(n) * sizeof(float));
    state.kernels->add_symmetric_product(jacobian, jacobian, state.factor);
    add_penalty(state);
    for (std::int32_t i = 0; i < n; ++i) {
      float& diagonal = state.factor[static_cast<std::int64_t>(i) * (stride + 1)];
      diagonal += shift * (diagonal > 0 ? diagonal : -diagonal);
    }
    state.is_definite = shift == 0;
    if (state.kernels->factorize(state.factor, n, stride)) return true;
  }
  return false;
}

/// Multiplies the energy of the cells by the ratio r of formats/body.md, which makes it that of all elements in a
/// linear body.
void scale_to_linear_energy(phn_body_state& state, phn_body_state::Point& point) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_modes;
  if (body.cells_at_rest.n_rows == 0) return;
  state.kernels->multiply_vector(body.cells_at_rest, point.q, state.cells_gradient);
  state.kernels->multiply_vector(body.lack_at_rest, point.q, state.lack_gradient);
  double of_cells = 0, lack = 0;
  for (std::int32_t m = 0; m < n; ++m) {
    of_cells += point.q[m] * state.cells_gradient[m];
    lack += point.q[m] * state.lack_gradient[m];
  }
  if (!(of_cells > 0)) return;
  const double more = lack / of_cells, slope = 2 * point.energy / of_cells;
  for (std::int32_t m = 0; m < n; ++m)
    point.gradient[m] += more * point.gradient[m] + slope * (state.lack_gradient[m] - more * state.cells_gradient[m]);
  point.energy += more * point.energy;
}

}  // namespace

bool evaluate_body(phn_body_state& state, phn_body_state::Point& point) {
  const phn_body& body = *state.body;
  const BodyKernels& kernels = *state.kernels;
  const std::int32_t n = body.info.n_cells, stride = body.stride;
  point.energy = 0;
  set_zero(point.gradient, static_cast<std::size_t>(stride));
  // Rows of a few cells stay in the cache while they are used.
  constexpr std::int32_t several = 4;
  for (std::int32_t first = 0; first < n; first += several) {
    const std::int32_t end = first + several < n ? first + several : n;
    const RowMatrix rows = {body.mode_gradients[9 * first], 9 * (end - first), stride};
    double *gradient = point.displacement_gradient + 9 * static_cast<std::int64_t>(first), stress[9 * several];
    kernels.multiply_vector(rows, point.q, gradient);
    for (std::int32_t c = first; c < end; ++c) {
      const std::int32_t i = 9 * (c - first), pressure_row = body.pressure_row[c];
      const BodyMaterial& material = body.material(c);
      double F[9], shape, change = 0, slope[9] = {};
      deformation_gradient(gradient + i, F);
      if (!body.law->shape(F, material.parameters, shape, stress + i, nullptr)) return false;
      if ((material.bulk > 0 || pressure_row >= 0) &&
          !body.law->volumetric(F, material.parameters, change, slope, nullptr))
        return false;
      point.energy += body.cell_weights[c] * (shape + material.bulk / 2 * change * change);
      for (int k = 0; k < 9; ++k)
        stress[i + k] = body.cell_weights[c] * (stress[i + k] + material.bulk * change * slope[k]);
      if (pressure_row < 0) continue;
      state.cell_pressures[pressure_row] = body.pressure_weights[c] * change;
      float factor[9];
      for (int k = 0; k < 9; ++k) factor[k] = static_cast<float>(body.pressure_weights[c] * slope[k]);
      kernels.combine_rows(rows[i], stride, factor,
                           point.volume_gradients + static_cast<std::int64_t>(pressure_row) * stride);
    }
    kernels.add_transposed_product(rows, stress, point.gradient);
  }
  scale_to_linear_energy(state, point);
  set_zero(point.pressures, static_cast<std::size_t>(body.pressure_modes.stride));
  kernels.add_transposed_product(body.pressure_modes, state.cell_pressures, point.pressures);
  for (std::int32_t k = 0; k < body.info.n_pressures; ++k) point.energy += point.pressures[k] * point.pressures[k] / 2;
  kernels.multiply_vector(body.pressure_modes, point.pressures, state.cell_pressures);
  kernels.add_transposed_product({point.volume_gradients, body.pressure_modes.n_rows, stride}, state.cell_pressures,
                                 point.gradient);
  return std::isfinite(point.energy) && all_finite(point.gradient, static_cast<std::size_t>(body.info.n_modes));
}

bool set_energy_rounding(phn_body_state& state) {
  const phn_body& body = *state.body;
  double volume = 0, &modulus = state.largest_modulus = 0;
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) volume += body.cell_weights[c];
  for (std::int32_t m = 0; m < body.n_materials; ++m) {
    if (!(body.materials[m].modulus > 0)) return false;
    modulus = std::fmax(modulus, body.materials[m].modulus);
  }
  state.energy_rounding = DBL_EPSILON * volume * modulus;  // Laws subtract numbers near three times the modulus.
  return state.energy_rounding > 0 && state.energy_rounding <= DBL_MAX;
}

bool update_stiffness(phn_body_state& state, std::int32_t n_cells) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_cells;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(body.pressure_modes.stride) * body.stride; ++i)
    state.pressure_jacobian[i] = 0;
  state.kernels->add_product(body.pressure_modes,
                             {state.current.volume_gradients, body.pressure_modes.n_rows, body.stride},
                             state.pressure_jacobian);
  state.kernels->multiply_vector(body.pressure_modes, state.predicted_pressures, state.cell_pressures);
  for (std::int32_t c = 0; c < n; ++c) {
    const phn_body_state::Cell& cell = state.cells[c];
    double square = 0;
    for (int k = 0; k < 9; ++k) {
      const double d = state.current.displacement_gradient[9 * c + k] - cell.displacement_gradient[k];
      square += d * d;
    }
    state.stiffness_change[c] = (body.cell_weights[c] * body.material(c).modulus * std::sqrt(square) +
                                 body.pressure_weights[c] * std::fabs(pressure_of(state, c) - cell.pressure)) *
                                state.squared_gradients[c];
  }
  std::int32_t cells[cells_of_panel];
  for (std::int32_t done = 0; done < n_cells && done < n;) {
    std::int32_t i = 0;
    for (; i < cells_of_panel && done < n_cells && done < n; ++i, ++done) {
      cells[i] = 0;
      for (std::int32_t c = 1; c < n; ++c)
        if (state.stiffness_change[c] > state.stiffness_change[cells[i]]) cells[i] = c;
      state.stiffness_change[cells[i]] = -1;
    }
    update_cells(state, cells, i);
  }
  return factorize(state);
}

bool init_stiffness(phn_body_state& state) {
  const phn_body& body = *state.body;
  const auto stride = static_cast<std::size_t>(body.stride);
  for (std::size_t i = 0; i < stride * stride; ++i) state.cell_stiffness[i] = 0;
  if (body.cells_at_rest.n_rows > 0)
    memcpy(state.cell_stiffness, body.lack_at_rest.data,
           static_cast<std::size_t>(body.info.n_modes) * stride * sizeof(float));
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) {
    state.cells[c] = {};
    state.squared_gradients[c] = 0;
    const float* rows = body.mode_gradients[9 * c];
    for (std::size_t m = 0; m < 9 * stride; ++m) state.squared_gradients[c] += static_cast<double>(rows[m]) * rows[m];
  }
  if (!update_stiffness(state, body.info.n_cells)) return false;
  memcpy(state.cell_stiffness_at_rest, state.cell_stiffness, stride * stride * sizeof(float));
  memcpy(state.factor_at_rest, state.factor, stride * stride * sizeof(float));
  return true;
}

void reset_stiffness(phn_body_state& state) {
  const auto stride = static_cast<std::size_t>(state.body->stride);
  memcpy(state.cell_stiffness, state.cell_stiffness_at_rest, stride * stride * sizeof(float));
  for (std::int32_t c = 0; c < state.body->info.n_cells; ++c) {
    set_zero(state.cells[c].displacement_gradient, 9);
    state.cells[c].pressure = 0;
    set_tangent(state, c, state.cells[c]);
  }
}

}  // namespace PHN_RUNTIME
