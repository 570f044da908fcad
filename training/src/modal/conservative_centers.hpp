// Selection of the centers of a conservative force network from the states of a node.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace phynness {

/// All columns of the least squares problem: 3 n columns of the centers, then 6 of the stiffness, with 3 n rows.
struct Columns {
  Eigen::MatrixXd centers, stiffness;
};

/// Forward selection of at most `wanted` states. Generalized cross-validation determines their number: where a body
/// snaps through, more centers would reproduce the jump at the states but be wrong between them.
/// @param rest  3 n: forces
/// @return the selected states in order
std::vector<Eigen::Index> choose_centers(Columns columns, Eigen::VectorXd rest, int wanted);

}  // namespace phynness
