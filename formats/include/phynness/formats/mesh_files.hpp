// The kinds of mesh files that are read, for scenes and for the readers.
#pragma once

#include <string_view>
#include <vector>

namespace phynness {

/// Extensions in small letters, with their dots; case does not matter in names of files.
inline const std::vector<std::string_view> mesh_file_extensions = {".msh", ".vtk", ".vtu", ".vtp", ".inp",
                                                                   ".stl", ".obj", ".ply", ".off"};

}  // namespace phynness
