// LDL^T by MUMPS, the same for a process alone and for a team.
#pragma once

#include <petscksp.h>

namespace phynness {

/// @param matrix  symmetric; the pattern is its own from now on
void set_up_factorization(KSP ksp, Mat matrix);

/// Of the latest factorization, those of the pressures included. Collective.
int negative_pivots(KSP ksp);

}  // namespace phynness
