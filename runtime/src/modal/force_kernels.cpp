#include "modal/force_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

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
  const std::int32_t n_centers = net.n_centers;
  for (std::int32_t begin = 0; begin <= n_centers; begin += at_once) {
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
/// @param lanes  which are summed at once: each lane has a sum of its own, so that the sums do not depend on it
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
PHN_INLINE double energy_of_centers(const Conservative<double>& net, const ForceTable& table, const double* x) {
  Real few[6 * (most_gathered + 1)];
  const ForceTerms terms = terms_of(net, table, few);
  const Real *c0 = terms.center[0], *c1 = terms.center[1], *c2 = terms.center[2], *w0 = terms.coefficient[0],
             *w1 = terms.coefficient[1], *w2 = terms.coefficient[2];
  const double x0 = x[0], x1 = x[1], x2 = x[2], s2 = net.shape * net.shape;
  double sums[1][at_once] = {}, total;
  for (std::int32_t begin = 0; begin < terms.n; begin += at_once) {
    for (std::int32_t i = 0; i < at_once; ++i) {
      const std::int32_t j = begin + i;
      const double y0 = x0 - static_cast<double>(c0[j]), y1 = x1 - static_cast<double>(c1[j]),
                   y2 = x2 - static_cast<double>(c2[j]);
      const double product =
          y0 * static_cast<double>(w0[j]) + y1 * static_cast<double>(w1[j]) + y2 * static_cast<double>(w2[j]);
      sums[0][i] += square_root(y0 * y0 + y1 * y1 + y2 * y2 + s2) * product;
    }
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

/// How many sums of stiffnesses stay in registers of so many bytes. GCC takes the loops over fewer lanes than a block
/// as operations of whole registers; other compilers may not.
[[maybe_unused]] constexpr std::int32_t lanes_of([[maybe_unused]] std::int32_t bytes) {
#if defined(__GNUC__) && !defined(__clang__)
  return bytes / static_cast<std::int32_t>(sizeof(Real));
#else
  return at_once;
#endif
}

/// Code that is optimized for size has one function for stiffness with and without energy. The results have the same
/// bits.
#ifdef __OPTIMIZE_SIZE__
constexpr bool small_code = true;
#else
constexpr bool small_code = false;
#endif

/// Instantiates all functions above for each instruction set.
/// @param lanes  of the sums that are kept in registers; with few registers all sums are kept in memory
#define PHN_KERNELS(name, attributes, lanes)                                                                          \
  namespace name {                                                                                                    \
  attributes void force(const Conservative<double>& net, const ForceTable& table, const double* x, double* sum) {     \
    force_of_centers(net, table, x, sum);                                                                             \
  }                                                                                                                   \
  attributes double energy(const Conservative<double>& net, const ForceTable& table, const double* x) {               \
    return energy_of_centers(net, table, x);                                                                          \
  }                                                                                                                   \
  template <bool with_stiffness, bool with_energy>                                                                    \
  attributes void derivatives(const Conservative<double>& net, const ForceTable& table, const double* x, double* sum, \
                              double* work, double* stiffness) {                                                      \
    if constexpr (with_energy && !energy_in_pass) {                                                                   \
      *work = energy(net, table, x);                                                                                  \
      if constexpr (with_stiffness) return derivatives<true, false>(net, table, x, sum, nullptr, stiffness);          \
      return force(net, table, x, sum);                                                                               \
    } else {                                                                                                          \
      derivatives_of_centers<with_stiffness ? lanes : at_once, with_stiffness, with_energy>(net, table, x, sum, work, \
                                                                                            stiffness);               \
    }                                                                                                                 \
  }                                                                                                                   \
  constexpr ForceKernels kernels = {#name,                                                                            \
                                    force,                                                                            \
                                    energy,                                                                           \
                                    derivatives<false, true>,                                                         \
                                    small_code ? derivatives<true, true> : derivatives<true, false>,                  \
                                    derivatives<true, true>};                                                         \
  }

PHN_KERNELS(any, , at_once)
#ifdef PHN_X86_64
PHN_KERNELS(avx2, __attribute__((target("avx2"))), lanes_of(32))
PHN_KERNELS(avx512, __attribute__((target("avx512f"))), lanes_of(64))
#endif

}  // namespace

const ForceKernels* force_kernels(int set) {
#ifdef PHN_X86_64
  if (set == 1) return __builtin_cpu_supports("avx2") ? &avx2::kernels : nullptr;
  if (set == 2) return __builtin_cpu_supports("avx512f") ? &avx512::kernels : nullptr;
#endif
  return set == 0 ? &any::kernels : nullptr;
}

const ForceKernels& best_force_kernels() {
  for (int set = n_instruction_sets - 1; set > 0; --set) {
    if (const ForceKernels* kernels = force_kernels(set)) return *kernels;
  }
  return any::kernels;
}

void set_rest(Conservative<double>& net, ForceTable& table, Real* centers) {
  const double rest[3] = {0, 0, 0};
  double force[3];
  for (double& f : table.at_rest) f = 0;
  set_rest(net);
  if (centers != nullptr) fill_force_table(net, centers);
  // The functions that later add these values also compute them, so that the results at rest are exactly 0.
  const ForceKernels& kernels = best_force_kernels();
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

}  // namespace PHN_RUNTIME
