#include "surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <set>

#include "coordinates.hpp"
#include "topology.hpp"

namespace phynness::meshes {
namespace {

template <class Keep>
Triangles filtered(const Triangles& triangles, Keep keep) {
  Triangles kept(triangles.rows(), 3);
  Eigen::Index n = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    if (keep(t)) kept.row(n++) = triangles.row(t);
  kept.conservativeResize(n, 3);
  return kept;
}

/// Renumbers the used nodes in their order.
Surface compacted(const Points& nodes, Triangles triangles) {
  std::vector<std::int32_t> position(static_cast<std::size_t>(nodes.rows()), -1);
  for (Eigen::Index i = 0; i < triangles.size(); ++i) position[triangles.data()[i]] = 0;
  Surface surface;
  surface.nodes.resize(std::count(position.begin(), position.end(), 0), 3);
  std::int32_t n = 0;
  for (std::size_t i = 0; i < position.size(); ++i)
    if (position[i] == 0) {
      surface.nodes.row(n) = nodes.row(static_cast<Eigen::Index>(i));
      position[i] = n++;
    }
  for (Eigen::Index i = 0; i < triangles.size(); ++i) triangles.data()[i] = position[triangles.data()[i]];
  surface.triangles = std::move(triangles);
  return surface;
}

/// Drops triangles without area: those with two equal corners, and repetitions of a triangle.
void drop_useless(Triangles& triangles, bool repair, std::vector<std::string>& notes) {
  const Eigen::Index before = triangles.rows();
  triangles = filtered(triangles, [&](Eigen::Index t) {
    const auto row = triangles.row(t);
    return row(0) != row(1) && row(1) != row(2) && row(0) != row(2);
  });
  if (const Eigen::Index n = before - triangles.rows(); n > 0)
    notes.push_back("dropped " + counted(static_cast<std::size_t>(n), "triangle", "triangles") +
                    " with two equal corners");
  if (!repair) return;
  std::set<Triangle> seen;
  const Eigen::Index distinct = triangles.rows();
  triangles = filtered(triangles, [&](Eigen::Index t) {
    Triangle key{triangles(t, 0), triangles(t, 1), triangles(t, 2)};
    std::sort(key.begin(), key.end());
    return seen.insert(key).second;
  });
  if (const Eigen::Index n = distinct - triangles.rows(); n > 0)
    notes.push_back("repair: dropped " +
                    counted(static_cast<std::size_t>(n), "repeated triangle", "repeated triangles"));
}

std::string list_inward(const Points& nodes, const Triangles& triangles, const SurfaceTopology& topology) {
  std::size_t inward = 0;
  for (std::size_t c = 0; c < topology.component_sizes.size(); ++c)
    inward += enclosed_volume(nodes, filtered(triangles, [&](Eigen::Index t) {
                                return topology.component[t] == static_cast<std::int32_t>(c);
                              })) < 0;
  if (inward == 0) return "";
  return "; normals point inward on " + std::to_string(inward) + " of " +
         counted(topology.component_sizes.size(), "component", "components");
}

}  // namespace

double enclosed_volume(const Points& nodes, const Triangles& triangles) {
  if (nodes.rows() == 0) return 0;
  const Eigen::RowVector3d origin = nodes.colwise().mean();  // near the body, which reduces cancellation
  double six_volumes = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Eigen::RowVector3d a = nodes.row(triangles(t, 0)) - origin, b = nodes.row(triangles(t, 1)) - origin,
                             c = nodes.row(triangles(t, 2)) - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

double area(const Points& nodes, const Triangles& triangles) {
  double twice = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Eigen::RowVector3d a = nodes.row(triangles(t, 0)), b = nodes.row(triangles(t, 1)),
                             c = nodes.row(triangles(t, 2));
    twice += (b - a).cross(c - a).norm();
  }
  return twice / 2;
}

double mean_edge(const Points& nodes, const Triangles& triangles) {
  double sum = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) sum += (nodes.row(triangles(t, k)) - nodes.row(triangles(t, (k + 1) % 3))).norm();
  return triangles.rows() == 0 ? 0 : sum / static_cast<double>(3 * triangles.rows());
}

Surface checked_surface(const RawMesh& raw, double scale_to_m, bool repair, const std::string& source,
                        std::vector<std::string>& notes) {
  Points nodes(static_cast<Eigen::Index>(raw.nodes.size()), 3);
  for (std::size_t i = 0; i < raw.nodes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (int k = 0; k < 3; ++k) nodes(row, k) = raw.nodes[i][k] * scale_to_m;
    require_coordinates(nodes.row(row), source + ": a vertex", row);
  }
  Triangles triangles = to_matrix(raw.triangles);
  drop_useless(triangles, repair, notes);
  if (triangles.rows() == 0)
    throw input_error(
        source + ": the surface has no triangle with three different corners",
        counted(raw.triangles.size(), "triangle", "triangles") + ", " + counted(raw.nodes.size(), "vertex", "vertices"),
        "export a closed surface");
  SurfaceTopology topology = surface_topology(triangles);

  if (repair && topology.component_sizes.size() > 1) {
    const auto largest = std::max_element(topology.component_sizes.begin(), topology.component_sizes.end());
    const auto keep = static_cast<std::int32_t>(largest - topology.component_sizes.begin());
    notes.push_back("repair: kept the largest of " + describe_components(topology.component_sizes, "triangles"));
    triangles = filtered(triangles, [&](Eigen::Index t) { return topology.component[t] == keep; });
    topology = surface_topology(triangles);
  }
  if (const std::string defects = describe_defects(topology, true); !defects.empty())
    throw input_error(
        source + ": the surface is not one closed manifold, so it has no inside to fill",
        defects + list_inward(nodes, triangles, topology),
        topology.closed_manifold()
            ? "keep one component, or set mesh.repair = true to keep the largest"
            : std::string("close the holes and separate parts that touch in the program that made the file") +
                  (repair || topology.component_sizes.size() < 2
                       ? ""
                       : "; mesh.repair = true keeps the largest component, if this component has no defects"));

  const std::int32_t turned = orient_consistently(triangles, topology);
  if (turned < 0)
    throw input_error(source + ": the surface is not orientable and has no inside", "",
                      "export a closed, orientable surface");
  double volume = enclosed_volume(nodes, triangles);
  if (turned > 0)
    notes.push_back("turned " + counted(static_cast<std::size_t>(turned), "triangle", "triangles") +
                    " with orientations opposite to their neighbours");
  if (volume < 0) {
    triangles.col(1).swap(triangles.col(2));
    volume = -volume;
    if (turned == 0) notes.push_back("turned all triangles: the normals pointed inward");
  }
  Surface surface = compacted(nodes, std::move(triangles));
  if (const Eigen::Index dropped = nodes.rows() - surface.nodes.rows(); dropped > 0)
    notes.push_back("dropped " + counted(static_cast<std::size_t>(dropped), "vertex", "vertices") +
                    " that no triangle uses");
  const double reach = (surface.nodes.colwise().maxCoeff() - surface.nodes.colwise().minCoeff()).norm();
  if (!(volume > 1e-12 * reach * reach * reach))
    throw input_error(source + ": the surface encloses no volume", std::to_string(volume) + " m^3",
                      "export a closed, solid shape");
  return surface;
}

}  // namespace phynness::meshes
