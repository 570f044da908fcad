// Geometry of contact: sweeps of free tools, changes of mode.
#include "contact/contact.hpp"

namespace PHN_RUNTIME {
namespace {

double slack_of(const phn_contact& contact) { return sweep_slack * contact.surface.size; }

/// Frees a tool with a proxy on the side of the surface from which it came.
void free_on_surface(const phn_contact& contact, double radius, ToolContact& tool) {
  tool.position = point_at(contact.surface, contact.surface.placed, tool.proxy, radius);
  tool.has_proxy = tool.in_contact = false;
}

/// Whether a larger radius has moved the offset surface past a tool that was outside of it.
bool surface_has_passed(const phn_contact& contact, double radius, const ToolContact& tool, SurfacePoint& point) {
  if (!(radius > tool.radius)) return false;
  nearest(contact.surface, contact.volumes, tool.radius, tool.position.x, point);
  const Vector normal = normal_at(contact.surface, point);
  const auto height = [&](double r) {
    return dot(tool.position - point_at(contact.surface, contact.surface.placed, point, r), normal);
  };
  return height(tool.radius) >= 0 && height(radius) < 0 &&
         movable_weight(contact.surface, point) >= smallest_movable_weight<double>;
}

}  // namespace

void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool) {
  const ContactSurface& surface = contact.surface;
  const Vector center = input.center, last_position = tool.position;
  if (tool.has_proxy && tool.mode != input.mode) {
    if (input.mode == PHN_TOOL_OFF) {
      tool.has_proxy = false;
    } else if (input.mode == PHN_TOOL_GRASP && tool.in_contact) {
      tool.grasp_offset = tool.position - point_at(surface, surface.rest, tool.proxy, 0) - tool.displacement;
    } else {
      free_on_surface(contact, input.radius, tool);
    }
  }
  if (!tool.has_proxy && input.mode != PHN_TOOL_OFF) {
    SurfacePoint point;
    double part = -1;
    if (tool.has_position) {
      part = surface_has_passed(contact, input.radius, tool, point)
                 ? 0
                 : sweep(surface, contact.volumes, input.radius, tool.position.x, center.x, slack_of(contact), point);
      tool.has_proxy = part >= 0;
    }
    if (!tool.has_proxy && input.mode == PHN_TOOL_GRASP) {
      const double distance = nearest(surface, contact.volumes, 0, center.x, point);
      tool.has_proxy = distance <= input.radius && movable_weight(surface, point) >= smallest_movable_weight<double>;
      part = 1;
    }
    if (tool.has_proxy) {
      tool.proxy = point;
      tool.was_separated = false;
      tool.response_index = 0;
      // The touched point of a grasp keeps its present displacement, so that it does not jump.
      const Vector touching = part < 1 ? tool.position + part * (center - tool.position) : center;
      tool.grasp_offset = touching - point_at(surface, surface.placed, point, 0);
    }
  }
  if (!tool.has_proxy) tool.in_contact = false;
  tool.has_position = true;
  tool.mode = input.mode;
  tool.radius = input.radius;
  tool.motion = center - last_position;
  tool.position = center;
}

void advect(const phn_contact& contact, const SurfacePoint& point, const Vector& from, ToolContact& tool) {
  const Vector y = point_at(contact.surface, contact.surface.placed, point, tool.radius),
               to = y + (tool.position - from);
  SurfacePoint hit;
  const bool blocked = sweep(contact.surface, contact.volumes, tool.radius, y.x, to.x, slack_of(contact), hit) >= 0;
  tool.position = blocked ? y : to;
}

}  // namespace PHN_RUNTIME
