// The loops of family rbfn that take its time (instruction_sets.hpp).
#pragma once

#include "instruction_sets.hpp"
#include "model.hpp"

namespace PHN_RUNTIME {

/// A Gaussian of displacement and coordinates is the product of one of each, exp(-|d - c_d|^2 / r^2) exp(-|X - c_X|^2 /
/// r^2): what belongs to the coordinates is computed once for a touched node.
struct NetworkKernels {
  const char* name;
  /// (11)-(12) of a force network. @param d  3 [m], of any size that is finite; @param force 3 [N]
  void (*force)(const Network& net, const double* d, double* force);
  /// Gaussians of three inputs: of a displacement from 0 on, of a point from 3 on. @param values  3; @param out
  /// n_neurons
  void (*of_inputs)(const Network& net, int first, const double* values, double* out);
  /// Gaussians of the last three inputs for all output nodes: for every nodes_per_block of them, those of each neuron
  /// in turn. @pre net of the full level
  /// @param table  whole blocks; what is beyond the last node is that of the last node
  void (*of_coordinates)(const Network& net, std::int32_t n_output, const double* points, Real* table);
  /// Displacements of all output nodes, those of the probe not yet set. @param table  of of_coordinates
  /// @param factor  n_neurons; @param share of the constants; @param scratch 3 n_neurons; @param field n_output x 3 [m]
  void (*field)(const Network& net, std::int32_t n_output, const Real* table, const double* factor, double share,
                double* scratch, double* field);
};

inline constexpr std::int32_t nodes_per_block = 16;

/// Null where library or processor lack the set.
const NetworkKernels* network_kernels(int set);
const NetworkKernels& best_network_kernels();

}  // namespace PHN_RUNTIME
