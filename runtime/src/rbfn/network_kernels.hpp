// The time-critical loops of family rbfn (instruction_sets.hpp).
#pragma once

#include "instruction_sets.hpp"
#include "model.hpp"

namespace PHN_RUNTIME {

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
  void (*of_coordinates)(const Network& net, std::int32_t n_output, const double* points, Real* table);
  /// Displacements of all output nodes; nodes that the probe moves are set later.
  /// @param table    from of_coordinates
  /// @param factor   n_neurons, from of_inputs
  /// @param share    factor of the constants
  /// @param scratch  3 n_neurons
  /// @param field    n_output x 3 [m]
  void (*field)(const Network& net, std::int32_t n_output, const Real* table, const double* factor, double share,
                double* scratch, double* field);
};

inline constexpr std::int32_t nodes_per_block = 16;

/// Null if the library or the processor does not have the instruction set.
const NetworkKernels* network_kernels(int set);
const NetworkKernels& best_network_kernels();

}  // namespace PHN_RUNTIME
