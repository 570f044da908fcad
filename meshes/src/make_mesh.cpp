#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
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

/// Edges of a surface far below the median make slivers. Remeshing keeps them where they are folded.
/// @return the shortest edge within a distance of a place, and the remedy; empty unless it is far below
std::string short_edges(const Surface& surface, const Eigen::RowVector3d& place, double distance_m,
                        bool in_file_units) {
  constexpr double far_below = 0.1;
  constexpr double to_merge = 0.2;  // clears slivers of clumps of up to 1 mm in surfaces of 2.6 and 5.5 mm
  std::vector<double> lengths;
  double shortest = std::numeric_limits<double>::infinity();
  Eigen::RowVector3d where = place;
  for (const auto& triangle : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector3d a = surface.nodes.row(triangle[k]), b = surface.nodes.row(triangle[(k + 1) % 3]);
      lengths.push_back((b - a).norm());
      if (lengths.back() < shortest && (a - place).norm() <= distance_m) shortest = lengths.back(), where = a;
    }
  const auto middle = lengths.begin() + std::ssize(lengths) / 2;
  std::nth_element(lengths.begin(), middle, lengths.end());
  if (shortest >= far_below * *middle) return "";
  const double per_m = in_file_units ? 1 : 1000;
  const char *const unit = in_file_units ? "" : " mm", *const unit_of_places = in_file_units ? " (file units)" : unit;
  where *= per_m;
  std::ostringstream text;
  text.precision(3);
  text << "the surface has edges of " << per_m * shortest << unit << " at (" << where[0] << ", " << where[1] << ", "
       << where[2] << ")" << unit_of_places << ", while its median edge is " << per_m * *middle << unit
       << "; merge nodes that are nearer to each other than " << to_merge * per_m * *middle << unit
       << " in the program that made it (in MeshLab: Merge Close Vertices)";
  return text.str();
}

/// Adds place, reason and remedy of flat cells of a mesh that was made here.
/// @param given  the surface of a file; may be null
void warn_of_slivers(MeshResult& result, const Surface* given, bool in_file_units) {
  if (result.quality.n_slivers == 0) return;
  const auto worst = cell_quality(result.mesh, result.quality.worst_cell, {});
  std::string reason =
      given ? short_edges(*given, to_eigen(worst.center_m).transpose(), result.quality.mean_edge_m, in_file_units) : "";
  if (reason.empty())
    reason =
        "the body is thinner there, or its surface is more sharply folded, than its edges are long; use a smaller "
        "mesh.target_size_m or a smoother surface";
  result.warnings.push_back("the worst of these is " + (in_file_units ? worst.str(1, " (file units)") : worst.str()) +
                            ": " + reason);
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
  untangle(wanted, notes);
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
  return spec.target_nodes ? meet_node_target(*spec.target_nodes, extent, place(spec), affordable)
                           : affordable(*spec.target_size_m);
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
       << " m^3: its edges are too long for the shape of the body; give a smaller mesh.target_size_m";
  result.warnings.push_back(text.str());
}

/// @param notes  about the surface
MeshResult filled(const MeshSpec& spec, Surface surface, const Regions& regions, const std::string& source,
                  std::vector<std::string> notes, bool in_file_units) {
  require_gmsh();  // otherwise the surface would be blamed
  untangle(surface, notes);
  const Extent extent{enclosed_volume(surface.nodes, surface.triangles), area(surface.nodes, surface.triangles)};
  const double given_edge_m = mean_edge(surface.nodes, surface.triangles);
  const auto as_given = [&] {
    require_affordable(extent, given_edge_m, place(spec));
    try {
      return generated_body(fill(surface, inclusions(regions, surface, given_edge_m)), source);
    } catch (const Error& error) {
      const std::string edges =
          short_edges(surface, surface.nodes.row(0), std::numeric_limits<double>::infinity(), in_file_units);
      throw input_error(source + ": the inside of the surface cannot be filled with tetrahedra", error.what(),
                        "repair the surface in the program that made it, where its sides touch or nearly touch" +
                            (edges.empty() ? "" : "; " + edges));
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
  warn_of_slivers(result, &surface, in_file_units);
  return result;
}

MeshResult from_surface(const MeshSpec& spec, const Regions& regions, const RawMesh& raw, const std::string& source,
                        bool in_file_units) {
  if (spec.remesh)
    throw input_error(place(spec) + ": remesh = true makes new tetrahedra within a body, but the file holds a surface",
                      source, "remove mesh.remesh: a closed surface is filled with tetrahedra without it");
  std::vector<std::string> notes;
  Surface surface = checked_surface(raw, spec.scale_to_m, spec.repair, source, notes);
  return filled(spec, std::move(surface), regions, source, std::move(notes), in_file_units);
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
                         const std::string& source, bool in_file_units) {
  const Mesh& old = body.mesh;
  if (const std::string defects = describe_defects(surface_topology(old.surface), true); !defects.empty())
    throw input_error(
        place(spec) + ": remesh = true keeps neither cavities of the body nor places where it touches itself",
        source + ", whose surface has " + defects,
        "remove mesh.remesh, and mesh the body again in the program that made it");
  MeshResult result = filled(spec, surface_of(old), regions, source, body.notes, in_file_units);
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

MeshResult from_file(const MeshSpec& spec, const Regions& regions, bool in_file_units) {
  const std::string source = spec.file.filename().string();
  RawMesh raw = read_mesh_file(spec.file);
  require_size(raw, spec, source);
  if (spec.thickness_m > 0) return shell_from_file(spec, raw, source);
  if (raw.tetrahedra.empty()) return from_surface(spec, regions, raw, source, in_file_units);
  MeshResult result = checked_body(raw, spec.scale_to_m, spec.repair, source);
  if (spec.remesh) return remeshed_body(spec, regions, result, source, in_file_units);
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
    const bool of_file = spec.shape == Shape::none;
    MeshResult result = of_file ? from_file(spec, scene.regions, in_file_units) : from_shape(spec, scene.regions);
    if (!of_file && result.made_here) warn_of_slivers(result, nullptr, in_file_units);
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
