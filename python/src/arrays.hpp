// What both parts of the module share: arrays of numpy, and statuses and errors as exceptions and warnings of Python.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>

namespace phynness::python {

namespace py = pybind11;

/// Throws phynness.Error with a status of the runtime, or without one (0).
[[noreturn]] void raise(const std::string& message, int status = 0);
[[noreturn]] void raise_type(const std::string& message);

/// Of a str, bytes or os.PathLike.
std::filesystem::path path_of(const py::object& given);

/// Vectors that a caller gives: one of shape (3,), or n of shape (n, 3), read where they are if they are float64 in C
/// order. @throws TypeError, ValueError of Python
class Vectors {
 public:
  Vectors(py::handle given, const char* name);
  bool is_one() const { return _numbers.ndim() == 1; }
  py::ssize_t size() const { return is_one() ? 1 : _numbers.shape(0); }
  void get(py::ssize_t i, double (&to)[3]) const { std::copy_n(_numbers.data() + 3 * i, 3, to); }

 private:
  static constexpr int aligned = 0x0100;  // NPY_ARRAY_ALIGNED
  py::array_t<double, py::array::forcecast | py::array::c_style | aligned> _numbers;
};

/// An array for the results of n vectors, n x ..., or of one, whose shape has no n.
py::array_t<double> results(const Vectors& d, std::initializer_list<py::ssize_t> of_one);

/// Warnings of many evaluations: one of Python for each kind, with their count. The first error is thrown.
class Tally {
 public:
  /// @return whether it is no error
  bool add(py::ssize_t row, int status) {
    if (status == 0) return true;
    _is_unusual = true;
    return add_unusual(row, status);
  }
  bool is_unusual() const { return _is_unusual; }
  void report(const std::string& where, py::ssize_t n) const;

 private:
  bool add_unusual(py::ssize_t row, int status);
  bool _is_unusual = false;
  int _error = 0;
  py::ssize_t _row = 0, _warnings[3] = {0, 0, 0};
};

/// Numbers that belong to `owner`, which then lives as long as the array. They cannot be written to.
template <class T>
py::array_t<T> view(py::handle owner, const T* numbers, std::initializer_list<py::ssize_t> shape) {
  py::array_t<T> array(shape, numbers, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

void add_model(py::module_& module);
void add_body(py::module_& module);
void add_training(py::module_& module);

/// The model of a text. @param mesh  the content of mesh.txt, or None
py::object model_of(const std::string& text, const std::string& name, py::object mesh, py::object training);

}  // namespace phynness::python
