// Force, energy and stiffness of a node of family modal: sums over its centers (instruction_sets.hpp).
#pragma once

#include "instruction_sets.hpp"
#include "model.hpp"

namespace PHN_RUNTIME {

/// Whether energy and force are summed in one pass over the centers. In the library in float the energy is summed in
/// double, in a pass of its own: an energy in float would have steps.
inline constexpr bool energy_in_pass = sizeof(Real) == sizeof(double);

struct ForceKernels {
  const char* name;
  /// As conservative_force, but with another order of summation.
  /// @param x      d / max_displacement, clamped
  /// @param force  3 [N]
  void (*force)(const Conservative<double>& net, const ForceTable& table, const double* x, double* force);
  /// @return the work from rest to x [J]
  double (*energy)(const Conservative<double>& net, const ForceTable& table, const double* x);
  /// The same bits of force and energy, and the stiffness, together in less time.
  /// @param energy     [J]; with_stiffness may leave it as it is
  /// @param stiffness  3 x 3 [N/m], bitwise symmetric; not used by with_energy
  using Derivatives = void(const Conservative<double>& net, const ForceTable& table, const double* x, double* force,
                           double* energy, double* stiffness);
  Derivatives *with_energy, *with_stiffness, *with_both;
};

/// Fills the table of a force and sets the constants that make force and energy at rest exactly 0.
/// @pre all other members of net are set, and table.centers
/// @param centers  table.centers; null: they are gathered
void set_rest(Conservative<double>& net, ForceTable& table, Real* centers);

/// Null if the library or the processor does not have the instruction set.
const ForceKernels* force_kernels(int set);
const ForceKernels& best_force_kernels();

}  // namespace PHN_RUNTIME
