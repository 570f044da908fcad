// A sphere that the coupling moves in free space, into contact, along the surface and out of contact
// (phynness_contact.h).
#pragma once

#include <phynness/phynness_contact.h>

#include "vector3.hpp"

struct TouchingSettings {
  double radius_m = 0.004, friction = 0;
  double clearance_m = 0.001;  ///< between sphere and surface if the position of the device is 0
};

/// Frame of the device: x and y along the surface at a node, z outward. At its origin the distance between the sphere
/// and this node is the clearance.
class TouchingTool {
 public:
  /// @param contact  of one tool
  /// @throws std::invalid_argument  the node is not a corner of a triangle
  TouchingTool(const TouchingSettings& settings, const phn_model* model, phn_data* data, phn_contact* contact,
               int32_t node);

  /// One step of the equilibrium between the coupling [N/m] from the device to the sphere, with its centre at `tool`,
  /// and the touched tissue.
  /// @param deepest  largest displacement of the touched point [m]; 0: no limit
  /// @return the centre of the sphere after the step
  Vector3 follow(Vector3 position, Vector3 tool, double coupling, double deepest);

  /// The contact that holds the surface; its nodes are -1 without contact.
  const phn_tool& held() const { return _state.held; }
  bool in_contact() const { return _state.in_contact != 0; }
  long touches() const { return _touches; }
  long cycles_in_contact() const { return _in_contact; }
  /// Status of the last step.
  int status() const { return _status; }

 private:
  Vector3 to_body(Vector3 d) const { return d.x * _axis[0] + d.y * _axis[1] + d.z * _axis[2]; }
  Vector3 to_device(const double* v) const {
    const Vector3 b{v[0], v[1], v[2]};
    return {dot(b, _axis[0]), dot(b, _axis[1]), dot(b, _axis[2])};
  }

  TouchingSettings _settings;
  phn_data* _data;
  phn_contact* _contact;
  Vector3 _origin, _axis[3];
  phn_contact_state _state{};
  int _status = 0;
  long _touches = 0, _in_contact = 0;
};
