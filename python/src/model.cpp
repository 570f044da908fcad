#include "model.hpp"

#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/text_file.hpp>

#include <limits>

namespace phynness::python {

phn_tool tool_at(const Place& at) {
  if (const auto* point = std::get_if<SurfacePoint>(&at)) return point->tool;
  const auto node = std::get<std::int64_t>(at);
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  return {{node < 0 || node > most ? -1 : static_cast<std::int32_t>(node), -1, -1}, {1, 0, 0}, {0, 0, 0}};
}

namespace {

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

void set_level(rt::Data& data, const Level& level, std::int32_t n_levels) {
  const int status = data.set_level(level.value_or(n_levels - 1));
  if (status < 0)
    raise("the model has the levels 0 to " + std::to_string(n_levels - 1) + ", not " + std::to_string(*level), status);
}

/// Evaluates all rows; Ctrl-C ends them.
/// @param evaluate  of a row and its displacement, returns a status
template <class Evaluate>
void for_each(const Vectors& d, const Asked& asked, Evaluate&& evaluate) {
  Tally tally;
  double x[3];
  for (py::ssize_t i = 0; i < d.size(); ++i) {
    d.get(i, x);
    if (!tally.add(i, evaluate(i, x))) break;
    if (i % (1 << 14) == (1 << 14) - 1 && PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  if (tally.is_unusual()) tally.report(asked.name(), d.size());
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

}  // namespace

phn_data* ModelObject::data(const Level& level) {
  if (!_data) _data = rt::Data(_model, 1);
  if (!_data) raise(_data.status().message(), _data.status());
  set_level(_data, level, info().n_levels);
  return _data.get();
}

ModelObject::ModelObject(const std::string& name, std::string text, py::object mesh, py::object training)
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

std::unique_ptr<ModelObject> ModelObject::open(const py::object& of) {
  if (py::isinstance<py::bytes>(of))
    return std::make_unique<ModelObject>("the text", of.cast<std::string>(), py::none(), py::none());
  const auto path = path_of(of);
  std::error_code code;
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 40;
  const bool is_folder = std::filesystem::is_directory(path, code);
  const auto file = is_folder ? path / "model.txt" : path;
  auto text =
      read_input_file(file, {"the model", "give a model directory, or the path of its model.txt", most_bytes, true});
  py::object mesh = py::none();
  if (is_folder && std::filesystem::exists(path / "mesh.txt", code))
    mesh = py::bytes(read_input_file(path / "mesh.txt", {"the mesh", "restore mesh.txt", most_bytes, true}));
  return std::make_unique<ModelObject>(file.string(), std::move(text), std::move(mesh), py::none());
}

void ModelObject::save(const py::object& to) const {
  const auto path = path_of(to);
  if (_mesh.is_none())
    write_text_file(path, _text);
  else
    write_model_texts(path, {_text, _mesh.cast<std::string>()});
}

ModelObject::Response ModelObject::response(const Place& at, py::handle displacements, const Level& level, bool force,
                                            bool energy, bool stiffness) {
  const Vectors d(displacements, "d");
  Response made;
  double *f = nullptr, *e = nullptr, *k = nullptr;
  if (force) f = made.force.emplace(results(d, {3})).mutable_data();
  if (energy) e = made.energy.emplace(results(d, {})).mutable_data();
  if (stiffness) k = made.stiffness.emplace(results(d, {3, 3})).mutable_data();
  Asked asked(at);
  phn_data* const memory = data(level);
  double unused[3];
  for_each(d, asked, [&](py::ssize_t i, const double(&x)[3]) {
    double *const fi = f ? f + 3 * i : unused, *const ei = e ? e + i : nullptr, *const ki = k ? k + 9 * i : nullptr;
    std::copy(x, x + 3, asked.tool.displacement);
    return phn_force(_model.get(), memory, &asked.tool, fi, ei, ki);
  });
  return made;
}

py::array_t<double> ModelObject::deform(const Place& at, py::handle displacements, const Level& level) {
  const Vectors d(displacements, "d");
  auto made = results(d, {info().n_output, 3});
  const auto n = 3 * static_cast<py::ssize_t>(info().n_output);
  Asked asked(at);
  phn_data* const memory = data(level);
  for_each(d, asked, [&, out = made.mutable_data()](py::ssize_t i, const double(&x)[3]) {
    std::copy(x, x + 3, asked.tool.displacement);
    return phn_deform(_model.get(), memory, &asked.tool, out + n * i);
  });
  return made;
}

py::array_t<double> ModelObject::field(std::int64_t node, py::handle displacements, const std::string& name,
                                       const Level& level) {
  std::int32_t number = 0;
  while (number < info().n_fields && name != info().field_names[number]) ++number;
  if (number == info().n_fields) raise("the model has no field " + printable(name), PHN_ERROR_UNDEFINED);
  const Vectors d(displacements, "d");
  auto made = results(d, {info().n_output});
  const Place at(node);
  Asked asked(at);
  phn_data* const memory = data(level);
  for_each(d, asked, [&, out = made.mutable_data()](py::ssize_t i, const double(&x)[3]) {
    std::copy(x, x + 3, asked.tool.displacement);
    return phn_field(_model.get(), memory, &asked.tool, number, out + info().n_output * i);
  });
  return made;
}

py::array_t<double> ModelObject::bound(const Place& at, py::handle displacements) const {
  return number(at, displacements, [this](const Asked& asked, double& bound) {
    const int status = phn_bound(_model.get(), &asked.tool, &bound);
    if (bound >= PHN_NO_BOUND) bound = std::numeric_limits<double>::infinity();
    return status;
  });
}

py::array_t<double> ModelObject::trained_depth(const Place& at, py::handle displacements) const {
  return number(at, displacements,
                [&](const Asked& asked, double& depth) { return phn_depth(_model.get(), &asked.tool, &depth); });
}

py::tuple ModelObject::nearest(py::handle x) const {
  const Vectors point(x, "x");
  if (!point.is_one()) throw py::value_error("x must have the shape (3,)");
  double from[3];
  point.get(0, from);
  SurfacePoint found;
  py::array_t<double> position(3);
  Tally tally;
  tally.add(0, phn_nearest(_model.get(), from, &found.tool, position.mutable_data(), nullptr));
  tally.report("x", 1);
  return py::make_tuple(found, position);
}

Coupled::Coupled(py::object owner, const std::vector<Place>& at, py::handle displacements, const Level& level)
    : _owner(std::move(owner)), _model(_owner.cast<ModelObject&>()) {
  const Vectors d(displacements, "d");
  if (d.is_one() || d.size() != static_cast<py::ssize_t>(at.size()))
    throw py::value_error("d must have the shape (" + std::to_string(at.size()) +
                          ", 3): a displacement for each place");
  if (at.empty()) throw py::value_error("there is no tool");
  std::vector<phn_tool> tools;
  for (std::size_t i = 0; i < at.size(); ++i)
    d.get(static_cast<py::ssize_t>(i), tools.emplace_back(tool_at(at[i])).displacement);
  if (at.size() > PHN_MOST_COUPLED) raise(phn_status_message(PHN_ERROR_TOO_MANY_TOOLS), PHN_ERROR_TOO_MANY_TOOLS);
  _data = rt::Data(_model.runtime(), static_cast<std::int32_t>(at.size()));
  if (!_data) raise(_data.status().message(), _data.status());
  set_level(_data, level, _model.info().n_levels);
  forces = py::array_t<double>({static_cast<py::ssize_t>(at.size()), py::ssize_t{3}});
  double* const f = forces.mutable_data();
  Tally tally;
  tally.add(0, _data.couple(tools, {f, 3 * tools.size()}, &result));
  tally.report(at.size() == 1 ? "one tool" : std::to_string(at.size()) + " tools", 1);
}

py::array_t<double> Coupled::deform() {
  py::array_t<double> out({static_cast<py::ssize_t>(_model.info().n_output), py::ssize_t{3}});
  Tally tally;
  tally.add(0, phn_coupled_deform(_model.runtime().get(), _data.get(), out.mutable_data()));
  tally.report("coupled tools", 1);
  return out;
}

py::object model_of(const std::string& text, const std::string& name, py::object mesh, py::object training) {
  return py::cast(std::make_unique<ModelObject>(name, text, std::move(mesh), std::move(training)));
}

}  // namespace phynness::python
