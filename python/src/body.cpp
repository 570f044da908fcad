// Body, as Python sees it: a reduced body of the runtime, which answers for several tools.
#include <phynness/formats/body.hpp>
#include <phynness/validation/loaded_body.hpp>

#include <limits>

#include "model.hpp"

namespace phynness::python {
namespace {

using py::arg, py::kw_only;

struct Pressed {
  py::array_t<double> forces, displacements;
  py::object bounds = py::none();
  double energy, residual;
};

py::array_t<double> rows(const double* values, std::size_t n) {
  return py::array_t<double>({static_cast<py::ssize_t>(n), py::ssize_t{3}}, values);
}

/// Used with the GIL held.
class BodyObject {
 public:
  explicit BodyObject(const py::object& of)
      : _body(py::isinstance<py::bytes>(of) ? LoadedBody(of.cast<std::string>(), "the text")
                                            : LoadedBody(path_of(of))) {}

  const phn_body_contents& info() const { return _body.info(); }
  py::bytes text() const { return _body.text(); }

  Pressed press(const std::vector<Place>& at, py::handle displacements, std::int32_t steps) {
    const Vectors d(displacements, "d");
    if (d.is_one() || d.size() != static_cast<py::ssize_t>(at.size()))
      throw py::value_error("d must have the shape (" + std::to_string(at.size()) +
                            ", 3): a displacement for each place");
    if (at.empty()) throw py::value_error("there is no tool");
    if (steps < 1) throw py::value_error("steps must be 1 or more");
    std::vector<phn_tool> tools;
    for (std::size_t i = 0; i < at.size(); ++i)
      d.get(static_cast<py::ssize_t>(i), tools.emplace_back(tool_at(at[i])).displacement);
    const auto said = _body.press_from_rest(tools, increments_from_rest, steps);
    Pressed pressed{rows(said.force_N.data()->data(), tools.size()),
                    rows(said.displacement_m.data(), static_cast<std::size_t>(said.displacement_m.rows())), py::none(),
                    said.pressed.energy, said.pressed.behind_m};
    if (_body.has_bounds()) {
      py::array_t<double> bounds(static_cast<py::ssize_t>(tools.size()));
      for (std::size_t i = 0; i < tools.size(); ++i)
        bounds.mutable_data()[i] = said.bound_N[i].value_or(std::numeric_limits<double>::infinity());
      pressed.bounds = bounds;
    }
    Tally tally;
    tally.add(0, said.status);
    if (tally.is_unusual()) tally.report(std::to_string(tools.size()) + " tools", 1);
    return pressed;
  }

 private:
  LoadedBody _body;
};

}  // namespace

void add_body(py::module_& module) {
  py::class_<Pressed>(module, "Pressed", "What Body.press answers.")
      .def_readonly("forces", &Pressed::forces, "(n, 3) [N].")
      .def_readonly("displacements", &Pressed::displacements, "Of the nodes of the body, (n_nodes, 3) [m].")
      .def_readonly("bounds", &Pressed::bounds,
                    "Of the errors of the forces, (n,) [N]; inf where nothing is known. None without calibrate --body.")
      .def_readonly("energy", &Pressed::energy, "[J].")
      .def_readonly("residual", &Pressed::residual, "Largest distance of a tool from the mean that it holds [m].");

  py::class_<BodyObject> body(module, "Body", R"(A reduced body, which answers for up to 8 tools.

path: a body.txt of phynness reduce, or its content as bytes. Error if it is missing or damaged.
)");
  body.def(py::init<const py::object&>(), arg("path"))
      .def("press", &BodyObject::press, arg("at"), arg("d"), kw_only(), arg("steps") = 60,
           R"(Forces of tools that are displaced together from rest, in eight increments: a Pressed.

at: a list of n nodes of the surface and SurfacePoints. d: (n, 3) [m]. steps: of Newton's method, at most, in each
increment. UnsettledWarning: more steps come closer. OutsideWarning: farther than trained. Error where nothing can move.
)")
      .def_property_readonly("text", &BodyObject::text, "The content of body.txt, bytes.");
  const auto property = [&](const char* name, auto phn_body_contents::*member, const char* doc) {
    body.def_property_readonly(
        name, [member](const BodyObject& b) { return b.info().*member; }, doc);
  };
  property("mesh_hash", &phn_body_contents::mesh_hash, "16 hexadecimal digits.");
  property("tool_radius_m", &phn_body_contents::tool_radius_m, "Of the round tool [m]; 0: nodes.");
  property("max_displacement_m", &phn_body_contents::max_displacement_m,
           "Largest displacement of the training data [m].");
  body.def_property_readonly(
      "nodes",
      [](py::object self) {
        const auto& info = self.cast<const BodyObject&>().info();
        return view(self, info.nodes, {info.n_nodes});
      },
      "Nodes of the surface, ascending.");
}

}  // namespace phynness::python
