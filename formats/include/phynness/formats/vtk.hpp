// Files for ParaView with states of a body: VTU and collections of VTU.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Values at the points of a grid: n_points rows; 1 column (scalar) or 3 (vector).
struct VtkField {
  std::string name;  ///< one word
  Eigen::MatrixXd values;
};

/// Points with cells of one kind: tetrahedra (4 columns), triangles (3) or vertices (1).
struct VtkGrid {
  Points points;
  Cells cells;
  std::vector<std::int32_t> node_numbers;  ///< n_points; written as field "node"
  std::vector<std::uint8_t> regions = {};  ///< of the cells, as Mesh::regions; written as cell data "region"
};

struct VtkState {
  double time = 0;
  std::vector<VtkField> fields;
};

/// VTK XML unstructured grid, version 1.0, arrays in base64; its time is the field data "TimeValue".
/// @pre sizes agree; every number is finite
std::string vtu_text(const VtkGrid& grid, const VtkState& state);
/// ParaView's list of VTU files and their times.
/// @param files  relative to the collection
std::string pvd_text(const std::vector<std::string>& files, const std::vector<double>& times);

}  // namespace phynness
