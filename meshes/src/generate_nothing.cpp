// Replaces generate_gmsh.cpp in a build without gmsh.
#include <phynness/formats/error.hpp>

#include "generate.hpp"

namespace phynness::meshes {
namespace {

[[noreturn]] void refuse(const char* what) {
  throw input_error(std::string(what) + " needs gmsh, and this program was built without it", "",
                    "give a file that holds tetrahedra, or build with PHYNNESS_WITH_GMSH=ON");
}

}  // namespace

RawMesh fill(const Surface&) { refuse("filling a surface"); }
RawMesh mesh_solid(const Solid&, double) { refuse("a built-in shape"); }
RawMesh mesh_drain(const Drain&, double) { refuse("a built-in shape"); }

}  // namespace phynness::meshes
