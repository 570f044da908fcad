// What contact with models and bodies has in common: argument checks and memory. Geometry is in approach.cpp, forces
// are in balance.cpp.
#include "contact/contact.hpp"

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr double largest_friction = 1e6;

constexpr phn_contact_state nothing = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 0, {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}}, 0};

int read_tool(const ContactSurface& surface, const phn_contact_tool& tool, ToolInput& input) {
  if (!finite(tool.center) || !std::isfinite(tool.radius) || !std::isfinite(tool.friction)) return PHN_ERROR_NOT_FINITE;
  if (tool.radius < 0 || tool.friction < 0 || tool.mode < PHN_TOOL_OFF || tool.mode > PHN_TOOL_GRASP)
    return PHN_ERROR_ARGUMENT;
  const double far = largest_distance * surface.size;
  for (int k = 0; k < 3; ++k) {
    const double apart = std::fmax(-far, std::fmin(far, tool.center[k] - surface.middle[k]));
    // A centre that is not clamped is passed on without rounding.
    input.center[k] = std::fabs(tool.center[k] - surface.middle[k]) <= far ? tool.center[k] : surface.middle[k] + apart;
  }
  input.radius = std::fmin(tool.radius, surface.size);
  input.friction = std::fmin(tool.friction, largest_friction);
  input.mode = tool.mode;
  return PHN_OK;
}

void write_state(const phn_contact& contact, const ToolContact& tool, phn_contact_state& state) {
  state = nothing;
  for (int k = 0; k < 3; ++k) state.proxy[k] = tool.place[k];
  if (!tool.felt) return;
  for (int k = 0; k < 3; ++k) {
    state.force[k] = tool.force[k];
    state.proxy[k] = tool.place[k] - tool.displacement[k];
    state.normal[k] = tool.normal[k];
  }
  state.scale = tool.scale;
  state.unbalanced = tool.unbalanced;
  state.held = held_by(contact, tool);
  state.in_contact = 1;
}

/// @param x  finite
void find_nearest(const phn_contact& contact, const double* x, phn_tool& tool, double* point) {
  const ContactSurface& surface = contact.surface;
  const double far = 1e3 * largest_distance * surface.size;
  ToolContact found = {};
  double near[3];
  for (int k = 0; k < 3; ++k) near[k] = surface.middle[k] + std::fmax(-far, std::fmin(far, x[k] - surface.middle[k]));
  nearest(surface, contact.volumes, 0, near, found.at);
  tool = held_by(contact, found);
  point_at(surface, surface.placed, found.at, 0, point);
}

}  // namespace

int lay_out_contact(Arena& arena, const WholeSurface& whole, std::int32_t max_tools, ContactParts& parts) {
  if (max_tools < 1) return PHN_ERROR_ARGUMENT;
  if (max_tools > most_touching) return PHN_ERROR_TOO_MANY_TOOLS;
  parts.contact = arena.take<phn_contact>(1);
  parts.surface = lay_out_contact_surface(arena, whole.n_vertices, whole.n_field, whole.n_triangles);
  parts.volumes = lay_out_volumes(arena, whole.n_triangles);
  parts.scratch = arena.take<TouchableEdge>(3 * static_cast<std::size_t>(whole.n_triangles));
  return arena.overflow() ? PHN_ERROR_BUFFER : PHN_OK;
}

int contact_size(const WholeSurface& whole, std::int32_t max_tools, std::size_t* bytes) {
  Arena arena;
  ContactParts parts;
  const int status = lay_out_contact(arena, whole, max_tools, parts);
  if (status == PHN_OK) *bytes = arena.needed();
  return status == PHN_ERROR_BUFFER ? PHN_ERROR_TOO_LARGE : status;
}

int build_contact(const WholeSurface& whole, const void* of, std::int32_t max_tools, ContactParts& parts,
                  phn_contact** contact) {
  const int status = build_contact_surface(whole.triangles, whole.n_triangles, parts.scratch, parts.surface);
  if (status != PHN_OK) return status;
  build_volumes(parts.surface, parts.volumes);
  *parts.contact = {of, max_tools, 0, 0, false, 0, 0, {}, {}, parts.surface, parts.volumes, {}};
  *contact = parts.contact;
  return PHN_OK;
}

int step_contact(phn_contact& contact, Touched& touched, std::int32_t most, std::int32_t n_tools,
                 const phn_contact_tool* tools, const phn_contact_state* states, const void* result,
                 std::size_t result_bytes, phn_coupled& coupled) {
  if (n_tools < 0 || (n_tools > 0 && (tools == nullptr || states == nullptr))) return PHN_ERROR_ARGUMENT;
  if (overlap(states, sizeof *states * static_cast<std::size_t>(n_tools), result, result_bytes))
    return PHN_ERROR_OVERLAP;
  if (n_tools > contact.max_tools || n_tools > most) return PHN_ERROR_TOOLS;
  ToolInput inputs[most_touching];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = read_tool(contact.surface, tools[t], inputs[t]);
    if (refused != PHN_OK) return refused;
  }
  for (std::int32_t t = n_tools; t < contact.max_tools; ++t) contact.tool[t] = {};
  for (std::int32_t t = 0; t < n_tools; ++t) approach(contact, inputs[t], contact.tool[t]);
  return balance(contact, touched, n_tools, inputs, coupled);
}

void write_states(const phn_contact* contact, int status, std::int32_t n_tools, phn_contact_state* states) {
  for (std::int32_t t = 0; states != nullptr && t < n_tools; ++t) {
    states[t] = nothing;
    if (status >= 0) write_state(*contact, contact->tool[t], states[t]);
  }
}

}  // namespace PHN_RUNTIME

using namespace PHN_RUNTIME;

extern "C" {

int phn_contact_reset(phn_contact* contact) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  for (ToolContact& tool : contact->tool) tool = {};
  contact->taken = contact->scale = 0;
  return PHN_OK;
}

int phn_contact_refit(phn_contact* contact, const double* field) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  ContactSurface& surface = contact->surface;
  for (std::int32_t i = 0; field != nullptr && i < 3 * surface.n_field; ++i) {
    if (!std::isfinite(field[i])) return PHN_ERROR_NOT_FINITE;
  }
  // Nearest surface points of free tools before the surface moves.
  SurfacePoint beside[most_touching];
  double distance[most_touching], from[most_touching][3];
  for (std::int32_t t = 0; t < contact->max_tools; ++t) {
    const ToolContact& tool = contact->tool[t];
    distance[t] = -1;
    if (!tool.known || tool.anchored) continue;
    double normal[3], apart[3];
    const double apart_by = nearest(surface, contact->volumes, tool.radius, tool.place, beside[t]);
    normal_at(surface, beside[t], normal);
    point_at(surface, surface.placed, beside[t], tool.radius, from[t]);
    subtract(tool.place, from[t], apart);
    if (dot(apart, normal) >= 0) distance[t] = apart_by;
  }
  const double moved = place(field, surface);
  refit_volumes(surface, contact->volumes);
  for (std::int32_t t = 0; t < contact->max_tools; ++t) {
    if (distance[t] >= 0 && distance[t] <= moved) carry(*contact, beside[t], from[t], contact->tool[t]);
  }
  return PHN_OK;
}

int phn_contact_nearest(const phn_contact* contact, const double x[3], phn_tool* tool, double point[3]) {
  phn_tool held = nothing.held;
  double place[3] = {0, 0, 0};
  int status = PHN_ERROR_ARGUMENT;
  if (contact != nullptr && x != nullptr && tool != nullptr) {
    status = overlap(tool, sizeof *tool, point, sizeof place) ? PHN_ERROR_OVERLAP
             : finite(x)                                      ? PHN_OK
                                                              : PHN_ERROR_NOT_FINITE;
    if (status == PHN_OK) find_nearest(*contact, x, held, place);
  }
  if (tool != nullptr) *tool = held;
  for (int k = 0; k < 3 && point != nullptr; ++k) point[k] = place[k];
  return status;
}

}  // extern "C"
