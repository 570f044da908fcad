#include "modal/modal_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// The first n entries of row r of a table times a vector.
PHN_INLINE double row_times(const std::int16_t* table, std::int32_t n_columns, const double* scale, std::size_t r,
                            std::int32_t n, const double* value) {
  const std::int16_t* row = table + r * static_cast<std::size_t>(n_columns);
  double sum = 0;
  for (std::int32_t j = 0; j < n; ++j) sum += row[j] * scale[j] * value[j];
  return sum;
}

/// field = sum_s amount_s mode_s in float for n rows, block by block. The sums of a block stay in registers while the
/// first n_modes of its n_columns modes are read in the order of memory.
PHN_INLINE void sum_modes(std::int32_t n_modes, std::int32_t n_columns, std::int32_t n, const float* mode,
                          const float* amount, double* field) {
  const std::size_t rest = static_cast<std::size_t>(n_columns - n_modes) * rows_per_block;
  for (std::int32_t begin = 0; begin < n; begin += rows_per_block) {
    float sum[rows_per_block] = {};
    for (std::int32_t s = 0; s < n_modes; ++s, mode += rows_per_block) {
      const float factor = amount[s];
      for (std::int32_t i = 0; i < rows_per_block; ++i) sum[i] += factor * mode[i];
    }
    mode += rest;
    const std::int32_t size = n - begin < rows_per_block ? n - begin : rows_per_block;
    if (size == rows_per_block) {
      for (std::int32_t i = 0; i < rows_per_block; ++i) field[begin + i] = static_cast<double>(sum[i]);
    } else {
      for (std::int32_t i = 0; i < size; ++i) field[begin + i] = static_cast<double>(sum[i]);
    }
  }
}

/// basis_i = q(x - c_i) - q(x) minus its value at rest; then x.
PHN_INLINE void fill_basis(const SharedModes& centers, const double* x, double* __restrict basis) {
  const SharedModes shared = centers;  // a copy, for which the compiler can exclude aliasing with the results
  const double at[3] = {x[0], x[1], x[2]}, q = std::sqrt(dot(at, at) + shared.shape * shared.shape);
  for (std::int32_t i = 0; i < shared.n_centers; ++i)
    basis[i] = amplitude_kernel(shared, at, q, i) - shared.basis_at_rest[i];
  for (int k = 0; k < 3; ++k) basis[shared.n_centers + k] = at[k];
}

PHN_INLINE void fill_basis_gradient(const SharedModes& centers, const double* x, double* __restrict gradient) {
  const SharedModes shared = centers;
  const double s2 = shared.shape * shared.shape, at[3] = {x[0], x[1], x[2]}, q0 = std::sqrt(dot(at, at) + s2);
  const double rest[3] = {at[0] / q0, at[1] / q0, at[2] / q0};
  const std::int32_t n = shared.n_centers;
  double *by_x = gradient, *by_y = gradient + (n + 3), *by_z = gradient + 2 * (n + 3);
  for (std::int32_t i = 0; i < n; ++i) {
    const double y[3] = {at[0] - shared.center[0][i], at[1] - shared.center[1][i], at[2] - shared.center[2][i]};
    const double inverse = 1 / std::sqrt(dot(y, y) + s2);
    by_x[i] = y[0] * inverse - rest[0];
    by_y[i] = y[1] * inverse - rest[1];
    by_z[i] = y[2] * inverse - rest[2];
  }
  for (int k = 0; k < 3; ++k) {
    by_x[n + k] = k == 0 ? 1 : 0;
    by_y[n + k] = k == 1 ? 1 : 0;
    by_z[n + k] = k == 2 ? 1 : 0;
  }
}

/// amplitude = basis times weights for n_rows rows; each weight is converted from 16 bits once for all rows.
template <std::int32_t n_rows>
PHN_INLINE void sum_amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* basis,
                               double* __restrict amplitude) {
  const std::int32_t m = tables.n_modes;
  constexpr std::int32_t at_once = 8;
  for (std::int32_t begin = 0; begin < m; begin += at_once) {
    const std::int16_t* weight = tables.weight + begin;
    const double* scale = tables.weight_scale + begin;
    double sum[n_rows][at_once] = {};
    const std::int32_t size = m - begin < at_once ? m - begin : at_once;
    if (size == at_once) {
      // Constant loop bounds let compilers vectorize the sums.
      for (std::int32_t r = 0; r < n_basis; ++r, weight += m) {
        for (std::int32_t j = 0; j < at_once; ++j) {
          const double w = weight[j];
          for (std::int32_t k = 0; k < n_rows; ++k) sum[k][j] += basis[k * n_basis + r] * w;
        }
      }
    } else {
      for (std::int32_t r = 0; r < n_basis; ++r, weight += m) {
        for (std::int32_t j = 0; j < size; ++j) {
          const double w = weight[j];
          for (std::int32_t k = 0; k < n_rows; ++k) sum[k][j] += basis[k * n_basis + r] * w;
        }
      }
    }
    for (std::int32_t k = 0; k < n_rows; ++k) {
      for (std::int32_t j = 0; j < size; ++j) amplitude[k * m + begin + j] = sum[k][j] * scale[j];
    }
  }
}

/// Nodes near the touched one, which have modes of their own. Prepared or not, the order of the products is the same.
PHN_INLINE void near_nodes(const ModalTables& tables, std::int32_t components, const PreparedNode* prepared,
                           const double* amplitude, double* field) {
  const std::int32_t n = components * tables.n_near;
  constexpr std::int32_t at_once = 12;
  for (std::int32_t begin = 0; begin < n; begin += at_once) {
    const std::int32_t size = n - begin < at_once ? n - begin : at_once;
    double sum[at_once] = {};
    if (prepared != nullptr && size == at_once) {
      for (std::int32_t j = 0; j < tables.n_modes; ++j) {
        const double* row = prepared->near_mode + static_cast<std::size_t>(j) * static_cast<std::size_t>(n) + begin;
        for (std::int32_t i = 0; i < at_once; ++i) sum[i] += row[i] * amplitude[j];
      }
    } else {
      for (std::int32_t i = 0; i < size; ++i)
        sum[i] = row_times(tables.near_mode, tables.n_columns, tables.near_mode_scale,
                           static_cast<std::size_t>(begin + i), tables.n_modes, amplitude);
    }
    for (std::int32_t i = 0; i < size; ++i)
      field[components * tables.near[(begin + i) / components] + i % components] = sum[i];
  }
}

PHN_INLINE void sum_field(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,
                          const double* amplitude, double* scratch, double* field) {
  const std::int32_t m = tables.n_modes;
  auto* amount = reinterpret_cast<float*>(scratch);
  if (prepared != nullptr) {
    for (std::int32_t j = 0; j < m; ++j) amount[j] = static_cast<float>(amplitude[j]);
    sum_modes(m, tables.n_columns, shared.n_rows, prepared->modes, amount, field);
  } else {
    for (std::int32_t s = 0; s < shared.n_modes; ++s)
      amount[s] = static_cast<float>(
          row_times(tables.mixing, tables.n_columns, tables.mixing_scale, static_cast<std::size_t>(s), m, amplitude));
    sum_modes(shared.n_modes, shared.n_modes, shared.n_rows, shared.modes, amount, field);
  }
  // Compilers divide faster by constants; at_once is a multiple of both.
  if (shared.components == 3) return near_nodes(tables, 3, prepared, amplitude, field);
  near_nodes(tables, 1, prepared, amplitude, field);
}

/// Product of shared modes and mixing for one block of rows.
PHN_INLINE void mix_block(const SharedTable& shared, const ModalTables& tables, const float* block, float* out) {
  for (std::int32_t j = 0; j < tables.n_modes; ++j, out += rows_per_block) {
    float sum[rows_per_block] = {};
    const auto scale = static_cast<float>(tables.mixing_scale[j]);
    const std::int16_t* mixing = tables.mixing + j;
    const float* mode = block;
    for (std::int32_t s = 0; s < shared.n_modes; ++s, mode += rows_per_block, mixing += tables.n_modes) {
      const auto factor = static_cast<float>(*mixing);
      for (std::int32_t i = 0; i < rows_per_block; ++i) sum[i] += factor * mode[i];
    }
    for (std::int32_t i = 0; i < rows_per_block; ++i) out[i] = scale * sum[i];
  }
}

/// @param table  6 whole_blocks(n_centers + 1), as ForceTable::centers
void fill_force_table(const Conservative<double>& net, Real* table) {
  const std::int32_t n = net.n_centers, n_whole = whole_blocks(n + 1);
  for (int k = 0; k < 3; ++k) {
    Real *center = table + k * n_whole, *coefficient = table + (3 + k) * n_whole;
    for (std::int32_t i = 0; i < n_whole; ++i) {
      const std::size_t at = 3 * static_cast<std::size_t>(i) + k;
      center[i] = coefficient[i] = 0;
      if (i >= n) continue;
      center[i] = static_cast<Real>(net.displacements[3 * static_cast<std::size_t>(net.center[i]) + k]);
      coefficient[i] =
          net.short_coefficient ? static_cast<Real>(net.short_coefficient[at]) : static_cast<Real>(net.coefficient[at]);
    }
    coefficient[n] = static_cast<Real>(-net.total[k]);
  }
}

/// The terms of a force in whole blocks: centers, then coefficients.
struct ForceTerms {
  const Real *center[3], *coefficient[3];
  std::int32_t n;  ///< with the center at 0
};

/// @param few  for the terms of a node that has no table
PHN_INLINE ForceTerms terms_of(const Conservative<double>& net, const ForceTable& table,
                               Real (&few)[6 * (most_gathered + 1)]) {
  const Real* from = table.centers;
  if (from == nullptr) {
    fill_force_table(net, few);
    from = few;
  }
  const std::int32_t n_whole = whole_blocks(net.n_centers + 1);
  return {{from, from + n_whole, from + 2 * n_whole},
          {from + 3 * n_whole, from + 4 * n_whole, from + 5 * n_whole},
          net.n_centers + 1};
}

/// force = K d + total + at_rest
PHN_INLINE void finish_force(const Conservative<double>& net, const double* x, const double* total,
                             const double* at_rest, double* force) {
  const double d[3] = {net.max_displacement * x[0], net.max_displacement * x[1], net.max_displacement * x[2]};
  multiply_symmetric(net.stiffness, d, force);
  for (int k = 0; k < 3; ++k) force[k] += total[k] + at_rest[k];
}

PHN_INLINE double finish_energy(const Conservative<double>& net, const double* x, double total) {
  const double d[3] = {net.max_displacement * x[0], net.max_displacement * x[1], net.max_displacement * x[2]};
  double kd[3];
  multiply_symmetric(net.stiffness, d, kd);
  return dot(d, kd) / 2 + net.max_displacement * ((total + net.energy_at_rest) + dot(net.force_at_rest, x));
}

/// Rows of the sums from which force, stiffness and energy are made.
constexpr std::int32_t stiffness_row = 3, along_row = 9;
constexpr std::int32_t n_sums(bool with_stiffness, bool with_energy) {
  return 3 + (with_stiffness ? 7 : 0) + (with_energy ? 1 : 0);
}

/// @param total  of sum_derivatives
PHN_INLINE void finish_stiffness(const Conservative<double>& net, const double* total, double* stiffness) {
  const double* sum = total + stiffness_row;
  const double along = total[along_row], by = 1 / net.max_displacement;
  const double xx = net.stiffness[0] + by * (sum[0] + along), xy = net.stiffness[1] + by * sum[1],
               xz = net.stiffness[2] + by * sum[2], yy = net.stiffness[3] + by * (sum[3] + along),
               yz = net.stiffness[4] + by * sum[4], zz = net.stiffness[5] + by * (sum[5] + along);
  const double rows[9] = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
  for (int k = 0; k < 9; ++k) stiffness[k] = rows[k];
}

PHN_INLINE void force_of_centers(const Conservative<double>& net, const ForceTable& table, const double* x,
                                 double* force) {
  const Real shape = static_cast<Real>(net.shape), s2 = shape * shape;
  const Real x0 = static_cast<Real>(x[0]), x1 = static_cast<Real>(x[1]), x2 = static_cast<Real>(x[2]);
  Real few[6 * (most_gathered + 1)];
  const ForceTerms terms = terms_of(net, table, few);
  const Real *c0 = terms.center[0], *c1 = terms.center[1], *c2 = terms.center[2], *w0 = terms.coefficient[0],
             *w1 = terms.coefficient[1], *w2 = terms.coefficient[2];
  Real sum[3][at_once] = {};
  for (std::int32_t begin = 0; begin < terms.n; begin += at_once) {
    for (std::int32_t i = 0; i < at_once; ++i) {
      const std::int32_t j = begin + i;
      const Real y0 = x0 - c0[j], y1 = x1 - c1[j], y2 = x2 - c2[j], b0 = w0[j], b1 = w1[j], b2 = w2[j];
      const Real q = square_root(y0 * y0 + y1 * y1 + y2 * y2 + s2), along = (y0 * b0 + y1 * b1 + y2 * b2) / q;
      sum[0][i] += q * b0 + along * y0;
      sum[1][i] += q * b1 + along * y1;
      sum[2][i] += q * b2 + along * y2;
    }
  }
  double total[3];
  add_up(sum, total);
  finish_force(net, x, total, table.at_rest, force);
}

/// Adds the terms of all centers: the force as force_of_centers, in its order, and of the same square roots and
/// quotients stiffness and energy. With q^2 = |y|^2 + shape^2, a = y . b / q, p = q b - a y the stiffness is the sum of
///   (p y^T + y (q b)^T) / q^2 + a I
/// @param lanes  of a register: each lane has a sum of its own, so that the sums do not depend on it
template <std::int32_t lanes, bool with_stiffness, bool with_energy>
PHN_INLINE void sum_derivatives(const ForceTerms& terms, const Real* x, Real s2,
                                Real (&sums)[n_sums(with_stiffness, with_energy)][at_once]) {
  constexpr std::int32_t n = n_sums(with_stiffness, with_energy);
  const Real *c0 = terms.center[0], *c1 = terms.center[1], *c2 = terms.center[2], *w0 = terms.coefficient[0],
             *w1 = terms.coefficient[1], *w2 = terms.coefficient[2];
  const Real x0 = x[0], x1 = x[1], x2 = x[2];
  Real zero = 0;
  PHN_HIDE(zero);
  for (std::int32_t first = 0; first < at_once; first += lanes) {
    Real sum[n][lanes];
    for (std::int32_t k = 0; k < n; ++k) {
      for (std::int32_t i = 0; i < lanes; ++i) sum[k][i] = zero;
    }
    for (std::int32_t begin = 0; begin < terms.n; begin += at_once) {
      for (std::int32_t i = 0; i < lanes; ++i) {
        const std::int32_t j = begin + first + i;
        const Real y0 = x0 - c0[j], y1 = x1 - c1[j], y2 = x2 - c2[j], b0 = w0[j], b1 = w1[j], b2 = w2[j];
        const Real square = y0 * y0 + y1 * y1 + y2 * y2 + s2, q = square_root(square);
        const Real product = y0 * b0 + y1 * b1 + y2 * b2, along = product / q;
        const Real t0 = q * b0, t1 = q * b1, t2 = q * b2, a0 = along * y0, a1 = along * y1, a2 = along * y2;
        sum[0][i] += t0 + a0;
        sum[1][i] += t1 + a1;
        sum[2][i] += t2 + a2;
        if constexpr (with_energy) sum[n - 1][i] += q * product;
        if constexpr (with_stiffness) {
          const Real inverse = 1 / square, g0 = y0 * inverse, g1 = y1 * inverse, g2 = y2 * inverse;
          const Real p0 = t0 - a0, p1 = t1 - a1, p2 = t2 - a2;
          sum[stiffness_row][i] += (p0 + t0) * g0;
          sum[stiffness_row + 1][i] += p0 * g1 + t1 * g0;
          sum[stiffness_row + 2][i] += p0 * g2 + t2 * g0;
          sum[stiffness_row + 3][i] += (p1 + t1) * g1;
          sum[stiffness_row + 4][i] += p1 * g2 + t2 * g1;
          sum[stiffness_row + 5][i] += (p2 + t2) * g2;
          sum[along_row][i] += along;
        }
      }
    }
    for (std::int32_t k = 0; k < n; ++k) {
      for (std::int32_t i = 0; i < lanes; ++i) sums[k][first + i] = sum[k][i];
    }
  }
}

/// The energy in double, also where forces are in float: an energy in float would have steps.
template <std::int32_t lanes>
PHN_INLINE double energy_of_centers(const Conservative<double>& net, const ForceTable& table, const double* x) {
  Real few[6 * (most_gathered + 1)];
  const ForceTerms terms = terms_of(net, table, few);
  const Real *c0 = terms.center[0], *c1 = terms.center[1], *c2 = terms.center[2], *w0 = terms.coefficient[0],
             *w1 = terms.coefficient[1], *w2 = terms.coefficient[2];
  const double x0 = x[0], x1 = x[1], x2 = x[2], s2 = net.shape * net.shape;
  double sums[1][at_once], total;
  for (std::int32_t first = 0; first < at_once; first += lanes) {
    double sum[lanes] = {};
    for (std::int32_t begin = 0; begin < terms.n; begin += at_once) {
      for (std::int32_t i = 0; i < lanes; ++i) {
        const std::int32_t j = begin + first + i;
        const double y0 = x0 - static_cast<double>(c0[j]), y1 = x1 - static_cast<double>(c1[j]),
                     y2 = x2 - static_cast<double>(c2[j]);
        const double product =
            y0 * static_cast<double>(w0[j]) + y1 * static_cast<double>(w1[j]) + y2 * static_cast<double>(w2[j]);
        sum[i] += square_root(y0 * y0 + y1 * y1 + y2 * y2 + s2) * product;
      }
    }
    for (std::int32_t i = 0; i < lanes; ++i) sums[0][first + i] = sum[i];
  }
  add_up_many(sums, &total);
  return finish_energy(net, x, total);
}

template <std::int32_t lanes, bool with_stiffness, bool with_energy>
PHN_INLINE void derivatives_of_centers(const Conservative<double>& net, const ForceTable& table, const double* x,
                                       double* force, double* energy, double* stiffness) {
  const Real shape = static_cast<Real>(net.shape);
  const Real at[3] = {static_cast<Real>(x[0]), static_cast<Real>(x[1]), static_cast<Real>(x[2])};
  constexpr std::int32_t n = n_sums(with_stiffness, with_energy);
  Real few[6 * (most_gathered + 1)], sums[n][at_once];
  double total[n];
  sum_derivatives<lanes, with_stiffness, with_energy>(terms_of(net, table, few), at, shape * shape, sums);
  add_up_many(sums, total);
  finish_force(net, x, total, table.at_rest, force);
  if constexpr (with_energy) *energy = finish_energy(net, x, total[n - 1]);
  if constexpr (with_stiffness) finish_stiffness(net, total, stiffness);
}

/// @param energy, stiffness  may be null
template <std::int32_t bytes>
PHN_INLINE void evaluate_centers(const Conservative<double>& net, const ForceTable& table, const double* x,
                                 double* force, double* energy, double* stiffness) {
  constexpr auto lanes = bytes / static_cast<std::int32_t>(sizeof(Real));
  if constexpr (sizeof(Real) == sizeof(double)) {
    if (energy != nullptr && stiffness != nullptr)
      return derivatives_of_centers<lanes, true, true>(net, table, x, force, energy, stiffness);
    if (energy != nullptr)
      return derivatives_of_centers<at_once, false, true>(net, table, x, force, energy, nullptr);
  } else if (energy != nullptr) {
    *energy = energy_of_centers<at_once>(net, table, x);
  }
  if (stiffness == nullptr) return force_of_centers(net, table, x, force);
  derivatives_of_centers<lanes, true, false>(net, table, x, force, nullptr, stiffness);
}

/// Instantiates all functions above for each instruction set.
#define PHN_KERNELS(name, attributes, bytes)                                                                           \
  namespace name {                                                                                                     \
  attributes void force(const Conservative<double>& net, const ForceTable& table, const double* x, double* sum) {      \
    force_of_centers(net, table, x, sum);                                                                              \
  }                                                                                                                    \
  attributes double energy(const Conservative<double>& net, const ForceTable& table, const double* x) {                \
    return energy_of_centers<at_once>(net, table, x);                        \
  }                                                                                                                    \
  attributes void evaluate(const Conservative<double>& net, const ForceTable& table, const double* x, double* force,   \
                           double* energy, double* stiffness) {                                                        \
    evaluate_centers<bytes>(net, table, x, force, energy, stiffness);                                                  \
  }                                                                                                                    \
  attributes void basis(const SharedModes& shared, const double* x, double* values) { fill_basis(shared, x, values); } \
  attributes void basis_gradient(const SharedModes& shared, const double* x, double* values) {                         \
    fill_basis_gradient(shared, x, values);                                                                            \
  }                                                                                                                    \
  attributes void amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* values,                    \
                             double* amplitude) {                                                                      \
    sum_amplitudes<1>(tables, n_basis, values, amplitude);                                                             \
  }                                                                                                                    \
  attributes void three_amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* values,              \
                                   double* amplitude) {                                                                \
    sum_amplitudes<3>(tables, n_basis, values, amplitude);                                                             \
  }                                                                                                                    \
  attributes void field(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,            \
                        const double* amplitude, double* scratch, double* values) {                                    \
    sum_field(shared, tables, prepared, amplitude, scratch, values);                                                   \
  }                                                                                                                    \
  attributes void sum_block(const SharedTable& shared, const ModalTables& tables, const float* block, float* out) {    \
    mix_block(shared, tables, block, out);                                                                             \
  }                                                                                                                    \
  constexpr ModalKernels kernels = {#name,          force,      evaluate,         energy, basis,                       \
                                    basis_gradient, amplitudes, three_amplitudes, field,  sum_block};                  \
  }

PHN_KERNELS(any, , 16)
#ifdef PHN_X86_64
PHN_KERNELS(avx2, __attribute__((target("avx2"))), 32)
PHN_KERNELS(avx512, __attribute__((target("avx512f"))), 64)
#endif

}  // namespace

void set_rest(Conservative<double>& net, ForceTable& table, Real* centers) {
  const double rest[3] = {0, 0, 0};
  double force[3];
  for (double& f : table.at_rest) f = 0;
  set_rest(net);
  if (centers != nullptr) fill_force_table(net, centers);
  // The functions that later add these values also compute them, so that the results at rest are exactly 0.
  const ModalKernels& kernels = best_modal_kernels();
  kernels.force(net, table, rest, force);
  for (int k = 0; k < 3; ++k) table.at_rest[k] = -force[k];
  Real few[6 * (most_gathered + 1)];
  const ForceTerms terms = terms_of(net, table, few);
  const double s2 = net.shape * net.shape;
  for (int k = 0; k < 3; ++k) net.force_at_rest[k] = 0;
  for (std::int32_t i = 0; i < terms.n; ++i) {
    double c[3], b[3];
    for (int k = 0; k < 3; ++k) {
      c[k] = static_cast<double>(terms.center[k][i]);
      b[k] = static_cast<double>(terms.coefficient[k][i]);
    }
    const double q = square_root(dot(c, c) + s2), along = dot(c, b) / q;
    for (int k = 0; k < 3; ++k) net.force_at_rest[k] -= q * b[k] + along * c[k];
  }
  net.energy_at_rest = 0;
  Conservative<double> unit = net;
  unit.max_displacement = 1;
  net.energy_at_rest = -kernels.energy(unit, table, rest);
}

const ModalKernels* modal_kernels(int set) {
#ifdef PHN_X86_64
  if (set == 1) return __builtin_cpu_supports("avx2") ? &avx2::kernels : nullptr;
  if (set == 2) return __builtin_cpu_supports("avx512f") ? &avx512::kernels : nullptr;
#endif
  return set == 0 ? &any::kernels : nullptr;
}

const ModalKernels& best_modal_kernels() {
  for (int set = n_instruction_sets - 1; set > 0; --set) {
    if (const ModalKernels* kernels = modal_kernels(set)) return *kernels;
  }
  return any::kernels;
}

}  // namespace PHN_RUNTIME
