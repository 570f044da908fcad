// Operators of p1-p1 and es-p1-p1 (docs/theory.md, Elements). A field of vectors is a column of 3 n_nodes numbers: all
// of its x, then y, then z. The points of the elements are their cells, then, of es-p1-p1, the edges of the mesh, an
// edge between regions once for each. The pressure is in nodes, in one between regions once for each, too.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <phynness/formats/law.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <vector>

#include "sparse_products.hpp"

namespace phynness::reduced {

/// dW/dF at each point, row by row of F.
using AtPoints = Eigen::Matrix<double, 9, Eigen::Dynamic>;

/// The energy density is shape + bulk_in_shape_Pa/2 g^2 at every point, and the pressure's in the cells. g is that of
/// phynness/schema/body_laws.hpp.
struct Elements {
  /// @param mesh  with the region of each cell, if the scene has any
  Elements(const Mesh& mesh, const Scene& scene);

  Eigen::Index n_nodes = 0, n_cells = 0, n_points = 0;
  Law law = nullptr;
  struct Part {
    std::vector<double> parameters;
    double bulk_in_shape_Pa = 0;
  };
  std::vector<Part> parts;            ///< the body, then its regions
  std::vector<std::uint8_t> part_of;  ///< n_points: a number of `parts`
  Eigen::VectorXd shear, bulk;  ///< volumes [m^3] of the shape and of the pressure at the points; bulk is 0 at edges
  std::array<Sparse, 3> derivative;  ///< n_points x n_nodes [1/m]: d/dx, d/dy, d/dz of a field
  Sparse pressure_values;            ///< n_points x n_pressures: value in the middle of a cell; 0 at edges
  Sparse laplace;                    ///< n_nodes x n_nodes [m]
  Sparse compressibility;  ///< n_pressures x n_pressures [m^3/Pa]: of 1/kappa and of the stabilization at rest

  /// Rows of `derivative` and `pressure_values` for some points.
  std::array<Sparse, 3> derivative_at(const std::vector<std::int32_t>& points) const;
  Sparse pressure_values_at(const std::vector<std::int32_t>& points) const;
  /// laplace for each component. @param fields  3 n_nodes x any
  Eigen::MatrixXd laplace_of(const Eigen::MatrixXd& fields) const;
};

/// Rows of F, or of dF/dq, for points: row 3 i + j is d u_i / d X_j. @return 9 matrices, n_points x columns of fields
std::array<Eigen::MatrixXd, 9> gradients(const std::array<Sparse, 3>& derivative, const Eigen::MatrixXd& fields);

/// Energy densities at the points of a displacement.
struct EnergyDensities {
  Eigen::VectorXd shape, g;       ///< n_points
  AtPoints shape_first, g_first;  ///< derivatives to F
};
/// @return nothing where the law is not defined at a point
std::optional<EnergyDensities> energy_densities(const Elements& elements, const Eigen::VectorXd& u);

/// The second derivative of the shape's density at rest, 9 x 9, and the first of g.
struct RestDerivatives {
  Eigen::Matrix<double, 9, 9> shape;
  Eigen::Matrix<double, 9, 1> g;
};
/// Of each part.
std::vector<RestDerivatives> derivatives_at_rest(const Elements& elements);

}  // namespace phynness::reduced
