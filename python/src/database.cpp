// Scenes, databases and training. HDF5 may not be thread-safe: all reading is done with the GIL held.
#include <pybind11/stl.h>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/training/families.hpp>
#include <phynness/training/node_training.hpp>
#include <phynness/training/scattered_forces.hpp>
#include <phynness/training/training.hpp>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "arrays.hpp"

namespace phynness::python {
namespace {

/// Mean difference of given energies from those of the fitted forces, over the largest; a factor of two is beyond it.
constexpr double most_energy_error = 0.1;

std::filesystem::path path_of(const py::object& given) {
  return py::module_::import("os").attr("fsdecode")(given).cast<std::string>();
}

/// The lines "key = value" of texts.
py::dict settings(const std::string& text) {
  py::dict all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(" = "); at != std::string::npos)
      all[py::str(line.substr(0, at))] = line.substr(at + 3);
  return all;
}

/// A copy of n x columns numbers.
template <class T>
py::array_t<T> copy(const T* numbers, py::ssize_t n, py::ssize_t columns = 0) {
  return columns == 0 ? py::array_t<T>({n}, numbers) : py::array_t<T>({n, columns}, numbers);
}
template <class T>
py::array_t<T> copy(const std::vector<T>& numbers) {
  return copy(numbers.data(), std::ssize(numbers));
}
template <class Matrix>
auto copy_of_matrix(const Matrix& m) {
  return copy(m.data(), m.rows(), m.cols());
}

class OpenDatabase {
 public:
  explicit OpenDatabase(const py::object& path) : _path(path_of(path)) {
    _database = std::make_shared<const Database>(Database::open(_path));
  }
  void close() { _database.reset(); }
  const std::shared_ptr<const Database>& get() const {
    if (!_database) raise("the database " + _path.string() + " is closed");
    return _database;
  }
  const DatabaseHeader& header() const { return get()->header(); }
  const std::filesystem::path& path() const { return _path; }

 private:
  std::filesystem::path _path;
  std::shared_ptr<const Database> _database;
};

/// A column, of which only what is indexed is read.
struct Column {
  py::object owner;
  ColumnArray array;

  py::ssize_t size() const { return static_cast<py::ssize_t>(array.shape.front()); }
  py::array read(std::size_t first, std::size_t count) const {
    std::vector<py::ssize_t> shape(array.shape.begin(), array.shape.end());
    shape[0] = static_cast<py::ssize_t>(count);
    py::array numbers(py::dtype(array.type), shape);
    owner.cast<const OpenDatabase&>().get()->read(array.name, first, count, numbers.mutable_data());
    return numbers;
  }
  py::object at(const py::object& key) const {
    if (py::isinstance<py::slice>(key)) {
      py::ssize_t start = 0, stop = 0, step = 0, n = 0;
      if (!key.cast<py::slice>().compute(size(), &start, &stop, &step, &n)) throw py::error_already_set();
      if (step == 1) return read(static_cast<std::size_t>(start), static_cast<std::size_t>(n));
    } else if (PyIndex_Check(key.ptr())) {
      auto i = py::int_(key).cast<py::ssize_t>();
      if (i < -size() || i >= size())
        throw py::index_error("there are " + std::to_string(size()) + " active nodes, and no index " +
                              std::to_string(i));
      return read(static_cast<std::size_t>(i < 0 ? i + size() : i), 1)[py::int_(0)];
    } else if (py::isinstance<py::tuple>(key) && !key.cast<py::tuple>().empty()) {
      const auto keys = key.cast<py::tuple>();
      const py::object first = keys[0];
      // The other axes are those of what is read.
      if (PyIndex_Check(first.ptr())) {
        const py::slice others(1, static_cast<py::ssize_t>(keys.size()), 1);
        return at(first)[keys[others]];
      }
    }
    return read(0, array.shape.front())[key];
  }
};

Column column_of(const py::object& database, const std::string& name) {
  for (auto& array : database.cast<const OpenDatabase&>().get()->columns())
    if (array.name == name) return {database, std::move(array)};
  throw py::key_error("the database has no column " + printable(name));
}

/// [training] with other values: numbers and words of Python are written as JSON does, which TOML reads.
TrainingSpec chosen(const Scene& scene, const py::kwargs& given) {
  std::string keys;
  const auto dumps = py::module_::import("json").attr("dumps");
  for (const auto& [name, value] : given) {
    if (!py::isinstance<py::str>(value) && !PyNumber_Check(value.ptr()))
      raise_type(name.cast<std::string>() + " must be a number or a word");
    const py::object plain =
        py::hasattr(value, "item") ? value.attr("item")() : py::reinterpret_borrow<py::object>(value);
    keys += name.cast<std::string>() + " = " + dumps(plain).cast<std::string>() + "\n";
  }
  return changed_training(scene, keys, "train()");
}

/// Works in another thread without the GIL, while this one looks for Ctrl-C and tells the progress.
Model trained(const ResponseSource& source, const TrainingSpec& spec, TrainingReport& report,
              const py::object& progress, int threads) {
  std::atomic<bool> is_stopped = false;
  std::atomic<std::int64_t> done = 0, total = 0;
  auto work = std::async(std::launch::async, [&] {
    return train(
        source, spec, report,
        [&](std::int64_t finished, std::int64_t all) {
          total = all;
          done = finished;
          return !is_stopped;
        },
        threads);
  });
  std::int64_t told = 0;
  const auto stop = [&] {
    is_stopped = true;
    const py::gil_scoped_release release;
    work.wait();
  };
  for (bool is_ready = false; !is_ready;) {
    {
      const py::gil_scoped_release release;
      is_ready = work.wait_for(std::chrono::milliseconds(20)) == std::future_status::ready;
    }
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none() && done != told) progress(told = done, total.load());
    } catch (...) {
      stop();
      throw;
    }
  }
  return work.get();
}

py::object train_database(const OpenDatabase& opened, const py::object& progress, int threads,
                          const py::kwargs& given) {
  const auto database = opened.get();  // stays open if it is closed meanwhile
  const Scene scene = stored_scene(database->header());
  const TrainingSpec spec = chosen(scene, given);
  ResponseSource source = responses_of(*database);
  source.rays = [read = source.rays](std::int32_t active) {
    const py::gil_scoped_acquire acquire;
    return read(active);
  };
  TrainingReport report;
  const Model model = trained(source, spec, report, progress, threads);
  py::dict figures;
  figures["trained_nodes"] = report.n_networks;
  figures["skipped_nodes"] = copy(report.skipped_nodes);
  figures["increments"] = report.n_increments_used;
  figures["increments_fitted"] = report.n_increments_fitted;
  figures["seconds"] = report.seconds;
  for (const auto& figure : operations(model.family).figures(report)) figures[figure.key] = figure.value;
  return model_of(write_model_text(model), "the trained model", py::bytes(write_mesh_text(database->header().mesh)),
                  figures);
}

Points points_of(const Vectors& vectors) {
  Points points(vectors.size(), 3);
  double x[3];
  for (py::ssize_t i = 0; i < points.rows(); ++i) {
    vectors.get(i, x);
    points.row(i) << x[0], x[1], x[2];
  }
  return points;
}

py::object train_forces(const py::object& displacements, const py::object& forces, const py::object& energies,
                        int centers, const std::string& title) {
  const Points d = points_of({displacements, "displacements"}), f = points_of({forces, "forces"});
  if (centers < 1 || centers > 100'000) throw py::value_error("centers must be from 1 to 100000");
  ScatteredFit made;
  {
    const py::gil_scoped_release release;
    made = fit_scattered(d, f, centers, title);
  }
  py::dict figures;
  figures["displacements_fitted"] = made.fitted;
  figures["training_error"] = made.fit.training_error;
  figures["left_out_error"] = made.fit.left_out_error;
  py::object model = model_of(write_model_text(made.model), "the trained model", py::none(), figures);
  if (energies.is_none()) return model;

  const auto given = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(energies);
  if (!given || given.ndim() != 1 || given.shape(0) != d.rows())
    throw py::value_error("energies must be " + std::to_string(d.rows()) + " numbers, one of each displacement");
  const auto found = model.attr("energy")(0, displacements).cast<py::array_t<double>>();
  double error = 0, largest = 0;
  for (py::ssize_t i = 0; i < d.rows(); ++i) {
    error += std::abs(found.at(i) - given.at(i)) / static_cast<double>(d.rows());
    largest = std::max(largest, std::abs(given.at(i)));
  }
  // Not negated, because an energy may be NaN.
  if (!(error <= most_energy_error * largest))
    raise("the energies are not those of the forces, whose mean difference is " + std::to_string(error) + " J\n" +
          "  remedy: check units, and that an energy is 0 at rest; forces are those that hold the displacements");
  figures["energy_error"] = largest > 0 ? error / largest : 0.0;
  return model;
}

}  // namespace

void add_database(py::module_& module) {
  using py::arg;
  py::class_<Scene>(module, "Scene", R"(A scene file (formats/scene.md).

Error with line, value and remedy if it is refused.

>>> scene = phynness.Scene("scenes/demo.toml")
>>> scene.settings["solver.element"], scene.settings["training.family"]
('p1-p1', 'modal')
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

  py::class_<Column>(module, "Column",
                     "A column of a Database, of which numpy reads only the active nodes that are indexed.\n\n"
                     "Axes: active nodes, directions, and those of a ray: increments, output nodes, components.")
      .def_property_readonly("name", [](const Column& c) { return c.array.name; })
      .def_property_readonly("unit", [](const Column& c) { return c.array.unit; })
      .def_property_readonly("description", [](const Column& c) { return c.array.description; })
      .def_property_readonly("shape", [](const Column& c) { return py::tuple(py::cast(c.array.shape)); })
      .def_property_readonly("dtype", [](const Column& c) { return py::dtype(c.array.type); })
      .def("__len__", &Column::size)
      .def("__getitem__", &Column::at, arg("key"))
      .def(
          "__array__",
          [](const Column& c, const py::object& dtype) -> py::object {
            py::array all = c.read(0, c.array.shape.front());
            return dtype.is_none() ? py::object(all) : all.attr("astype")(dtype);
          },
          arg("dtype") = py::none());

  py::class_<OpenDatabase> database(module, "Database",
                                    R"(A finished database of phynness precompute (formats/database.md).

A mapping from names of columns, such as "force" and "displacement", to Column; a context manager that closes the file.
Its other arrays are copies. Entries of increments that did not converge are 0: see column "status", 0 where it did.

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
  const auto property = [&](const char* name, auto&& get, const char* doc) {
    database.def_property_readonly(
        name, [get](const OpenDatabase& d) { return get(d.header()); }, doc);
  };
  using Header = const DatabaseHeader&;
  property(
      "mesh_hash", [](Header h) { return h.mesh_hash; }, "16 hexadecimal digits.");
  property(
      "physics_hash", [](Header h) { return h.physics_hash; }, "Of the scene.");
  property(
      "software_version", [](Header h) { return h.software_version; }, "That solved it.");
  property(
      "nodes", [](Header h) { return copy_of_matrix(h.mesh.nodes); }, "(n_nodes, 3) [m], undeformed.");
  property(
      "cells", [](Header h) { return copy_of_matrix(h.mesh.cells); }, "(n, 4), of shells (n, 3).");
  property(
      "triangles", [](Header h) { return copy_of_matrix(h.mesh.surface); }, "Of the surface, (n, 3), normals outward.");
  property(
      "active_nodes", [](Header h) { return copy(h.sets.active); }, "Nodes that are probed, ascending.");
  property(
      "output_nodes", [](Header h) { return copy(h.sets.output); }, "Nodes whose displacement is stored.");
  property(
      "fixed_nodes", [](Header h) { return copy(h.sets.fixed); }, "Nodes that do not move.");
  property(
      "magnitudes_m", [](Header h) { return copy(h.magnitudes_m); }, "Of the increments, ascending [m].");

  module.def("train", &train_database, arg("database"), py::kw_only(), arg("progress") = py::none(), arg("threads") = 0,
             R"(Trains a Model on a Database; its figures are in Model.training.

progress: called with the numbers of trained and of all nodes. threads: 0: one for each core; the result does not depend on it.
Other arguments are keys of [training] (formats/scene.md), which replace those of the database's scene, as family="modal".

Error for impossible values, as in a scene. Ctrl-C ends the training.
)");
  module.def("train_forces", &train_forces, arg("displacements"), arg("forces"), arg("energies") = py::none(),
             py::kw_only(), arg("centers") = 80, arg("title") = "",
             R"(Trains a Model on forces of one place at any displacements.

displacements, forces: (n, 3) [m], [N], of at least 6 displacements; a force is the one that holds its displacement.
energies: (n,) [J], compared with those of the fit, which uses forces only. centers: largest number, at most half of n.

The model has the one node 0, energy and stiffness, and no deformation. The range is that of the displacements. At most 600 of
them are fitted, spread over directions and depths: Model.training tells how many. Errors: scattered_forces.hpp.

>>> d = np.random.default_rng(1).normal(size=(60, 3)) * 0.003
>>> model = phynness.train_forces(d, 30 * d)
>>> bool(np.allclose(model.stiffness(0, [0, 0, 0]), 30 * np.eye(3), atol=1e-3))
True
)");
}

}  // namespace phynness::python
