// Messages of Haply's Inverse service: haply_inverse.hpp names the pages that document them. Functions throw
// std::runtime_error if a message is not as documented.
#pragma once

#include <array>
#include <string>

namespace phynness::devices::haply {

using Force = std::array<double, 3>;

struct State {
  std::array<double, 3> position_m{};
  bool has_force = false;
  Force force_N{};        ///< current_cursor_force
  std::string not_ready;  ///< why the device cannot be used; empty: it can
};

/// The device of the first message: the one with this id or, if the id is empty, the only one.
std::string select_device(const std::string& message, const std::string& wanted_id);

/// The state of one device in the first message or in a state update.
State read_state(const std::string& message, const std::string& device_id);

/// A command for the force [N]; with a profile, also the one that introduces the program to the service.
std::string force_command(const std::string& device_id, const std::string& force_name, const Force& force,
                          const std::string& profile = "");

/// The beginning of a message in one line, for messages to the user.
std::string beginning_of(const std::string& message);

/// Text with a question mark for each character that cannot be printed.
std::string printable(const std::string& text);

}  // namespace phynness::devices::haply
