#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/validation/loaded_model.hpp>
#include <tuple>

namespace phynness {
namespace {

constexpr std::int32_t most_tools = 16;

/// @throws Error (input) if the runtime refused several round tools
void require_one_round_tool(int status, std::size_t n_tools) {
  if (status == PHN_ERROR_ROUND_TOOLS)
    throw input_error("a model of round tools answers one tool", std::to_string(n_tools) + " tools",
                      several_round_tools);
}

rt::Span<double> span(Points& points) { return {points.data(), static_cast<std::size_t>(points.size())}; }

}  // namespace

phn_tool tool_at(const SurfacePoint& place, const Vec3& displacement_m) {
  phn_tool tool{};
  std::ranges::copy(place.nodes, tool.nodes);
  std::ranges::copy(place.weights, tool.weights);
  std::ranges::copy(displacement_m, tool.displacement);
  return tool;
}

LoadedModel::LoadedModel(const std::filesystem::path& dir) : _name((dir / "model.txt").string()) {
  ModelTexts texts = read_model_texts(dir);
  _text = std::move(texts.model);
  _mesh_text_bytes = texts.mesh.size();
  load();
  _mesh = read_mesh_text(texts.mesh, (dir / "mesh.txt").string());
  require_mesh(_mesh, _runtime.info().mesh_hash);
}

LoadedModel::LoadedModel(Model model, Mesh mesh, const std::string& name)
    : _name(name),
      _text(write_model_text(model)),
      _mesh_text_bytes(write_mesh_text(mesh).size()),
      _model(std::move(model)),
      _mesh(std::move(mesh)) {
  load();
}

std::string LoadedModel::hash() const {
  constexpr std::size_t digits = 16;
  return _text.substr(_text.size() - digits - 1, digits);
}

void LoadedModel::load() {
  _runtime = rt::Model(_text);
  if (_runtime) _data = rt::Data(_runtime, most_tools);
  const rt::Status status = _runtime ? _data.status() : _runtime.status();
  if (status.ok()) return;
  model();  // throws an error with the line and the value if the text is invalid
  const std::size_t at = _runtime.wrong_byte();
  throw input_error("the runtime cannot load " + _name,
                    status.message() + (at > 0 ? " (byte " + std::to_string(at) + ")" : std::string()),
                    "train the model again with this version");
}

void LoadedModel::require_same(const std::string& what, const std::string& mesh_hash, const std::string& physics_hash,
                               const char* remedy) const {
  const auto& own = _runtime.info().provenance;
  for (const auto& [kind, of_model, other] :
       {std::tuple{"mesh", own.mesh_hash, mesh_hash}, std::tuple{"physics", own.physics_hash, physics_hash}})
    if (*of_model != 0 && other != of_model)
      throw input_error(what + " has another " + kind + " than the model " + _name,
                        "hash " + other + ", of the model " + of_model, remedy);
}

const Model& LoadedModel::model() const {
  if (!_model) _model = read_model_text(_text, _name);
  return *_model;
}

void LoadedModel::check(int status, std::int32_t node) const {
  if (status >= 0) return;
  if (status == PHN_ERROR_NOT_ACTIVE && node >= 0 && node < _mesh.n_nodes()) {
    const auto all = _runtime.active_nodes();
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

void LoadedModel::set_level(std::int32_t level) {
  const auto n = _runtime.n_levels();
  if (_data.set_level(level) != PHN_OK)
    throw input_error("the model has no such level", std::to_string(level),
                      n == 1 ? "omit the level, or train the model with [training] levels"
                             : "give a number from 0 to " + std::to_string(n - 1) + ", which is the full level");
  _level = level;
}

Vec3 LoadedModel::force(std::int32_t node, const Vec3& displacement_m) const {
  Vec3 f{};
  check(_data.force(node, displacement_m, f), node);
  return f;
}

double LoadedModel::trained_depth(std::int32_t node, const Vec3& displacement_m) const {
  double depth_m = 0;
  check(_runtime.trained_depth(node, displacement_m, depth_m), node);
  return depth_m;
}

bool LoadedModel::has_bounds() const {
  double bound = 0;
  return level() + 1 == _runtime.n_levels() &&
         _runtime.bound(_runtime.info().active_nodes[0], Vec3{}, bound) != PHN_ERROR_UNDEFINED;
}

std::optional<double> LoadedModel::error_bound(std::int32_t node, const Vec3& displacement_m) const {
  double bound = 0;
  const int status = _runtime.bound(node, displacement_m, bound);
  if (status == PHN_ERROR_UNDEFINED) return std::nullopt;
  check(status, node);
  if (bound >= PHN_NO_BOUND) return std::nullopt;
  return bound;
}

ModelResponse LoadedModel::respond(const std::vector<std::int32_t>& nodes,
                                   const std::vector<Vec3>& displacement_m) const {
  const std::size_t n_tools = nodes.size();
  if (n_tools > static_cast<std::size_t>(most_tools))
    throw input_error("there are too many tools", std::to_string(n_tools),
                      "give at most " + std::to_string(most_tools) + " tools");
  ModelResponse response;
  response.displacement_m.resize(_runtime.n_output(), 3);
  std::vector<double> d;
  for (const auto& v : displacement_m) d.insert(d.end(), v.begin(), v.end());
  for (const auto node : nodes) force(node, {0, 0, 0});  // throws an error with the number of an inactive node
  // Without output nodes there is no place for displacements, which the runtime would refuse.
  response.status =
      _runtime.n_output() == 0 ? PHN_ERROR_UNDEFINED : _data.blend_paper(nodes, d, span(response.displacement_m));
  if (response.status == PHN_ERROR_UNDEFINED) {
    response.status = PHN_OK;
    response.displacement_m.resize(0, 3);
  }
  require_one_round_tool(response.status, n_tools);
  check(response.status, nodes.empty() ? -1 : nodes[0]);
  response.force_N.assign(n_tools, std::nullopt);
  if (n_tools == 1) {
    const Vec3& v = displacement_m[0];
    Vec3 f{};
    double energy = 0;
    const bool has_energy = _runtime.info().has_energy != 0;
    const int status = has_energy ? _data.force(nodes[0], v, f, energy) : _data.force(nodes[0], v, f);
    check(status, nodes[0]);
    response.status |= status;
    response.force_N[0] = f;
    const std::int32_t n_fields = response.displacement_m.rows() > 0 ? _runtime.n_fields() : 0;
    if (n_fields > 0) response.fields.resize(_runtime.n_output(), n_fields);
    for (std::int32_t field = 0; field < n_fields; ++field)
      check(_data.field(nodes[0], v, field,
                        {response.fields.col(field).data(), static_cast<std::size_t>(_runtime.n_output())}),
            nodes[0]);
    if (has_energy) {
      response.energy_J = energy;
      return response;
    }
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
  }
  return response;
}

ModelResponse LoadedModel::couple(const std::vector<phn_tool>& tools) const {
  const std::size_t n_tools = tools.size();
  ModelResponse response;
  std::vector<double> forces(3 * n_tools);
  const int status = _data.couple(tools, forces, &response.coupled);
  require_one_round_tool(status, n_tools);
  if (status == PHN_ERROR_TOOLS || status == PHN_ERROR_TOO_MANY_TOOLS)
    throw input_error("there are too many coupled tools", std::to_string(n_tools),
                      "give at most " + std::to_string(PHN_MOST_COUPLED) + " tools");
  if (status == PHN_ERROR_UNDEFINED)
    throw input_error("this model has forces only, or a touched node is not an output node", "coupled tools",
                      "train it with modes and make all touched nodes output nodes, or touch a single node");
  const auto all_fixed = _runtime.fixed_nodes();
  for (const auto& tool : tools)
    for (int k = 0; k < 3 && status == PHN_ERROR_NOT_ACTIVE; ++k) {
      const bool fixed = std::binary_search(all_fixed.begin(), all_fixed.end(), tool.nodes[k]);
      if (tool.weights[k] > 0 && !fixed) force(tool.nodes[k], {0, 0, 0});  // throws an error for an inactive node
    }
  if (status == PHN_ERROR_NOT_ACTIVE)
    throw input_error("all nodes of a tool are fixed", "", "touch a part of the surface that can move");
  check(status, n_tools == 0 ? -1 : tools[0].nodes[0]);
  for (std::size_t t = 0; t < n_tools; ++t)
    response.force_N.emplace_back(Vec3{forces[3 * t], forces[3 * t + 1], forces[3 * t + 2]});
  if (_runtime.info().has_energy != 0) response.energy_J = response.coupled.energy;
  double bound = 0;
  if (n_tools == 1 && _runtime.bound(tools[0], bound).ok())
    response.bound_N.push_back(bound < PHN_NO_BOUND ? std::optional(bound) : std::nullopt);
  response.displacement_m.resize(_runtime.n_output(), 3);
  const int deformed = _data.coupled_deform(span(response.displacement_m));
  if (deformed == PHN_ERROR_UNDEFINED) response.displacement_m.resize(0, 3);
  response.status = status;
  return response;
}

}  // namespace phynness
