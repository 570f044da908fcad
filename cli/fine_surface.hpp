// The deformed surface, subdivided as the runtime does it, as a file to look at.
#pragma once

#include <filesystem>
#include <phynness/evaluation/loaded_model.hpp>
#include <string>

namespace phynness::cli {

/// @throws Error unless the name ends in .vtk, .vtu or .obj
void check_surface_name(const std::filesystem::path& file);

/// VTK: the surface at rest with field `displacement` [m] and `node` (-1: a vertex between nodes); OBJ: the
/// deformed one.
/// @param displacement_m  n_output x 3; @param levels 0 ... 6
/// @return its number of vertices
/// @throws Error if the model has no surface or it cannot be subdivided so often
std::int32_t write_fine_surface(const LoadedModel& model, const Points& displacement_m, int levels,
                                const std::filesystem::path& file, const std::string& title);

}  // namespace phynness::cli
