// Moves tools on the bodies of bodies.hpp.
#pragma once

#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>

#include "../runtime/loaded_model.hpp"
#include "bodies.hpp"

namespace phynness::test {

/// A loaded model and its contact.
struct Touch {
  explicit Touch(const LoadedModel& model, int max_tools = 4) : loaded(model) {
    std::size_t bytes = 0;
    LoadedModel::check(phn_contact_size(loaded.model, max_tools, &bytes));
    memory.resize(bytes);
    LoadedModel::check(phn_contact_init(memory.data(), bytes, loaded.model, max_tools, &contact));
  }
  phn_contact_state step(const phn_contact_tool& tool) {
    phn_contact_state state;
    status = phn_contact_step(contact, 1, &tool, &state, &report);
    EXPECT_GE(status, 0);
    return state;
  }
  std::vector<phn_contact_state> step(const std::vector<phn_contact_tool>& tools) {
    std::vector<phn_contact_state> states(tools.size());
    const auto n = static_cast<std::int32_t>(tools.size());
    status = phn_contact_step(contact, n, tools.data(), states.data(), &report);
    EXPECT_GE(status, 0);
    return states;
  }
  /// What the held point of the surface does in the field of the last step.
  Vector3d moved(const phn_tool& held) {
    Points field(info_of(loaded.model).n_output, 3);
    EXPECT_GE(phn_contact_deform(contact, field.data()), 0);
    Vector3d u(0, 0, 0);
    for (int k = 0; k < 3; ++k)
      if (held.nodes[k] < field.rows()) u += held.weights[k] * field.row(held.nodes[k]).transpose();
    return u;
  }

  const LoadedModel& loaded;
  std::vector<char> memory;
  phn_contact* contact = nullptr;
  phn_contact_report report = {};
  int status = 0;
};

inline phn_contact_tool tool_at(const Vector3d& x, double radius, int mode = PHN_TOOL_PRESS, double friction = 0) {
  return {{x[0], x[1], x[2]}, radius, friction, mode};
}
inline Vector3d vector(const double* x) { return {x[0], x[1], x[2]}; }

inline const LoadedModel& linear_ball() {
  static const LoadedModel loaded(write_model_text(linear_model(ball())), 8);
  return loaded;
}
inline const LoadedModel& bent_ball() {
  static const LoadedModel loaded(write_model_text(bent_model(ball())), 8);
  return loaded;
}

inline Vector3d random_direction(Numbers& numbers) {
  for (;;) {
    const Vector3d x = numbers.vector();
    if (x.norm() > 0.1 && x.norm() < 1) return x.normalized();
  }
}

}  // namespace phynness::test
