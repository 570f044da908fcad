#include "core/kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// The terms of a force in whole blocks: centers, then coefficients.
struct ForceTerms {
  const double *center[3], *coefficient[3];
  std::int32_t n;  ///< with the center at 0
};

PHN_INLINE ForceTerms terms_of(const ModalForce& node) {
  const double* from = node.table;
  const std::int32_t n_whole = whole_blocks(node.n_centers + 1);
  return {{from, from + n_whole, from + 2 * n_whole},
          {from + 3 * n_whole, from + 4 * n_whole, from + 5 * n_whole},
          node.n_centers + 1};
}

/// force = K d + total + force_at_rest
PHN_INLINE void finish_force(const ModalForce& node, const double* x, const double* total, double* force) {
  const double d[3] = {node.max_displacement * x[0], node.max_displacement * x[1], node.max_displacement * x[2]};
  multiply_symmetric(node.stiffness, d, force);
  for (int k = 0; k < 3; ++k) force[k] += total[k] + node.force_at_rest[k];
}

PHN_INLINE double finish_energy(const ModalForce& node, const double* x, double total) {
  const double d[3] = {node.max_displacement * x[0], node.max_displacement * x[1], node.max_displacement * x[2]};
  double kd[3];
  multiply_symmetric(node.stiffness, d, kd);
  return dot(d, kd) / 2 + node.max_displacement * ((total + node.energy_at_rest) + dot(node.slope_at_rest, x));
}

/// Rows of the sums from which force, stiffness and energy are made.
constexpr std::int32_t stiffness_row = 3, along_row = 9;
constexpr std::int32_t n_sums(bool with_stiffness, bool with_energy) {
  return 3 + (with_stiffness ? 7 : 0) + (with_energy ? 1 : 0);
}

/// @param total  of sum_derivatives
PHN_INLINE void finish_stiffness(const ModalForce& node, const double* total, double* stiffness) {
  const double* sum = total + stiffness_row;
  const double along = total[along_row], by = 1 / node.max_displacement;
  const double xx = node.stiffness[0] + by * (sum[0] + along), xy = node.stiffness[1] + by * sum[1],
               xz = node.stiffness[2] + by * sum[2], yy = node.stiffness[3] + by * (sum[3] + along),
               yz = node.stiffness[4] + by * sum[4], zz = node.stiffness[5] + by * (sum[5] + along);
  const double rows[9] = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
  for (int k = 0; k < 9; ++k) stiffness[k] = rows[k];
}

/// Adds the terms of all centers: the force and, of the same square roots and quotients, stiffness and energy. With q^2
/// = |y|^2 + shape^2, a = y . b / q, p = q b - a y the stiffness is the sum of
///   (p y^T + y (q b)^T) / q^2 + a I
/// @param lanes  which are summed at once: each lane has a sum of its own, so that the sums do not depend on it
template <std::int32_t lanes, bool with_stiffness, bool with_energy>
PHN_INLINE void sum_derivatives(const ForceTerms& terms, const double* x, double s2,
                                double (&sums)[n_sums(with_stiffness, with_energy)][block_size]) {
  constexpr std::int32_t n = n_sums(with_stiffness, with_energy);
  const double *c0 = terms.center[0], *c1 = terms.center[1], *c2 = terms.center[2], *w0 = terms.coefficient[0],
               *w1 = terms.coefficient[1], *w2 = terms.coefficient[2];
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  double zero = 0;
  PHN_HIDE(zero);
  for (std::int32_t first = 0; first < block_size; first += lanes) {
    double sum[n][lanes];
    for (std::int32_t k = 0; k < n; ++k)
      for (std::int32_t i = 0; i < lanes; ++i) sum[k][i] = zero;
    for (std::int32_t begin = 0; begin < terms.n; begin += block_size)
      for (std::int32_t i = 0; i < lanes; ++i) {
        const std::int32_t j = begin + first + i;
        const double y0 = x0 - c0[j], y1 = x1 - c1[j], y2 = x2 - c2[j], b0 = w0[j], b1 = w1[j], b2 = w2[j];
        const double square = y0 * y0 + y1 * y1 + y2 * y2 + s2, q = square_root(square);
        const double product = y0 * b0 + y1 * b1 + y2 * b2, along = product / q;
        const double t0 = q * b0, t1 = q * b1, t2 = q * b2, a0 = along * y0, a1 = along * y1, a2 = along * y2;
        sum[0][i] += t0 + a0;
        sum[1][i] += t1 + a1;
        sum[2][i] += t2 + a2;
        if constexpr (with_energy) sum[n - 1][i] += q * product;
        if constexpr (with_stiffness) {
          const double inverse = 1 / square, g0 = y0 * inverse, g1 = y1 * inverse, g2 = y2 * inverse;
          const double p0 = t0 - a0, p1 = t1 - a1, p2 = t2 - a2;
          sum[stiffness_row][i] += (p0 + t0) * g0;
          sum[stiffness_row + 1][i] += p0 * g1 + t1 * g0;
          sum[stiffness_row + 2][i] += p0 * g2 + t2 * g0;
          sum[stiffness_row + 3][i] += (p1 + t1) * g1;
          sum[stiffness_row + 4][i] += p1 * g2 + t2 * g1;
          sum[stiffness_row + 5][i] += (p2 + t2) * g2;
          sum[along_row][i] += along;
        }
      }
    for (std::int32_t k = 0; k < n; ++k)
      for (std::int32_t i = 0; i < lanes; ++i) sums[k][first + i] = sum[k][i];
  }
}

template <std::int32_t lanes, bool with_stiffness, bool with_energy>
PHN_INLINE void derivatives_of_centers(const ModalForce& node, const double* x, double* force, double* energy,
                                       double* stiffness) {
  constexpr std::int32_t n = n_sums(with_stiffness, with_energy);
  double sums[n][block_size];
  double total[n];
  sum_derivatives<lanes, with_stiffness, with_energy>(terms_of(node), x, node.shape * node.shape, sums);
  add_up_many(sums, total);
  finish_force(node, x, total, force);
  if constexpr (with_energy) *energy = finish_energy(node, x, total[n - 1]);
  if constexpr (with_stiffness) finish_stiffness(node, total, stiffness);
}

/// Number of sums of stiffnesses that stay in registers of this size. GCC takes the loops over fewer lanes than a block
/// as operations of whole registers; other compilers may not.
constexpr std::int32_t lanes_of([[maybe_unused]] std::int32_t bytes) {
#if defined(__GNUC__) && !defined(__clang__)
  return bytes > 0 ? bytes / static_cast<std::int32_t>(sizeof(double)) : block_size;
#else
  return block_size;
#endif
}

/// Code that is optimized for size has one function for stiffness with and without energy. The results have the same
/// bits.
#ifdef __OPTIMIZE_SIZE__
constexpr bool small_code = true;
#else
constexpr bool small_code = false;
#endif

/// @param bytes  of a register that keeps sums; with few registers all sums are kept in memory
#define PHN_FORCE_KERNELS(name, bytes, attributes)                                                                     \
  namespace name {                                                                                                     \
  template <bool with_stiffness, bool with_energy>                                                                     \
  attributes void derivatives(const ModalForce& node, const double* x, double* sum, double* work, double* stiffness) { \
    constexpr std::int32_t lanes = with_stiffness ? lanes_of(bytes) : block_size;                                      \
    derivatives_of_centers<lanes, with_stiffness, with_energy>(node, x, sum, work, stiffness);                         \
  }                                                                                                                    \
  constexpr ForceKernels kernels = {#name, derivatives<false, false>, derivatives<false, true>,                        \
                                    small_code ? derivatives<true, true> : derivatives<true, false>,                   \
                                    derivatives<true, true>};                                                          \
  }

PHN_FOR_EACH_SET(PHN_FORCE_KERNELS, ForceKernels)

}  // namespace

const ForceKernels* force_kernels(int set) { return kernels_for(kernels_of_sets, set); }
const ForceKernels& best_force_kernels() { return best_of(kernels_of_sets); }

void set_rest(ModalForce& node, double* table) {
  const double rest[3] = {0, 0, 0};
  double force[3];
  for (int k = 0; k < 3; ++k) {
    node.force_at_rest[k] = node.slope_at_rest[k] = 0;
    double *coefficient = table + (3 + k) * whole_blocks(node.n_centers + 1), total = 0;
    for (std::int32_t i = 0; i < node.n_centers; ++i) total += coefficient[i];
    coefficient[node.n_centers] = -total;
  }
  // The functions that later add these values also compute them, so that the results at rest are exactly 0.
  const ForceKernels& kernels = best_force_kernels();
  kernels.force(node, rest, force, nullptr, nullptr);
  for (int k = 0; k < 3; ++k) node.force_at_rest[k] = -force[k];
  const ForceTerms terms = terms_of(node);
  const double s2 = node.shape * node.shape;
  for (std::int32_t i = 0; i < terms.n; ++i) {
    double c[3], b[3];
    for (int k = 0; k < 3; ++k) {
      c[k] = terms.center[k][i];
      b[k] = terms.coefficient[k][i];
    }
    const double q = square_root(dot(c, c) + s2), along = dot(c, b) / q;
    for (int k = 0; k < 3; ++k) node.slope_at_rest[k] -= q * b[k] + along * c[k];
  }
  node.energy_at_rest = 0;
  ModalForce unit = node;
  unit.max_displacement = 1;
  double energy = 0;
  kernels.with_energy(unit, rest, force, &energy, nullptr);
  node.energy_at_rest = -energy;
}

}  // namespace PHN_RUNTIME
