// Failures of PETSc and MUMPS, made from outside: this program defines two functions of PETSc that the solver calls,
// which pass the call on to the library. Included once in a program, linked before PETSc.
#pragma once

#include <dlfcn.h>
#include <petscmat.h>

#include <cmath>
#include <functional>
#include <new>

namespace phynness::test {

enum class FaultSite { factorization, substitution };
enum class Fault {
  none,
  singular,       ///< factorization: MUMPS receives a matrix with an empty row
  out_of_memory,  ///< factorization: MUMPS may use 1 MB only
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

extern "C" PetscErrorCode MatCholeskyFactorNumeric(Mat factors, Mat matrix, const MatFactorInfo* info) {
  using namespace phynness::test;
  static const auto real = of_petsc<decltype(MatCholeskyFactorNumeric)>("MatCholeskyFactorNumeric");
  PetscErrorCode code{};
  const Fault fault = fault_at(FaultSite::factorization, code);
  if (fault == Fault::petsc_error) return code;
  if (fault == Fault::out_of_memory) PetscCall(MatMumpsSetIcntl(factors, 23, 1));
  if (fault != Fault::singular && fault != Fault::not_finite) return real(factors, matrix, info);
  Mat copy = nullptr;
  PetscInt n = 0;
  PetscCall(MatDuplicate(matrix, MAT_COPY_VALUES, &copy));
  PetscCall(MatGetSize(matrix, &n, nullptr));
  const PetscInt row = n / 2;
  PetscCall(MatZeroRowsColumns(copy, 1, &row, fault == Fault::singular ? 0.0 : std::nan(""), nullptr, nullptr));
  code = real(factors, copy, info);
  PetscCall(MatDestroy(&copy));
  return code;
}

extern "C" PetscErrorCode MatSolve(Mat factors, Vec b, Vec x) {
  using namespace phynness::test;
  static const auto real = of_petsc<decltype(MatSolve)>("MatSolve");
  PetscErrorCode code{};
  const Fault fault = fault_at(FaultSite::substitution, code);
  if (fault == Fault::petsc_error) return code;
  PetscCall(real(factors, b, x));
  if (fault == Fault::not_finite) PetscCall(VecSet(x, std::nan("")));
  return PetscErrorCode{};
}
