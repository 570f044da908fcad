// Training on a database.
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/training/families.hpp>
#include <phynness/training/training.hpp>

#include <atomic>
#include <chrono>
#include <future>
#include <string>

#include "open_database.hpp"

namespace phynness::python {
namespace {

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
  // A copy, so that the file stays open if it is closed meanwhile.
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
  const auto database = opened.get();
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

}  // namespace

void add_training(py::module_& module) {
  using py::arg;
  module.def("train", &train_database, arg("database"), py::kw_only(), arg("progress") = py::none(), arg("threads") = 0,
             R"(Trains a Model on a Database; its figures are in Model.training.

progress: called with the numbers of trained and of all nodes. threads: 0: one for each core; the result does not depend on it.
Other arguments are keys of [training] (formats/scene.md), which replace those of the database's scene, as family="modal".

Error for impossible values, as in a scene. Ctrl-C ends the training.
)");
}

}  // namespace phynness::python
