// A reduced body (formats/body.md): what `phynness reduce` writes and phynness_body.h reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Energy [J] of a state q:
///     sum_c shear_c (shape(F_c) + bulk/2 g(F_c)^2) r + b . b / 2
///     r = 1 + (q . lack_at_rest q) / (q . cells_at_rest q),  b = sum_c bulk_c g(F_c) pressures_c
///     F_c = I + gradients_c q
/// shape is that of the law file, and g its of_pressure or, without one, its volumetric (laws/tables/law.py).
struct ReducedBody {
  std::string mesh_hash, physics_hash, law;
  std::vector<double> parameters;  ///< of the law, in the order of its file [Pa or 1]
  double bulk_in_shape_Pa = 0;     ///< bulk above
  double tool_radius_m = 0;        ///< 0: node probes
  double depth_m = 0;              ///< largest displacement of the training data
  Relaxation relaxation{};
  std::vector<std::int32_t> nodes;  ///< of the surface, ascending numbers in the mesh
  std::vector<std::int32_t> kinds;  ///< body_node_* of schema/body_grammar.hpp
  Points points;                    ///< n x 3 [m]
  Triangles surface;                ///< positions among the nodes, normals outward
  ScaledTable modes;                ///< 3 n x n_modes: displacements [m], row 3 i + k
  std::vector<double> shear_m3;     ///< of the cells, with their weights
  std::vector<double> bulk_rJ;      ///< [sqrt(J)]
  /// Empty, or a row for each region with a cell or without: parameters and bulk in place of those above.
  Eigen::MatrixXd regions{};
  std::vector<std::int32_t> region_of_cell;  ///< 0, or i + 1 of row i; empty without regions
  ScaledTable gradients;  ///< 9 n_cells x n_modes: du_i/dX_j in row 9 c + 3 i + j, smaller in the last modes
  /// n_modes x n_modes, symmetric [J]: the second derivative of the first sum at rest, and what it lacks; or none.
  ScaledTable cells_at_rest, lack_at_rest;
  ScaledTable pressures;  ///< n_cells x n_pressures
  /// n x 6, or none: xx, xy, xz, yy, yz, zz of the root of the compliance that the modes lack at a node at rest
  /// [(m/N)^1/2]; zeros where tools are probed.
  ScaledTable lacking;
  double coverage = 0;      ///< of the bounds
  std::int32_t n_rays = 0;  ///< from which they are
  /// Empty, or schema::n_coupled_kinds rows of coefficients: one tool, two, three or more.
  Eigen::Matrix<double, Eigen::Dynamic, schema::n_coupled_terms> bounds{};
};

/// Increments in which tools of a body come from rest where no motion is given. Measured on a gallbladder, pairs of
/// tools of random directions to the full depth that have not settled after 60 steps for each: 36 % in one increment, 2
/// % in four, 0.8 % in eight and in 32.
inline constexpr int increments_from_rest = 8;

/// Modes or cells of the next larger body that `reduce` tries.
inline std::int64_t grown(std::int64_t n) { return 3 * n / 2; }

/// The content of a body.txt, not checked. @throws Error (input), as read_input_file()
std::string read_body_file(const std::filesystem::path& file);
/// The text of a body.txt. @throws Error (failure) if a number is out of the range of the format
std::string write_body_text(const ReducedBody& body);
/// @param source_name  for messages. @throws Error (input) if the text is not a body.txt of this version
ReducedBody read_body_text(const std::string& text, const std::string& source_name);

}  // namespace phynness
