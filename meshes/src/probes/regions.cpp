// Cells of the regions of a scene.
#include <algorithm>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/meshes/meshes.hpp>
#include <sstream>
#include <utility>

#include "probes/select_nodes.hpp"
#include "shapes/generate.hpp"
#include "surface/topology.hpp"

namespace phynness {
namespace {

using meshes::counted, meshes::SelectableBody;
using Numbers = std::vector<std::uint8_t>;

Eigen::Matrix<double, 4, 3> corners_of(const Mesh& mesh, Eigen::Index c) {
  return mesh.nodes(mesh.cells.row(c), Eigen::all);
}

Points centroids(const Mesh& mesh) {
  Points middles(mesh.n_cells(), 3);
  for (Eigen::Index c = 0; c < mesh.n_cells(); ++c) middles.row(c) = corners_of(mesh, c).colwise().mean();
  return middles;
}

bool uses_group(const Selection& selection) {
  return std::ranges::any_of(selection, [](const Selector& s) {
    return s.kind == SelectorKind::group || (s.kind != SelectorKind::near && std::ranges::any_of(s.of, uses_group));
  });
}

/// The region of each point. @param known  of each cell; empty: the points are the middles of all cells
/// @param overlap  receives the points that are in the region and in another one of its order
template <class Overlap>
Numbers regions_at(const Scene& scene, const SelectableBody& body, const Numbers& known, const Overlap& overlap) {
  Numbers at(body.every_node.size(), 0);
  const auto points_of = [&](std::size_t i) {
    const Region& region = scene.regions[i];
    const auto made = body.mesh.cell_groups.find(meshes::inclusion_group(i));
    if (known.empty() && made != body.mesh.cell_groups.end()) return made->second;
    if (known.empty() || !uses_group(region.cells))
      return meshes::select_nodes(region.cells, body, {"cells of region '" + region.name + "'", region.where.prefix()});
    NodeList points;
    for (const auto point : body.every_node)
      if (known[static_cast<std::size_t>((*body.in_cell)[static_cast<std::size_t>(point)])] == i + 1)
        points.push_back(point);
    return points;
  };
  for (std::size_t i = 0; i < scene.regions.size(); ++i) {
    const Region& region = scene.regions[i];
    NodeList shared;
    for (const auto point : points_of(i)) {
      std::uint8_t& now = at[static_cast<std::size_t>(point)];
      const int order = now > 0 ? scene.regions[now - 1u].order : region.order - 1;
      if (order == region.order) shared.push_back(point);
      if (order < region.order) now = static_cast<std::uint8_t>(i + 1);
    }
    if (!shared.empty()) overlap(region, scene.regions[at[static_cast<std::size_t>(shared[0])] - 1u], shared.size());
  }
  return at;
}

void refuse_overlap(const Region& region, const Region& other, std::size_t n) {
  throw input_error(
      region.where.prefix() + "region '" + region.name + "' overlaps region '" + other.name + "'",
      counted(n, "cell", "cells"),
      "give one of them a higher order, such as order = " + std::to_string(other.order + 1) + ", or move them apart");
}

SelectableBody body_of(const Scene& scene, const Mesh& mesh) {
  SelectableBody body(mesh);
  body.fixed = meshes::select_nodes(scene.fixed, body, {"fixed nodes", scene.fixed_where.prefix()});
  return body;
}

NodeList every_cell(const Mesh& mesh) {
  NodeList cells(static_cast<std::size_t>(mesh.n_cells()));
  std::iota(cells.begin(), cells.end(), 0);
  return cells;
}

}  // namespace

Numbers cell_regions(const Scene& scene, const Mesh& mesh) {
  if (scene.regions.empty() || !mesh.regions.empty()) return mesh.regions;
  const SelectableBody nodes = body_of(scene, mesh);
  const Points middles = centroids(mesh);
  const NodeList cells = every_cell(mesh);
  const Numbers regions = regions_at(scene, SelectableBody(nodes, middles, cells), {}, refuse_overlap);
  for (std::size_t i = 0; i < scene.regions.size(); ++i) {
    const Region& region = scene.regions[i];
    const auto n = static_cast<std::size_t>(std::ranges::count(regions, static_cast<std::uint8_t>(i + 1)));
    const auto refuse = [&](const char* what, const char* remedy) {
      throw input_error(region.where.prefix() + "region '" + region.name + "' " + what,
                        std::to_string(n) + " of " + counted(cells.size(), "cell", "cells"), remedy);
    };
    if (n == 0) refuse("has no cell", "regions of higher order cover all of it: lower their order, or make it larger");
    if (n == cells.size())
      refuse("is the whole body", "give these parameters in [material], or make the region smaller");
  }
  return regions;
}

std::string region_group(std::size_t number) { return region_group_prefix + std::to_string(number); }

void take_written_regions(const Scene& scene, Mesh& mesh, const std::string& source) {
  const auto refuse = [&](const std::string& what) {
    throw input_error("the mesh is not of this scene: " + what, source, "make it again with phynness mesh SCENE");
  };
  Numbers in_file(scene.regions.empty() ? 0 : static_cast<std::size_t>(mesh.n_cells()), 0);
  for (std::size_t r = 1; r <= scene.regions.size(); ++r) {
    const auto group = mesh.cell_groups.find(region_group(r));
    if (group == mesh.cell_groups.end())
      refuse("it has no group of cells " + region_group(r) + " for region '" + scene.regions[r - 1].name + "'");
    for (const auto cell : group->second) in_file[static_cast<std::size_t>(cell)] = static_cast<std::uint8_t>(r);
  }
  if (std::ranges::none_of(scene.regions, [](const Region& region) { return uses_group(region.cells); })) {
    Numbers in_scene;
    try {
      in_scene = cell_regions(scene, mesh);
    } catch (const Error& error) {
      refuse(error.what());
    }
    for (std::size_t r = 1; r <= scene.regions.size(); ++r) {
      std::size_t both = 0, either = 0;
      for (std::size_t c = 0; c < in_file.size(); ++c) {
        both += in_file[c] == r && in_scene[c] == r;
        either += in_file[c] == r || in_scene[c] == r;
      }
      if (2 * both < either) refuse("region '" + scene.regions[r - 1].name + "' is elsewhere in it");
    }
  }
  mesh.regions = std::move(in_file);
}

std::string RegionFigures::str() const {
  std::ostringstream text;
  text.precision(3);
  text << name << ": " << meshes::counted(static_cast<std::size_t>(cells), "cell", "cells") << ", " << 1e6 * volume_m3
       << " mL";
  constexpr double much = 0.1;  // The text asks for smaller cells.
  if (off > 0)
    text << " (" << 100 * off << " % of that in cells of another part"
         << (off > much ? ": use smaller cells there)" : ")");
  text << ", shear modulus " << shear_modulus_Pa << " Pa, K/mu " << bulk_to_shear;
  return text.str();
}

std::vector<RegionFigures> region_figures(const Scene& scene, const Mesh& mesh) {
  if (scene.regions.empty()) return {};
  const Numbers regions = cell_regions(scene, mesh);
  // The centroids of the 64 equal parts of each cell, and its own, without which a small region may have no point.
  Mesh part;
  part.nodes = Points::Zero(4, 3);
  part.nodes.bottomRows(3).setIdentity();
  part.cells = Cells(1, 4);
  part.cells << 0, 1, 2, 3;
  const Points inside = centroids(refined(refined(part)));
  const Eigen::Index n = inside.rows() + 1;
  Points points(mesh.n_cells() * n, 3);
  NodeList in_cell;
  std::vector<double> volumes;
  for (Eigen::Index c = 0; c < mesh.n_cells(); ++c) {
    const auto x = corners_of(mesh, c);
    const Eigen::Matrix3d edges = x.bottomRows(3).rowwise() - x.row(0);
    points.middleRows(c * n, n - 1) = (inside * edges).rowwise() + x.row(0);
    points.row(c * n + n - 1) = x.colwise().mean();
    in_cell.insert(in_cell.end(), static_cast<std::size_t>(n), static_cast<std::int32_t>(c));
    volumes.push_back(edges.determinant() / 6);
  }
  const SelectableBody nodes = body_of(scene, mesh);
  const Numbers at = regions_at(scene, SelectableBody(nodes, points, in_cell), regions, [](const auto&...) {});
  std::vector<RegionFigures> figures(scene.regions.size() + 1);
  std::vector<double> sampled(figures.size(), 0);
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    ++figures[regions[c]].cells;
    figures[regions[c]].volume_m3 += volumes[c];
    for (Eigen::Index k = 0; k + 1 < n; ++k) {
      const auto region = at[c * static_cast<std::size_t>(n) + static_cast<std::size_t>(k)];
      const double volume = volumes[c] / static_cast<double>(n - 1);
      sampled[region] += volume;
      if (region != regions[c]) figures[region].off += volume, figures[regions[c]].off += volume;
    }
  }
  const auto all = materials(scene);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    figures[i].name = i == 0 ? "rest of the body" : "region " + scene.regions[i - 1].name;
    if (sampled[i] > 0) figures[i].off /= sampled[i];
    figures[i].shear_modulus_Pa = all[i]->shear_modulus_Pa, figures[i].bulk_modulus_Pa = all[i]->bulk_modulus_Pa;
    figures[i].bulk_to_shear = all[i]->bulk_to_shear();
  }
  return figures;
}

}  // namespace phynness
