// Family rbfn: networks of Gaussians, equations (11)-(12).
#include "core/families.hpp"
#include "core/kernels.hpp"
#include "core/rbfn/exponential.hpp"

namespace PHN_RUNTIME {
namespace {

PHN_INLINE std::int32_t smaller(std::int32_t a, std::int32_t b) { return a < b ? a : b; }

PHN_INLINE double scaled(const Network& net, int input, double value) {
  return clamp((value - net.input_center[input]) / net.input_half_range[input], DBL_MAX);
}

PHN_INLINE double gaussian(double x0, double x1, double x2, double c0, double c1, double c2, double spread) {
  const double t0 = x0 - c0, t1 = x1 - c1, t2 = x2 - c2;
  return exp_of_negative(-((t0 * t0 + t1 * t1 + t2 * t2) * spread));
}

PHN_INLINE void force_of(const Network& net, const double* d, double* force) {
  const double x[3] = {scaled(net, 0, d[0]), scaled(net, 1, d[1]), scaled(net, 2, d[2])};
  const double spread = net.inverse_square_spread;
  double sum[3][block_size] = {};
  for (std::int32_t begin = 0; begin < net.n_neurons; begin += block_size) {
    const double *c0 = net.center[0] + begin, *c1 = net.center[1] + begin, *c2 = net.center[2] + begin;
    const double *w0 = net.weight[0] + begin, *w1 = net.weight[1] + begin, *w2 = net.weight[2] + begin;
    for (std::int32_t i = 0; i < block_size; ++i) {
      const double h = gaussian(x[0], x[1], x[2], c0[i], c1[i], c2[i], spread);
      sum[0][i] += w0[i] * h;
      sum[1][i] += w1[i] * h;
      sum[2][i] += w2[i] * h;
    }
  }
  double total[3];
  add_up_many(sum, total);
  for (int k = 0; k < 3; ++k) force[k] = net.output_center[k] + net.output_half_range[k] * (net.bias[k] + total[k]);
}

PHN_INLINE void gaussians_of_inputs(const Network& net, int first, const double* values, double* out) {
  double x[3];
  for (int k = 0; k < 3; ++k) x[k] = scaled(net, first + k, values[k]);
  const double spread = net.inverse_square_spread;
  double h[block_size];
  for (std::int32_t begin = 0; begin < net.n_neurons; begin += block_size) {
    const double *c0 = net.center[first] + begin, *c1 = net.center[first + 1] + begin,
                 *c2 = net.center[first + 2] + begin;
    for (std::int32_t i = 0; i < block_size; ++i) h[i] = gaussian(x[0], x[1], x[2], c0[i], c1[i], c2[i], spread);
    const std::int32_t size = smaller(block_size, net.n_neurons - begin);
    for (std::int32_t i = 0; i < size; ++i) out[begin + i] = h[i];
  }
}

PHN_INLINE void gaussians_of_coordinates(const Network& net, std::int32_t n_output, const double* points,
                                         double* table) {
  const double spread = net.inverse_square_spread;
  for (std::int32_t begin = 0; begin < n_output; begin += nodes_per_block) {
    double x[3][nodes_per_block];
    for (std::int32_t o = 0; o < nodes_per_block; ++o) {
      const double* point = points + 3 * smaller(begin + o, n_output - 1);
      for (int k = 0; k < 3; ++k) x[k][o] = scaled(net, 3 + k, point[k]);
    }
    for (std::int32_t i = 0; i < net.n_neurons; ++i, table += nodes_per_block) {
      const double c0 = net.center[3][i], c1 = net.center[4][i], c2 = net.center[5][i];
      for (std::int32_t o = 0; o < nodes_per_block; ++o)
        table[o] = gaussian(x[0][o], x[1][o], x[2][o], c0, c1, c2, spread);
    }
  }
}

/// @tparam by_nodes  hide the address of the next neuron's row from the compiler; otherwise GCC 12 vectorizes over
///                   neurons for AVX-512, which takes four times as long
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
  double* __restrict amount = reinterpret_cast<double*>(scratch);
  for (std::int32_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) amount[3 * i + k] = range[k] * net.weight[k][i] * factor[i];
  for (std::int32_t begin = 0; begin < n_output; begin += nodes_per_block) {
    double sum[3][nodes_per_block];
    for (int k = 0; k < 3; ++k)
      for (std::int32_t o = 0; o < nodes_per_block; ++o) sum[k][o] = constant[k];
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
    for (std::int32_t o = 0; o < size; ++o)
      for (int k = 0; k < 3; ++k) field[3 * (begin + o) + k] = sum[k][o];
  }
}

#define PHN_NETWORK_KERNELS(name, bytes, attributes)                                                               \
  namespace name {                                                                                                 \
  attributes void force(const Network& net, const double* d, double* out) { force_of(net, d, out); }               \
  attributes void of_inputs(const Network& net, int first, const double* values, double* out) {                    \
    gaussians_of_inputs(net, first, values, out);                                                                  \
  }                                                                                                                \
  attributes void of_coordinates(const Network& net, std::int32_t n_output, const double* points, double* table) { \
    gaussians_of_coordinates(net, n_output, points, table);                                                        \
  }                                                                                                                \
  attributes void field(const Network& net, std::int32_t n_output, const double* table, const double* factor,      \
                        double share, double* scratch, double* out) {                                              \
    field_of_table<(bytes > 0)>(net, n_output, table, factor, share, scratch, out);                                \
  }                                                                                                                \
  constexpr NetworkKernels kernels = {#name, force, of_inputs, of_coordinates, field};                             \
  }

PHN_FOR_EACH_SET(PHN_NETWORK_KERNELS, NetworkKernels)

}  // namespace

const NetworkKernels* network_kernels(int set) { return kernels_for(kernels_of_sets, set); }
const NetworkKernels& best_network_kernels() { return best_of(kernels_of_sets); }

void response_derivatives(const Networks& nets, const double* d, double* force, double*, double*) {
  best_network_kernels().force(nets.force, d, force);
}

void response_basis(const phn_model&, const Networks& nets, const double* d, double* basis, double*) {
  best_network_kernels().of_inputs(nets.deformation, 0, d, basis);
}

void response_field(const phn_model& model, const Networks& nets, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field) {
  best_network_kernels().field(nets.deformation, model.n_output, prepared->gaussians, basis, share, scratch, field);
}

void prepare_response(const phn_model& model, const Networks& nets, PreparedNode& entry) {
  best_network_kernels().of_coordinates(nets.deformation, model.n_output, model.output_points, entry.gaussians);
}

}  // namespace PHN_RUNTIME
