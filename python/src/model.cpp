// Models: the runtime's wrapper (phynness.hpp) on arrays. Working memory is taken from the model's store for each call,
// so that threads never share it; the store itself is only used by a thread that holds the GIL.
#include <pybind11/stl.h>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/phynness.hpp>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arrays.hpp"

namespace phynness::python {
namespace {

using Level = std::optional<std::int32_t>;

/// A place on the surface: what tools of the runtime have besides their displacement.
struct SurfacePoint {
  phn_tool tool{{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};

  SurfacePoint() = default;
  SurfacePoint(const std::vector<std::int32_t>& nodes, const std::vector<double>& weights) {
    if (nodes.empty() || nodes.size() > 3 || weights.size() != nodes.size())
      throw py::value_error("a point has one to three nodes and a weight for each of them");
    std::copy(nodes.begin(), nodes.end(), tool.nodes);
    std::copy(weights.begin(), weights.end(), tool.weights);
  }
  std::size_t n() const { return static_cast<std::size_t>(std::find(tool.nodes, tool.nodes + 3, -1) - tool.nodes); }
  py::tuple nodes() const { return py::tuple(py::cast(std::vector(tool.nodes, tool.nodes + n()))); }
  py::tuple weights() const { return py::tuple(py::cast(std::vector(tool.weights, tool.weights + n()))); }
  std::string text() const {
    return "SurfacePoint(" + py::repr(nodes()).cast<std::string>() + ", " + py::repr(weights()).cast<std::string>() +
           ")";
  }
};

/// Where a tool is: at a node, or at a point of the surface.
using Place = std::variant<std::int64_t, SurfacePoint>;

phn_tool tool_at(const Place& at) {
  if (const auto* point = std::get_if<SurfacePoint>(&at)) return point->tool;
  const auto node = std::get<std::int64_t>(at);
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  return {{node < 0 || node > most ? -1 : static_cast<std::int32_t>(node), -1, -1}, {1, 0, 0}, {0, 0, 0}};
}

/// Answers the questions about one place by the functions for nodes, or those for points.
struct Asked {
  phn_tool tool;
  bool is_node;
  const Place& at;

  explicit Asked(const Place& place) : tool(tool_at(place)), is_node(place.index() == 0), at(place) {}
  std::string name() const {
    return is_node ? "node " + std::to_string(std::get<std::int64_t>(at)) : std::get<SurfacePoint>(at).text();
  }
};

class Model {
 public:
  Model(std::string name, std::string text, py::object mesh, py::object training)
      : _text(std::move(text)), _mesh(std::move(mesh)), _training(std::move(training)), _model(_text) {
    if (_model) return;
    const int status = _model.status();
    std::string said = name + ": " + _model.status().message();
    try {
      read_model_text(_text, name);
    } catch (const Error& error) {
      said = error.what();
    }
    raise(said, status);
  }
  static std::unique_ptr<Model> open(const py::object& of) {
    if (py::isinstance<py::bytes>(of))
      return std::make_unique<Model>("the text", of.cast<std::string>(), py::none(), py::none());
    const std::filesystem::path path = py::module_::import("os").attr("fsdecode")(of).cast<std::string>();
    std::error_code code;
    constexpr std::uint64_t most_bytes = std::uint64_t{1} << 40;
    const bool is_folder = std::filesystem::is_directory(path, code);
    const auto file = is_folder ? path / "model.txt" : path;
    auto text =
        read_input_file(file, {"the model", "give a model directory, or the path of its model.txt", most_bytes, true});
    py::object mesh = py::none();
    if (is_folder && std::filesystem::exists(path / "mesh.txt", code))
      mesh = py::bytes(read_input_file(path / "mesh.txt", {"the mesh", "restore mesh.txt", most_bytes, true}));
    return std::make_unique<Model>(file.string(), std::move(text), std::move(mesh), py::none());
  }

  const phn_info& info() const { return _model.info(); }
  py::bytes text() const { return _text; }
  py::object training() const { return _training; }
  void save(const py::object& to) const {
    const std::filesystem::path path = py::module_::import("os").attr("fsdecode")(to).cast<std::string>();
    if (_mesh.is_none())
      write_text_file(path, _text);
    else
      write_model_texts(path, {_text, _mesh.cast<std::string>()});
  }
  py::tuple pickled() const { return py::make_tuple(text(), _mesh, _training); }

  /// Force, energy and stiffness, of which only those that are asked for are computed.
  struct Response {
    std::optional<py::array_t<double>> force, energy, stiffness;
  };
  Response response(const Place& at, py::handle displacements, const Level& level, bool force, bool energy,
                    bool stiffness) {
    const Vectors d(displacements, "d");
    Response made;
    double *f = nullptr, *e = nullptr, *k = nullptr;
    if (force) f = made.force.emplace(results(d, {3})).mutable_data();
    if (energy) e = made.energy.emplace(results(d, {})).mutable_data();
    if (stiffness) k = made.stiffness.emplace(results(d, {3, 3})).mutable_data();
    Asked asked(at);
    Lease data(*this, level);
    double unused[3];
    for_each(d, asked, [&](py::ssize_t i, const double(&x)[3]) {
      double *const fi = f ? f + 3 * i : unused, *const ei = e ? e + i : nullptr, *const ki = k ? k + 9 * i : nullptr;
      if (asked.is_node) return phn_force(_model.get(), data->get(), asked.tool.nodes[0], x, fi, ei, ki);
      std::copy(x, x + 3, asked.tool.displacement);
      return phn_force_at(_model.get(), data->get(), &asked.tool, fi, ei, ki);
    });
    return made;
  }

  py::array_t<double> deform(const Place& at, py::handle displacements, const Level& level) {
    const Vectors d(displacements, "d");
    auto made = results(d, {info().n_output, 3});
    const auto n = 3 * static_cast<py::ssize_t>(info().n_output);
    Asked asked(at);
    Lease data(*this, level);
    for_each(d, asked, [&, out = made.mutable_data()](py::ssize_t i, const double(&x)[3]) {
      if (asked.is_node) return phn_deform(_model.get(), data->get(), asked.tool.nodes[0], x, out + n * i);
      std::copy(x, x + 3, asked.tool.displacement);
      double force[3];
      const int status = phn_couple(_model.get(), data->get(), 1, &asked.tool, force, nullptr);
      return status < 0 ? status : phn_coupled_deform(_model.get(), data->get(), out + n * i) | status;
    });
    return made;
  }

  py::array_t<double> field(std::int64_t node, py::handle displacements, const std::string& name, const Level& level) {
    std::int32_t number = 0;
    while (number < info().n_fields && name != info().field_names[number]) ++number;
    if (number == info().n_fields) raise("the model has no field " + printable(name), PHN_ERROR_UNDEFINED);
    const Vectors d(displacements, "d");
    auto made = results(d, {info().n_output});
    const Place at(node);
    const Asked asked(at);
    Lease data(*this, level);
    for_each(d, asked, [&, out = made.mutable_data()](py::ssize_t i, const double(&x)[3]) {
      return phn_field(_model.get(), data->get(), asked.tool.nodes[0], x, number, out + info().n_output * i);
    });
    return made;
  }

  /// A number about each displacement, without warnings, because it tells of them.
  template <class Value>
  py::array_t<double> number(const Place& at, py::handle displacements, Value&& value) {
    const Vectors d(displacements, "d");
    auto made = results(d, {});
    Asked asked(at);
    for_each(d, asked, [&, out = made.mutable_data()](py::ssize_t i, const double(&x)[3]) {
      std::copy(x, x + 3, asked.tool.displacement);
      return std::min(value(asked, out[i]), 0);
    });
    return made;
  }
  py::array_t<double> bound(const Place& at, py::handle displacements) {
    return number(at, displacements, [this](const Asked& asked, double& bound) {
      const int status = asked.is_node ? phn_bound(_model.get(), asked.tool.nodes[0], asked.tool.displacement, &bound)
                                       : phn_bound_at(_model.get(), &asked.tool, &bound);
      if (bound >= PHN_NO_BOUND) bound = std::numeric_limits<double>::infinity();
      return status;
    });
  }
  py::array_t<double> trust(const Place& at, py::handle displacements, double phn_trusted::*what) {
    return number(at, displacements, [&](const Asked& asked, double& value) {
      phn_trusted trusted;
      const int status = asked.is_node ? phn_trust(_model.get(), asked.tool.nodes[0], asked.tool.displacement, &trusted)
                                       : phn_trust_at(_model.get(), &asked.tool, &trusted);
      value = trusted.*what;
      return status;
    });
  }

  py::tuple nearest(py::handle x) const {
    const Vectors point(x, "x");
    if (!point.is_one()) throw py::value_error("x must have the shape (3,)");
    double from[3];
    point.get(0, from);
    SurfacePoint found;
    py::array_t<double> position(3);
    Tally tally;
    tally.add(0, phn_nearest(_model.get(), from, &found.tool, position.mutable_data()));
    tally.report("x", 1);
    return py::make_tuple(found, position);
  }

  std::vector<phn_level> levels() const {
    std::vector<phn_level> all(static_cast<std::size_t>(info().n_levels));
    for (std::size_t l = 0; l < all.size(); ++l) _model.level_info(static_cast<std::int32_t>(l), all[l]).ignore();
    return all;
  }
  const rt::Model& runtime() const { return _model; }
  static void set_level(rt::Tools& data, const Level& level, std::int32_t n_levels) {
    const int status = data.set_level(level.value_or(n_levels - 1));
    if (status < 0)
      raise("the model has the levels 0 to " + std::to_string(n_levels - 1) + ", not " + std::to_string(*level),
            status);
  }

 private:
  /// Working memory of one call. It is taken and given back with the GIL held.
  class Lease {
   public:
    Lease(Model& model, const Level& level) : _of(model) {
      if (model._store.empty()) {
        _data = std::make_unique<rt::Tools>(model._model, 1);
        if (!*_data) raise(_data->status().message(), _data->status());
      } else {
        _data = std::move(model._store.back());
        model._store.pop_back();
      }
      set_level(*_data, level, model.info().n_levels);
    }
    ~Lease() { _of._store.push_back(std::move(_data)); }
    Lease(const Lease&) = delete;
    rt::Tools* operator->() const { return _data.get(); }

   private:
    Model& _of;
    std::unique_ptr<rt::Tools> _data;
  };

  /// Evaluates all rows, those of large arrays without the GIL; Ctrl-C ends them.
  /// @param evaluate  of a row and its displacement, returns a status
  template <class Evaluate>
  static void for_each(const Vectors& d, const Asked& asked, Evaluate&& evaluate) {
    Tally tally;
    const auto some = [&](py::ssize_t begin, py::ssize_t end) {
      double x[3];
      for (py::ssize_t i = begin; i < end; ++i) {
        d.get(i, x);
        if (!tally.add(i, evaluate(i, x))) return false;
      }
      return true;
    };
    if (d.is_one()) {
      some(0, 1);
    } else {
      constexpr py::ssize_t at_once = 1 << 14;
      bool goes_on = true;
      for (py::ssize_t i = 0; i < d.size() && goes_on; i += at_once) {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        const py::gil_scoped_release release;
        goes_on = some(i, std::min(d.size(), i + at_once));
      }
    }
    if (tally.is_unusual()) tally.report(asked.name(), d.size());
  }

  std::string _text;
  py::object _mesh, _training;
  rt::Model _model;
  std::vector<std::unique_ptr<rt::Tools>> _store;
};

/// Several tools at once, with the working memory that remembers them.
class Coupled {
 public:
  Coupled(py::object owner, const std::vector<Place>& at, py::handle displacements, const Level& level)
      : _owner(std::move(owner)), _model(_owner.cast<Model&>()) {
    const Vectors d(displacements, "d");
    if (d.is_one() || d.size() != static_cast<py::ssize_t>(at.size()))
      throw py::value_error("d must have the shape (" + std::to_string(at.size()) +
                            ", 3): a displacement for each place");
    if (at.empty()) throw py::value_error("there is no tool");
    std::vector<phn_tool> tools;
    for (std::size_t i = 0; i < at.size(); ++i)
      d.get(static_cast<py::ssize_t>(i), tools.emplace_back(tool_at(at[i])).displacement);
    if (at.size() > PHN_MOST_COUPLED) raise(phn_status_message(PHN_ERROR_TOO_MANY_TOOLS), PHN_ERROR_TOO_MANY_TOOLS);
    _data = rt::Tools(_model.runtime(), static_cast<std::int32_t>(at.size()));
    if (!_data) raise(_data.status().message(), _data.status());
    Model::set_level(_data, level, _model.info().n_levels);
    forces = py::array_t<double>({static_cast<py::ssize_t>(at.size()), py::ssize_t{3}});
    double* const f = forces.mutable_data();
    Tally tally;
    {
      const py::gil_scoped_release release;
      tally.add(0, _data.couple(tools, rt::Span<double>(f, 3 * tools.size()), &result));
    }
    tally.report(at.size() == 1 ? "one tool" : std::to_string(at.size()) + " tools", 1);
  }

  // With the GIL held, because two threads may have the same object.
  py::array_t<double> deform() {
    py::array_t<double> out({static_cast<py::ssize_t>(_model.info().n_output), py::ssize_t{3}});
    Tally tally;
    tally.add(0, phn_coupled_deform(_model.runtime().get(), _data.get(), out.mutable_data()));
    tally.report("coupled tools", 1);
    return out;
  }
  py::array_t<double> bounds() const {
    double bounds[PHN_MOST_COUPLED];
    Tally tally;
    tally.add(0, std::min<int>(_data.coupled_bound(bounds), 0));
    tally.report("bounds of coupled tools", 1);
    for (double& bound : bounds)
      if (bound >= PHN_NO_BOUND) bound = std::numeric_limits<double>::infinity();
    return py::array_t<double>(forces.shape(0), bounds);
  }

  py::array_t<double> forces;
  phn_coupled result{};

 private:
  py::object _owner;
  Model& _model;
  rt::Tools _data;
};

/// A number of one vector, or the array of those of several.
py::object scalar_or_array(py::array_t<double> array) {
  if (array.ndim() == 0) return py::float_(*array.data());
  return array;
}
template <class T>
py::object or_none(std::optional<T> value) {
  return value ? scalar_or_array(std::move(*value)) : py::none();
}

}  // namespace

py::object model_of(const std::string& text, const std::string& name, py::object mesh, py::object training) {
  return py::cast(std::make_unique<Model>(name, text, std::move(mesh), std::move(training)));
}

void add_model(py::module_& module) {
  using py::arg, py::kw_only;
  const auto level = arg("level") = py::none();

  py::class_<SurfacePoint>(module, "SurfacePoint",
                           "A place on the surface: one to three nodes of a triangle, with barycentric weights >= 0 of "
                           "sum 1.\n\nSee Model.nearest.")
      .def(py::init<const std::vector<std::int32_t>&, const std::vector<double>&>(), arg("nodes"), arg("weights"))
      .def_property_readonly("nodes", &SurfacePoint::nodes)
      .def_property_readonly("weights", &SurfacePoint::weights)
      .def("__repr__", &SurfacePoint::text);

  py::class_<phn_level>(module, "Level",
                        "Sizes and errors of a level of a model (phynness_levels.h); errors are fractions of the "
                        "largest force and displacement, 0 without an estimate.")
      .def_readonly("force_centers", &phn_level::force_centers)
      .def_readonly("deformation_centers", &phn_level::deformation_centers)
      .def_readonly("modes", &phn_level::modes)
      .def_readonly("error_force", &phn_level::error_force)
      .def_readonly("error_displacement", &phn_level::error_displacement);

  py::class_<Coupled>(
      module, "Coupled",
      "Several tools at once, of Model.couple: forces (n, 3) [N], energy [J], and residual, the largest "
      "distance of a tool from the point that it holds [m].")
      .def_readonly("forces", &Coupled::forces)
      .def_property_readonly("energy", [](const Coupled& c) { return c.result.energy; })
      .def_property_readonly("residual", [](const Coupled& c) { return c.result.residual; })
      .def("deform", &Coupled::deform, "Displacements of all output nodes, (n_output, 3) [m].")
      .def("bounds", &Coupled::bounds,
           "Bounds of the errors of the forces, (n,) [N]; inf where nothing is known. Error if the model has none.");

  py::class_<Model> model(module, "Model", R"(A trained model.

path: a model directory, the path of a model.txt, or the content of a model.txt as bytes.

Error if it is missing or damaged. A model is constant; its arrays are views of it, which cannot be written to.

>>> model = phynness.Model("examples/model")
>>> model.family, model.n_nodes, len(model.active_nodes), model.triangles.shape
('modal', 200, 62, (382, 3))
)");
  model.def(py::init(&Model::open), arg("path"))
      .def(
          "force",
          [](Model& m, const Place& at, py::handle d, const Level& l) {
            return *m.response(at, d, l, true, false, false).force;
          },
          arg("at"), arg("d"), kw_only(), level, R"(Force that holds the displacement d, (3,) or (n, 3) [N].

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
          [](Model& m, const Place& at, py::handle d, const Level& l) {
            return scalar_or_array(*m.response(at, d, l, false, true, false).energy);
          },
          arg("at"), arg("d"), kw_only(), level,
          "Stored energy, a float or (n,) [J]; the force is its gradient. Error in family rbfn. As force.")
      .def(
          "stiffness",
          [](Model& m, const Place& at, py::handle d, const Level& l) {
            return *m.response(at, d, l, false, false, true).stiffness;
          },
          arg("at"), arg("d"), kw_only(), level,
          "Derivative of the force, symmetric, (3, 3) or (n, 3, 3) [N/m]. Error in family rbfn. As force.")
      .def(
          "response",
          [](Model& m, const Place& at, py::handle d, const Level& l) {
            auto made = m.response(at, d, l, true, true, true);
            return py::make_tuple(*made.force, scalar_or_array(*made.energy), *made.stiffness);
          },
          arg("at"), arg("d"), kw_only(), level,
          "Force, energy and stiffness together, in 1.6 times the time of a force, with the same bits as alone.")
      .def("deform", &Model::deform, arg("at"), arg("d"), kw_only(), level,
           R"(Displacements of all output nodes under one tool, (n_output, 3) or (n, n_output, 3) [m].

at, level, errors and warnings: as force, and every point of the surface.

>>> model = phynness.Model("examples/model")
>>> point, position = model.nearest([0, 0, 0.1])
>>> model.deform(point, [0, 0, -0.01]).shape == model.output_points.shape
True
)")
      .def(
          "field", &Model::field, arg("node"), arg("d"), arg("name"), kw_only(), level,
          "A scalar field at all output nodes, (n_output,) or (n, n_output), in its unit in fields. Error if the model "
          "has no such field.")
      .def(
          "bound", [](Model& m, const Place& at, py::handle d) { return scalar_or_array(m.bound(at, d)); }, arg("at"),
          arg("d"), R"(Bound of the error of force, a float or (n,) [N]; inf beyond the trained range.

It holds for random displacements with the coverage of the model (formats/model.md), and is no guarantee.
Error if the model has none (phynness calibrate).

>>> model = phynness.Model("examples/model")
>>> model.bound(95, [[0, 0, -0.01], [0, 0, -0.1]]).round(5)
array([0.00045,     inf])
)")
      .def("nearest", &Model::nearest, arg("x"),
           "The SurfacePoint of the undeformed surface that is nearest to x, and its position, each (3,) [m].")
      .def(
          "couple",
          [](py::object self, const std::vector<Place>& at, py::handle d, const Level& l) {
            return std::make_unique<Coupled>(std::move(self), at, d, l);
          },
          arg("at"), arg("d"), kw_only(), level, R"(Forces of up to 8 tools at once, at nodes or between them.

at: a list of n nodes and SurfacePoints. d: (n, 3) [m]. Errors and warnings: as force.

>>> model = phynness.Model("examples/model")
>>> point, position = model.nearest([0, 0, 0.1])
>>> both = model.couple([95, point], [[0, 0, -0.01], [0, 0, 0.002]])
>>> both.forces.shape, both.deform().shape
((2, 3), (146, 3))
)")
      .def("save", &Model::save, arg("path"),
           "Writes a model directory, model.txt and mesh.txt; of a model that was read without a mesh the file alone.")
      .def_property_readonly("text", &Model::text, "The content of model.txt, bytes.")
      .def_property_readonly("training", &Model::training, "Figures of train, a dict; None in a model that was read.")
      .def_property_readonly("levels", &Model::levels, "A list of Level; the last one is the full model.")
      .def(py::pickle([](const Model& m) { return m.pickled(); },
                      [](const py::tuple& t) {
                        return std::make_unique<Model>("the text", t[0].cast<std::string>(), t[1], t[2]);
                      }));
  const auto trust = [&](const char* name, double phn_trusted::*what, const char* doc) {
    model.def(
        name, [what](Model& m, const Place& at, py::handle d) { return scalar_or_array(m.trust(at, d, what)); },
        arg("at"), arg("d"), doc);
  };
  trust("trained_depth", &phn_trusted::trained_depth,
        "Depth of the trained range in the direction of d, a float or (n,) [m].");
  trust("trained_distance", &phn_trusted::relative,
        "Distance of d from the training data, a float or (n,): 0 at data, above 1 extrapolation.");

  const auto property = [&](const char* name, auto phn_info::*member, const char* doc) {
    model.def_property_readonly(
        name, [member](const Model& m) { return m.info().*member; }, doc);
  };
  property("family", &phn_info::family, "\"modal\", \"rbfn\" or \"linear\".");
  property("title", &phn_info::title, "Of the scene.");
  property("mesh_hash", &phn_info::mesh_hash, "16 hexadecimal digits.");
  property("max_displacement_m", &phn_info::max_displacement_m, "Largest displacement of the training data [m].");
  property("n_nodes", &phn_info::n_nodes, "Of the mesh.");
  model.def_property_readonly(
      "has_energy", [](const Model& m) { return m.info().has_energy != 0; }, "False in family rbfn.");
  model.def_property_readonly(
      "fields",
      [](const Model& m) {
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
          const phn_info& info = self.cast<const Model&>().info();
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

}  // namespace phynness::python
