// Organ, as Python sees it: a model, a body or both, for several tools and for spheres.
#include <pybind11/stl.h>

#include <phynness/phynness_batch.hpp>

#include <filesystem>
#include <limits>

#include "organ.hpp"

namespace phynness::python {

Organ organ_of(const NamedText& model, const NamedText& body, std::int32_t max_tools, std::int32_t steps) {
  Organ organ(model.text, body.text, max_tools, steps);
  if (organ) return organ;
  const NamedText& wrong = organ.model() == nullptr && !model.text.empty() ? model : body;
  std::string said = wrong.name + ": " + organ.status().message();
  if (organ.model() != nullptr && organ.body() != nullptr)
    said = body.name + " is a body of another mesh than " + model.name;
  else if (const std::size_t at = organ.wrong_byte(); at > 0)
    said += " (line " +
            std::to_string(
                1 + std::count(wrong.text.begin(), wrong.text.begin() + static_cast<std::ptrdiff_t>(at - 1), '\n')) +
            ")";
  raise(said, organ.status());
}

py::object nearest_places(const Organ& organ, py::handle x) {
  const Vectors points(x, "x");
  py::list found;
  Tally tally;
  for (py::ssize_t i = 0; i < points.size(); ++i) {
    SurfacePoint place;
    double from[3], at[3], distance = 0;
    points.get(i, from);
    if (!tally.add(i, organ.nearest(from, place.tool, at, distance))) break;
    place.position = py::array_t<double>(3, at);
    place.distance = py::float_(distance);
    found.append(std::move(place));
  }
  tally.report([](py::ssize_t) { return std::string("x"); }, points.size());
  return points.is_one() ? py::object(found[0]) : py::object(found);
}

namespace {

using py::arg, py::kw_only;

struct Held {
  using OfModule = void;
  py::array_t<double> forces;
  OrganReport report;
  int status;
};

struct Touched {
  using OfModule = void;
  py::array_t<double> forces, proxies, normals;
  py::array_t<bool> in_contact;
  OrganReport report;
  int status;
};

/// Used with the GIL held.
class OrganObject {
 public:
  using OfModule = void;
  OrganObject(NamedText model, NamedText body, std::int32_t of_max_tools, std::int32_t of_steps)
      : model_text(std::move(model.text)), body_text(std::move(body.text)), max_tools(of_max_tools), steps(of_steps) {
    if (max_tools < 1) throw py::value_error("max_tools must be 1 or more");
    if (steps < 1) throw py::value_error("steps must be 1 or more");
    model.text = model_text;
    body.text = body_text;
    organ = organ_of(model, body, max_tools, steps);
  }

  static std::unique_ptr<OrganObject> open(const py::object& model, const py::object& body, std::int32_t max_tools,
                                           std::int32_t steps) {
    NamedText of_model, of_body;
    if (py::isinstance<ModelObject>(model)) {
      of_model = {"the model", model.cast<const ModelObject&>().text};
    } else if (!model.is_none()) {
      of_model = text_of(model, "model.txt", "the model");
    }
    if (!body.is_none()) of_body = text_of(body, "body.txt", "the body");
    if (model.is_none() && body.is_none()) raise("an organ is made of a model, a body, or both");
    return std::make_unique<OrganObject>(std::move(of_model), std::move(of_body), max_tools, steps);
  }

  Held hold(py::handle at, py::handle displacements, std::int32_t increments, double dt) {
    Tools tools(at, displacements);
    const auto n = static_cast<std::size_t>(tools.size());
    if (increments < 0) throw py::value_error("increments must be 0 or more");
    if (!(dt >= 0)) throw py::value_error("dt must be 0 or more");
    const double part_of_dt = dt / std::max(increments, 1);
    std::vector<phn_tool> wanted;
    for (py::ssize_t i = 0; i < tools.size(); ++i) wanted.push_back(tools.get(i));
    Held held{tools.results({3}), {}, 0};
    Span<double> forces(held.forces.mutable_data(), 3 * n);
    if (increments > 0) organ.reset().ignore();
    for (std::int32_t i = 1; i <= std::max(increments, 1); ++i) {
      auto part = wanted;
      for (std::size_t t = 0; t < n && increments > 0; ++t)
        for (int k = 0; k < 3; ++k) part[t].displacement[k] = wanted[t].displacement[k] * i / increments;
      held.status = organ.hold(part, forces, &held.report);
      if (held.status >= 0 && dt > 0) {
        const int relaxed = organ.relax(part, part_of_dt, forces);
        held.status = relaxed < 0 ? relaxed : held.status | relaxed;
      }
      if (held.status < 0) break;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    report(held.status, n == 1 ? tools.name(0) : std::to_string(n) + " tools");
    n_held = n;
    return held;
  }

  Touched touch(py::handle centers, double radius, double friction, const std::string& mode) {
    const Vectors at(centers, "centers");
    const int modes = mode == "press" ? PHN_TOOL_PRESS : mode == "grasp" ? PHN_TOOL_GRASP : PHN_TOOL_OFF;
    if (modes == PHN_TOOL_OFF && mode != "off") throw py::value_error("mode must be \"press\", \"grasp\" or \"off\"");
    const py::ssize_t n = at.size();
    std::vector<phn_contact_tool> spheres(static_cast<std::size_t>(n));
    std::vector<phn_contact_state> states(spheres.size());
    for (py::ssize_t i = 0; i < n; ++i) {
      phn_contact_tool& sphere = spheres[static_cast<std::size_t>(i)];
      at.get(i, sphere.center);
      sphere.radius = radius;
      sphere.friction = friction;
      sphere.mode = modes;
    }
    Touched made{vectors(n), vectors(n), vectors(n), py::array_t<bool>(n), {}, 0};
    made.status = organ.touch(spheres, states, &made.report);
    report(made.status, std::to_string(n) + " spheres");
    for (py::ssize_t i = 0; i < n; ++i) {
      const phn_contact_state& state = states[static_cast<std::size_t>(i)];
      std::copy_n(state.force, 3, made.forces.mutable_data(i));
      std::copy_n(state.proxy, 3, made.proxies.mutable_data(i));
      std::copy_n(state.normal, 3, made.normals.mutable_data(i));
      made.in_contact.mutable_at(i) = state.in_contact != 0;
    }
    return made;
  }

  py::array_t<double> deform() {
    const auto n = static_cast<py::ssize_t>(organ.n_deform());
    py::array_t<double> out({n / 3, py::ssize_t{3}});
    const int status = organ.deform({out.mutable_data(), static_cast<std::size_t>(n)});
    report(std::min(status, 0), "deform");  // hold and touch warned
    return out;
  }

  py::array_t<double> bound() {
    py::array_t<double> bounds(static_cast<py::ssize_t>(n_held));
    const int status = organ.bound({bounds.mutable_data(), n_held});
    report(std::min(status, 0), "bound");
    for (std::size_t i = 0; i < n_held; ++i)
      if (bounds.data()[i] >= PHN_NO_BOUND) bounds.mutable_data()[i] = std::numeric_limits<double>::infinity();
    return bounds;
  }

  void reset() { organ.reset().ignore(); }

  py::array_t<PlaceRow> nearest_batch(py::handle x) {
    const Vectors points(x, "x");
    const auto n = static_cast<std::size_t>(points.size());
    std::vector<phn_tool> tools(n);
    std::vector<double> at(3 * n), distances(n);
    std::vector<int> statuses(n);
    evaluate([&](Batch& all) { return all.nearest({points.data(), 3 * n}, tools, at, distances, statuses); });
    py::array_t<PlaceRow> rows(points.size());
    PlaceRow* const row = rows.mutable_data();
    for (std::size_t i = 0; i < n; ++i) {
      std::copy_n(tools[i].nodes, 3, row[i].nodes);
      std::copy_n(tools[i].weights, 3, row[i].weights);
      std::copy_n(at.data() + 3 * i, 3, row[i].position);
      row[i].distance = distances[i];
      row[i].status = statuses[i];
    }
    return rows;
  }

  py::tuple hold_batch(py::handle at, py::handle displacements) {
    const Vectors d(displacements, "d");
    if (d.is_one()) throw py::value_error("d must have the shape (n, 3), a displacement for each place");
    const auto n = static_cast<std::size_t>(d.size());
    std::vector<phn_tool> tools(n);
    if (py::isinstance<py::array>(at) && py::reinterpret_borrow<py::array>(at).dtype().kind() == 'V') {
      const auto rows = py::array_t<PlaceRow, py::array::c_style | py::array::forcecast>::ensure(at);
      if (!rows) raise_type("the rows of places are not those of nearest_batch");
      if (rows.ndim() != 1 || rows.size() != d.size())
        throw py::value_error("there are " + std::to_string(rows.size()) + " places, but " + std::to_string(n) +
                              " displacements in d");
      for (std::size_t i = 0; i < n; ++i) {
        const PlaceRow& row = rows.data()[i];
        std::copy_n(row.nodes, 3, tools[i].nodes);
        std::copy_n(row.weights, 3, tools[i].weights);
        d.get(static_cast<py::ssize_t>(i), tools[i].displacement);
      }
    } else {
      Tools given(at, displacements);
      for (std::size_t i = 0; i < n; ++i) tools[i] = given.get(static_cast<py::ssize_t>(i));
    }
    py::array_t<double> forces({d.size(), py::ssize_t{3}});
    py::array_t<int> statuses(d.size());
    Span<double> to(forces.mutable_data(), 3 * n);
    Span<int> said(statuses.mutable_data(), n);
    evaluate([&](Batch& all) { return all.hold(tools, to, said); });
    return py::make_tuple(std::move(forces), std::move(statuses));
  }

  std::string model_text, body_text;
  std::int32_t max_tools, steps;
  Organ organ;

 private:
  static NamedText text_of(const py::object& given, const char* name, const char* what) {
    if (py::isinstance<py::bytes>(given)) return {what, given.cast<std::string>()};
    std::filesystem::path path = py::module_::import("os").attr("fsdecode")(given).cast<std::string>();
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) path /= name;
    return {path.string(), content_of(py::str(path.string()), what)};
  }
  static py::array_t<double> vectors(py::ssize_t n) { return py::array_t<double>({n, py::ssize_t{3}}); }
  static void report(int status, const std::string& where) {
    Tally tally;
    tally.add(0, status);
    tally.report([&](py::ssize_t) { return where; }, 1);
  }

  template <class Call>
  void evaluate(const Call& call) {
    if (batch == nullptr) batch = std::make_unique<Batch>(organ);
    int status = PHN_OK;
    {
      const py::gil_scoped_release others_may_run;
      status = call(*batch);
    }
    report(status, "a batch is answered by a model");
  }

  std::size_t n_held = 0;
  std::unique_ptr<Batch> batch;
};

py::object bytes_or_none(const std::string& text) { return text.empty() ? py::none() : py::object(py::bytes(text)); }

/// With four digits, in one line.
std::string in_words(const py::array& numbers) {
  const py::dict format(arg("float_kind") = py::str("{:.4g}").attr("format"));
  const auto lines =
      py::module_::import("numpy").attr("array2string")(numbers, arg("separator") = ", ", arg("formatter") = format);
  return py::str(" ").attr("join")(lines.attr("split")()).cast<std::string>();
}

template <class Result>
std::string energy_and_status(const Result& r) {
  return py::str(", energy={:.4g} J, status={})").format(r.report.energy_J, r.status).template cast<std::string>();
}

template <class Result>
void add_report(py::class_<Result>& result) {
  result
      .def_property_readonly(
          "energy", [](const Result& r) { return r.report.energy_J; }, "[J]; 0 in family rbfn.")
      .def_property_readonly(
          "residual", [](const Result& r) { return r.report.residual_m; },
          "Largest distance of a tool from what it holds [m].")
      .def_readonly("status", &Result::status, "0, or a sum of PHN_WARNING_* of phynness.h.")
      .def("__reduce__",
           [](const Result&) -> py::object { raise_type("what an Organ answers is not pickled; its arrays are"); });
}

void add_batches(py::class_<OrganObject>& organ) {
  PYBIND11_NUMPY_DTYPE(PlaceRow, nodes, status, weights, position, distance);
  organ
      .def("nearest_batch", &OrganObject::nearest_batch, arg("x"),
           R"(The places nearest to n points, found by all processors: an array of n rows.

x: (n, 3) [m]. Its fields: nodes (3,), -1 where unused; weights (3,); position (3,) [m], undeformed; distance [m], < 0
inside; status, below 0 and without nodes where x is not finite. Rows may be picked, copied and written by masks, as of
any array.
)")
      .def("hold_batch", &OrganObject::hold_batch, arg("at"), arg("d"),
           R"(Forces of n tools that do not act on each other, by the model on all processors: (forces, status).

at: rows of nearest_batch, or n nodes and SurfacePoints. d: (n, 3) [m]. forces: (n, 3) [N]; status: (n,), 0, a sum of
PHN_WARNING_* of phynness.h, or below 0 where a tool is refused, whose force is zero. Nothing is raised or warned of for a
single tool. Other threads of Python run meanwhile. Error without a model.

>>> organ = phynness.Organ("examples/model")
>>> places = organ.nearest_batch(np.array([[0, 0, 0.1], [0.01, 0, 0.1]]))
>>> forces, status = organ.hold_batch(places, np.array([[0, 0, -0.01], [0, 0, -0.005]]))
)");
}

}  // namespace

void add_organ(py::module_& module) {
  py::class_<Held> held(module, "Held", "What Organ.hold answers.");
  held.def_readonly("forces", &Held::forces, "(n, 3), or of one tool (3,) [N].").def("__repr__", [](const Held& h) {
    return "Held(forces=" + in_words(h.forces) + " N" + energy_and_status(h);
  });
  add_report(held);
  py::class_<Touched> touched(module, "Touched", "What Organ.touch answers, for each sphere.");
  touched.def_readonly("forces", &Touched::forces, "On the body, (n, 3) [N]; zeros without contact.")
      .def_readonly("proxies", &Touched::proxies, "Centres on the undeformed surface, (n, 3) [m].")
      .def_readonly("normals", &Touched::normals, "Outward, (n, 3); zeros without contact.")
      .def_readonly("in_contact", &Touched::in_contact, "(n,), bool.")
      .def("__repr__", [](const Touched& t) {
        return "Touched(forces=" + in_words(t.forces) + " N, in_contact=" + in_words(t.in_contact) +
               energy_and_status(t);
      });
  add_report(touched);

  py::class_<OrganObject> organ(module, "Organ",
                                R"(A model, a body of the same mesh, or both: several tools, and spheres in contact.

model: a Model, a model directory, a model.txt or its bytes; body: a body.txt of phynness reduce or its bytes; either may
be None. One tool is answered by the model, several by the body; spheres by the body where there is one.
max_tools: of one call. steps: of Newton's method, at most, that a body makes in one call or increment.

Error if a file is missing or damaged, or if the body has another mesh. Pickles and copies hold the texts and are at rest.

>>> organ = phynness.Organ("examples/model", max_tools=2)
>>> both = organ.hold([95, organ.nearest([0, 0, 0.1])], [[0, 0, -0.01], [0, 0, 0.002]])
>>> both.forces.shape, organ.deform().shape
((2, 3), (146, 3))
)");
  add_batches(organ);
  organ
      .def(py::init(&OrganObject::open), arg("model"), arg("body") = py::none(), kw_only(), arg("max_tools") = 8,
           arg("steps") = 60)
      .def(
          "nearest", [](const OrganObject& o, py::handle x) { return nearest_places(o.organ, x); }, arg("x"),
          "The SurfacePoint that is nearest to x, (3,), or a list of n, (n, 3) [m]. As Model.nearest.")
      .def("hold", &OrganObject::hold, arg("at"), arg("d"), kw_only(), arg("increments") = 0, arg("dt") = 0.0,
           R"(Forces of tools that are displaced together: a Held.

at: n nodes and SurfacePoints, or one. d: (n, 3) or (3,) [m]. increments: from rest in so many equal parts of d, as a body,
whose forces depend on the motion before, needs for millimetres (8 in phynness eval); 0: from the present state.

dt: seconds since the hold before, of a body that relaxes (Organ.relaxation); 0: the elastic force. reset() forgets.

UnsettledWarning: more steps or increments come closer. OutsideWarning: farther than trained. Error where nothing can move.
)")
      .def("touch", &OrganObject::touch, arg("centers"), arg("radius"), kw_only(), arg("friction") = 0.0,
           arg("mode") = "press",
           R"(Moves spheres and gives the forces of their contact: a Touched. One call for each cycle of a haptic loop.

centers: (n, 3) or (3,) [m]. radius [m]. mode: "press", "grasp" or "off". A sphere that is new has no contact; move it in.
)")
      .def("deform", &OrganObject::deform,
           "Displacements of the last hold or touch, of the model's output nodes or, without a model, of the body's "
           "nodes, "
           "(n, 3) [m].")
      .def("bound", &OrganObject::bound,
           "Bounds of the errors of the forces of the last hold, (n,) [N]; inf where nothing is known. Error without.")
      .def("reset", &OrganObject::reset, "Back to rest; every contact ends.")
      .def_property_readonly(
          "text", [](const OrganObject& o) { return bytes_or_none(o.model_text); },
          "The content of model.txt, bytes, or None.")
      .def_property_readonly(
          "body_text", [](const OrganObject& o) { return bytes_or_none(o.body_text); },
          "The content of body.txt, bytes, or None.")
      .def_property_readonly(
          "mesh_hash",
          [](const OrganObject& o) {
            return o.organ.model() != nullptr ? o.organ.info().mesh_hash : o.organ.body_info().mesh_hash;
          },
          "16 hexadecimal digits.")
      .def_property_readonly(
          "max_displacement_m",
          [](const OrganObject& o) {
            return o.organ.model() != nullptr ? o.organ.info().max_displacement_m
                                              : o.organ.body_info().max_displacement_m;
          },
          "Largest displacement of the training data [m].")
      .def_property_readonly(
          "relaxation",
          [](const OrganObject& o) {
            const phn_relaxation& r = o.organ.relaxation();
            py::array_t<double> terms({py::ssize_t{r.n_terms}, py::ssize_t{2}});
            for (std::int32_t i = 0; i < r.n_terms; ++i) {
              terms.mutable_at(i, 0) = r.g[i];
              terms.mutable_at(i, 1) = r.tau_s[i];
            }
            return terms;
          },
          "Rows of g and tau [s], (n, 2); without rows the body is elastic.")
      .def_property_readonly(
          "nodes",
          [](py::object self) {
            const Organ& o = self.cast<const OrganObject&>().organ;
            return o.model() != nullptr ? view(self, o.info().output_nodes, {o.info().n_output})
                                        : view(self, o.body_info().nodes, {o.body_info().n_nodes});
          },
          "Of deform, numbers of the mesh, ascending.")
      .def_property_readonly(
          "points",
          [](py::object self) {
            const Organ& o = self.cast<const OrganObject&>().organ;
            return o.model() != nullptr ? view(self, o.info().output_points, {o.info().n_output, 3})
                                        : view(self, o.body_info().points, {o.body_info().n_nodes, 3});
          },
          "Of nodes, (n, 3) [m], undeformed.")
      .def("__reduce__", [](const py::object& self) {
        const auto& o = self.cast<const OrganObject&>();
        return py::make_tuple(
            py::module_::import("functools")
                .attr("partial")(py::type::of(self), arg("max_tools") = o.max_tools, arg("steps") = o.steps),
            py::make_tuple(bytes_or_none(o.model_text), bytes_or_none(o.body_text)));
      });
}

}  // namespace phynness::python
