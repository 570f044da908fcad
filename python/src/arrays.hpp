// What all parts of the module share: places and arrays of numpy, and statuses as exceptions and warnings of Python.
#pragma once

#include <phynness/phynness.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

namespace phynness::python {

namespace py = pybind11;

/// Throws phynness.Error with a status of the runtime, or without one (0).
[[noreturn]] void raise(const std::string& message, int status = 0);
[[noreturn]] void raise_type(const std::string& message);

/// The content of a file, by the function open of Python. @param what  for messages. @throws phynness.Error
std::string content_of(const py::object& path, const char* what);

/// Vectors that a caller gives: one of shape (3,), or n of shape (n, 3), read where they are if they are float64 in C
/// order. @throws TypeError, ValueError of Python
class Vectors {
 public:
  Vectors(py::handle given, const char* name);
  bool is_one() const { return _numbers.ndim() == 1; }
  py::ssize_t size() const { return is_one() ? 1 : _numbers.shape(0); }
  const double* data() const { return _numbers.data(); }
  void get(py::ssize_t i, double (&to)[3]) const { std::copy_n(_numbers.data() + 3 * i, 3, to); }

 private:
  static constexpr int aligned = 0x0100;  // NPY_ARRAY_ALIGNED
  py::array_t<double, py::array::forcecast | py::array::c_style | aligned> _numbers;
};

/// A place on the surface: what tools of the runtime have besides their displacement.
struct SurfacePoint {
  using OfModule = void;
  phn_tool tool{};
  py::object position = py::none(), distance = py::none();  ///< of nearest

  SurfacePoint() = default;
  SurfacePoint(const std::vector<std::int32_t>& nodes, const std::vector<double>& weights);
  std::vector<std::int32_t> nodes() const;
  std::vector<double> weights() const;
  std::string text() const;
};

/// Tools that a caller gives: one or n places, each a node or a SurfacePoint, and one or n displacements. One place or
/// one displacement stands for all. @throws TypeError, ValueError of Python
class Tools {
 public:
  Tools(py::handle at, py::handle displacements);
  bool is_one() const { return _at_one && _d.is_one(); }
  py::ssize_t size() const { return _at_one ? _d.size() : static_cast<py::ssize_t>(_places.size()); }
  const phn_tool& get(py::ssize_t i) {
    phn_tool& tool = _places[_at_one ? 0 : static_cast<std::size_t>(i)];
    _d.get(_d.is_one() ? 0 : i, tool.displacement);
    return tool;
  }
  /// For messages. @param i  of a tool, or -1: of all
  std::string name(py::ssize_t i = -1) const;
  /// An array for the results of all, n x ..., or of one, whose shape has no n.
  py::array_t<double> results(std::initializer_list<py::ssize_t> of_one) const;

 private:
  Vectors _d;
  bool _at_one;
  std::vector<phn_tool> _places;
};

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
  /// @param where  of a row, or of all (-1)
  template <class Where>
  void report(const Where& where, py::ssize_t n) const {
    if (_is_unusual) report_unusual(where(_error < 0 ? _row : -1), n);
  }

 private:
  bool add_unusual(py::ssize_t row, int status);
  void report_unusual(const std::string& where, py::ssize_t n) const;
  bool _is_unusual = false;
  int _error = 0;
  py::ssize_t _row = 0, _warnings[5] = {};
};

/// Numbers that belong to `owner`, which then lives as long as the array. They cannot be written to.
template <class T>
py::array_t<T> view(py::handle owner, const T* numbers, std::initializer_list<py::ssize_t> shape) {
  py::array_t<T> array(shape, numbers, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// A row of the array of places that nearest_batch gives and hold_batch takes, without padding.
struct PlaceRow {
  std::int32_t nodes[3], status;
  double weights[3], position[3], distance;
};

void add_places(py::module_& module);
void add_model(py::module_& module);
void add_organ(py::module_& module);

}  // namespace phynness::python

/// The conversion of the classes of the module. Objects that no constructor made, as C.__new__(C), have no content.
template <class T>
class pybind11::detail::type_caster<T, std::void_t<typename T::OfModule>> : public type_caster_base<T> {
 public:
  bool load(handle given, bool converts) {
    if (!type_caster_base<T>::load(given, converts)) return false;
    if (!given.is_none() && !reinterpret_cast<instance*>(given.ptr())->get_value_and_holder().holder_constructed())
      phynness::python::raise_type("an object of __new__ has no content; call its class");
    return true;
  }
};
