#include "body/elements.hpp"

namespace PHN_RUNTIME {
namespace {

/// A diagonal is at most raised to this many times itself.
constexpr float largest_shift = 1e3f;

void gradient_at(const double* strain, double F[9]) {
  for (int k = 0; k < 9; ++k) F[k] = strain[k] + (k % 4 == 0 ? 1 : 0);
}

bool changes_volume(const phn_body& body, std::int32_t cell) { return body.bulk > 0 || body.bulk_of_cell[cell] > 0; }

const float* pressures_of(const phn_body& body, std::int32_t cell) {
  return body.pressures + static_cast<std::int64_t>(cell) * body.pressure_stride;
}

/// b, and its products with the pressures of the cells.
void sum_pressures(phn_body_state& state) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_cells;
  set_zero(state.pressure_sums, static_cast<std::size_t>(body.pressure_stride));
  for (std::int32_t c = 0; c < n; ++c) state.pressure_at[c] = body.bulk_of_cell[c] * state.change[c];
  state.kernels->add(body.pressures, n, body.pressure_stride, state.pressure_at, state.pressure_sums);
  state.kernels->times(body.pressures, n, body.pressure_stride, state.pressure_sums, state.pressure_at);
}

/// Adds the second derivatives of cells from `first` on to the stiffness. @return false where a law is not defined
bool add_panel(phn_body_state& state, std::int32_t first, std::int32_t end) {
  const phn_body& body = *state.body;
  const std::int32_t stride = body.stride;
  for (std::int32_t c = first; c < end; ++c) {
    double F[9], value, stress[9], slope[9], A[81], second[81];
    const std::size_t at = 9 * static_cast<std::size_t>(c);
    gradient_at(state.strain + at, F);
    if (!body.law->shape(F, body.parameters, value, stress, A)) return false;
    for (double& a : A) a *= body.shear[c];
    const float* rows = body.gradients + static_cast<std::int64_t>(at) * stride;
    if (changes_volume(body, c)) {
      if (!body.law->volumetric(F, body.parameters, value, slope, second)) return false;
      const double bulk = body.shear[c] * body.bulk, p = bulk * value + body.bulk_of_cell[c] * state.pressure_at[c];
      for (int i = 0; i < 9; ++i)
        for (int j = 0; j < 9; ++j) A[9 * i + j] += bulk * slope[i] * slope[j] + p * second[9 * i + j];
      if (body.bulk_of_cell[c] > 0) {
        const float* psi = pressures_of(body, c);
        float* change = state.turned;  // dg/dq times the weight
        for (std::int32_t m = 0; m < stride; ++m) {
          float sum = 0;
          for (int k = 0; k < 9; ++k) sum += static_cast<float>(body.bulk_of_cell[c] * slope[k]) * rows[k * stride + m];
          change[m] = sum;
        }
        for (std::int32_t k = 0; k < body.info.n_pressures; ++k)
          for (std::int32_t m = 0; m < stride; ++m) state.bulk_rows[k * stride + m] += psi[k] * change[m];
      }
    }
    float* out = state.panel + static_cast<std::int64_t>(9 * (c - first)) * stride;
    for (int i = 0; i < 9; ++i)
      for (std::int32_t m = 0; m < stride; ++m) {
        float sum = 0;
        for (int j = 0; j < 9; ++j) sum += static_cast<float>(A[9 * i + j]) * rows[j * stride + m];
        out[i * stride + m] = sum;
      }
  }
  state.kernels->add_products(body.gradients + static_cast<std::int64_t>(9 * first) * stride, state.panel,
                              9 * (end - first), stride, state.stiffness);
  return true;
}

}  // namespace

bool evaluate_body(phn_body_state& state, const double* q, double& energy, double* forces) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_cells;
  state.kernels->times(body.gradients, 9 * static_cast<std::int64_t>(n), body.stride, q, state.strain);
  energy = 0;
  for (std::int32_t c = 0; c < n; ++c) {
    double F[9], shape;
    const std::size_t at = 9 * static_cast<std::size_t>(c);
    gradient_at(state.strain + at, F);
    double *stress = state.stress + at, *slope = state.bulk_slope + at;
    if (!body.law->shape(F, body.parameters, shape, stress, nullptr)) return false;
    state.change[c] = 0;
    if (changes_volume(body, c) && !body.law->volumetric(F, body.parameters, state.change[c], slope, nullptr))
      return false;
    energy += body.shear[c] * (shape + body.bulk / 2 * state.change[c] * state.change[c]);
  }
  sum_pressures(state);
  for (std::int32_t k = 0; k < body.info.n_pressures; ++k)
    energy += state.pressure_sums[k] * state.pressure_sums[k] / 2;
  for (std::int32_t c = 0; c < n; ++c) {
    const std::size_t at = 9 * static_cast<std::size_t>(c);
    const double p = body.shear[c] * body.bulk * state.change[c] + body.bulk_of_cell[c] * state.pressure_at[c];
    const bool changes = changes_volume(body, c);
    for (std::size_t k = at; k < at + 9; ++k)
      state.stress[k] = body.shear[c] * state.stress[k] + (changes ? p * state.bulk_slope[k] : 0);
  }
  set_zero(forces, static_cast<std::size_t>(body.stride));
  state.kernels->add(body.gradients, 9 * static_cast<std::int64_t>(n), body.stride, state.stress, forces);
  return std::isfinite(energy) && all_finite(forces, static_cast<std::size_t>(body.info.n_modes));
}

bool renew_stiffness(phn_body_state& state) {
  const phn_body& body = *state.body;
  const std::int32_t n = body.info.n_modes, stride = body.stride;
  const auto size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(stride);
  double energy;
  // The strains may be those of a trial that was refused.
  if (!evaluate_body(state, state.q, energy, state.trial_forces)) return false;
  for (float shift = 0; shift <= largest_shift; shift = shift == 0 ? 1e-3f : 8 * shift) {
    for (std::size_t i = 0; i < size; ++i) state.stiffness[i] = 0;
    const auto n_bulk = static_cast<std::size_t>(body.info.n_pressures) * static_cast<std::size_t>(stride);
    for (std::size_t i = 0; i < n_bulk; ++i) state.bulk_rows[i] = 0;
    for (std::int32_t c = 0; c < body.info.n_cells; c += cells_of_panel) {
      const std::int32_t end = c + cells_of_panel < body.info.n_cells ? c + cells_of_panel : body.info.n_cells;
      if (!add_panel(state, c, end)) return false;
    }
    state.kernels->add_products(state.bulk_rows, state.bulk_rows, body.info.n_pressures, stride, state.stiffness);
    for (std::int32_t i = 0; i < n; ++i) {
      float& diagonal = state.stiffness[static_cast<std::size_t>(i) * static_cast<std::size_t>(stride + 1)];
      diagonal += shift * (diagonal > 0 ? diagonal : -diagonal);
    }
    if (state.kernels->factorize(state.stiffness, n, stride)) return true;
  }
  return false;
}

}  // namespace PHN_RUNTIME
