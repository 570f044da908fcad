#include "parts.hpp"

#include <array>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/phynness.hpp>
#include <string>

#include "sampling.hpp"
#include "threads.hpp"

namespace phynness::reduced {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int increments = 4, steps_of_increment = 100;
constexpr double part_of_depth = 0.5;
/// Displacements of tools that show the stiffness at rest, in depths: the square of this is left of it.
constexpr double small_part_of_depth = 1e-3;

/// Uniform on the sphere.
Vector3d direction(SplitMix64& random) {
  for (;;) {
    Vector3d x;
    for (Index k = 0; k < 3; ++k) x[k] = static_cast<double>(random.next() >> 11) * 0x1p-52 - 1;
    const double size = x.norm();
    if (size <= 1 && size > 0.01) return x / size;
  }
}

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

/// Displacements from rest to `tools`: the fields of the increments that settle.
/// @param n  nodes of the body's surface
MatrixXd press(Organ& organ, const std::vector<phn_tool>& tools, Index n) {
  require(organ.reset());
  MatrixXd fields(3 * n, increments);
  Points displacement(n, 3);
  std::vector<double> forces(3 * tools.size());
  for (int i = 1; i <= increments; ++i) {
    auto part = tools;
    for (phn_tool& tool : part)
      for (double& d : tool.displacement) d = d * i / increments;
    const auto status = organ.hold(part, forces);
    require(status);
    if (status.unsettled()) return fields.leftCols(i - 1);
    require(organ.deform({displacement.data(), static_cast<std::size_t>(displacement.size())}));
    fields.col(i - 1) = displacement.reshaped();
  }
  return fields;
}

}  // namespace

MatrixXd fields_of_pairs(const ReducedBody& body, const std::vector<std::int32_t>& active, bool inward, int pairs,
                         std::uint64_t seed, int threads, const std::function<void()>& done) {
  const Organ of_threads({}, write_body_text(body), PHN_MOST_COUPLED, steps_of_increment);
  const Points normals = node_normals(body.points, body.surface);
  std::vector<MatrixXd> of_pairs(static_cast<std::size_t>(pairs));
  for_each_index(threads, threads, [&](std::int32_t first) {
    Organ organ = of_threads.another();
    for (std::int32_t p = first; p < pairs; p += threads) {
      SplitMix64 random(node_seed(seed, p));
      std::vector<phn_tool> tools;
      for (const std::int32_t a : draw_without_replacement(active.size(), 2, random)) {
        const std::int32_t node = active[static_cast<std::size_t>(a)];
        Vector3d d = part_of_depth * body.depth_m * direction(random);
        if (inward && normals.row(node).dot(d) > 0) d = -d;
        tools.push_back({{node, -1, -1}, {1, 0, 0}, {d[0], d[1], d[2]}});
      }
      of_pairs[static_cast<std::size_t>(p)] = press(organ, tools, body.points.rows());
      done();
    }
  });
  return side_by_side(std::move(of_pairs), 3 * body.points.rows());
}

std::vector<Eigen::Matrix3d> stiffnesses_at_rest(const ReducedBody& body, const std::vector<std::int32_t>& nodes,
                                                 int threads) {
  const Organ of_threads({}, write_body_text(body), 1, steps_of_increment);
  std::vector<Eigen::Matrix3d> all(nodes.size());
  for_each_index(threads, threads, [&](std::int32_t first) {
    Organ organ = of_threads.another();
    for (auto i = static_cast<std::size_t>(first); i < nodes.size(); i += static_cast<std::size_t>(threads))
      all[i] = stiffness_at_rest(organ, nodes[i], small_part_of_depth * body.depth_m);
  });
  return all;
}

}  // namespace phynness::reduced
