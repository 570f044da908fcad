// Contact with models and bodies: argument checks and memory. Geometry is in approach.cpp, forces are in balance.cpp.
#include "contact/contact.hpp"

#include "body/body.hpp"

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr double largest_friction = 1e6;

constexpr phn_contact_state no_contact = {
    {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 0, {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}, {0, 0}}, 0, 0};

int read_tool(const ContactSurface& surface, const phn_contact_tool& tool, ToolInput& input) {
  if (tool.reserved != 0) return PHN_ERROR_VERSION;
  if (!finite(tool.center) || !std::isfinite(tool.radius) || !std::isfinite(tool.friction)) return PHN_ERROR_NOT_FINITE;
  if (tool.radius < 0 || tool.friction < 0 || tool.mode < PHN_TOOL_OFF || tool.mode > PHN_TOOL_GRASP)
    return PHN_ERROR_ARGUMENT;
  const double far = largest_distance * surface.size;
  for (int k = 0; k < 3; ++k) {
    const double difference = std::fmax(-far, std::fmin(far, tool.center[k] - surface.middle[k]));
    // A centre that is not clamped is passed on without rounding.
    input.center[k] =
        std::fabs(tool.center[k] - surface.middle[k]) <= far ? tool.center[k] : surface.middle[k] + difference;
  }
  input.radius = std::fmin(tool.radius, surface.size);
  input.friction = std::fmin(tool.friction, largest_friction);
  input.mode = tool.mode;
  return PHN_OK;
}

void write_state(const phn_contact& contact, const ToolContact& tool, phn_contact_state& state) {
  state = no_contact;
  for (int k = 0; k < 3; ++k) state.proxy[k] = tool.position[k];
  if (!tool.in_contact) return;
  for (int k = 0; k < 3; ++k) {
    state.force[k] = tool.force[k];
    state.proxy[k] = tool.position[k] - tool.displacement[k];
    state.normal[k] = tool.normal[k];
  }
  state.scale = tool.scale;
  state.unbalanced = tool.unbalanced;
  state.held = constraint_of(contact, tool);
  state.in_contact = 1;
}

/// Displaces the surface by a field, or with null back to rest.
void displace(phn_contact& contact, const double* field) {
  ContactSurface& surface = contact.surface;
  // Nearest surface points of free tools before the surface moves.
  SurfacePoint beside[most_touching];
  double distance[most_touching];
  Vector from[most_touching];
  for (std::int32_t t = 0; t < contact.max_tools; ++t) {
    const ToolContact& tool = contact.tool[t];
    distance[t] = -1;
    if (!tool.has_position || tool.has_proxy) continue;
    const double to_surface = nearest(surface, contact.volumes, tool.radius, tool.position.x, beside[t]);
    from[t] = point_at(surface, surface.placed, beside[t], tool.radius);
    if (dot(tool.position - from[t], normal_at(surface, beside[t])) >= 0) distance[t] = to_surface;
  }
  const double moved = place(field, surface);
  refit_volumes(surface, contact.volumes);
  contact.is_displaced = field != nullptr;
  for (std::int32_t t = 0; t < contact.max_tools; ++t)
    if (distance[t] >= 0 && distance[t] <= moved) advect(contact, beside[t], from[t], contact.tool[t]);
}

/// Moves the surface to where a tool that grasps left it in the last step. Other tools only push it inwards, where a
/// proxy without a force follows it.
void update_surface(phn_contact& contact) {
  bool moves = false;
  for (std::int32_t t = 0; t < contact.n_tools && contact.n_tools > 1; ++t)
    moves = moves || (contact.tool[t].in_contact && contact.tool[t].mode == PHN_TOOL_GRASP);
  if (moves && field_of_contact(contact, contact.field) >= 0) {
    displace(contact, contact.field);
  } else if (contact.is_displaced) {
    displace(contact, nullptr);
  }
}

/// Writes the states after the step, because they may overlap the tools.
void write_states(const phn_contact* contact, int status, std::int32_t n_tools, phn_contact_state* states) {
  for (std::int32_t t = 0; states != nullptr && t < n_tools; ++t) {
    states[t] = no_contact;
    if (status >= 0) write_state(*contact, contact->tool[t], states[t]);
  }
}

}  // namespace

int lay_out_contact(Arena& arena, const WholeSurface& whole, std::int32_t max_tools, ContactParts& parts) {
  if (max_tools < 1) return PHN_ERROR_ARGUMENT;
  if (max_tools > most_touching) return PHN_ERROR_TOO_MANY_TOOLS;
  parts.contact = arena.take<phn_contact>(1);
  parts.scratch = arena.take<TouchableEdge>(3 * static_cast<std::size_t>(whole.n_triangles));
  phn_contact& made = parts.made;
  made.max_tools = max_tools;
  made.surface = lay_out_contact_surface(arena, whole.n_vertices, whole.n_field, whole.n_triangles);
  made.volumes = lay_out_volumes(arena, whole.n_triangles);
  made.field = max_tools > 1 ? arena.take<double>(3, static_cast<std::size_t>(whole.n_field)) : nullptr;
  return arena.overflow() ? PHN_ERROR_BUFFER : PHN_OK;
}

int build_contact(const WholeSurface& whole, ContactParts& parts, phn_contact** contact) {
  phn_contact& made = parts.made;
  const int status = build_contact_surface(whole.triangles, whole.n_triangles, parts.scratch, made.surface);
  if (status != PHN_OK) return status;
  build_volumes(made.surface, made.volumes);
  *parts.contact = made;
  *contact = parts.contact;
  return PHN_OK;
}

int step_contact(phn_contact& contact, Touched& touched, std::int32_t n_tools, const phn_contact_tool* tools,
                 const phn_contact_state* states, const phn_contact_report* report, phn_coupled& coupled) {
  if (n_tools < 0 || (n_tools > 0 && (tools == nullptr || states == nullptr))) return PHN_ERROR_ARGUMENT;
  if (overlap(states, sizeof *states * static_cast<std::size_t>(n_tools), report, sizeof *report))
    return PHN_ERROR_OVERLAP;
  if (n_tools > contact.max_tools) return PHN_ERROR_TOOLS;
  ToolInput inputs[most_touching];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = read_tool(contact.surface, tools[t], inputs[t]);
    if (refused != PHN_OK) return refused;
  }
  update_surface(contact);
  contact.n_tools = n_tools;
  for (std::int32_t t = n_tools; t < contact.max_tools; ++t) contact.tool[t] = {};
  for (std::int32_t t = 0; t < n_tools; ++t) approach(contact, inputs[t], contact.tool[t]);
  return balance(contact, touched, n_tools, inputs, coupled);
}

int field_of_contact(const phn_contact& contact, double* out) {
  return contact.state != nullptr ? phn_body_deform(contact.state->body, contact.state, out)
                                  : phn_coupled_deform(contact.data->model, contact.data, out);
}

}  // namespace PHN_RUNTIME

using namespace PHN_RUNTIME;

extern "C" {

int phn_contact_reset(phn_contact* contact) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  for (ToolContact& tool : contact->tool) tool = {};
  contact->work = contact->scale = 0;
  contact->n_tools = 0;
  return PHN_OK;
}

int phn_contact_step(phn_contact* contact, int32_t n_tools, const phn_contact_tool* tools, phn_contact_state* states,
                     phn_contact_report* report) {
  phn_contact_report made = {};
  int status = PHN_ERROR_ARGUMENT;
  if (contact != nullptr)
    status = (contact->state != nullptr ? step_on_body : step_on_model)(*contact, n_tools, tools, states, report, made);
  write_states(contact, status, n_tools, states);
  if (report != nullptr) *report = made;
  return status;
}

int phn_contact_deform(phn_contact* contact, double* out) {
  return contact == nullptr || out == nullptr ? PHN_ERROR_ARGUMENT : field_of_contact(*contact, out);
}

}  // extern "C"
