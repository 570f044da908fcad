#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/body.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/validation/named_organ.hpp>
#include <tuple>

namespace phynness {
namespace {

Span<double> span(Points& points) { return {points.data(), static_cast<std::size_t>(points.size())}; }

/// Averages the fields of tools with the weights of equations (15)-(16). These are inverse distances in the undeformed
/// state, multiplied by the smallest distance, so that every term is in [0, 1].
Points blended(const Points& output, const std::vector<Eigen::RowVector3d>& tools, const std::vector<Points>& fields) {
  Points sum = Points::Zero(output.rows(), 3);
  std::vector<double> distance(tools.size()), weight(tools.size());
  for (Eigen::Index o = 0; o < output.rows(); ++o) {
    for (std::size_t t = 0; t < tools.size(); ++t) {
      const Eigen::RowVector3d apart = output.row(o) - tools[t];
      distance[t] = std::sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
    }
    const double nearest = *std::ranges::min_element(distance);
    for (std::size_t t = 0; t < tools.size(); ++t) weight[t] = distance[t] > 0 ? nearest / distance[t] : 1;
    const double all = std::accumulate(weight.begin(), weight.end(), 0.0);
    for (std::size_t t = 0; t < tools.size(); ++t) sum.row(o) += weight[t] / all * fields[t].row(o);
  }
  return sum;
}

}  // namespace

phn_tool tool_at(const SurfacePoint& place, const Vec3& displacement_m) {
  phn_tool tool{};
  std::ranges::copy(place.nodes, tool.nodes);
  std::ranges::copy(place.weights, tool.weights);
  std::ranges::copy(displacement_m, tool.displacement);
  return tool;
}

NamedOrgan::NamedOrgan(const std::filesystem::path& dir) : _name((dir / "model.txt").string()) {
  ModelTexts texts = read_model_texts(dir);
  _text = std::move(texts.model);
  _mesh_text_bytes = texts.mesh.size();
  load(1);
  _mesh = read_mesh_text(texts.mesh, (dir / "mesh.txt").string());
  require_mesh(_mesh, info().mesh_hash);
}

NamedOrgan::NamedOrgan(Model model, Mesh mesh, const std::string& name)
    : _name(name),
      _text(write_model_text(model)),
      _mesh_text_bytes(write_mesh_text(mesh).size()),
      _model(std::move(model)),
      _mesh(std::move(mesh)) {
  load(1);
}

NamedOrgan NamedOrgan::body(const std::filesystem::path& file, std::int32_t steps) {
  return body(read_body_file(file), file.string(), steps);
}

NamedOrgan NamedOrgan::body(std::string text, std::string name, std::int32_t steps) {
  NamedOrgan organ(std::move(name), std::move(text));
  organ._is_body = true;
  organ.load(steps);
  return organ;
}

NamedOrgan NamedOrgan::body_on_same_mesh(const std::filesystem::path& file, std::int32_t steps) const {
  auto made = body(file, steps);
  require_same("the body " + made.name(), made.body_info().mesh_hash, info().provenance.physics_hash);
  return made;
}

void NamedOrgan::load(std::int32_t steps) {
  _organ = _is_body ? Organ({}, _text, PHN_MOST_COUPLED, steps) : Organ(_text, {}, PHN_MOST_COUPLED);
  if (_organ) return;
  if (_is_body)
    read_body_text(_text, _name);  // throws an error with the line and the value if the text is invalid
  else
    model();  // the same
  const std::size_t at = _organ.wrong_byte();
  throw input_error(
      "the runtime cannot load " + _name,
      _organ.status().message() + (at > 0 ? " (byte " + std::to_string(at) + ")" : std::string()),
      _is_body ? "make it again with phynness reduce of this version" : "train the model again with this version");
}

std::string NamedOrgan::hash() const {
  constexpr std::size_t digits = 16;
  return _text.substr(_text.size() - digits - 1, digits);
}

const Model& NamedOrgan::model() const {
  if (!_model) _model = read_model_text(_text, _name);
  return *_model;
}

void NamedOrgan::require_same(const std::string& what, const std::string& mesh_hash, const std::string& physics_hash,
                              const char* remedy) const {
  const auto& own = info().provenance;
  for (const auto& [kind, of_model, other] :
       {std::tuple{"mesh", own.mesh_hash, mesh_hash}, std::tuple{"physics", own.physics_hash, physics_hash}})
    if (*of_model != 0 && other != of_model)
      throw input_error(what + " has another " + kind + " than the model " + _name,
                        "hash " + other + ", of the model " + of_model, remedy);
}

bool NamedOrgan::has_bounds() const {
  if (_is_body) return _text.find("\n" + std::string(schema::body_bounds_word) + " ") != std::string::npos;
  double bound = 0;
  return is_of_full_level() && _organ.bound(tool_at(info().active_nodes[0], Vec3{}), bound) != PHN_ERROR_UNDEFINED;
}

void NamedOrgan::set_level(std::int32_t level) {
  const auto n = info().n_levels;
  if (phn_set_level(_organ.model(), _organ.data(), level) != PHN_OK)
    throw input_error("the model has no such level", std::to_string(level),
                      n == 1 ? "omit the level, or train the model with [training] levels"
                             : "give a number from 0 to " + std::to_string(n - 1) + ", which is the full level");
  _level = level;
}

void NamedOrgan::check(int status, std::int32_t node) const {
  if (status >= 0) return;
  if (status == PHN_ERROR_NOT_ACTIVE && node >= 0 && node < _mesh.n_nodes()) {
    const auto all = active_nodes();
    std::vector<std::int32_t> active(all.begin(), all.end());
    const auto distance = [&](std::int32_t i) { return (_mesh.nodes.row(i) - _mesh.nodes.row(node)).norm(); };
    const auto n = std::min<std::size_t>(3, active.size());
    std::partial_sort(active.begin(), active.begin() + static_cast<std::ptrdiff_t>(n), active.end(),
                      [&](auto a, auto b) { return distance(a) < distance(b); });
    std::string nearest;
    for (std::size_t i = 0; i < n; ++i) nearest += (i ? ", " : "") + std::to_string(active[i]);
    throw input_error("the node is not an active node of the model", "node " + std::to_string(node),
                      "touch an active node; the nearest are " + nearest);
  }
  throw input_error("the runtime reports an error",
                    phn_status_message(status) + std::string(" (node ") + std::to_string(node) + ")",
                    "touch different active nodes of the mesh, 0 to " + std::to_string(_mesh.n_nodes() - 1) +
                        ", with finite displacements");
}

void NamedOrgan::check(int status, const std::vector<phn_tool>& tools) const {
  if (status >= 0) return;
  const std::string count = std::to_string(tools.size()) + " tools";
  const std::int32_t first = tools.empty() ? -1 : tools[0].nodes[0];
  if (_is_body)
    throw input_error("the runtime refuses tools on " + _name,
                      phn_status_message(status) + (tools.empty() ? "" : " (first node " + std::to_string(first) + ")"),
                      "touch a part of its surface that can move, with finite displacements and at most eight tools");
  if (status == PHN_ERROR_ROUND_TOOLS)
    throw input_error("a model of round tools answers one tool", count, several_round_tools);
  if (status == PHN_ERROR_TOOLS || status == PHN_ERROR_TOO_MANY_TOOLS)
    throw input_error("there are too many coupled tools", std::to_string(tools.size()),
                      "give at most " + std::to_string(PHN_MOST_COUPLED) + " tools");
  if (status == PHN_ERROR_UNDEFINED)
    throw input_error("this model has forces only, or a touched node is not an output node", "coupled tools",
                      "train it with modes and make all touched nodes output nodes, or touch a single node");
  const std::span<const std::int32_t> all_fixed(info().fixed_nodes, static_cast<std::size_t>(info().n_fixed));
  std::string fixed;
  for (const auto& tool : tools)
    for (int k = 0; k < 3 && status == PHN_ERROR_NOT_ACTIVE; ++k)
      if (tool.weights[k] > 0 && std::ranges::binary_search(all_fixed, tool.nodes[k]))
        fixed += (fixed.empty() ? "" : ", ") + std::to_string(tool.nodes[k]);
      else if (tool.weights[k] > 0)
        force(tool.nodes[k], {0, 0, 0});  // throws an error for an inactive node
  if (status == PHN_ERROR_NOT_ACTIVE)
    throw input_error("all nodes of a tool are fixed", "fixed nodes " + fixed,
                      "touch a part of the surface that can move");
  check(status, first);
}

Vec3 NamedOrgan::force(std::int32_t node, const Vec3& displacement_m) const {
  Vec3 f{};
  check(_organ.hold(tool_at(node, displacement_m), f), node);
  return f;
}

double NamedOrgan::trained_depth(std::int32_t node, const Vec3& displacement_m) const {
  double depth_m = 0;
  check(_organ.depth(tool_at(node, displacement_m), depth_m), node);
  return depth_m;
}

std::optional<double> NamedOrgan::error_bound(std::int32_t node, const Vec3& displacement_m) const {
  double bound = 0;
  const int status = _organ.bound(tool_at(node, displacement_m), bound);
  if (status == PHN_ERROR_UNDEFINED) return std::nullopt;
  check(status, node);
  if (bound >= PHN_NO_BOUND) return std::nullopt;
  return bound;
}

OrganResponse NamedOrgan::hold(const std::vector<phn_tool>& tools) const {
  const std::size_t n_tools = tools.size();
  OrganResponse response;
  std::vector<double> forces(3 * n_tools);
  response.status = _organ.hold(tools, forces, &response.report);
  check(response.status, tools);
  for (std::size_t t = 0; t < n_tools; ++t)
    response.force_N.emplace_back(Vec3{forces[3 * t], forces[3 * t + 1], forces[3 * t + 2]});
  if (_is_body || info().has_energy != 0) response.energy_J = response.report.energy_J;
  double bounds[PHN_MOST_COUPLED];
  if ((_is_body || is_of_full_level()) && _organ.bound(bounds).ok())
    for (std::size_t t = 0; t < n_tools; ++t)
      response.bound_N.push_back(bounds[t] < PHN_NO_BOUND ? std::optional(bounds[t]) : std::nullopt);
  response.displacement_m.resize(static_cast<Eigen::Index>(_organ.n_deform() / 3), 3);
  if (_organ.deform(span(response.displacement_m)) == PHN_ERROR_UNDEFINED) response.displacement_m.resize(0, 3);
  return response;
}

OrganResponse NamedOrgan::hold_from_rest(const std::vector<phn_tool>& tools, int increments) const {
  _organ.reset().ignore();
  OrganResponse response;
  for (int i = 1; i <= increments; ++i) {
    auto moved = tools;
    for (std::size_t t = 0; t < tools.size(); ++t)
      for (int k = 0; k < 3; ++k) moved[t].displacement[k] = tools[t].displacement[k] * i / increments;
    response = hold(moved);
  }
  return response;
}

OrganResponse NamedOrgan::blend(const std::vector<std::int32_t>& nodes, const std::vector<Vec3>& displacement_m) const {
  const std::size_t n_tools = nodes.size();
  const std::int32_t n_output = info().n_output;
  for (const auto node : nodes) force(node, {0, 0, 0});  // throws an error with the number of an inactive node
  if (n_tools > 1 && has_round_tools()) check(PHN_ERROR_ROUND_TOOLS, std::vector<phn_tool>(n_tools));
  OrganResponse response;
  std::vector<Points> fields;
  std::vector<Eigen::RowVector3d> places;
  for (std::size_t t = 0; t < n_tools && n_output > 0; ++t) {
    const phn_tool tool = tool_at(nodes[t], displacement_m[t]);
    const int status = phn_deform(_organ.model(), _organ.data(), &tool, fields.emplace_back(n_output, 3).data());
    if (status == PHN_ERROR_UNDEFINED) break;
    check(status, nodes[t]);
    response.status |= status;
    places.push_back(_mesh.nodes.row(nodes[t]));
  }
  response.force_N.assign(n_tools, std::nullopt);
  if (places.size() < n_tools)
    response.status = PHN_OK;  // the model has forces only
  else if (n_tools == 1)
    response.displacement_m = std::move(fields[0]);
  else
    response.displacement_m = blended(Eigen::Map<const Points>(info().output_points, n_output, 3), places, fields);
  if (n_tools != 1) {
    // The weights are singular at a touched node; their limit is the displacement of its tool, or the mean of those.
    const auto output = output_nodes();
    for (Eigen::Index o = 0; o < response.displacement_m.rows(); ++o) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      double n = 0;
      for (std::size_t t = 0; t < n_tools; ++t)
        if (nodes[t] == output[static_cast<std::size_t>(o)]) sum += to_eigen(displacement_m[t]).transpose(), ++n;
      if (n > 0) response.displacement_m.row(o) = sum / n;
    }
    return response;
  }
  const Vec3& v = displacement_m[0];
  const phn_tool tool = tool_at(nodes[0], v);
  Vec3 f{};
  double energy = 0;
  const int status = info().has_energy != 0 ? _organ.hold(tool, f, energy) : _organ.hold(tool, f);
  check(status, nodes[0]);
  response.status |= status;
  response.force_N[0] = f;
  const std::int32_t n_fields = response.displacement_m.rows() > 0 ? info().n_fields : 0;
  if (n_fields > 0) response.fields.resize(n_output, n_fields);
  for (std::int32_t field = 0; field < n_fields; ++field)
    check(phn_field(_organ.model(), _organ.data(), &tool, field, response.fields.col(field).data()), nodes[0]);
  response.energy_J = energy;
  if (info().has_energy != 0) return response;
  // Simpson's rule. The network is smooth over its spread, so that with 32 intervals the quadrature error is far
  // below the error of the network.
  double work = 0;
  constexpr int n = 32;
  for (int i = 0; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    const Vec3 at = force(nodes[0], {s * v[0], s * v[1], s * v[2]});
    work += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * (at[0] * v[0] + at[1] * v[1] + at[2] * v[2]);
  }
  response.energy_J = work / (3 * n);
  return response;
}

}  // namespace phynness
