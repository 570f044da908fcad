// A reduced body in the runtime, with memory in vectors that a C program would allocate, and tools on its surface.
#pragma once

#include <gtest/gtest.h>
#include <phynness/phynness_body.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <phynness/formats/selector.hpp>
#include <string>
#include <vector>

namespace phynness::test {

struct LoadedBody {
  explicit LoadedBody(const std::string& text, std::int32_t max_tools = 3) {
    std::size_t bytes = 0, wrong = 0;
    status = phn_body_size(text.data(), text.size(), &bytes, &wrong);
    if (status != PHN_OK) return;
    memory.resize(bytes);
    status = phn_body_init(memory.data(), bytes, text.data(), text.size(), &body, &wrong);
    if (status != PHN_OK || phn_body_state_size(body, max_tools, &bytes) != PHN_OK) return;
    state_memory.resize(bytes);
    most = max_tools;
    rest();
  }
  void rest() { status = phn_body_state_init(state_memory.data(), state_memory.size(), body, most, &state); }
  /// @return a status of phynness.h
  int press(const std::vector<phn_tool>& tools, int steps = 200) {
    return phn_body_force(body, state, static_cast<std::int32_t>(tools.size()), tools.data(), steps, force[0].data(),
                          &pressed);
  }
  Eigen::VectorXd deformation() const {
    phn_body_contents info;
    phn_body_info(body, &info);
    Eigen::VectorXd u(3 * info.n_nodes);
    EXPECT_EQ(phn_body_deform(body, state, u.data()), PHN_OK);
    return u;
  }

  int status;
  std::int32_t most = 0;
  std::vector<char> memory, state_memory;
  const phn_body* body = nullptr;
  phn_body_state* state = nullptr;
  std::array<Eigen::Vector3d, 3> force{};
  phn_body_report pressed{};
};

/// Expects the forces of two tools to be the derivatives of the energy, by differences over h [m].
/// @param press  with the displacements of both. @param where  for messages
template <class Press>
void expect_forces_of_an_energy(const LoadedBody& body, const std::array<Eigen::Vector3d, 2>& d, double h,
                                const Press& press, double where) {
  ASSERT_GE(press(d[0], d[1]), PHN_OK);
  const Eigen::Vector3d forces[] = {body.force[0], body.force[1]};
  for (std::size_t k = 0; k < 6; ++k) {
    double energy[2];
    for (const int side : {0, 1}) {
      auto moved = d;
      moved[k / 3][static_cast<Eigen::Index>(k % 3)] += side == 0 ? -h : h;
      ASSERT_GE(press(moved[0], moved[1]), PHN_OK);
      energy[side] = body.pressed.energy;
    }
    EXPECT_NEAR((energy[1] - energy[0]) / (2 * h), forces[k / 3][static_cast<Eigen::Index>(k % 3)],
                1e-3 * forces[0].norm())
        << where << " " << k;
  }
}

inline phn_tool tool_at(const SurfacePoint& at, const Eigen::Vector3d& d) {
  phn_tool tool{};
  std::copy_n(at.nodes.begin(), 3, tool.nodes);
  std::copy_n(at.weights.begin(), 3, tool.weights);
  std::copy_n(d.data(), 3, tool.displacement);
  return tool;
}

}  // namespace phynness::test
