// Kinds of mesh files, for scenes and for the readers.
#pragma once

#include <string_view>
#include <vector>

namespace phynness {

/// Extensions in lower case with their dots; upper case is accepted, too.
inline const std::vector<std::string_view> mesh_file_extensions = {".msh", ".vtk", ".vtu", ".vtp", ".inp",
                                                                   ".stl", ".obj", ".ply", ".off"};

}  // namespace phynness
