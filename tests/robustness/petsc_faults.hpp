// Failures of PETSc and memory, made from outside: this program defines functions of PETSc that the solver calls
// in factorizations and substitutions, which pass the call on to the library: a factorization reads the matrix by
// MatSeqAIJGetCSRAndMemType, and substitutions end with a VecNorm of this type only. Included once in a program, linked
// before PETSc.
#pragma once

#include <dlfcn.h>
#include <petscmat.h>

#include <cmath>
#include <functional>
#include <new>
#include <vector>

namespace phynness::test {

enum class FaultSite { factorization, substitution };
enum class Fault {
  none,
  singular,       ///< factorization: of a matrix with an empty row
  out_of_memory,  ///< factorization
  not_finite,     ///< NaN in the matrix, as of a kernel, or in the solution
  petsc_error,    ///< the call fails
  bad_alloc,      ///< std::bad_alloc is thrown
};
inline std::function<Fault(FaultSite)> fault_hook;  ///< empty: no faults

template <class Function>
Function* of_petsc(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// The present fault of the site; the two that need no call of the library are thrown or printed here.
inline Fault fault_at(FaultSite site, PetscErrorCode& code) {
  const Fault fault = fault_hook ? fault_hook(site) : Fault::none;
  if (fault == Fault::bad_alloc) throw std::bad_alloc();
  code = fault == Fault::petsc_error ? PetscError(PETSC_COMM_SELF, __LINE__, __func__, __FILE__, PETSC_ERR_LIB,
                                                  PETSC_ERROR_INITIAL, "injected by a test")
                                     : PetscErrorCode{};
  return fault;
}

}  // namespace phynness::test

extern "C" PetscErrorCode MatSeqAIJGetCSRAndMemType(Mat matrix, const PetscInt** i, const PetscInt** j, PetscScalar** a,
                                                    PetscMemType* type) {
  using namespace phynness::test;
  static const auto real = of_petsc<decltype(MatSeqAIJGetCSRAndMemType)>("MatSeqAIJGetCSRAndMemType");
  PetscErrorCode code{};
  const Fault fault = fault_at(FaultSite::factorization, code);
  if (fault == Fault::petsc_error) return code;
  if (fault == Fault::out_of_memory) throw std::bad_alloc();
  PetscCall(real(matrix, i, j, a, type));
  if (fault != Fault::singular && fault != Fault::not_finite) return PetscErrorCode{};
  PetscInt n = 0;
  PetscCall(MatGetSize(matrix, &n, nullptr));
  static std::vector<PetscScalar> copy;
  copy.assign(*a, *a + (*i)[n]);
  for (PetscInt row = 0; row < n; ++row)
    for (PetscInt k = (*i)[row]; k < (*i)[row + 1]; ++k)
      if (row == n / 2 || (*j)[k] == n / 2) copy[k] = row == (*j)[k] && fault == Fault::not_finite ? std::nan("") : 0.0;
  *a = copy.data();
  return PetscErrorCode{};
}

extern "C" PetscErrorCode VecNorm(Vec x, NormType type, PetscReal* value) {
  using namespace phynness::test;
  static const auto real = of_petsc<decltype(VecNorm)>("VecNorm");
  PetscErrorCode code{};
  const Fault fault = type == NORM_1 ? fault_at(FaultSite::substitution, code) : Fault::none;
  if (fault == Fault::petsc_error) return code;
  if (fault == Fault::not_finite) PetscCall(VecSet(x, std::nan("")));
  return real(x, type, value);
}
