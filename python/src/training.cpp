// The module phynness._training: training on a database, which the package has where it was built with it.
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/training/families.hpp>
#include <phynness/training/training.hpp>

#include <pybind11/numpy.h>

#include <string>

namespace phynness::python {
namespace {

namespace py = pybind11;

/// [training] with other values: numbers and words of Python are written as JSON does, which TOML reads.
TrainingSpec chosen(const Scene& scene, const py::kwargs& given) {
  std::string keys;
  const auto dumps = py::module_::import("json").attr("dumps");
  for (const auto& [name, value] : given) {
    if (!py::isinstance<py::str>(value) && !PyNumber_Check(value.ptr()))
      throw py::type_error(name.cast<std::string>() + " must be a number or a word");
    const py::object plain =
        py::hasattr(value, "item") ? value.attr("item")() : py::reinterpret_borrow<py::object>(value);
    keys += name.cast<std::string>() + " = " + dumps(plain).cast<std::string>() + "\n";
  }
  return changed_training(scene, keys, "train()");
}

/// Texts of model.txt and mesh.txt, and the figures of the training.
py::tuple train_database(const py::object& path, const py::object& progress, int threads, const py::kwargs& given) {
  const auto database = Database::open(py::module_::import("os").attr("fsdecode")(path).cast<std::string>());
  const TrainingSpec spec = chosen(stored_scene(database.header()), given);
  ResponseSource source = responses_of(database);
  // HDF5 may not be thread-safe, and other threads of Python may use it.
  source.rays = [read = source.rays](std::int32_t active) {
    const py::gil_scoped_acquire acquire;
    return read(active);
  };
  const auto told = [&](std::int64_t done, std::int64_t all) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(done, all);
  };
  TrainingReport report;
  const Model model = [&] {
    const py::gil_scoped_release release;
    return train(source, spec, report, told, threads);
  }();
  py::dict figures;
  figures["trained_nodes"] = report.n_networks;
  figures["skipped_nodes"] = py::array_t<std::int32_t>(std::ssize(report.skipped_nodes), report.skipped_nodes.data());
  figures["increments"] = report.n_increments_used;
  figures["increments_fitted"] = report.n_increments_fitted;
  figures["seconds"] = report.seconds;
  for (const auto& figure : operations(model.family).figures(report)) figures[figure.key] = figure.value;
  return py::make_tuple(py::bytes(write_model_text(model)), py::bytes(write_mesh_text(database.header().mesh)),
                        figures);
}

}  // namespace
}  // namespace phynness::python

PYBIND11_MODULE(_training, module) {
  using namespace phynness::python;
  module.def("train", &train_database, py::arg("database"), py::arg("progress"), py::arg("threads"));
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const phynness::Error& error) {
      PyErr_SetString(py::module_::import("phynness").attr("Error").ptr(), error.what());
    }
  });
}
