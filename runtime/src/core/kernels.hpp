// The time-critical loops. They are compiled for several instruction sets; the one for the present processor is
// selected at run time. All variants perform the same operations in the same order without fused multiply-add, so that
// results are bitwise the same.
#pragma once

#include <cstddef>

#include "core/model.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define PHN_X86_64
#endif

#if defined(__GNUC__) && !defined(__clang__)
/// Separates the optimization of the code before and after this point for the array. Otherwise GCC 12 chooses the
/// vectorization of a loop by the summation after it, and the loop takes twice as long.
#define PHN_KEEP_IN_MEMORY(array) __asm__("" : "+m"(array))
/// Hides the value of a variable from the optimization. GCC 12 clears an array in memory even if its entries stay in
/// registers, unless it does not know that they are 0.
#define PHN_HIDE(number) __asm__("" : "+m"(number))
#else
#define PHN_KEEP_IN_MEMORY(array)
#define PHN_HIDE(number)
#endif

/// Instantiates KERNELS(name, bytes of a register, attributes) for each instruction set, and `kernels_of_sets`. The
/// registers of any processor count as 0 bytes.
#ifdef PHN_X86_64
#define PHN_FOR_EACH_SET(KERNELS, Kind)                            \
  KERNELS(any, 0, )                                                \
  KERNELS(avx2, 32, __attribute__((target("avx2"))))               \
  KERNELS(avx512, 64, __attribute__((target("avx512f,avx512dq")))) \
  constexpr const Kind* kernels_of_sets[] = {&any::kernels, &avx2::kernels, &avx512::kernels};
#else
#define PHN_FOR_EACH_SET(KERNELS, Kind) \
  KERNELS(any, 0, )                     \
  constexpr const Kind* kernels_of_sets[] = {&any::kernels};
#endif

namespace PHN_RUNTIME {

/// 0: any processor; 1: AVX2; 2: AVX-512.
inline constexpr int n_instruction_sets = 3;

/// Null if the library or the processor does not have the instruction set.
template <class Kernels, int n>
const Kernels* kernels_for(const Kernels* const (&of_sets)[n], int set) {
#ifdef PHN_X86_64
  if (set == 1) return __builtin_cpu_supports("avx2") ? of_sets[1] : nullptr;
  if (set == 2) return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") ? of_sets[2] : nullptr;
#endif
  return set == 0 ? of_sets[0] : nullptr;
}
template <class Kernels, int n>
const Kernels& best_of(const Kernels* const (&of_sets)[n]) {
  for (int set = n - 1; set > 0; --set)
    if (const Kernels* kernels = kernels_for(of_sets, set)) return *kernels;
  return *of_sets[0];
}

/// Adds up the lanes of n vectors of partial sums, which it overwrites.
template <class T, std::size_t n>
PHN_INLINE void add_up_many(T (&sum)[n][block_size], double* total) {
  static_assert(block_size == 16);
  for (std::size_t k = 0; k < n; ++k) {
    PHN_KEEP_IN_MEMORY(sum[k]);
    for (std::int32_t i = 0; i < 8; ++i) sum[k][i] += sum[k][i + 8];
    PHN_KEEP_IN_MEMORY(sum[k]);
    for (std::int32_t i = 0; i < 4; ++i) sum[k][i] += sum[k][i + 4];
    PHN_KEEP_IN_MEMORY(sum[k]);
    total[k] = static_cast<double>((sum[k][0] + sum[k][2]) + (sum[k][1] + sum[k][3]));
  }
}

/// Force, energy and stiffness of a node of family modal: sums over its centers.
struct ForceKernels {
  const char* name;
  /// The force alone or, with the same bits, together with energy, stiffness or both.
  /// @param x          d / max_displacement, clamped
  /// @param force      3 [N]
  /// @param energy     the work from rest to x [J]; with_stiffness may leave it as it is
  /// @param stiffness  3 x 3 [N/m], bitwise symmetric; used with it only
  using Derivatives = void(const ModalForce& node, const double* x, double* force, double* energy, double* stiffness);
  Derivatives *force, *with_energy, *with_stiffness, *with_both;
};
const ForceKernels* force_kernels(int set);
const ForceKernels& best_force_kernels();

/// Completes the table of a force and sets the constants that make force and energy at rest exactly 0.
/// @pre all other members of node are set
/// @param table  node.table, with centers and coefficients
void set_rest(ModalForce& node, double* table);

struct PreparedNode;

/// Deformations and fields of family modal.
struct ModalKernels {
  const char* name;
  /// Basis of all amplitudes: kernels minus their values at rest, then x.
  /// @param x      d / max_displacement, clamped
  /// @param basis  n_centers + 3
  void (*basis)(const SharedModes& shared, const double* x, double* basis);
  /// Derivatives of the basis. @param gradient  3 x (n_centers + 3), row k by x_k
  void (*basis_gradient)(const SharedModes& shared, const double* x, double* gradient);
  /// amplitude = weights^T basis. @param basis  n_basis, the number of rows of tables.weight
  /// @param amplitude  tables.n_modes
  void (*amplitudes)(const ModalTables& tables, std::int32_t n_basis, const double* basis, double* amplitude);
  /// The same for three rows at once. @param basis  3 x n_basis; @param amplitude 3 x tables.n_modes
  void (*three_amplitudes)(const ModalTables& tables, std::int32_t n_basis, const double* basis, double* amplitude);
  /// Values at all output nodes; nodes that the probe moves are set later.
  /// @param prepared   of the node's deformation, or null
  /// @param amplitude  tables.n_modes > 0; @param scratch shared.n_modes; @param field shared.n_rows
  void (*field)(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,
                const double* amplitude, double* scratch, double* field);
  /// Product of shared modes and mixing for one block of rows. @pre tables of the full level
  /// @param out  tables.n_modes x rows_per_block
  void (*sum_block)(const SharedTable& shared, const ModalTables& tables, const float* block, float* out);
};
const ModalKernels* modal_kernels(int set);
const ModalKernels& best_modal_kernels();

/// q(x - c_i) - q(x) for a given q = q(x).
PHN_INLINE double amplitude_kernel(const SharedModes& shared, const double* x, double q, std::int32_t i) {
  const double y[3] = {x[0] - shared.center[0][i], x[1] - shared.center[1][i], x[2] - shared.center[2][i]};
  return std::sqrt(dot(y, y) + shared.shape * shared.shape) - q;
}

/// A Gaussian of displacement and coordinates is the product exp(-|d - c_d|^2 / r^2) exp(-|X - c_X|^2 / r^2). The
/// factor of the coordinates is computed once for a touched node.
struct NetworkKernels {
  const char* name;
  /// Equations (11)-(12) of a force network. @param d  3 [m], finite; @param force 3 [N]
  void (*force)(const Network& net, const double* d, double* force);
  /// Gaussians of three inputs. @param first  first input: 0 for a displacement, 3 for a point
  /// @param values  3; @param out n_neurons
  void (*of_inputs)(const Network& net, int first, const double* values, double* out);
  /// Gaussians of the last three inputs for all output nodes, in blocks of nodes_per_block nodes, in each block neuron
  /// after neuron. @pre net of the full level
  /// @param table  whole blocks; the last block is padded with values of the last node
  void (*of_coordinates)(const Network& net, std::int32_t n_output, const double* points, double* table);
  /// Displacements of all output nodes; nodes that the probe moves are set later.
  /// @param table    from of_coordinates
  /// @param factor   n_neurons, from of_inputs
  /// @param share    factor of the constants
  /// @param scratch  3 n_neurons
  /// @param field    n_output x 3 [m]
  void (*field)(const Network& net, std::int32_t n_output, const double* table, const double* factor, double share,
                double* scratch, double* field);
};
inline constexpr std::int32_t nodes_per_block = 16;
const NetworkKernels* network_kernels(int set);
const NetworkKernels& best_network_kernels();

}  // namespace PHN_RUNTIME
