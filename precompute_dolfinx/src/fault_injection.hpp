// A hook by which tests make library calls fail that fail very rarely. Only tests set the hook.
#pragma once

#include <functional>
#include <new>

#include "petsc_check.hpp"

namespace phynness {

enum class FaultSite { factorization, substitution, residual, tangent, fields };
enum class Fault {
  none,
  singular,       ///< factorization: MUMPS receives a singular matrix
  out_of_memory,  ///< factorization: MUMPS may use 1 MB only
  not_finite,     ///< NaN in the result of a kernel or a substitution
  petsc_error,    ///< a PETSc call fails
  bad_alloc,      ///< std::bad_alloc is thrown
};

inline std::function<Fault(FaultSite)> fault_hook;

/// Throws the injected error, or returns a fault that the caller must produce.
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
