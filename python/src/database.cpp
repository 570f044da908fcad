// Scenes and databases.
#include <pybind11/stl.h>
#include <phynness/formats/error.hpp>
#include <phynness/training/node_training.hpp>
#include <phynness/validation/locking.hpp>

#include <sstream>
#include <string>
#include <vector>

#include "open_database.hpp"

namespace phynness::python {
namespace {

/// The lines "key = value" of texts.
py::dict settings(const std::string& text) {
  py::dict all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(" = "); at != std::string::npos)
      all[py::str(line.substr(0, at))] = line.substr(at + 3);
  return all;
}

template <class Matrix>
auto copy_of_matrix(const Matrix& m) {
  return copy(m.data(), m.rows(), m.cols());
}

/// A column of all active nodes.
py::array column_of(const OpenDatabase& database, const std::string& name) {
  for (const auto& array : database.get()->columns()) {
    if (array.name != name) continue;
    py::array numbers(py::dtype(array.type), std::vector<py::ssize_t>(array.shape.begin(), array.shape.end()));
    database.get()->read(name, 0, array.shape.front(), numbers.mutable_data());
    return numbers;
  }
  throw py::key_error("the database has no column " + printable(name));
}

using py::arg;

void add_scene(py::module_& module) {
  py::class_<Scene>(module, "Scene", R"(A scene file (formats/scene.md).

Error with line, value and remedy if it is refused.

>>> scene = phynness.Scene("scenes/demo.toml")
>>> scene.settings["solver.element"], scene.settings["training.family"]
('es-p1-p1', 'modal')
)")
      .def(py::init([](const py::object& path) { return read_scene(path_of(path)); }), arg("path"))
      .def_static(
          "from_text",
          [](const std::string& text) { return parse_scene(text, "the text", std::filesystem::current_path()); },
          arg("text"), "The scene of a text, whose relative paths start at the working directory.")
      .def_readonly("title", &Scene::title)
      .def_readonly("text", &Scene::text)
      .def_property_readonly("physics_hash", &physics_hash, "Of all keys that affect a solve, 16 hexadecimal digits.")
      .def_property_readonly(
          "settings", [](const Scene& s) { return settings(physics_summary(s) + other_settings(s)); },
          "Every key \"section.name\" with its value as text, defaults included.")
      .def_property_readonly(
          "warnings", [](const Scene& s) { return scene_warnings(s); }, "Sentences about values that give bad results.")
      .def_property_readonly("notes", &scene_notes, "Sentences about the meaning of defaults.");
}

void add_arrays(py::class_<OpenDatabase>& database) {
  const auto property = [&](const char* name, const char* doc, auto&& get) {
    database.def_property_readonly(
        name, [get](const OpenDatabase& d) { return get(d.header()); }, doc);
  };
  using Header = const DatabaseHeader&;
  property("mesh_hash", "16 hexadecimal digits.", [](Header h) { return h.mesh_hash; });
  property("physics_hash", "Of the scene.", [](Header h) { return h.physics_hash; });
  property("software_version", "That solved it.", [](Header h) { return h.software_version; });
  property("nodes", "(n_nodes, 3) [m], undeformed.", [](Header h) { return copy_of_matrix(h.mesh.nodes); });
  property("cells", "(n, 4), of shells (n, 3).", [](Header h) { return copy_of_matrix(h.mesh.cells); });
  property("triangles", "Of the surface, (n, 3), normals outward.",
           [](Header h) { return copy_of_matrix(h.mesh.surface); });
  property("active_nodes", "Nodes that are probed, ascending.", [](Header h) { return copy(h.sets.active); });
  property("output_nodes", "Nodes whose displacement is stored.", [](Header h) { return copy(h.sets.output); });
  property("fixed_nodes", "Nodes that do not move.", [](Header h) { return copy(h.sets.fixed); });
  property("magnitudes_m", "Of the increments, ascending [m].", [](Header h) { return copy(h.magnitudes_m); });
}

}  // namespace

void add_database(py::module_& module) {
  add_scene(module);
  py::class_<OpenDatabase> database(module, "Database",
                                    R"(A finished database of phynness precompute (formats/database.md).

A mapping from names of columns, such as "force" and "displacement", to arrays, whose axes are active nodes, directions, and
those of a ray: increments, output nodes, components. Each access reads the whole column; h5py reads parts of a file. A
context manager closes it. Entries of increments that did not converge are 0: see column "status", 0 where it did.

Error if the file is missing, damaged or unfinished, or if it is closed.
)");
  database.def(py::init<const py::object&>(), arg("path"))
      .def("close", &OpenDatabase::close, "Closes the file. Arrays stay valid.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](OpenDatabase& d, const py::args&) { d.close(); })
      .def("__getitem__", &column_of, arg("name"))
      .def("__contains__",
           [](const OpenDatabase& d, const std::string& name) {
             const auto all = d.get()->columns();
             return std::any_of(all.begin(), all.end(), [&](const auto& column) { return column.name == name; });
           })
      .def("keys",
           [](const OpenDatabase& d) {
             std::vector<std::string> names;
             for (const auto& column : d.get()->columns()) names.push_back(column.name);
             return names;
           })
      .def_property_readonly("path", [](const OpenDatabase& d) { return d.path().string(); })
      .def_property_readonly(
          "scene", [](const OpenDatabase& d) { return stored_scene(d.header()); }, "The Scene that was solved.")
      .def_property_readonly(
          "displacements",
          [](const OpenDatabase& d) {
            const auto& h = d.header();
            auto all = copy_of_matrix(training_tables(h).displacements);
            return all.reshape({std::ssize(h.directions), std::ssize(h.magnitudes_m), std::ptrdiff_t{3}});
          },
          "Imposed displacements, (directions, increments, 3) [m].")
      .def_property_readonly(
          "directions",
          [](const OpenDatabase& d) {
            return copy(d.header().directions.data()->data(), std::ssize(d.header().directions), 3);
          },
          "Exploratory directions, unit vectors, (n, 3).");
  add_arrays(database);
}

}  // namespace phynness::python
