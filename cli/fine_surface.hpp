// Writes the deformed surface, subdivided by the runtime, to a file for viewers.
#pragma once

#include <filesystem>
#include <phynness/evaluation/loaded_model.hpp>
#include <string>

namespace phynness::cli {

/// @throws Error (input) unless the name ends in .vtu or .obj
void check_surface_name(const std::filesystem::path& file);

/// A VTK file has the undeformed surface with the fields `displacement` [m] and `node` (-1: a vertex between nodes). An
/// OBJ file has the deformed surface.
/// @param displacement_m  n_output x 3
/// @param levels          0 ... 6
/// @return number of vertices
/// @throws Error (input) if the model has no surface, or if the surface cannot be subdivided that often
std::int32_t write_fine_surface(const LoadedModel& model, const Points& displacement_m, int levels,
                                const std::filesystem::path& file, const std::string& title);

}  // namespace phynness::cli
