// phynness for C++17: the functions of phynness_loop.h as members of a class, and the two usual bodies: a node that the
// tool holds, and a surface that a sphere touches. In the manner of phynness.hpp.
#ifndef PHYNNESS_LOOP_HPP
#define PHYNNESS_LOOP_HPP

#include <phynness/phynness_loop.h>

#include <cmath>
#include <phynness/phynness_contact.hpp>

namespace phynness::rt {

/// The defaults of phynness_loop.h.
inline phn_loop_settings loop_defaults() noexcept {
  phn_loop_settings settings;
  phn_loop_defaults(&settings);
  return settings;
}

/// The controller between a device and a body; see phynness_loop.h.
class Loop : public detail::Built<phn_loop, detail::Nothing> {
 public:
  Loop() = default;
  explicit Loop(const phn_loop_settings& settings, Span<std::byte> own = {}) {
    const auto init = [&](void* place, std::size_t bytes, phn_loop** loop) {
      return phn_loop_init(place, bytes, &settings, loop);
    };
    build(own, phn_loop_size, init);
  }

  Status engage() noexcept { return phn_loop_engage(get()); }
  Status release() noexcept { return phn_loop_release(get()); }
  Status clutch(bool on) noexcept { return phn_loop_clutch(get(), on ? 1 : 0); }
  Status reset() noexcept { return phn_loop_reset(get()); }
  /// @param sample  null: none arrived
  Status read(const phn_loop_sample* sample, double now_s, Out3 tool) noexcept {
    return phn_loop_read(get(), sample, now_s, tool.data());
  }
  Status hold(const phn_loop_response& response, double now_s, Out3 force_N) noexcept {
    return phn_loop_hold(get(), &response, now_s, force_N.data());
  }
  Status held(In3 force_N) noexcept { return phn_loop_held(get(), force_N.data()); }
  phn_loop_report report() const noexcept {
    phn_loop_report report = {};
    phn_loop_get_report(get(), &report);
    return report;
  }
};

/// A body of which the tool holds one active node. The origin of its frame is the place of this node at rest.
class HeldNode {
 public:
  HeldNode(const Model& model, Data& data, std::int32_t node) noexcept : _model(&model), _data(&data), _node(node) {}

  phn_loop_response at(In3 tool) noexcept {
    phn_loop_response response = {};
    response.in_contact = 1;
    const bool energy = _model->info().has_energy != 0;
    response.has_stiffness = energy;
    response.energy = -1;
    for (int k = 0; k < 3; ++k) response.displacement[k] = tool.data()[k];
    response.status = phn_force(_model->get(), _data->get(), _node, tool.data(), response.force,
                                energy ? &response.energy : nullptr, energy ? response.stiffness : nullptr);
    return response;
  }

 private:
  const Model* _model;
  Data* _data;
  std::int32_t _node;
};

/// A body that a sphere touches; its frame is that of the mesh.
class TouchingSphere {
 public:
  TouchingSphere(Contact& contact, Tools& data, double radius_m, double friction) noexcept
      : _contact(&contact), _data(&data), _tool{{0, 0, 0}, radius_m, friction, PHN_TOOL_PRESS} {}

  phn_loop_response at(In3 tool) noexcept {
    for (int k = 0; k < 3; ++k) _tool.center[k] = tool.data()[k];
    phn_coupled coupled = {};
    phn_loop_response response = {};
    response.status = _contact->step(*_data, _tool, _state, &coupled);
    response.in_contact = _state.in_contact;
    response.energy = coupled.energy;
    for (int k = 0; k < 3; ++k) {
      response.force[k] = _state.force[k];
      response.displacement[k] = _state.held.displacement[k];
    }
    return response;
  }
  const phn_contact_state& state() const noexcept { return _state; }

 private:
  Contact* _contact;
  Tools* _data;
  phn_contact_tool _tool;
  phn_contact_state _state = {};
};

/// Places the device: its origin is `height` [m] above a node of the surface, its z axis points outward there.
/// @return PHN_ERROR_UNDEFINED if the node is not a corner of a triangle
inline Status place_above(const Model& model, std::int32_t node, double height, phn_loop_settings& settings) noexcept {
  const phn_info& info = model.info();
  std::int32_t vertex = 0;
  while (vertex < info.n_output && info.output_nodes[vertex] != node) ++vertex;
  const auto point = [&](std::int32_t i) {
    return i < info.n_output ? info.output_points + 3 * i : info.fixed_points + 3 * (i - info.n_output);
  };
  double normal[3] = {0, 0, 0};
  for (const std::int32_t* t = info.triangles; t < info.triangles + 3 * info.n_triangles; t += 3) {
    if (t[0] != vertex && t[1] != vertex && t[2] != vertex) continue;
    const double *a = point(t[0]), *b = point(t[1]), *c = point(t[2]);
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      normal[k] += (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
    }
  }
  const double size = std::hypot(normal[0], normal[1], normal[2]);
  if (vertex == info.n_output || !(size > 0)) return PHN_ERROR_UNDEFINED;
  double* const R = settings.rotation;  // its columns are the axes of the device in the frame of the body
  for (int k = 0; k < 3; ++k) R[3 * k + 2] = normal[k] / size;
  const int aside = std::fabs(R[2]) < 0.7 ? 0 : 1;
  for (int k = 0; k < 3; ++k) R[3 * k] = (k == aside) - R[3 * aside + 2] * R[3 * k + 2];
  const double along = std::hypot(R[0], R[3], R[6]);
  for (int k = 0; k < 3; ++k) R[3 * k] /= along;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    R[3 * k + 1] = R[3 * i + 2] * R[3 * j] - R[3 * j + 2] * R[3 * i];
  }
  for (int k = 0; k < 3; ++k) settings.origin_m[k] = point(vertex)[k] + height * R[3 * k + 2];
  return PHN_OK;
}

}  // namespace phynness::rt

#endif
