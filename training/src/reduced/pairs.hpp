// Fields of pairs of tools, which nobody has solved, from a reduced body with more modes and cells.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <phynness/formats/body.hpp>

namespace phynness::reduced {

/// Displacements in steps from rest to half the depth of the body under two tools, at random touched nodes in random
/// directions. What does not settle is left out.
/// @param body     with all nodes of the mesh
/// @param active   nodes that a tool may touch, at least 2
/// @param inward   directions do not leave the body
/// @param done     called after each pair, on any thread
/// @param threads  at least 1; the result is bitwise independent of it
/// @return 3 n_nodes x any: all of their x, then y, then z
Eigen::MatrixXd fields_of_pairs(const ReducedBody& body, const std::vector<std::int32_t>& active, bool inward,
                                int pairs, std::uint64_t seed, int threads, const std::function<void()>& done);

}  // namespace phynness::reduced
