#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <sstream>

#include "read/file_mesh.hpp"
#include "read/flat_cells.hpp"
#include "shapes/generate.hpp"

namespace phynness {
namespace {

using namespace meshes;

std::string place(const MeshSpec& spec) { return spec.where.prefix() + "mesh"; }

/// Reason and place of flat cells of a mesh that was made here, and the remedy.
std::string reason_of_slivers(const MeshResult& result, const MeshSpec& spec, bool in_file_units) {
  const auto worst = cell_quality(result.mesh, result.quality.worst_cell, {});
  const std::string of_files_triangles =
      "the file's triangles have short edges there, or the body is thin or sharply folded; mesh.target_size_m makes "
      "new "
      "triangles with edges of one length";
  const std::string of_new_triangles =
      "the body is thinner there, or its surface is more sharply folded, than its edges are long; use a smaller "
      "mesh.target_size_m or a smoother surface";
  return "the worst of these is " + (in_file_units ? worst.str(1, " (file units)") : worst.str()) + ": " +
         (spec.shape == Shape::none && !spec.target_size_m && !spec.target_nodes ? of_files_triangles
                                                                                 : of_new_triangles);
}

/// A defect of a mesh that was made here is a failure and not an error of the input; another size may work.
template <class Check>
MeshResult generated(const Check& check, const char* remedy) {
  try {
    return check();
  } catch (const Error& error) {
    throw failure("the mesh that gmsh made is defective", error.what(), remedy);
  }
}

MeshResult generated_body(RawMesh raw, const std::string& source) {
  const std::int32_t peeled = peel_slivers(raw), split = split_slivers(raw);
  MeshResult result = generated([&] { return checked_body(std::move(raw), 1, false, source); },
                                "try another mesh.target_size_m or mesh.target_nodes");
  if (peeled > 0)
    result.notes.push_back("removed " + counted(static_cast<std::size_t>(peeled), "flat cell", "flat cells") +
                           " from the surface");
  if (split > 0)
    result.notes.push_back("added " + counted(static_cast<std::size_t>(split), "node", "nodes") +
                           " inside, between faces of the surface with flat cells");
  result.made_here = true;
  return result;
}

using Regions = std::vector<Region>;

MeshResult filled_at(const Surface& surface, double edge_m, const Regions& regions, const std::string& source) {
  std::vector<std::string> notes;
  Surface wanted = remeshed(surface, edge_m);
  try {
    untangle(wanted, notes);
  } catch (const Error& error) {
    throw failure("the surface with new triangles intersects itself", error.what(),
                  "try another mesh.target_size_m or mesh.target_nodes");
  }
  MeshResult result = generated_body(fill(wanted, inclusions(regions, wanted, edge_m)), source);
  result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
  return result;
}

/// Makes a mesh of the wanted size or number of nodes and adds a note about the result.
MeshResult sized(const MeshSpec& spec, const Extent& extent, const std::function<MeshResult(double)>& mesh_at) {
  const auto affordable = [&](double edge_m) {
    require_affordable(extent, edge_m, place(spec));
    return mesh_at(edge_m);
  };
  if (spec.target_nodes) return meet_node_target(*spec.target_nodes, extent, place(spec), affordable);
  require_short(extent, *spec.target_size_m, spec.shape == Shape::none, place(spec));
  constexpr int most_tries = 6;
  double edge_m = *spec.target_size_m;
  for (int n = 1;; ++n) try {
      return affordable(edge_m);
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::input || n == most_tries) throw;
      edge_m *= slightly_finer;
    }
}

/// The surface of a body with its own nodes only.
Surface surface_of(const Mesh& mesh) {
  const auto nodes = surface_nodes(mesh.surface);
  Surface surface{mesh.nodes(nodes, Eigen::indexing::all), mesh.surface};
  for (auto& node : surface.triangles.reshaped())
    node = static_cast<std::int32_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  return surface;
}

MeshResult meshed_solid(const MeshSpec& spec, double edge_m, const Regions& regions, const std::string& source) {
  MeshResult body = generated_body(mesh_solid(spec, edge_m), source);
  if (regions.empty()) return body;
  const Surface surface = surface_of(body.mesh);
  const auto within = inclusions(regions, surface, edge_m);
  return within.empty() ? body : generated_body(fill(surface, within), source);
}

MeshResult from_shape(const MeshSpec& spec, const Regions& regions) {
  const std::string source = std::string("shape '") + name(spec.shape) + "'";
  if (spec.shape == Shape::drain) {
    MeshResult result = sized(spec, extent_of_shape(spec), [&](double edge_m) {
      RawMesh raw = mesh_drain(spec, edge_m);
      return generated([&] { return checked_shell(std::move(raw), 1, false, source); },
                       "try a smaller mesh.target_size_m or more mesh.target_nodes");
    });
    check_wall(result, spec.thickness_m, place(spec));
    return result;
  }
  if (spec.shape == Shape::liver) {
    const Surface liver = liver_surface(spec.size_m);
    const Extent extent{enclosed_volume(liver.nodes, liver.triangles), area(liver.nodes, liver.triangles)};
    return sized(spec, extent, [&](double edge_m) { return filled_at(liver, edge_m, regions, source); });
  }
  return sized(spec, extent_of_shape(spec), [&](double edge_m) { return meshed_solid(spec, edge_m, regions, source); });
}

/// Edges that are too long for a body cut off what is thinner or narrower than they are.
void warn_of_volume(MeshResult& result, double given_m3) {
  const double change = result.quality.volume_m3 / given_m3 - 1;
  if (std::abs(change) <= 0.05) return;
  std::ostringstream text;
  text << "remeshing changed the volume of the body by " << std::showpos << std::round(100 * change) << std::noshowpos
       << " %, from " << given_m3 << " to " << result.quality.volume_m3
       << " m^3: its edges are too long for the shape of the body; give a smaller mesh.target_size_m or more "
          "mesh.target_nodes";
  result.warnings.push_back(text.str());
}

/// @param notes  about the surface
MeshResult filled(const MeshSpec& spec, Surface surface, const Regions& regions, const std::string& source,
                  std::vector<std::string> notes) {
  require_gmsh();  // otherwise the surface would be blamed
  untangle(surface, notes);
  const Extent extent{enclosed_volume(surface.nodes, surface.triangles), area(surface.nodes, surface.triangles)};
  const double given_edge_m = mean_edge(surface.nodes, surface.triangles);
  const auto as_given = [&] {
    require_affordable(extent, given_edge_m, place(spec));
    try {
      return generated_body(fill(surface, inclusions(regions, surface, given_edge_m)), source);
    } catch (const Error& error) {
      throw input_error(source + ": the inside of the surface cannot be filled with tetrahedra", error.what(),
                        "repair the surface in the program that made it, where its sides touch or nearly touch");
    }
  };
  MeshResult result;
  if (!spec.target_nodes && !spec.target_size_m) {
    result = as_given();
    notes.push_back("filled the file's own triangles: neither mesh.target_size_m nor mesh.target_nodes is given");
  } else {
    try {
      result = sized(spec, extent, [&](double edge_m) { return filled_at(surface, edge_m, regions, source); });
      warn_of_volume(result, extent.volume_m3);
      notes.push_back("remeshed the surface of " + std::to_string(surface.triangles.rows()) + " triangles to " +
                      std::to_string(result.mesh.surface.rows()));
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::input) throw;
      result = as_given();
      std::string reason = error.what();
      reason = reason.substr(0, reason.find('\n'));
      result.warnings.push_back("the wanted size is not met: remeshing failed (" + reason +
                                "), so the file's own triangles were filled");
    }
  }
  result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
  return result;
}

MeshResult from_surface(const MeshSpec& spec, const Regions& regions, const RawMesh& raw, const std::string& source) {
  if (spec.remesh)
    throw input_error(place(spec) + ": remesh = true makes new tetrahedra within a body, but the file holds a surface",
                      source, "remove mesh.remesh: a closed surface is filled with tetrahedra without it");
  std::vector<std::string> notes;
  Surface surface = checked_surface(raw, spec.scale_to_m, spec.repair, source, notes);
  return filled(spec, std::move(surface), regions, source, std::move(notes));
}

std::string summary(const QualityReport& quality) {
  std::ostringstream text;
  text.precision(2);
  text << counted(static_cast<std::size_t>(quality.n_cells), "cell", "cells") << " (worst quality "
       << quality.min_quality << ", " << quality.n_slivers << " below " << sliver_quality << ")";
  return text.str();
}

/// New tetrahedra within the surface of a body.
MeshResult remeshed_body(const MeshSpec& spec, const Regions& regions, const MeshResult& body,
                         const std::string& source) {
  const Mesh& old = body.mesh;
  if (const std::string defects = describe_defects(surface_topology(old.surface), true); !defects.empty())
    throw input_error(
        place(spec) + ": remesh = true keeps neither cavities of the body nor places where it touches itself",
        source + ", whose surface has " + defects,
        "remove mesh.remesh, and mesh the body again in the program that made it");
  MeshResult result = filled(spec, surface_of(old), regions, source, body.notes);
  std::ostringstream text;
  text.precision(2);
  text << "replaced " << summary(body.quality) << " of the file by " << summary(result.quality)
       << "; the volume changed by " << std::showpos << 100 * (result.quality.volume_m3 / body.quality.volume_m3 - 1)
       << " %";
  result.notes.push_back(text.str());
  return result;
}

MeshResult shell_from_file(const MeshSpec& spec, const RawMesh& raw, const std::string& source) {
  if (!raw.tetrahedra.empty())
    throw input_error(place(spec) + ": a shell is made of triangles, but the file holds tetrahedra", source,
                      "remove mesh.thickness_m to simulate the solid, or give the middle surface of the shell");
  MeshResult result = checked_shell(raw, spec.scale_to_m, spec.repair, source);
  check_wall(result, spec.thickness_m, place(spec));
  if (spec.target_nodes || spec.target_size_m)
    result.warnings.push_back(
        "a shell's triangles are not changed: mesh.target_nodes and mesh.target_size_m have no effect");
  return result;
}

/// @throws Error (input) if the body is so small or so large that squares and cubes of lengths cannot be computed
void require_size(const RawMesh& raw, const MeshSpec& spec, const std::string& source) {
  constexpr double smallest_m = 1e-9, largest_m = 1e9;
  Eigen::AlignedBox3d box;
  for (const auto& x : raw.nodes)
    if (const Eigen::Vector3d point(x[0], x[1], x[2]); point.allFinite()) box.extend(point);
  if (box.isEmpty()) return;
  const double size_m = spec.scale_to_m * box.sizes().maxCoeff();
  // Coincident points and coordinates that are too large are reported by the checks of nodes.
  if ((size_m >= smallest_m && size_m <= largest_m) || box.sizes().isZero(0) ||
      box.sizes().maxCoeff() > largest_coordinate_m)
    return;
  std::ostringstream value;
  value << source << ", " << size_m << " m with scale_to_m = " << spec.scale_to_m;
  throw input_error(place(spec) + ": the size of the body is impossible", value.str(),
                    "correct mesh.scale_to_m, the length of the file's unit in metres");
}

MeshResult from_file(const MeshSpec& spec, const Regions& regions) {
  const std::string source = spec.file.filename().string();
  RawMesh raw = read_mesh_file(spec.file);
  require_size(raw, spec, source);
  if (spec.thickness_m > 0) return shell_from_file(spec, raw, source);
  if (raw.tetrahedra.empty()) return from_surface(spec, regions, raw, source);
  MeshResult result = checked_body(raw, spec.scale_to_m, spec.repair, source);
  if (spec.remesh) return remeshed_body(spec, regions, result, source);
  if (spec.target_nodes || spec.target_size_m)
    result.warnings.push_back(
        "the file holds tetrahedra, which are not changed: mesh.target_nodes and mesh.target_size_m "
        "have no effect without remesh = true");
  return result;
}

}  // namespace

bool holds_open_surface(const std::filesystem::path& file) {
  const RawMesh raw = read_mesh_file(file);
  return raw.tetrahedra.empty() && !surface_topology(to_matrix(raw.triangles)).open_edges.empty();
}

MeshResult make_shell(const std::filesystem::path& file) {
  return checked_shell(read_mesh_file(file), 1, false, file.filename().string());
}

MeshResult make_mesh(const Scene& scene, bool in_file_units) {
  const MeshSpec spec = with_standard_sizes(scene.mesh);
  try {
    MeshResult result = spec.shape == Shape::none ? from_file(spec, scene.regions) : from_shape(spec, scene.regions);
    if (result.made_here && result.quality.n_slivers > 0)
      result.warnings.push_back(reason_of_slivers(result, spec, in_file_units));
    if (!in_file_units) warn_of_size(result, spec.scale_to_m);
    result.mesh.regions = cell_regions(scene, result.mesh);
    for (std::size_t r = 0; r < scene.regions.size(); ++r)
      if (result.mesh.cell_groups.erase(inclusion_group(r)) == 0 && result.made_here &&
          can_be_inclusion(scene.regions[r]))
        result.notes.push_back("tetrahedra do not end at the surface of region '" + scene.regions[r].name +
                               "', which crosses or touches that of the body or of another region");
    for (const RegionFigures& region : region_figures(scene, result.mesh)) result.notes.push_back(region.str());
    return result;
  } catch (const Error& error) {
    // Errors of gmsh and of the checks of its meshes do not contain the place in the scene.
    if (error.kind() == Error::Kind::input || spec.where.file.empty()) throw;
    throw Error(error.kind(), place(spec) + ": " + error.what(), "", "");
  }
}

}  // namespace phynness
