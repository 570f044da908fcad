#include "shell.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "coincident_nodes.hpp"
#include "coordinates.hpp"
#include "surface.hpp"
#include "topology.hpp"

namespace phynness::meshes {
namespace {

// A director is the mean normal of the two triangles at an edge. Beyond this angle it represents neither of them.
constexpr double sharpest_fold_deg = 120, sharp_fold_deg = 60;
constexpr double flat_triangle = 1e-6;  // twice the area over the square of the longest edge
// Area of the inner face over that of the middle surface, 1 - t / (2 R) for a bend of radius R. Below 0.75, t > R / 2,
// the theory of shells has errors of some per cent. The inner face of a wall of thickness 2 R intersects itself.
constexpr double thick_layer = 0.75, thickest_layer = 0.05;
// As a fraction of the length of the surface. The ratio of bending stiffness to membrane stiffness is the square of
// this.
constexpr double thinnest_wall = 1e-12;

/// Keeps the nodes for which `kept` is true and renumbers them in their order.
void reduce(RawMesh& raw, const std::vector<char>& kept, std::vector<std::string>& notes) {
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> number(raw.nodes.size(), -1), dropped;
  for (std::size_t t = 0; t < raw.triangles.size(); ++t)
    if (kept[t]) {
      triangles.push_back(raw.triangles[t]);
      for (const auto node : raw.triangles[t]) number[node] = 0;
    }
  std::vector<std::array<double, 3>> nodes;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) {
      dropped.push_back(static_cast<std::int32_t>(i));
      continue;
    }
    number[i] = static_cast<std::int32_t>(nodes.size());
    nodes.push_back(raw.nodes[i]);
  }
  for (auto& triangle : triangles)
    for (auto& node : triangle) node = number[node];
  for (auto& [name, group] : raw.groups) {
    std::vector<std::int32_t> left;
    for (const auto node : group)
      if (number[node] >= 0) left.push_back(number[node]);
    group = std::move(left);
  }
  if (!dropped.empty())
    notes.push_back("dropped " + counted(dropped.size(), "unreferenced node", "unreferenced nodes") +
                    " (numbers in the file's list, from 0): " + first_few(dropped, 20));
  raw.nodes = std::move(nodes);
  raw.triangles = std::move(triangles);
}

/// Drops triangles with two equal corners, and nodes that no triangle uses.
void drop_useless(RawMesh& raw, std::vector<std::string>& notes) {
  std::vector<char> kept(raw.triangles.size(), 1);
  for (std::size_t t = 0; t < kept.size(); ++t) {
    const auto& [a, b, c] = raw.triangles[t];
    kept[t] = a != b && b != c && a != c;
  }
  if (const auto n = std::count(kept.begin(), kept.end(), 0); n > 0)
    notes.push_back("dropped " + counted(static_cast<std::size_t>(n), "triangle", "triangles") +
                    " with two equal corners");
  reduce(raw, kept, notes);
}

/// A seam with duplicate nodes is a slit: it results in a warning, or with `repair` the nodes are merged.
void look_at_twins(RawMesh& raw, const Points& nodes, bool repair, MeshResult& result) {
  const auto first = coincident_nodes(nodes);
  const auto twins = repeated(first);
  if (twins.empty()) return;
  const std::string text =
      counted(twins.size(), "node lies", "nodes lie") + " exactly on another node (" + first_few(twins) + ")";
  if (!repair) {
    result.warnings.push_back(text +
                              ": the surface has a slit there, unless the nodes should be merged; mesh.repair = true "
                              "merges them");
    return;
  }
  result.notes.push_back("repair: merged coincident nodes: " + text);
  for (auto& triangle : raw.triangles)
    for (auto& node : triangle) node = first[static_cast<std::size_t>(node)];
  for (auto& [name, group] : raw.groups) {
    for (auto& node : group) node = first[static_cast<std::size_t>(node)];
    std::sort(group.begin(), group.end());
    group.erase(std::unique(group.begin(), group.end()), group.end());
  }
  drop_useless(raw, result.notes);
}

/// The nodes of the file in metres.
Points scaled_nodes(const RawMesh& raw, double scale_to_m, const std::string& source) {
  Points nodes(static_cast<Eigen::Index>(raw.nodes.size()), 3);
  for (Eigen::Index i = 0; i < nodes.rows(); ++i) {
    for (int k = 0; k < 3; ++k)
      nodes(i, k) = raw.nodes[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] * scale_to_m;
    require_coordinates(nodes.row(i), source + ": a node", i);
  }
  return nodes;
}

void require_triangles(const RawMesh& raw, const std::string& source) {
  if (raw.triangles.empty())
    throw input_error(source + ": holds no triangle with three different corners", "",
                      "give the middle surface of a shell");
}

void require_sound_edges(SurfaceTopology topology, const std::string& source) {
  topology.open_edges.clear();
  topology.inconsistent_edges.clear();
  if (const std::string defects = describe_defects(topology, true); !defects.empty())
    throw input_error(source + ": the triangles do not form the surface of a shell", defects,
                      topology.component_sizes.size() > 1
                          ? "keep one piece, or set mesh.repair = true to keep the largest"
                          : "change the mesh: at most two triangles may share an edge, and the triangles of a node "
                            "must form one fan");
}

void require_areas(const Mesh& mesh, const std::string& source) {
  std::vector<std::int32_t> flat;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto corner = [&](int i) -> Eigen::RowVector3d { return mesh.nodes.row(mesh.cells(t, i)); };
    const Eigen::RowVector3d u = corner(1) - corner(0), v = corner(2) - corner(0);
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
    if (!(u.cross(v).norm() > flat_triangle * longest)) flat.push_back(static_cast<std::int32_t>(t));
  }
  if (!flat.empty())
    throw input_error(source + ": triangles have no area",
                      counted(flat.size(), "triangle", "triangles") + ": " + first_few(flat), "mesh the surface again");
}

void look_at_folds(const Mesh& mesh, const std::string& source, std::vector<std::string>& warnings) {
  std::map<Edge, std::vector<Eigen::RowVector3d>> normals;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto corner = [&](int i) -> Eigen::RowVector3d { return mesh.nodes.row(mesh.cells(t, i)); };
    const Eigen::RowVector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (int i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(mesh.cells(t, i), mesh.cells(t, (i + 1) % 3));
      normals[{a, b}].push_back(normal);
    }
  }
  const auto cosine = [](double degrees) { return std::cos(degrees * 3.14159265358979 / 180); };
  std::size_t sharp = 0;
  for (const auto& [edge, pair] : normals) {
    if (pair.size() < 2) continue;
    const double cos_angle = pair[0].dot(pair[1]);
    if (cos_angle < cosine(sharpest_fold_deg))
      throw input_error(source + ": the shell's middle surface is folded back on itself",
                        "at the edge between nodes " + std::to_string(edge[0]) + " and " + std::to_string(edge[1]),
                        "round the fold, or mesh it finer");
    sharp += cos_angle < cosine(sharp_fold_deg);
  }
  if (sharp > 0)
    warnings.push_back("the surface turns by more than 60 degrees at " + counted(sharp, "edge", "edges") +
                       ": shell theory needs a smooth surface; mesh it finer there, or model the corner as a solid");
}

}  // namespace

MeshResult checked_shell(const RawMesh& given, double scale_to_m, bool repair, const std::string& source) {
  MeshResult result;
  RawMesh raw = given;
  result.notes = std::move(raw.notes);
  drop_useless(raw, result.notes);
  require_triangles(raw, source);
  look_at_twins(raw, scaled_nodes(raw, scale_to_m, source), repair, result);
  require_triangles(raw, source);
  auto topology = surface_topology(to_matrix(raw.triangles));
  if (repair && topology.component_sizes.size() > 1) {
    const auto largest = std::max_element(topology.component_sizes.begin(), topology.component_sizes.end());
    const auto keep = static_cast<std::int32_t>(largest - topology.component_sizes.begin());
    result.notes.push_back("repair: kept the largest of " + describe_components(topology.component_sizes, "triangles"));
    std::vector<char> kept(raw.triangles.size(), 0);
    for (std::size_t t = 0; t < kept.size(); ++t) kept[t] = topology.component[t] == keep;
    reduce(raw, kept, result.notes);
    topology = surface_topology(to_matrix(raw.triangles));
  }
  require_sound_edges(topology, source);

  Mesh& mesh = result.mesh;
  mesh.nodes = scaled_nodes(raw, scale_to_m, source);
  mesh.surface = to_matrix(raw.triangles);
  const std::int32_t turned = orient_consistently(mesh.surface, topology);
  if (turned < 0)
    throw input_error(source + ": the surface is not orientable", "",
                      "cut the surface so that it has a front and a back");
  if (turned > 0)
    result.notes.push_back("turned " + counted(static_cast<std::size_t>(turned), "triangle", "triangles") +
                           " with orientations opposite to their neighbours");
  if (topology.open_edges.empty() && enclosed_volume(mesh.nodes, mesh.surface) < 0)
    mesh.surface.col(1).swap(mesh.surface.col(2));
  mesh.cells = mesh.surface;
  mesh.groups = std::move(raw.groups);
  require_areas(mesh, source);
  look_at_folds(mesh, source, result.warnings);
  result.quality = measure_quality(mesh);
  if (result.quality.n_slivers > 0) {
    std::ostringstream text;
    text.precision(2);
    text << counted(static_cast<std::size_t>(result.quality.n_slivers), "sliver", "slivers") << ", worst quality "
         << result.quality.min_quality << " in triangle " << result.quality.worst_cell;
    result.warnings.push_back(text.str());
  }
  warn_of_size(result, scale_to_m);
  return result;
}

void check_wall(MeshResult& result, double thickness_m, const std::string& source) {
  const Mesh& mesh = result.mesh;
  const auto metres = [](double value) {
    std::ostringstream text;
    text << value << " m";
    return text.str();
  };
  const double longest = (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).maxCoeff();
  if (!(thickness_m < longest))
    throw input_error(source + ": the shell is thicker than it is long",
                      "thickness_m = " + metres(thickness_m) + ", the middle surface is " + metres(longest) + " long",
                      "check the units, lengths are in metres; simulate a thick wall as a solid, without thickness_m");
  if (thickness_m < thinnest_wall * longest)
    throw input_error(
        source + ": the wall is too thin for double precision",
        "thickness_m = " + metres(thickness_m) + ", the middle surface is " + metres(longest) + " long",
        "check the units, lengths are in metres; make the wall at least " + metres(thinnest_wall * longest) + " thick");
  std::map<Edge, Eigen::RowVector3d> directors;
  const auto corner = [&](Eigen::Index t, int i) -> Eigen::RowVector3d { return mesh.nodes.row(mesh.cells(t, i % 3)); };
  const auto edge = [&](Eigen::Index t, int i) -> Edge {
    const auto [a, b] = std::minmax(mesh.cells(t, i), mesh.cells(t, (i + 1) % 3));
    return {a, b};
  };
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const Eigen::RowVector3d normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    for (int i = 0; i < 3; ++i) directors.try_emplace(edge(t, i), Eigen::RowVector3d::Zero()).first->second += normal;
  }
  double thinnest = 1;
  Eigen::Index worst = 0;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const Eigen::RowVector3d u = corner(t, 1) - corner(t, 0), v = corner(t, 2) - corner(t, 0);
    std::array<Eigen::RowVector3d, 3> D;
    for (int i = 0; i < 3; ++i) D[static_cast<std::size_t>(i)] = directors.at(edge(t, i)).normalized();
    // Linear in the triangle, given at the midpoints of its edges 0-1, 1-2, 2-0.
    const Eigen::RowVector3d along_u = 2 * (D[1] - D[2]), along_v = 2 * (D[1] - D[0]);
    const Eigen::RowVector3d middle = (D[0] + D[1] + D[2]) / 3;
    for (const double zeta : {thickness_m / 2, -thickness_m / 2}) {
      const double share = (u + zeta * along_u).cross(v + zeta * along_v).dot(middle) / u.cross(v).dot(middle);
      if (share < thinnest) thinnest = share, worst = t;
    }
  }
  const std::string where = "thickness_m = " + metres(thickness_m) + ", the sharpest bend is at triangle " +
                            std::to_string(worst) + " (" + metres(corner(worst, 0)[0]) + ", " +
                            metres(corner(worst, 0)[1]) + ", " + metres(corner(worst, 0)[2]) + ")";
  if (thinnest < thickest_layer)
    throw input_error(source + ": the wall is so thick that its inner face intersects itself at a bend", where,
                      "make the wall thinner, round the bend, or simulate a solid, without thickness_m");
  if (thinnest < thick_layer)
    result.warnings.push_back(
        "the wall is thicker than half the radius of a bend, for which a solid would be more "
        "accurate than a shell; " +
        where);
}

}  // namespace phynness::meshes
