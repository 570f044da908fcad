// Geometry of contact: sweeps of free tools, changes of mode.
#include "contact/contact.hpp"

namespace PHN_RUNTIME {
namespace {

double slack_of(const phn_contact& contact) { return sweep_slack * contact.surface.size; }

/// Places an anchored tool that becomes free on the side of the surface from which it came.
void free_on_surface(const phn_contact& contact, double radius, ToolContact& tool) {
  point_at(contact.surface, contact.surface.placed, tool.proxy, radius, tool.position);
  tool.has_proxy = tool.in_contact = false;
}

/// Whether a larger radius has moved the offset surface past a tool that was outside of it.
bool is_overtaken(const phn_contact& contact, double radius, const ToolContact& tool, SurfacePoint& at) {
  if (!(radius > tool.radius)) return false;
  double normal[3], y[3], apart[3];
  nearest(contact.surface, contact.volumes, tool.radius, tool.position, at);
  normal_at(contact.surface, at, normal);
  point_at(contact.surface, contact.surface.placed, at, tool.radius, y);
  subtract(tool.position, y, apart);
  const double was = dot(apart, normal);
  point_at(contact.surface, contact.surface.placed, at, radius, y);
  subtract(tool.position, y, apart);
  return was >= 0 && dot(apart, normal) < 0 && movable_weight(contact.surface, at) >= smallest_movable_weight<double>;
}

/// Starts a grasp. The touched point keeps its present displacement, so that it does not jump.
void start_grasp(const phn_contact& contact, const double* center, ToolContact& tool) {
  double x[3];
  point_at(contact.surface, contact.surface.placed, tool.proxy, 0, x);
  subtract(center, x, tool.grasp_offset);
}

}  // namespace

void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool) {
  const ContactSurface& surface = contact.surface;
  const double *c = input.center, was[3] = {tool.position[0], tool.position[1], tool.position[2]};
  if (tool.has_proxy && tool.mode != input.mode) {
    if (input.mode == PHN_TOOL_OFF) {
      tool.has_proxy = false;
    } else if (input.mode == PHN_TOOL_GRASP && tool.in_contact) {
      double x[3];
      point_at(surface, surface.rest, tool.proxy, 0, x);
      for (int k = 0; k < 3; ++k) tool.grasp_offset[k] = tool.position[k] - x[k] - tool.displacement[k];
    } else {
      free_on_surface(contact, input.radius, tool);
    }
  }
  if (!tool.has_proxy && input.mode != PHN_TOOL_OFF) {
    SurfacePoint at;
    double part = -1;
    if (tool.has_position) {
      part = is_overtaken(contact, input.radius, tool, at)
                 ? 0
                 : sweep(surface, contact.volumes, input.radius, tool.position, c, slack_of(contact), at);
      tool.has_proxy = part >= 0;
    }
    if (!tool.has_proxy && input.mode == PHN_TOOL_GRASP) {
      const double distance = nearest(surface, contact.volumes, 0, c, at);
      tool.has_proxy = distance <= input.radius && movable_weight(surface, at) >= smallest_movable_weight<double>;
      part = 1;
    }
    if (tool.has_proxy) {
      double touching[3];
      for (int k = 0; k < 3; ++k) touching[k] = tool.position[k] + part * (c[k] - tool.position[k]);
      tool.proxy = at;
      tool.was_separated = false;
      tool.response_index = 0;
      start_grasp(contact, part < 1 ? touching : c, tool);
    }
  }
  if (!tool.has_proxy) tool.in_contact = false;
  tool.has_position = true;
  tool.mode = input.mode;
  tool.radius = input.radius;
  for (int k = 0; k < 3; ++k) {
    tool.motion[k] = c[k] - was[k];
    tool.position[k] = c[k];
  }
}

void advect(const phn_contact& contact, const SurfacePoint& at, const double* from, ToolContact& tool) {
  double y[3], apart[3], to[3];
  subtract(tool.position, from, apart);
  point_at(contact.surface, contact.surface.placed, at, tool.radius, y);
  for (int k = 0; k < 3; ++k) to[k] = y[k] + apart[k];
  SurfacePoint hit;
  const bool blocked = sweep(contact.surface, contact.volumes, tool.radius, y, to, slack_of(contact), hit) >= 0;
  for (int k = 0; k < 3; ++k) tool.position[k] = blocked ? y[k] : to[k];
}

}  // namespace PHN_RUNTIME
