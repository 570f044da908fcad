// Model, as Python sees it.
#include <pybind11/stl.h>

#include <filesystem>
#include <limits>

#include "organ.hpp"

namespace phynness::python {
namespace {

using py::arg, py::kw_only;
using ModelClass = py::class_<ModelObject>;

/// A number of one tool, or the array of those of several.
py::object scalar_or_array(py::array_t<double> array) {
  if (array.ndim() == 0) return py::float_(*array.data());
  return array;
}

/// The argument of every evaluation.
py::arg_v level() { return arg("level") = py::none(); }

/// @param of  a path, or bytes of a text
std::unique_ptr<ModelObject> open(const py::object& of) {
  if (py::isinstance<py::bytes>(of))
    return std::make_unique<ModelObject>(NamedText{"the text", of.cast<std::string>()}, py::none(), py::none());
  const std::filesystem::path path = py::module_::import("os").attr("fsdecode")(of).cast<std::string>();
  std::error_code code;
  const bool is_folder = std::filesystem::is_directory(path, code);
  const std::string file = (is_folder ? path / "model.txt" : path).string(), beside = (path / "mesh.txt").string();
  py::object mesh = py::none();
  if (is_folder && std::filesystem::exists(beside, code)) mesh = py::bytes(content_of(py::str(beside), "the mesh"));
  return std::make_unique<ModelObject>(NamedText{file, content_of(py::str(file), "the model")}, mesh, py::none());
}

struct Response {
  py::array_t<double> force, energy, stiffness;
};

/// What is asked for together has the same bits as alone.
Response response(ModelObject& model, py::handle at, py::handle displacements, const Level& l, bool energy,
                  bool stiffness) {
  Tools tools(at, displacements);
  Response made;
  double* const f = (made.force = tools.results({3})).mutable_data();
  double* const e = energy || stiffness ? (made.energy = tools.results({})).mutable_data() : nullptr;
  double* const k = stiffness ? (made.stiffness = tools.results({3, 3})).mutable_data() : nullptr;
  Organ& organ = model.at(l);
  for_each(tools, [&](py::ssize_t i, const phn_tool& tool) {
    double force[3], of_all[9];
    const int status = k   ? organ.hold(tool, force, e[i], of_all)
                       : e ? organ.hold(tool, force, e[i])
                           : organ.hold(tool, force);
    std::copy_n(force, 3, f + 3 * i);
    if (k != nullptr) std::copy_n(of_all, 9, k + 9 * i);
    return status;
  });
  return made;
}

py::array_t<double> deform(ModelObject& model, py::handle at, py::handle displacements, const Level& l) {
  Tools tools(at, displacements);
  auto made = tools.results({model.info().n_output, 3});
  Organ& organ = model.at(l);
  const std::size_t n = organ.n_deform();
  for_each(tools, [&, out = made.mutable_data()](py::ssize_t i, const phn_tool& tool) -> int {
    double force[3];
    const int held = organ.hold(tool, force);
    return held < 0 ? held : held | organ.deform({out + static_cast<py::ssize_t>(n) * i, n});
  });
  return made;
}

py::array_t<double> field(ModelObject& model, py::handle at, py::handle displacements, const std::string& name,
                          const Level& l) {
  const phn_info& info = model.info();
  std::int32_t number = 0;
  while (number < info.n_fields && name != info.field_names[number]) ++number;
  if (number == info.n_fields)
    raise("the model has no field " + py::repr(py::cast(name)).cast<std::string>(), PHN_ERROR_UNDEFINED);
  Tools tools(at, displacements);
  auto made = tools.results({info.n_output});
  Organ& organ = model.at(l);
  for_each(tools, [&, out = made.mutable_data()](py::ssize_t i, const phn_tool& tool) {
    return phn_field(organ.model(), organ.data(), &tool, number, out + info.n_output * i);
  });
  return made;
}

/// A number about each tool, without warnings, because it tells of them.
template <class Value>
py::object number(py::handle at, py::handle displacements, Value&& value) {
  Tools tools(at, displacements);
  auto made = tools.results({});
  for_each(tools, [&, out = made.mutable_data()](py::ssize_t i, const phn_tool& tool) {
    return std::min(int{value(tool, out[i])}, 0);
  });
  return scalar_or_array(made);
}

void add_responses(ModelClass& model) {
  model.def(py::init(&open), arg("path"))
      .def(py::init([](const py::bytes& text, py::object mesh_text, py::object training) {
             return std::make_unique<ModelObject>(NamedText{"the text", text}, std::move(mesh_text),
                                                  std::move(training));
           }),
           arg("text"), arg("mesh_text"), arg("training"))
      .def(
          "force",
          [](ModelObject& m, py::handle at, py::handle d, const Level& l) {
            return response(m, at, d, l, false, false).force;
          },
          arg("at"), arg("d"), kw_only(), level(), R"(Force that holds the displacement d, (3,) or (n, 3) [N].

at: an active node, a SurfacePoint, or a list or array of n of them, each with its own displacement.
level: index of levels; without it the full model.

Error for other nodes and for numbers that are not finite. OutsideWarning where a displacement is longer than trained.

>>> model = phynness.Model("examples/model")
>>> model.force(95, [0, 0, -0.01]).round(4)
array([ 0.0259, -0.0017, -0.0922])
>>> model.force(95, np.zeros((5, 3))).shape
(5, 3)
>>> model.force(model.nearest([[0, 0, 0.1], [0.05, 0, 0.1]]), [0, 0, -0.002]).shape
(2, 3)
)")
      .def(
          "energy",
          [](ModelObject& m, py::handle at, py::handle d, const Level& l) {
            return scalar_or_array(response(m, at, d, l, true, false).energy);
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Stored energy, a float or (n,) [J]; the force is its gradient. Error in family rbfn. As force.")
      .def(
          "stiffness",
          [](ModelObject& m, py::handle at, py::handle d, const Level& l) {
            return response(m, at, d, l, false, true).stiffness;
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Derivative of the force, symmetric, (3, 3) or (n, 3, 3) [N/m]. Error in family rbfn, and between nodes of a "
          "model of node probes. As force.")
      .def(
          "response",
          [](ModelObject& m, py::handle at, py::handle d, const Level& l) {
            auto made = response(m, at, d, l, true, true);
            return py::make_tuple(made.force, scalar_or_array(made.energy), made.stiffness);
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Force, energy and stiffness together, in 1.6 times the time of a force, with the same bits as alone.")
      .def("deform", &deform, arg("at"), arg("d"), kw_only(), level(),
           R"(Displacements of all output nodes under one tool, (n_output, 3) or (n, n_output, 3) [m]. As force.

>>> model = phynness.Model("examples/model")
>>> model.deform(model.nearest([0, 0, 0.1]), [0, 0, -0.01]).shape == model.output_points.shape
True
)")
      .def(
          "field", &field, arg("at"), arg("d"), arg("name"), kw_only(), level(),
          "A scalar field at all output nodes, (n_output,) or (n, n_output), in its unit in fields. Error if the model "
          "has no such field. As force.")
      .def(
          "trained_depth",
          [](const ModelObject& m, py::handle at, py::handle d) {
            return number(at, d, [&](const phn_tool& tool, double& depth) { return m.organ.depth(tool, depth); });
          },
          arg("at"), arg("d"), "Depth of the trained range in the direction of d, a float or (n,) [m].")
      .def(
          "bound",
          [](const ModelObject& m, py::handle at, py::handle d) {
            return number(at, d, [&](const phn_tool& tool, double& bound) {
              const auto status = m.organ.bound(tool, bound);
              if (bound >= PHN_NO_BOUND) bound = std::numeric_limits<double>::infinity();
              return status;
            });
          },
          arg("at"), arg("d"), R"(Bound of the error of force, a float or (n,) [N]; inf beyond the trained range.

It holds for random displacements with the coverage of the model (formats/model.md), and is no guarantee.
Error if the model has none (phynness calibrate).

>>> model = phynness.Model("examples/model")
>>> model.bound(95, [[0, 0, -0.01], [0, 0, -0.1]]).round(5)
array([0.00045,     inf])
)")
      .def(
          "nearest", [](const ModelObject& m, py::handle x) { return nearest_places(m.organ, x); }, arg("x"),
          R"(The place of the undeformed surface that is nearest to x, (3,) [m]: a SurfacePoint, also for force.

Of n points, (n, 3), it is a list of n.

>>> model = phynness.Model("examples/model")
>>> model.force(model.nearest([0, 0, 0.1]), [0, 0, -0.01]).shape
(3,)
)");
}

void add_texts(ModelClass& model) {
  model
      .def_property_readonly(
          "text", [](const ModelObject& m) { return py::bytes(m.text); }, "The content of model.txt, bytes.")
      .def_readonly("mesh_text", &ModelObject::mesh, "The content of mesh.txt, bytes; None if it was read without.")
      .def_readonly("training", &ModelObject::training, "Figures of train, a dict; None in a model that was read.")
      .def("__reduce__",
           [](const py::object& self) {
             const auto& m = self.cast<const ModelObject&>();
             return py::make_tuple(py::type::of(self), py::make_tuple(py::bytes(m.text), m.mesh, m.training));
           })
      .def_property_readonly(
          "levels",
          [](const ModelObject& m) {
            py::list all;
            for (std::int32_t l = 0; l < m.info().n_levels; ++l) {
              phn_level level;
              phn_level_info(m.organ.model(), l, &level);
              all.append(py::dict(arg("force_centers") = level.force_centers,
                                  arg("deformation_centers") = level.deformation_centers, arg("modes") = level.modes,
                                  arg("error_force") = level.error_force,
                                  arg("error_displacement") = level.error_displacement));
            }
            return all;
          },
          "Sizes and errors of the levels, dicts with the names of phn_level in phynness.h; the last one is the full "
          "model.");
}

void add_properties(ModelClass& model) {
  const auto property = [&](const char* name, auto phn_info::*member, const char* doc) {
    model.def_property_readonly(
        name, [member](const ModelObject& m) { return m.info().*member; }, doc);
  };
  property("family", &phn_info::family, "\"modal\", \"rbfn\" or \"linear\".");
  property("title", &phn_info::title, "Of the scene.");
  property("mesh_hash", &phn_info::mesh_hash, "16 hexadecimal digits.");
  property("max_displacement_m", &phn_info::max_displacement_m, "Largest displacement of the training data [m].");
  property("n_nodes", &phn_info::n_nodes, "Of the mesh.");
  model.def_property_readonly(
      "provenance",
      [](const ModelObject& m) {
        const phn_provenance& p = m.info().provenance;
        return py::dict(arg("mesh_hash") = p.mesh_hash, arg("physics_hash") = p.physics_hash,
                        arg("element") = p.element, arg("shear_modulus_Pa") = p.shear_modulus_Pa,
                        arg("reference") = p.reference, arg("finer_mean") = p.finer_mean,
                        arg("finer_p95") = p.finer_p95, arg("finer_tool_radius_m") = p.finer_tool_radius_m,
                        arg("finer_probes") = p.finer_probes, arg("finer_nodes") = p.finer_nodes,
                        arg("bound_reference") = p.bound_reference);
      },
      R"(What the finite elements of the training solved, and how far they are from a finer solution, a dict with the names
of phn_provenance in phynness.h. "" and 0: not recorded.)");
  model.def_property_readonly(
      "has_energy", [](const ModelObject& m) { return m.info().has_energy != 0; }, "False in family rbfn.");
  model.def_property_readonly(
      "fields",
      [](const ModelObject& m) {
        py::dict fields;
        for (int f = 0; f < m.info().n_fields; ++f) fields[m.info().field_names[f]] = m.info().field_units[f];
        return fields;
      },
      "Names of the scalar fields, each with its unit.");
  const auto array = [&](const char* name, auto phn_info::*member, std::int32_t phn_info::*n, py::ssize_t columns,
                         const char* doc) {
    model.def_property_readonly(
        name,
        [member, n, columns](py::object self) {
          const phn_info& info = self.cast<const ModelObject&>().info();
          return columns == 1 ? view(self, info.*member, {info.*n}) : view(self, info.*member, {info.*n, columns});
        },
        doc);
  };
  array("active_nodes", &phn_info::active_nodes, &phn_info::n_active, 1, "Nodes that can be touched, ascending.");
  array("output_nodes", &phn_info::output_nodes, &phn_info::n_output, 1, "Nodes whose displacement is modelled.");
  array("fixed_nodes", &phn_info::fixed_nodes, &phn_info::n_fixed, 1, "Nodes of the surface that never move.");
  array("output_points", &phn_info::output_points, &phn_info::n_output, 3, "(n_output, 3) [m], undeformed.");
  array("fixed_points", &phn_info::fixed_points, &phn_info::n_fixed, 3, "(n_fixed, 3) [m].");
  array("triangles", &phn_info::triangles, &phn_info::n_triangles, 3,
        "(n, 3), normals outward: 0 ... n_output - 1 are output nodes, then come fixed nodes.");
}

}  // namespace

ModelObject::ModelObject(NamedText named, py::object mesh_text, py::object figures)
    : mesh(std::move(mesh_text)), training(std::move(figures)), organ(organ_of(named, {}, 1, 1)) {
  text = std::move(named.text);
}

Organ& ModelObject::at(const Level& level) {
  const std::int32_t n = info().n_levels;
  const auto number = level.value_or(n - 1);
  const int status = phn_set_level(organ.model(), organ.data(), number);
  if (status < 0)
    raise("the model has the levels 0 to " + std::to_string(n - 1) + ", not " + std::to_string(number), status);
  return organ;
}

void add_model(py::module_& module) {
  ModelClass model(module, "Model", R"(A trained model, which answers one tool.

path: a model directory, the path of a model.txt, or the content of a model.txt as bytes.

Error if it is missing or damaged. A model is constant; its arrays are views of it, which cannot be written to. Pickles and
copies hold its text.

>>> model = phynness.Model("examples/model")
>>> model.family, model.n_nodes, len(model.active_nodes), model.triangles.shape
('modal', 200, 62, (382, 3))
)");
  add_responses(model);
  add_texts(model);
  add_properties(model);
}

}  // namespace phynness::python
