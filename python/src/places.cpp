// Places of tools, as Python gives them.
#include <pybind11/stl.h>

#include <limits>

#include "arrays.hpp"

namespace phynness::python {
namespace {

py::tuple tuple_of(const auto& list) { return py::tuple(py::cast(list)); }

phn_tool at_node(std::int64_t node) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  constexpr double rest[3] = {0, 0, 0};
  return phn_tool_at(node < 0 || node > most ? -1 : static_cast<std::int32_t>(node), rest);
}

phn_tool place_of(py::handle given) {
  if (py::isinstance<SurfacePoint>(given)) return given.cast<const SurfacePoint&>().tool;
  if (PyIndex_Check(given.ptr()) == 0)
    raise_type("a place is the number of a node or a SurfacePoint, not " + py::repr(given).cast<std::string>());
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(given.ptr()));
  if (!number) throw py::error_already_set();
  int overflow = 0;
  const long long node = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  return at_node(overflow != 0 ? -1 : node);
}

bool is_one_place(py::handle given) {
  if (py::isinstance<SurfacePoint>(given)) return true;
  if (py::isinstance<py::array>(given)) return py::reinterpret_borrow<py::array>(given).ndim() == 0;
  return PyIndex_Check(given.ptr()) != 0 || py::isinstance<py::str>(given) || py::isinstance<py::bytes>(given) ||
         PySequence_Check(given.ptr()) == 0;
}

std::string text_of(const phn_tool& tool) {
  SurfacePoint point;
  point.tool = tool;
  return tool.nodes[1] < 0 && tool.weights[0] == 1 ? "node " + std::to_string(tool.nodes[0]) : point.text();
}

}  // namespace

SurfacePoint::SurfacePoint(const std::vector<std::int32_t>& nodes, const std::vector<double>& weights) {
  if (nodes.empty() || nodes.size() > 3 || weights.size() != nodes.size())
    throw py::value_error("a point has one to three nodes and a weight for each of them");
  std::fill_n(tool.nodes, 3, -1);
  std::copy(nodes.begin(), nodes.end(), tool.nodes);
  std::copy(weights.begin(), weights.end(), tool.weights);
}
std::vector<std::int32_t> SurfacePoint::nodes() const {
  return {tool.nodes, std::find(tool.nodes, tool.nodes + 3, -1)};
}
std::vector<double> SurfacePoint::weights() const { return {tool.weights, tool.weights + nodes().size()}; }
std::string SurfacePoint::text() const {
  const auto said = [](const auto& list) { return py::repr(tuple_of(list)).template cast<std::string>(); };
  return "SurfacePoint(" + said(nodes()) + ", " + said(weights()) + ")";
}

Tools::Tools(py::handle at, py::handle displacements) : _d(displacements, "d"), _at_one(is_one_place(at)) {
  if (_at_one)
    _places.push_back(place_of(at));
  else
    for (const py::handle place : py::iter(at)) _places.push_back(place_of(place));
  if (!_at_one && !_d.is_one() && _d.size() != size())
    throw py::value_error("there are " + std::to_string(size()) + " places, but " + std::to_string(_d.size()) +
                          " displacements in d");
}

std::string Tools::name(py::ssize_t i) const {
  if (!_at_one && i < 0) return std::to_string(size()) + " places";
  return text_of(_places[_at_one ? 0 : static_cast<std::size_t>(i)]);
}

py::array_t<double> Tools::results(std::initializer_list<py::ssize_t> of_one) const {
  py::array::ShapeContainer shape(of_one);
  if (!is_one()) shape->insert(shape->begin(), size());
  return py::array_t<double>(std::move(shape));
}

void add_places(py::module_& module) {
  using py::arg;
  py::class_<SurfacePoint>(module, "SurfacePoint",
                           "A place on the surface: one to three nodes of a triangle, with barycentric weights >= 0 of "
                           "sum 1.\n\nSee Model.nearest.")
      .def(py::init([](const std::vector<std::int32_t>& nodes, const std::vector<double>& weights, py::object position,
                       py::object distance) {
             SurfacePoint point(nodes, weights);
             point.position = std::move(position);
             point.distance = std::move(distance);
             return point;
           }),
           arg("nodes"), arg("weights"), arg("position") = py::none(), arg("distance") = py::none())
      .def_property_readonly("nodes", [](const SurfacePoint& p) { return tuple_of(p.nodes()); })
      .def_property_readonly("weights", [](const SurfacePoint& p) { return tuple_of(p.weights()); })
      .def_readonly("position", &SurfacePoint::position, "Of nearest: of this place, undeformed, (3,) [m]; else None.")
      .def_readonly("distance", &SurfacePoint::distance, "Of nearest: from this place to x [m], < 0 inside; else None.")
      .def("__repr__", &SurfacePoint::text)
      .def("__reduce__", [](const py::object& self) {
        const auto& p = self.cast<const SurfacePoint&>();
        return py::make_tuple(py::type::of(self), py::make_tuple(p.nodes(), p.weights(), p.position, p.distance));
      });
}

}  // namespace phynness::python
