// Evaluation of a recorded motion: the forces of all its steps, compared with those that the file holds.
#pragma once

#include <filesystem>
#include <optional>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/motion.hpp>

namespace phynness::cli {

/// Evaluates every step with the runtime and prints a summary to stdout.
/// @param name       of the motion, for messages
/// @param json_file  the motion with the forces, energies and status of this model, in the format of the motion
/// @throws Error (input) with the step if the model cannot answer it; nothing is written then
void answer_motion(const LoadedModel& model, const Motion& motion, const std::string& name,
                   const std::optional<std::filesystem::path>& json_file);

}  // namespace phynness::cli
