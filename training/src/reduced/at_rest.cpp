#include "parts.hpp"

#include <array>
#include <phynness/formats/error.hpp>
#include <phynness/phynness.hpp>

#include "threads.hpp"

namespace phynness::reduced {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int most_steps = 100;
/// Displacements of tools that show the stiffness at rest, in depths: the square of this is left of it.
constexpr double small_part_of_depth = 1e-3;

void require(Organ::Status status) {
  if (!status.ok())
    throw failure("the runtime refuses the reduced body", status.message(), "please report this defect");
}

/// At rest, of a tool alone at a node [N/m]; symmetric.
Eigen::Matrix3d stiffness_at_rest(Organ& organ, std::int32_t node, double small_m) {
  Eigen::Matrix3d stiffness;
  for (Index k = 0; k < 3; ++k) {
    Vector3d difference = Vector3d::Zero();
    for (const double sign : {1.0, -1.0}) {
      phn_tool tool{{node, -1, -1}, {1, 0, 0}, {0, 0, 0}};
      tool.displacement[k] = sign * small_m;
      std::array<double, 3> force{};
      require(organ.reset());
      require(organ.hold(tool, force));
      difference += sign * to_eigen(force);
    }
    stiffness.col(k) = difference / (2 * small_m);
  }
  return (stiffness + stiffness.transpose()) / 2;
}

}  // namespace

std::vector<Eigen::Matrix3d> stiffnesses_at_rest(const ReducedBody& body, const std::vector<std::int32_t>& nodes,
                                                 int threads, const std::function<void()>& on_node) {
  const Organ of_threads({}, write_body_text(body), 1, most_steps);
  std::vector<Eigen::Matrix3d> all(nodes.size());
  for_each_index(threads, threads, [&](std::int32_t first) {
    Organ organ = of_threads.another();
    for (auto i = static_cast<std::size_t>(first); i < nodes.size(); i += static_cast<std::size_t>(threads)) {
      all[i] = stiffness_at_rest(organ, nodes[i], small_part_of_depth * body.depth_m);
      on_node();
    }
  });
  return all;
}

}  // namespace phynness::reduced
