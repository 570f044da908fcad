// The module phynness._phynness; the package and its types are in phynness/.
#include <pybind11/stl.h>

#include "arrays.hpp"

namespace phynness::python {
namespace {

py::handle error_type;  // never released: interpreters end in no order
struct WarningKind {
  int status;
  const char *name, *doc;
  py::handle type;
};
WarningKind warnings[5] = {
    {PHN_WARNING_OUTSIDE, "OutsideWarning", "Displacements longer than trained, or a place that was not trained.", {}},
    {PHN_WARNING_INCOMPLETE,
     "IncompleteWarning",
     "A node some of whose directions were not trained to full depth.",
     {}},
    {PHN_WARNING_UNSETTLED,
     "UnsettledWarning",
     "Tools are not followed: too close together, or faster than the body settles.",
     {}},
    {PHN_WARNING_NEAR,
     "NearWarning",
     "Springs join near tools of a body: their forces may be off by a third and more.",
     {}},
    {PHN_WARNING_RELAXATION,
     "RelaxationWarning",
     "A relaxing force is approximate: the place moves, or the tool has left.",
     {}}};

py::handle new_type(py::module_& module, const char* name, const char* doc, py::handle base, const py::dict& members) {
  const std::string full = std::string("phynness.") + name;
  const py::handle type = PyErr_NewExceptionWithDoc(full.c_str(), doc, base.ptr(), members.ptr());
  if (!type) throw py::error_already_set();
  module.attr(name) = type;
  return type;
}

}  // namespace

void raise(const std::string& message, int status) {
  py::object error = error_type(message);
  if (status != 0) error.attr("status") = status;
  PyErr_SetObject(error_type.ptr(), error.ptr());
  throw py::error_already_set();
}

void raise_type(const std::string& message) { throw py::type_error(message); }

std::string content_of(const py::object& path, const char* what) {
  try {
    const auto file = py::module_::import("builtins").attr("open")(path, "rb");
    const std::string content = file.attr("read")().cast<std::string>();
    file.attr("close")();
    return content;
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_OSError)) throw;
    raise(std::string(what) + " cannot be read: " + py::str(error.value()).cast<std::string>());
  }
}

Vectors::Vectors(py::handle given, const char* name) {
  auto array = py::reinterpret_borrow<py::object>(given);
  if (!py::isinstance<py::array>(given)) {
    array = py::array::ensure(given);
    if (!array) raise_type(std::string(name) + " is no array of numbers");
  }
  const auto& plain = py::reinterpret_borrow<py::array>(array);
  const char kind = plain.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    raise_type(std::string(name) + " must have real numbers, but its dtype is " +
               py::str(plain.dtype()).cast<std::string>());
  if (plain.ndim() < 1 || plain.ndim() > 2 || plain.shape(plain.ndim() - 1) != 3)
    throw py::value_error(std::string(name) + " must have the shape (3,) or (n, 3), not " +
                          py::str(array.attr("shape")).cast<std::string>());
  _numbers = decltype(_numbers)::ensure(array);
  if (!_numbers) raise_type(std::string(name) + " cannot be converted to float64");
}

bool Tally::add_unusual(py::ssize_t row, int status) {
  if (status < 0) {
    _error = status;
    _row = row;
    return false;
  }
  for (int k = 0; k < 5; ++k) _warnings[k] += (status & warnings[k].status) != 0;
  return true;
}

void Tally::report_unusual(const std::string& where, py::ssize_t n) const {
  const auto of_row = [&](py::ssize_t row) { return n == 1 ? "" : ", row " + std::to_string(row); };
  if (_error < 0) raise(phn_status_message(_error) + std::string(" (") + where + of_row(_row) + ")", _error);
  for (int k = 0; k < 5; ++k) {
    if (_warnings[k] == 0) continue;
    std::string text = phn_status_message(warnings[k].status) + std::string(" (") + where;
    if (n > 1) text += ", " + std::to_string(_warnings[k]) + " of " + std::to_string(n) + " rows";
    py::object warning = warnings[k].type(text + ")");
    warning.attr("count") = _warnings[k];
    py::module_::import("warnings").attr("warn")(warning);
  }
}

}  // namespace phynness::python

PYBIND11_MODULE(_phynness, module) {
  using namespace phynness::python;
  module.attr("__version__") = PHYNNESS_VERSION;
  py::dict members;
  members["status"] = py::none();
  error_type = new_type(module, "Error",
                        "What phynness refuses, in words with a remedy.\n\nstatus: of the runtime, PHN_ERROR_* of "
                        "phynness.h, below 0; None for other errors.",
                        PyExc_ValueError, members);
  members["status"] = 0;
  members["count"] = 0;
  const py::handle base = new_type(module, "StatusWarning",
                                   "A status of the runtime above 0, once for each call.\n\nstatus: PHN_WARNING_* of "
                                   "phynness.h.\ncount: number of rows that have it.",
                                   PyExc_UserWarning, members);
  for (auto& kind : warnings) {
    members["status"] = kind.status;
    kind.type = new_type(module, kind.name, kind.doc, base, members);
  }
  add_places(module);
  add_model(module);
  add_organ(module);
  for (const auto& [name, value] : module.attr("__dict__").cast<py::dict>())
    if (PyType_Check(value.ptr())) value.attr("__module__") = "phynness";
  module.def("__dir__", [] {
    std::vector<std::string> names;
    for (const auto& [name, value] : py::module_::import("phynness._phynness").attr("__dict__").cast<py::dict>())
      if (const auto text = name.cast<std::string>(); text[0] != '_') names.push_back(text);
    std::sort(names.begin(), names.end());
    return names;
  });
}
