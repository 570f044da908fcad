// Energies of the law files with their derivatives. The build makes them: body_laws.cpp of laws/tables/tables.py.
#pragma once

#include <stdint.h>

namespace phynness::runtime {

/// An energy density W(F) and its derivatives.
/// @param F           components, row by row
/// @param parameters  of the law, in the order of its file. Moduli may have any unit, which is then that of W.
/// @param first       output, dW/dF, 9
/// @param second      output, d2W/dF2, 9 x 9; null: not computed
/// @return            false where the law is not defined, det F <= 0 for example, or a result is not finite; the output
///                    is then undefined
using BodyEnergy = bool (*)(const double* F, const double* parameters, double& value, double* first, double* second);

/// W = shape + kappa/2 g^2. `volumetric` is g or, in a law that has it, of_pressure (laws/tables/law.py), which a
/// pressure sees in mixed elements.
struct BodyLaw {
  const char* name;
  int32_t n_parameters;
  BodyEnergy shape, volumetric;
};

/// @param name  ends with 0 @return  null: there is no such law
const BodyLaw* find_body_law(const char* name);

}  // namespace phynness::runtime
