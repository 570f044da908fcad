// Geometry of contact: sweeps of free tools, changes of mode.
#include "contact/contact.hpp"

namespace PHN_RUNTIME {
namespace {

double slack_of(const phn_contact& contact) { return sweep_slack * contact.surface.size; }

/// Places an anchored tool that becomes free on the side of the surface from which it came.
void put_on_surface(const phn_contact& contact, double radius, ToolContact& tool) {
  point_at(contact.surface, contact.surface.placed, tool.at, radius, tool.place);
  tool.anchored = tool.felt = false;
}

/// Whether a larger radius has moved the offset surface past a tool that was outside of it.
bool overtaken(const phn_contact& contact, double radius, const ToolContact& tool, SurfacePoint& at) {
  if (!(radius > tool.radius)) return false;
  double normal[3], y[3], apart[3];
  nearest(contact.surface, contact.volumes, tool.radius, tool.place, at);
  normal_at(contact.surface, at, normal);
  point_at(contact.surface, contact.surface.placed, at, tool.radius, y);
  subtract(tool.place, y, apart);
  const double was = dot(apart, normal);
  point_at(contact.surface, contact.surface.placed, at, radius, y);
  subtract(tool.place, y, apart);
  return was >= 0 && dot(apart, normal) < 0 && movable(contact.surface, at) >= least_movable<double>;
}

/// Starts a grasp. The touched point keeps its present displacement, so that it does not jump.
void grip(const phn_contact& contact, const double* center, ToolContact& tool) {
  double x[3];
  point_at(contact.surface, contact.surface.placed, tool.at, 0, x);
  subtract(center, x, tool.grip);
}

}  // namespace

void approach(const phn_contact& contact, const ToolInput& input, ToolContact& tool) {
  const ContactSurface& surface = contact.surface;
  const double *c = input.center, was[3] = {tool.place[0], tool.place[1], tool.place[2]};
  if (tool.anchored && tool.mode != input.mode) {
    if (input.mode == PHN_TOOL_OFF) {
      tool.anchored = false;
    } else if (input.mode == PHN_TOOL_GRASP && tool.felt) {
      double x[3];
      point_at(surface, surface.rest, tool.at, 0, x);
      for (int k = 0; k < 3; ++k) tool.grip[k] = tool.place[k] - x[k] - tool.displacement[k];
    } else {
      put_on_surface(contact, input.radius, tool);
    }
  }
  if (!tool.anchored && input.mode != PHN_TOOL_OFF) {
    SurfacePoint at;
    double part = -1;
    if (tool.known) {
      part = overtaken(contact, input.radius, tool, at)
                 ? 0
                 : sweep(surface, contact.volumes, input.radius, tool.place, c, slack_of(contact), at);
      tool.anchored = part >= 0;
    }
    if (!tool.anchored && input.mode == PHN_TOOL_GRASP) {
      const double distance = nearest(surface, contact.volumes, 0, c, at);
      tool.anchored = distance <= input.radius && movable(surface, at) >= least_movable<double>;
      part = 1;
    }
    if (tool.anchored) {
      double touching[3];
      for (int k = 0; k < 3; ++k) touching[k] = tool.place[k] + part * (c[k] - tool.place[k]);
      tool.at = at;
      tool.loose = false;
      tool.order = 0;
      grip(contact, part < 1 ? touching : c, tool);
    }
  }
  if (!tool.anchored) tool.felt = false;
  tool.known = true;
  tool.mode = input.mode;
  tool.radius = input.radius;
  for (int k = 0; k < 3; ++k) {
    tool.moved[k] = c[k] - was[k];
    tool.place[k] = c[k];
  }
}

void carry(const phn_contact& contact, const SurfacePoint& at, const double* from, ToolContact& tool) {
  double y[3], apart[3], to[3];
  subtract(tool.place, from, apart);
  point_at(contact.surface, contact.surface.placed, at, tool.radius, y);
  for (int k = 0; k < 3; ++k) to[k] = y[k] + apart[k];
  SurfacePoint hit;
  const bool blocked = sweep(contact.surface, contact.volumes, tool.radius, y, to, slack_of(contact), hit) >= 0;
  for (int k = 0; k < 3; ++k) tool.place[k] = blocked ? y[k] : to[k];
}

}  // namespace PHN_RUNTIME
