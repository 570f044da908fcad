// Which states of a node become centers of its conservative force network.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace phynness {

/// All columns of the least squares problem: 3 n x 3 n of the centers, then 6 of the stiffness.
struct Columns {
  Eigen::MatrixXd centers, stiffness;
};

/// Forward selection; returns the states chosen, in order, as many as generalized cross-validation is for.
/// Where a body snaps, more of them follow the jump at the states and miss it between them.
/// @param rest  3 n: forces
std::vector<Eigen::Index> choose_centers(Columns columns, Eigen::VectorXd rest, int wanted);

}  // namespace phynness
