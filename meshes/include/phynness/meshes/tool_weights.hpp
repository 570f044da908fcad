// Points of the surface, and what a tool there moves: nodes and weights, by the closed form of
// phynness/schema/round_tool.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>
#include <span>
#include <vector>

namespace phynness {

/// The corners of a triangle, one in each column.
Eigen::Matrix3d corners_of(const Points& nodes, const Triangles& surface, Eigen::Index t);
/// Its normal, by the order of the corners, with twice the area as length.
Eigen::Vector3d normal_of(const Eigen::Matrix3d& corners);
/// Barycentric weights of the point of a triangle that is nearest to x. @param corners  as corners_of()
Eigen::Vector3d nearest_in_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& x);
/// The point of the surface nearest to x [m]. @pre surface has triangles
SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x);

/// Tools on a surface. Not for several threads at once.
class SurfaceTools {
 public:
  /// @param nodes, surface  of the mesh; any unit, the same as radii; both must outlive this object
  SurfaceTools(const Points& nodes, const Triangles& surface);

  /// The nodes that a tool moves, without fixed nodes. A tool of radius 0 moves the corners of its triangle, with their
  /// barycentric weights. A round tool moves the mean with the weights int phi N_i dA / int phi dA, where phi is the
  /// pressure and N_i is the linear function of node i on the surface, divided beside fixed nodes as weight_divisor()
  /// of schema says. Its forces on the nodes are w_i F.
  /// @param fixed   fixed nodes, ascending
  /// @param center  its nodes and weights are used; corners of weight 0 may be -1
  /// @throws Error (input) if nothing is left of the tool
  TouchedNodes touched_nodes(std::span<const std::int32_t> fixed, const SurfacePoint& center, double radius);

  /// Receives a triangle of the surface and the integrals of the pressure over it, as schema::integrate_pressure().
  using TakeIntegrals = std::function<void(Eigen::Index triangle, std::span<const double> integrals)>;
  /// @param quadratic  integrals of the six quadratic functions instead of the three linear ones
  /// @pre radius > 0
  void press(const SurfacePoint& center, double radius, bool quadratic, const TakeIntegrals& take);

 private:
  const Points& _nodes;
  const Triangles& _surface;
  Points _normals;
  std::vector<std::int32_t> _neighbors, _reached;
  std::vector<char> _is_reached;
};

/// One tool of a SurfaceTools.
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double radius);
/// Those at some nodes, all of one radius.
std::vector<TouchedNodes> tools_of(const Mesh& mesh, const std::vector<std::int32_t>& fixed,
                                   const std::vector<std::int32_t>& nodes, double radius);

}  // namespace phynness
