// Model and what belongs to it, as Python sees them.
#include "model.hpp"

namespace phynness::python {
namespace {

using py::arg, py::kw_only;
using ModelClass = py::class_<ModelObject>;

/// A number of one vector, or the array of those of several.
py::object scalar_or_array(py::array_t<double> array) {
  if (array.ndim() == 0) return py::float_(*array.data());
  return array;
}
template <class T>
py::object or_none(std::optional<T> value) {
  return value ? scalar_or_array(std::move(*value)) : py::none();
}

/// The argument of every evaluation.
py::arg_v level() { return arg("level") = py::none(); }

void add_parts(py::module_& module) {
  py::class_<SurfacePoint>(module, "SurfacePoint",
                           "A place on the surface: one to three nodes of a triangle, with barycentric weights >= 0 of "
                           "sum 1.\n\nSee Model.nearest.")
      .def(py::init<const std::vector<std::int32_t>&, const std::vector<double>&>(), arg("nodes"), arg("weights"))
      .def_property_readonly("nodes", &SurfacePoint::nodes)
      .def_property_readonly("weights", &SurfacePoint::weights)
      .def("__repr__", &SurfacePoint::text);

  py::class_<Coupled>(
      module, "Coupled",
      "Several tools at once, of Model.couple: forces (n, 3) [N], energy [J], and residual, the largest "
      "distance of a tool from the point that it holds [m].")
      .def_readonly("forces", &Coupled::forces)
      .def_property_readonly("energy", [](const Coupled& c) { return c.result.energy; })
      .def_property_readonly("residual", [](const Coupled& c) { return c.result.residual; })
      .def("deform", &Coupled::deform, "Displacements of all output nodes, (n_output, 3) [m].");
}

void add_responses(ModelClass& model) {
  model.def(py::init(&ModelObject::open), arg("path"))
      .def(
          "force",
          [](ModelObject& m, const Place& at, py::handle d, const Level& l) {
            return *m.response(at, d, l, true, false, false).force;
          },
          arg("at"), arg("d"), kw_only(), level(), R"(Force that holds the displacement d, (3,) or (n, 3) [N].

at: an active node, or a SurfacePoint, which between nodes needs a model of round tools; other models have couple.
level: index of levels; without it the full model.

Error for other nodes and for numbers that are not finite. OutsideWarning where a displacement is longer than trained.

>>> model = phynness.Model("examples/model")
>>> model.force(95, [0, 0, -0.01]).round(4)
array([ 0.0259, -0.0017, -0.0922])
>>> model.force(95, np.zeros((5, 3))).shape
(5, 3)
)")
      .def(
          "energy",
          [](ModelObject& m, const Place& at, py::handle d, const Level& l) {
            return scalar_or_array(*m.response(at, d, l, false, true, false).energy);
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Stored energy, a float or (n,) [J]; the force is its gradient. Error in family rbfn. As force.")
      .def(
          "stiffness",
          [](ModelObject& m, const Place& at, py::handle d, const Level& l) {
            return *m.response(at, d, l, false, false, true).stiffness;
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Derivative of the force, symmetric, (3, 3) or (n, 3, 3) [N/m]. Error in family rbfn. As force.")
      .def(
          "response",
          [](ModelObject& m, const Place& at, py::handle d, const Level& l) {
            auto made = m.response(at, d, l, true, true, true);
            return py::make_tuple(*made.force, scalar_or_array(*made.energy), *made.stiffness);
          },
          arg("at"), arg("d"), kw_only(), level(),
          "Force, energy and stiffness together, in 1.6 times the time of a force, with the same bits as alone.")
      .def("deform", &ModelObject::deform, arg("at"), arg("d"), kw_only(), level(),
           R"(Displacements of all output nodes under one tool, (n_output, 3) or (n, n_output, 3) [m].

at, level, errors and warnings: as force, and every point of the surface.

>>> model = phynness.Model("examples/model")
>>> point, position = model.nearest([0, 0, 0.1])
>>> model.deform(point, [0, 0, -0.01]).shape == model.output_points.shape
True
)")
      .def(
          "field", &ModelObject::field, arg("node"), arg("d"), arg("name"), kw_only(), level(),
          "A scalar field at all output nodes, (n_output,) or (n, n_output), in its unit in fields. Error if the model "
          "has no such field.")
      .def(
          "trained_depth",
          [](ModelObject& m, const Place& at, py::handle d) { return scalar_or_array(m.trained_depth(at, d)); },
          arg("at"), arg("d"), "Depth of the trained range in the direction of d, a float or (n,) [m].")
      .def(
          "bound", [](ModelObject& m, const Place& at, py::handle d) { return scalar_or_array(m.bound(at, d)); },
          arg("at"), arg("d"), R"(Bound of the error of force, a float or (n,) [N]; inf beyond the trained range.

It holds for random displacements with the coverage of the model (formats/model.md), and is no guarantee.
Error if the model has none (phynness calibrate).

>>> model = phynness.Model("examples/model")
>>> model.bound(95, [[0, 0, -0.01], [0, 0, -0.1]]).round(5)
array([0.00045,     inf])
)");
}

void add_surface(ModelClass& model) {
  model
      .def("nearest", &ModelObject::nearest, arg("x"),
           "The SurfacePoint of the undeformed surface that is nearest to x, and its position, each (3,) [m].")
      .def(
          "couple",
          [](py::object self, const std::vector<Place>& at, py::handle d, const Level& l) {
            return std::make_unique<Coupled>(std::move(self), at, d, l);
          },
          arg("at"), arg("d"), kw_only(), level(),
          R"(Forces of up to 8 tools at once, at nodes or between them; of one round tool.

at: a list of n nodes and SurfacePoints. d: (n, 3) [m]. Errors and warnings: as force. Of several
round tools a Body has the forces.

>>> model = phynness.Model("examples/model")
>>> point, position = model.nearest([0, 0, 0.1])
>>> both = model.couple([95, point], [[0, 0, -0.01], [0, 0, 0.002]])
>>> both.forces.shape, both.deform().shape
((2, 3), (146, 3))
)")
      .def("save", &ModelObject::save, arg("path"),
           "Writes a model directory, model.txt and mesh.txt; of a model that was read without a mesh the file alone.")
      .def_property_readonly("text", &ModelObject::text, "The content of model.txt, bytes.")
      .def_property_readonly("training", &ModelObject::training,
                             "Figures of train, a dict; None in a model that was read.");
  model.def_property_readonly(
      "levels",
      [](const ModelObject& m) {
        py::list all;
        for (std::int32_t l = 0; l < m.info().n_levels; ++l) {
          phn_level level;
          m.runtime().level_info(l, level).ignore();
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

void add_model(py::module_& module) {
  add_parts(module);
  ModelClass model(module, "Model", R"(A trained model.

path: a model directory, the path of a model.txt, or the content of a model.txt as bytes.

Error if it is missing or damaged. A model is constant; its arrays are views of it, which cannot be written to.

>>> model = phynness.Model("examples/model")
>>> model.family, model.n_nodes, len(model.active_nodes), model.triangles.shape
('modal', 200, 62, (382, 3))
)");
  add_responses(model);
  add_surface(model);
  add_properties(model);
}

}  // namespace phynness::python
