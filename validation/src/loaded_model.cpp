#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/validation/loaded_model.hpp>

namespace phynness {

LoadedModel::LoadedModel(const std::filesystem::path& dir, std::int32_t max_tools)
    : LoadedModel(read_model_dir(dir), (dir / "model.txt").string(), max_tools) {}

LoadedModel::LoadedModel(ModelDir dir, const std::string& name, std::int32_t max_tools)
    : _dir(std::move(dir)), _max_tools(max_tools) {
  const auto require = [&](int status) {
    if (status < 0)
      throw input_error("the runtime refuses " + name, phn_status_message(status),
                        "train the model again with this version");
  };
  std::size_t bytes = 0;
  require(phn_model_size(_dir.model_text.data(), _dir.model_text.size(), &bytes));
  _model_memory.resize(bytes);
  require(
      phn_model_init(_model_memory.data(), bytes, _dir.model_text.data(), _dir.model_text.size(), &_model));
  require(phn_data_size(_model, max_tools, &bytes));
  _data_memory.resize(bytes);
  require(phn_data_init(_data_memory.data(), bytes, _model, max_tools, &_data));
}

void LoadedModel::check(int status, std::int32_t node) const {
  if (status >= 0) return;
  if (status == PHN_ERROR_NOT_ACTIVE && node >= 0 && node < _dir.mesh.n_nodes()) {
    std::vector<std::int32_t> active;
    for (const auto& entry : _dir.model.nodes) active.push_back(entry.node);
    const auto distance = [&](std::int32_t i) {
      return (_dir.mesh.nodes.row(i) - _dir.mesh.nodes.row(node)).norm();
    };
    const auto n = std::min<std::size_t>(3, active.size());
    std::partial_sort(active.begin(), active.begin() + static_cast<std::ptrdiff_t>(n), active.end(),
                      [&](auto a, auto b) { return distance(a) < distance(b); });
    std::string nearest;
    for (std::size_t i = 0; i < n; ++i) nearest += (i ? ", " : "") + std::to_string(active[i]);
    throw input_error("the model has no network for this node", "node " + std::to_string(node),
                      "touch an active node; the nearest are " + nearest);
  }
  throw input_error("the runtime refuses the request",
                    phn_status_message(status) + std::string(" (node ") + std::to_string(node) + ")",
                    "touch different active nodes of the mesh, 0 to " +
                        std::to_string(_dir.mesh.n_nodes() - 1) + ", with finite displacements");
}

void LoadedModel::set_level(std::int32_t level) {
  const auto n = phn_n_levels(_model);
  if (phn_set_level(_model, _data, level) != PHN_OK)
    throw input_error("the model has no such level", std::to_string(level),
                      n == 1 ? "train it with [training] levels, or leave the level away"
                             : "levels are numbered 0 to " + std::to_string(n - 1) + ", the full one");
}

Vec3 LoadedModel::force(std::int32_t node, const Vec3& displacement_m) const {
  Vec3 f{};
  check(phn_force(_model, _data, node, displacement_m.data(), f.data()), node);
  return f;
}

double LoadedModel::trained_distance(std::int32_t node, const Vec3& displacement_m) const {
  double distance = 0, relative = 0;
  check(phn_trained_distance(_model, node, displacement_m.data(), &distance, &relative), node);
  return relative;
}

double LoadedModel::trained_depth(std::int32_t node, const Vec3& displacement_m) const {
  double depth = 0;
  check(phn_trained_depth(_model, node, displacement_m.data(), &depth), node);
  return depth;
}

ModelResponse LoadedModel::respond(const std::vector<std::int32_t>& nodes,
                                   const std::vector<Vec3>& displacement_m) const {
  const std::size_t n_tools = nodes.size();
  if (n_tools > static_cast<std::size_t>(_max_tools))
    throw input_error("too many tools", std::to_string(n_tools), "at most " + std::to_string(_max_tools));
  ModelResponse response;
  response.displacement_m.resize(phn_n_output(_model), 3);
  std::vector<double> d;
  for (const auto& v : displacement_m) d.insert(d.end(), v.begin(), v.end());
  for (const auto node : nodes) force(node, {0, 0, 0});  // refuses inactive nodes by number
  response.status = phn_deform(_model, _data, static_cast<std::int32_t>(n_tools), nodes.data(), d.data(),
                               response.displacement_m.data());
  if (response.status == PHN_ERROR_UNDEFINED) {
    response.status = PHN_OK;
    response.displacement_m.resize(0, 3);
  }
  check(response.status, nodes.empty() ? -1 : nodes[0]);
  response.force_N.assign(n_tools, std::nullopt);
  if (n_tools == 1) {
    const Vec3& v = displacement_m[0];
    Vec3 f{};
    const int status = phn_force(_model, _data, nodes[0], v.data(), f.data());
    check(status, nodes[0]);
    response.status |= status;
    response.force_N[0] = f;
    const std::int32_t n_fields = response.displacement_m.rows() > 0 ? phn_n_fields(_model) : 0;
    if (n_fields > 0) response.fields.resize(phn_n_output(_model), n_fields);
    for (std::int32_t field = 0; field < n_fields; ++field)
      check(phn_field(_model, _data, nodes[0], v.data(), field, response.fields.col(field).data()), nodes[0]);
    double energy = 0;
    if (phn_energy(_model, _data, nodes[0], v.data(), &energy) >= 0) {
      response.energy_J = energy;
      return response;
    }
    // Simpson's rule; the network is smooth over its spread, 32 intervals are far below its own error.
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
  int status = phn_couple(_model, _data, static_cast<std::int32_t>(n_tools), tools.data(), forces.data(),
                          &response.coupled);
  if (status == PHN_ERROR_TOOLS)
    throw input_error("too many tools to couple", std::to_string(n_tools), "at most 8");
  if (status == PHN_ERROR_UNDEFINED)
    throw input_error(
        "this model has forces only, or a touched node is no output node", "coupled tools",
        "train it with modes and with all touched nodes among the output nodes, or touch single nodes");
  for (const auto& tool : tools)
    for (int k = 0; k < 3 && status == PHN_ERROR_NOT_ACTIVE; ++k) {
      const bool fixed = std::binary_search(_dir.model.fixed.begin(), _dir.model.fixed.end(), tool.nodes[k]);
      if (tool.weights[k] > 0 && !fixed) force(tool.nodes[k], {0, 0, 0});  // refuses inactive nodes by number
    }
  if (status == PHN_ERROR_NOT_ACTIVE)
    throw input_error("a tool holds nothing but fixed nodes", "",
                      "touch a part of the surface that can move");
  check(status, n_tools == 0 ? -1 : tools[0].nodes[0]);
  for (std::size_t t = 0; t < n_tools; ++t)
    response.force_N.emplace_back(Vec3{forces[3 * t], forces[3 * t + 1], forces[3 * t + 2]});
  if (schema::traits(_dir.model.family).has_energy) response.energy_J = response.coupled.energy;
  response.displacement_m.resize(phn_n_output(_model), 3);
  const int deformed = phn_coupled_deform(_model, _data, response.displacement_m.data());
  if (deformed == PHN_ERROR_UNDEFINED) response.displacement_m.resize(0, 3);
  response.status = status;
  return response;
}

}  // namespace phynness
