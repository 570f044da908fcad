// Where tests make calls fail that libraries make fail once in a million. Nothing in the product sets the
// hook.
#pragma once

#include <functional>
#include <new>

#include "petsc_check.hpp"

namespace phynness {

enum class FaultSite { factorization, substitution, residual, tangent, fields };
enum class Fault {
  none,
  singular,       ///< of a factorization: MUMPS gets a matrix that has no inverse
  out_of_memory,  ///< of a factorization: MUMPS may use 1 MB
  not_finite,     ///< NaN in what a kernel or a substitution gives
  petsc_error,    ///< a PETSc call ends with an error
  bad_alloc,      ///< std::bad_alloc
};

inline std::function<Fault(FaultSite)> fault_hook;

/// What is to go wrong here, if it is not one of the errors that this throws itself.
inline Fault injected_fault(FaultSite site) {
  if (!fault_hook) return Fault::none;
  const Fault fault = fault_hook(site);
  if (fault == Fault::bad_alloc) throw std::bad_alloc();
  if (fault == Fault::petsc_error)
    PHYNNESS_PETSC(PetscError(PETSC_COMM_SELF, __LINE__, __func__, __FILE__, PETSC_ERR_LIB, PETSC_ERROR_INITIAL,
                              "injected by a test"));
  return fault;
}

}  // namespace phynness
