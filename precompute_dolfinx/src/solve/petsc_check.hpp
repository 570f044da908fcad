// Conversion of PETSc error codes to exceptions, and owned handles of PETSc objects.
#pragma once

#include <petscsnes.h>

#include <Eigen/Core>
#include <phynness/formats/error.hpp>
#include <string>
#include <type_traits>
#include <utility>

// New names of PETSc for older versions.
#if PETSC_VERSION_LT(3, 21, 0)
#define SNESLineSearchShellSetApply SNESLineSearchShellSetUserFunc
#endif
#if PETSC_VERSION_LT(3, 25, 0)
#define SNES_DIVERGED_FUNCTION_NANORINF SNES_DIVERGED_FNORM_NAN
#endif

namespace phynness {

/// The file with PETSc's own messages (solver_log.hpp).
std::string solver_log_file();

inline void petsc_check(PetscErrorCode code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw failure(std::string("PETSc failed in ") + call, text ? text : "error " + std::to_string(code),
                "see its message in " + solver_log_file() +
                    ", and try a smaller scene to distinguish a resource limit from a defect");
}

/// Owns a PETSc object, which `Destroy` destroys.
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

/// Access to the values of a vector of this process, during the lifetime of the object; `const` for reading only.
template <class Scalar>
class VecValues {
 public:
  explicit VecValues(Vec vector) : _vector(vector) {
    PHYNNESS_PETSC(VecGetLocalSize(vector, &_size));
    if constexpr (std::is_const_v<Scalar>)
      PHYNNESS_PETSC(VecGetArrayRead(vector, &_values));
    else
      PHYNNESS_PETSC(VecGetArray(vector, &_values));
  }
  ~VecValues() {
    if constexpr (std::is_const_v<Scalar>)
      VecRestoreArrayRead(_vector, &_values);
    else
      VecRestoreArray(_vector, &_values);
  }
  VecValues(const VecValues&) = delete;

  Scalar& operator[](Eigen::Index i) const { return _values[i]; }
  auto map() const {
    return Eigen::Map<std::conditional_t<std::is_const_v<Scalar>, const Eigen::VectorXd, Eigen::VectorXd>>(_values,
                                                                                                           _size);
  }

 private:
  Vec _vector;
  PetscInt _size = 0;
  Scalar* _values = nullptr;
};
using ReadValues = VecValues<const PetscScalar>;
using WriteValues = VecValues<PetscScalar>;

/// Access to the rows of a matrix of this process, numbered from 0, during the lifetime of the object.
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
