// A recorded motion of tools: formats/motion.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace phynness {

/// First value of a motion file.
inline constexpr std::string_view motion_format = "phynness motion 1";

/// Tools that keep their places on the surface while they move.
struct Motion {
  using Vector = std::array<double, 3>;
  /// Nodes -1 are unused; the weights are >= 0 and have the sum 1. A tool at a node: {node, -1, -1}, {1, 0, 0}.
  struct Tool {
    std::array<std::int32_t, 3> nodes{-1, -1, -1};
    std::array<double, 3> weights{};
  };
  static constexpr std::size_t most_tools = 8, most_steps = 1'000'000, most_bytes = std::size_t{32} << 20;
  static constexpr double largest_displacement_m = 1e6;

  std::string mesh_hash;       ///< of the model for which it was recorded; "": not stated
  std::vector<Tool> tools;     ///< 1 to most_tools
  std::vector<double> time_s;  ///< one per step, not decreasing
  /// displacement_m[step][tool]; empty where the tool does not touch the surface.
  std::vector<std::vector<std::optional<Vector>>> displacement_m;
  /// As displacement_m; no steps if the file has no forces.
  std::vector<std::vector<std::optional<Vector>>> force_N;
};

/// @param name  for messages
/// @throws Error (input) if the text is not a motion; the message names the key, the step and the tool
Motion read_motion_text(std::string_view text, const std::string& name);

}  // namespace phynness
