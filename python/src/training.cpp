// Training on a database, and on forces of one's own.
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/training/families.hpp>
#include <phynness/training/scattered_forces.hpp>
#include <phynness/training/training.hpp>

#include <atomic>
#include <chrono>
#include <future>
#include <string>

#include "open_database.hpp"

namespace phynness::python {
namespace {

/// Mean difference of given energies from those of the fitted forces, over the largest; a factor of two is beyond it.
constexpr double most_energy_error = 0.1;

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

py::object train_forces(const py::object& displacements, const py::object& forces, const py::object& energies,
                        int centers, const std::string& title) {
  const Points d = points_of(displacements, "displacements"), f = points_of(forces, "forces");
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

void add_training(py::module_& module) {
  using py::arg;
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
