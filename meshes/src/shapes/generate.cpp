#include "generate.hpp"

#include <dlfcn.h>

#include <Eigen/Geometry>
#include <cmath>
#include <phynness/formats/error.hpp>

#include "gmsh_module.hpp"

namespace phynness::meshes {
namespace {

/// Reference volume of the raw mesh, for any orientation of its cells.
double volume(const RawMesh& raw) {
  double six = 0;
  for (const auto& cell : raw.tetrahedra) {
    const auto x = [&](int k) { return to_eigen(raw.nodes[cell[k]]); };
    six += std::abs((x(1) - x(0)).dot((x(2) - x(0)).cross(x(3) - x(0))));
  }
  return six / 6;
}

/// Loads gmsh at the first call. The dynamic linker looks beside the installed libraries, or in the folder of the
/// build.
const GmshModule& gmsh() {
  static const GmshModule* const module = [] {
    if (!PHYNNESS_GMSH)
      throw input_error("filling a surface or a built-in shape needs gmsh, and this program was built without it", "",
                        "give a file that holds tetrahedra, or build with PHYNNESS_WITH_GMSH=ON");
    // Never unloaded, because libraries below gmsh keep pointers to their code until the program ends.
    void* const library = dlopen("phynness_gmsh.so", RTLD_LAZY | RTLD_LOCAL);
    const void* const functions = library ? dlsym(library, "phynness_gmsh") : nullptr;
    if (!functions)
      throw failure("gmsh cannot be loaded", dlerror(),
                    "check the installation of libgmsh, and that cmake --install has installed phynness_gmsh.so");
    return static_cast<const GmshModule*>(functions);
  }();
  return *module;
}

}  // namespace

void require_gmsh() { gmsh(); }

RawMesh fill(const Surface& surface, const std::vector<Inclusion>& inclusions) {
  const double unit = mean_edge(surface.nodes, surface.triangles);
  std::vector<Inclusion> within = inclusions;
  for (Inclusion& inclusion : within) inclusion.surface.nodes /= unit;
  RawMesh raw = gmsh().fill({surface.nodes / unit, surface.triangles}, within);
  // The given nodes are restored exactly, because division and multiplication by the unit round them.
  for (Eigen::Index i = 0; i < std::ssize(raw.nodes); ++i)
    for (int k = 0; k < 3; ++k)
      raw.nodes[i][k] = i < surface.nodes.rows() ? surface.nodes(i, k) : raw.nodes[i][k] * unit;
  for (const Inclusion& inclusion : inclusions) {
    const Eigen::AlignedBox3d box(inclusion.surface.nodes.colwise().minCoeff().transpose(),
                                  inclusion.surface.nodes.colwise().maxCoeff().transpose());
    for (const auto& cell : raw.tetrahedra) {
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const auto node : cell) middle += to_eigen(raw.nodes[node]) / 4;
      if (box.contains(middle) && is_inside(inclusion.surface, middle.transpose()))
        raw.cell_groups[inclusion.group].emplace_back(cell.begin(), cell.end());
    }
  }
  const double wanted = enclosed_volume(surface.nodes, surface.triangles), got = volume(raw);
  if (!(std::abs(got - wanted) <= 1e-6 * wanted))
    throw failure("gmsh's tetrahedra do not fill the inside of the surface",
                  std::to_string(got) + " of " + std::to_string(wanted) + " m^3",
                  "check the surface for triangles that intersect, or change mesh.target_size_m");
  return raw;
}

RawMesh mesh_solid(const MeshSpec& solid, double edge_m) {
  const bool round = solid.shape != Shape::block;
  const Vec3 size_m = round ? Vec3{solid.radius_m, solid.radius_m, solid.length_m} : solid.size_m;
  // Regular shapes have many points at equal distances, among which gmsh selects by rounding errors. With dimensions
  // rounded to seven digits the mesh does not depend on the unit of length. The nodes are then scaled to the exact
  // size.
  const auto in_edges = [edge_m](double length_m) {
    constexpr int bits = 24;
    int exponent = 0;
    const double fraction = std::frexp(length_m / edge_m, &exponent);
    return std::ldexp(std::round(std::ldexp(fraction, bits)), exponent - bits);
  };
  const Vec3 size{in_edges(size_m[0]), in_edges(size_m[1]), in_edges(size_m[2])};
  RawMesh raw = gmsh().solid(solid.shape, size, in_edges(solid.inner_radius_m));
  for (auto& x : raw.nodes)
    for (std::size_t k = 0; k < 3; ++k) x[k] *= size_m[k] / size[k];
  return raw;
}

RawMesh mesh_drain(const MeshSpec& drain, double edge_m) {
  RawMesh raw = gmsh().drain(
      {drain.radius_m / edge_m, drain.length_m / edge_m, drain.slit_length_m / edge_m, drain.slit_width_m / edge_m});
  for (auto& x : raw.nodes)
    for (auto& component : x) component *= edge_m;
  return raw;
}

}  // namespace phynness::meshes
