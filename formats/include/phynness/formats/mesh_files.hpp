// Kinds of mesh files, for scenes and for the readers.
#pragma once

#include <string>
#include <string_view>

namespace phynness {

/// Extensions in lower case with their dots; upper case is accepted, too.
inline constexpr std::string_view mesh_file_extensions[] = {".msh", ".vtk", ".vtu", ".inp",
                                                            ".stl", ".obj", ".ply", ".off"};

/// The remedy for files of other kinds.
inline std::string mesh_file_kinds() {
  std::string text = "give a file whose name ends in one of";
  for (const auto ending : mesh_file_extensions) text.append(" ").append(ending);
  return text + "; `meshio convert FILE mesh.vtu` makes one of most others";
}

}  // namespace phynness
