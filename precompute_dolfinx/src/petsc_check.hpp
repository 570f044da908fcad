// PETSc error codes become exceptions; handles are owned.
#pragma once

#include <petscsnes.h>

#include <phynness/formats/error.hpp>
#include <string>
#include <utility>

// PETSc's new names, for PETSc that has only the old ones.
#if PETSC_VERSION_LT(3, 21, 0)
#define SNESLineSearchShellSetApply SNESLineSearchShellSetUserFunc
#endif
#if PETSC_VERSION_LT(3, 25, 0)
#define SNES_DIVERGED_FUNCTION_NANORINF SNES_DIVERGED_FNORM_NAN
#endif

namespace phynness {

/// Where PETSc's own messages are (solver_log.hpp).
std::string solver_log_file();

inline void petsc_check(PetscErrorCode code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw failure(
      std::string("PETSc failed in ") + call, text ? text : "error " + std::to_string(code),
      "its own message is in " + solver_log_file() + "; run on a smaller scene to tell a resource limit from a defect");
}

/// Owns a PETSc object; `Destroy` is its destructor function.
template <typename T, PetscErrorCode (*Destroy)(T*)>
class PetscHandle {
 public:
  PetscHandle() = default;
  PetscHandle(PetscHandle&& other) noexcept : _object(std::exchange(other._object, nullptr)) {}
  PetscHandle& operator=(PetscHandle&& other) noexcept {
    std::swap(_object, other._object);
    return *this;
  }
  ~PetscHandle() {
    if (_object) Destroy(&_object);
  }
  T* address() { return &_object; }
  operator T() const { return _object; }

 private:
  T _object = nullptr;
};

using PetscMat = PetscHandle<Mat, MatDestroy>;
using PetscVec = PetscHandle<Vec, VecDestroy>;
using PetscSnes = PetscHandle<SNES, SNESDestroy>;

#define PHYNNESS_PETSC(call) ::phynness::petsc_check((call), #call)

inline double dot(Vec a, Vec b) {
  PetscScalar value = 0;
  PHYNNESS_PETSC(VecDot(a, b, &value));
  return value;
}

inline double norm(Vec a) {
  PetscReal value = 0;
  PHYNNESS_PETSC(VecNorm(a, NORM_2, &value));
  return value;
}

/// Rows of a matrix of this process, from 0, for as long as this lives.
class CsrPattern {
 public:
  explicit CsrPattern(Mat matrix) : _matrix(matrix) {
    PetscBool done = PETSC_FALSE;
    PHYNNESS_PETSC(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &n, &row_start, &column, &done));
  }
  ~CsrPattern() {
    PetscBool done = PETSC_FALSE;
    MatRestoreRowIJ(_matrix, 0, PETSC_FALSE, PETSC_FALSE, &n, &row_start, &column, &done);
  }
  CsrPattern(const CsrPattern&) = delete;

  PetscInt n = 0;
  const PetscInt *row_start = nullptr, *column = nullptr;

 private:
  Mat _matrix;
};

}  // namespace phynness
