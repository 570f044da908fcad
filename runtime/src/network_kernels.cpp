#include "network_kernels.hpp"

#include "exponential.hpp"

namespace phynness::runtime {
namespace {

/// Neurons at a time, whatever the width of registers: sums are the same everywhere.
constexpr std::int32_t at_once = 16;

PHN_INLINE std::int32_t smaller(std::int32_t a, std::int32_t b) { return a < b ? a : b; }

/// Some neurons in a row, or copies of the last ones filled up with zeros.
struct Neurons {
  const double *center[3], *weight[3];
  double copy[6][at_once];

  PHN_INLINE void take(const Network& net, int first_input, std::int32_t begin, bool weights) {
    const std::int32_t size = smaller(at_once, net.n_neurons - begin);
    for (int k = 0; k < 3; ++k) {
      center[k] = net.center[first_input + k] + begin;
      weight[k] = net.weight[k] + begin;
      if (size == at_once) continue;
      for (std::int32_t i = 0; i < at_once; ++i) {
        copy[k][i] = i < size ? center[k][i] : 0;
        copy[3 + k][i] = weights && i < size ? weight[k][i] : 0;
      }
      center[k] = copy[k];
      weight[k] = copy[3 + k];
    }
  }
};

PHN_INLINE void scale_inputs(const Network& net, int first, const double* value, double* x) {
  for (int k = 0; k < 3; ++k) x[k] = (value[k] - net.input_center[first + k]) / net.input_half_range[first + k];
}

/// @param h  at_once
PHN_INLINE void gaussians(const Neurons& neurons, const double* x, double inverse_square_spread, double* h) {
  for (std::int32_t i = 0; i < at_once; ++i) {
    const double t0 = x[0] - neurons.center[0][i], t1 = x[1] - neurons.center[1][i], t2 = x[2] - neurons.center[2][i];
    h[i] = exp_of_negative(-((t0 * t0 + t1 * t1 + t2 * t2) * inverse_square_spread));
  }
}

PHN_INLINE void force_of(const Network& net, const double* d, double* force) {
  double x[3], h[at_once], sum[3][at_once] = {};
  scale_inputs(net, 0, d, x);
  Neurons neurons;
  for (std::int32_t begin = 0; begin < net.n_neurons; begin += at_once) {
    neurons.take(net, 0, begin, true);
    gaussians(neurons, x, net.inverse_square_spread, h);
    for (int k = 0; k < 3; ++k) {
      for (std::int32_t i = 0; i < at_once; ++i) sum[k][i] += neurons.weight[k][i] * h[i];
    }
  }
  for (int k = 0; k < 3; ++k) {
    for (std::int32_t half = at_once / 2; half > 0; half /= 2) {
      for (std::int32_t i = 0; i < half; ++i) sum[k][i] += sum[k][i + half];
    }
    force[k] = net.output_center[k] + net.output_half_range[k] * (net.bias[k] + sum[k][0]);
  }
}

PHN_INLINE void gaussians_of_displacement(const Network& net, const double* d, double* out) {
  double x[3], h[at_once];
  scale_inputs(net, 0, d, x);
  Neurons neurons;
  for (std::int32_t begin = 0; begin < net.n_neurons; begin += at_once) {
    neurons.take(net, 0, begin, false);
    gaussians(neurons, x, net.inverse_square_spread, h);
    const std::int32_t size = smaller(at_once, net.n_neurons - begin);
    for (std::int32_t i = 0; i < size; ++i) out[begin + i] = h[i];
  }
}

PHN_INLINE void gaussians_of_coordinates(const Network& net, std::int32_t n_output, const double* points,
                                         double* table) {
  const double spread = net.inverse_square_spread;
  for (std::int32_t begin = 0; begin < n_output; begin += nodes_per_block) {
    double x[3][nodes_per_block];
    for (std::int32_t o = 0; o < nodes_per_block; ++o) {
      double one[3];
      scale_inputs(net, 3, points + 3 * smaller(begin + o, n_output - 1), one);
      for (int k = 0; k < 3; ++k) x[k][o] = one[k];
    }
    for (std::int32_t i = 0; i < net.n_neurons; ++i, table += nodes_per_block) {
      const double c0 = net.center[3][i], c1 = net.center[4][i], c2 = net.center[5][i];
      for (std::int32_t o = 0; o < nodes_per_block; ++o) {
        const double t0 = x[0][o] - c0, t1 = x[1][o] - c1, t2 = x[2][o] - c2;
        table[o] = exp_of_negative(-((t0 * t0 + t1 * t1 + t2 * t2) * spread));
      }
    }
  }
}

/// @tparam by_nodes  hide from the compiler where the next neuron's row lies: GCC 12 puts neurons into registers of
/// AVX-512 otherwise, and takes four times as long
template <bool by_nodes>
PHN_INLINE void field_of_table(const Network& net, std::int32_t n_output, const double* table, const double* factor,
                               double share, double* scratch, double* field) {
  const std::int32_t n = net.n_neurons;
  double constant[3], range[3];
  for (int k = 0; k < 3; ++k) {
    constant[k] = share * (net.output_center[k] + net.output_half_range[k] * net.bias[k]);
    range[k] = net.output_half_range[k];
  }
  const std::size_t rest = static_cast<std::size_t>(net.n_prepared - n) * nodes_per_block;
  double* __restrict amount = scratch;
  for (std::int32_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) amount[3 * i + k] = range[k] * net.weight[k][i] * factor[i];
  }
  for (std::int32_t begin = 0; begin < n_output; begin += nodes_per_block) {
    double sum[3][nodes_per_block];
    for (int k = 0; k < 3; ++k) {
      for (std::int32_t o = 0; o < nodes_per_block; ++o) sum[k][o] = constant[k];
    }
    for (std::int32_t i = 0; i < n; ++i, table += nodes_per_block) {
#ifdef PHN_X86_64
      if constexpr (by_nodes) __asm__("" : "+r"(table));
#endif
      for (int k = 0; k < 3; ++k) {
        const double a = amount[3 * i + k];
        for (std::int32_t o = 0; o < nodes_per_block; ++o) sum[k][o] += a * table[o];
      }
    }
    table += rest;
    const std::int32_t size = smaller(nodes_per_block, n_output - begin);
    for (std::int32_t o = 0; o < size; ++o) {
      for (int k = 0; k < 3; ++k) field[3 * (begin + o) + k] = sum[k][o];
    }
  }
}

/// Everything above once more for each set of instructions.
#define PHN_KERNELS(name, by_nodes, attributes)                                                                    \
  namespace name {                                                                                                 \
  attributes void force(const Network& net, const double* d, double* out) { force_of(net, d, out); }               \
  attributes void of_displacement(const Network& net, const double* d, double* out) {                              \
    gaussians_of_displacement(net, d, out);                                                                        \
  }                                                                                                                \
  attributes void of_coordinates(const Network& net, std::int32_t n_output, const double* points, double* table) { \
    gaussians_of_coordinates(net, n_output, points, table);                                                        \
  }                                                                                                                \
  attributes void field(const Network& net, std::int32_t n_output, const double* table, const double* factor,      \
                        double share, double* scratch, double* out) {                                              \
    field_of_table<by_nodes>(net, n_output, table, factor, share, scratch, out);                                   \
  }                                                                                                                \
  constexpr NetworkKernels kernels = {#name, force, of_displacement, of_coordinates, field};                       \
  }

PHN_KERNELS(any, false, )
#ifdef PHN_X86_64
PHN_KERNELS(avx2, true, __attribute__((target("avx2"))))
PHN_KERNELS(avx512, true, __attribute__((target("avx512f,avx512dq"))))
#endif

}  // namespace

const NetworkKernels* network_kernels(int set) {
#ifdef PHN_X86_64
  if (set == 1) return __builtin_cpu_supports("avx2") ? &avx2::kernels : nullptr;
  if (set == 2)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") ? &avx512::kernels : nullptr;
#endif
  return set == 0 ? &any::kernels : nullptr;
}

const NetworkKernels& best_network_kernels() {
  for (int set = n_instruction_sets - 1; set > 0; --set) {
    if (const NetworkKernels* kernels = network_kernels(set)) return *kernels;
  }
  return any::kernels;
}

}  // namespace phynness::runtime
