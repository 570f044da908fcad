#include <phynness/formats/body.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/validation/loaded_body.hpp>

namespace phynness {
namespace {

void require_good(int status, const std::string& what, const std::string& where = "",
                  const char* remedy = "make it again with phynness reduce of this version") {
  if (status < 0) throw input_error(what, phn_status_message(status) + where, remedy);
}

}  // namespace

LoadedBody::LoadedBody(const std::filesystem::path& file) : LoadedBody(read_body_file(file), file.string()) {}

LoadedBody::LoadedBody(std::string text, std::string name) : _name(std::move(name)), _text(std::move(text)) {
  std::size_t bytes = 0, wrong = 0;
  const auto require = [&](int status) {
    if (status < 0) read_body_text(_text, _name);  // throws an error with the line and the value
    require_good(status, "the runtime cannot load " + _name, wrong > 0 ? " (byte " + std::to_string(wrong) + ")" : "");
  };
  require(phn_body_size(_text.data(), _text.size(), &bytes, &wrong));
  _body_memory.resize(bytes);
  require(phn_body_init(_body_memory.data(), bytes, _text.data(), _text.size(), &_body, &wrong));
  require(phn_body_info(_body, &_info));
  _state_memory.resize(state_bytes(PHN_MOST_COUPLED));
  reset();
}

bool LoadedBody::has_bounds() const {
  return _text.find("\n" + std::string(schema::body_bounds_word) + " ") != std::string::npos;
}

void LoadedBody::require_mesh(const std::string& mesh_hash, const std::string& of) const {
  if (mesh_hash != _info.mesh_hash)
    throw input_error("the body " + _name + " has another mesh than " + of,
                      "hash " + std::string(_info.mesh_hash) + ", of the other " + mesh_hash,
                      "give a body that phynness reduce made of a database of this mesh");
}

std::size_t LoadedBody::state_bytes(std::int32_t max_tools) const {
  std::size_t bytes = 0;
  require_good(phn_body_state_size(_body, max_tools, &bytes), "the runtime cannot prepare " + _name);
  return bytes;
}

void LoadedBody::reset() {
  require_good(phn_body_state_init(_state_memory.data(), _state_memory.size(), _body, PHN_MOST_COUPLED, &_state),
               "the runtime cannot prepare " + _name);
}

BodyResponse LoadedBody::press(const std::vector<phn_tool>& tools, std::int32_t steps) {
  BodyResponse response;
  response.force_N.resize(tools.size());
  std::vector<double> forces(3 * tools.size());  // of too many tools, too, which get zeros
  response.status = phn_body_force(_body, _state, static_cast<std::int32_t>(tools.size()), tools.data(), steps,
                                   forces.data(), &response.pressed);
  require_good(response.status, "the runtime refuses tools on " + _name,
               tools.empty() ? "" : " (first node " + std::to_string(tools[0].nodes[0]) + ")",
               "touch a part of its surface that can move, with finite displacements and at most eight tools");
  for (std::size_t t = 0; t < tools.size(); ++t)
    response.force_N[t] = {forces[3 * t], forces[3 * t + 1], forces[3 * t + 2]};
  double bounds[PHN_MOST_COUPLED];
  response.bound_N.resize(tools.size());
  if (phn_body_bound(_body, _state, bounds) >= 0)
    for (std::size_t t = 0; t < tools.size(); ++t)
      if (bounds[t] < PHN_NO_BOUND) response.bound_N[t] = bounds[t];
  response.displacement_m.resize(_info.n_nodes, 3);
  require_good(phn_body_deform(_body, _state, response.displacement_m.data()), "the runtime cannot deform " + _name);
  return response;
}

BodyResponse LoadedBody::press_from_rest(const std::vector<phn_tool>& tools, int increments, std::int32_t steps) {
  reset();
  BodyResponse response;
  for (int i = 1; i <= increments; ++i) {
    auto moved = tools;
    for (std::size_t t = 0; t < tools.size(); ++t)
      for (int k = 0; k < 3; ++k) moved[t].displacement[k] = tools[t].displacement[k] * i / increments;
    response = press(moved, steps);
  }
  return response;
}

}  // namespace phynness
