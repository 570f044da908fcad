// A reduced body whose modes are all displacements of the nodes of a block and whose cells are all tetrahedra, each
// with its pressure, and a model of the same mesh.
#pragma once

#include <Eigen/Dense>
#include <phynness/formats/body.hpp>
#include <phynness/schema/body_grammar.hpp>

#include "block_mesh.hpp"
#include "closed_forms.hpp"
#include "runtime/small_model.hpp"

namespace phynness::test {

inline constexpr double block_radius = 0.035, block_depth = 0.02;

class Block {
 public:
  explicit Block(const char* law = "mooney-rivlin")
      : material(material_of(law_named(law),
                             law == std::string("gent")
                                 ? std::vector<std::pair<std::string_view, double>>{{"shear_modulus_Pa", 500},
                                                                                    {"j_m", 5},
                                                                                    {"bulk_modulus_Pa", 5e3}}
                                 : std::vector<std::pair<std::string_view, double>>{{"c10_Pa", 200},
                                                                                    {"c01_Pa", 50},
                                                                                    {"bulk_modulus_Pa", 5e3}})),
        mesh(block_mesh({4, 4, 1}, {0.12, 0.12, 0.03})) {
    const Eigen::Index n = mesh.n_nodes(), cells = mesh.n_cells();
    for (std::int32_t i = 0; i < n; ++i) {
      body.nodes.push_back(i);
      const bool is_fixed = mesh.nodes(i, 0) == 0;
      body.kinds.push_back(is_fixed ? schema::body_node_fixed : schema::body_node_touchable);
      if (is_fixed) fixed.push_back(i);
    }
    Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(3 * n, 3 * (n - std::ssize(fixed)));
    for (Eigen::Index i = 0, m = 0; i < n; ++i)
      for (Eigen::Index k = 0; k < 3 && body.kinds[static_cast<std::size_t>(i)] != schema::body_node_fixed; ++k)
        modes(3 * i + k, m++) = 0.01;
    Eigen::MatrixXd gradients(9 * cells, modes.cols());
    for (Eigen::Index c = 0; c < cells; ++c) {
      for (Eigen::Index m = 0; m < modes.cols(); ++m) {
        const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> G = gradient(c, modes.col(m));
        gradients.block<9, 1>(9 * c, m) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(G.data());
      }
      body.shear_m3.push_back(volume_of(c));
      body.bulk_rJ.push_back(std::sqrt(material.bulk_modulus_Pa * volume_of(c)));
    }
    body.mesh_hash = body.physics_hash = "0123456789abcdef";
    body.law = law;
    body.parameters = material.parameters;
    body.tool_radius_m = block_radius;
    body.depth_m = block_depth;
    body.points = mesh.nodes;
    body.surface = mesh.surface;
    body.modes = scaled_table(modes);
    body.gradients = scaled_table(gradients);
    body.pressures = scaled_table(Eigen::MatrixXd::Identity(cells, cells));
  }

  Eigen::Matrix3d corners(Eigen::Index c) const {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = (mesh.nodes.row(mesh.cells(c, k + 1)) - mesh.nodes.row(mesh.cells(c, 0))).transpose();
    return edges;
  }
  double volume_of(Eigen::Index c) const { return corners(c).determinant() / 6; }
  /// Of displacements of all nodes, 3 n.
  Eigen::Matrix3d gradient(Eigen::Index c, const Eigen::VectorXd& u) const {
    Eigen::Matrix3d moved;
    for (int k = 0; k < 3; ++k)
      moved.col(k) = u.segment<3>(3 * mesh.cells(c, k + 1)) - u.segment<3>(3 * mesh.cells(c, 0));
    return moved * corners(c).inverse();
  }
  double energy(const Eigen::VectorXd& u) const {
    double sum = 0;
    for (Eigen::Index c = 0; c < mesh.n_cells(); ++c)
      sum += volume_of(c) * energy_density(material, Eigen::Matrix3d::Identity() + gradient(c, u));
    return sum;
  }

  Material material;
  Mesh mesh;
  std::vector<std::int32_t> fixed;
  ReducedBody body;
};

/// A model of springs at the free nodes of the block, which knows nothing of their neighbours.
inline Model springs_on(const Block& block) {
  Model model = small_linear_model();
  const ActiveNodeModel spring = model.nodes[0];
  model.mesh_hash = block.body.mesh_hash;
  model.physics_hash = block.body.physics_hash;
  model.n_mesh_nodes = static_cast<std::int32_t>(block.mesh.n_nodes());
  model.fixed = block.fixed;
  model.output.clear();
  model.nodes.clear();
  for (std::int32_t i = 0; i < block.mesh.n_nodes(); ++i)
    if (block.body.kinds[static_cast<std::size_t>(i)] != schema::body_node_fixed) model.output.push_back(i);
  const auto n = static_cast<std::int32_t>(model.output.size());
  model.output_points = block.mesh.nodes(model.output, Eigen::all);
  model.fixed_points = block.mesh.nodes(block.fixed, Eigen::all);
  model.surface = block.mesh.surface;
  for (std::int32_t i = 0; i < n; ++i) {
    ActiveNodeModel& node = model.nodes.emplace_back(spring);
    node.node = model.output[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) node.point[static_cast<std::size_t>(k)] = model.output_points(i, k);
    node.prescribed = {node.node};
    node.prescribed_weight = {1};
    node.linear.stiffness = 10 * Eigen::Matrix3d::Identity();
    node.linear.unit_responses = Eigen::MatrixXd::Zero(n, 9);
    for (int axis = 0; axis < 3; ++axis) node.linear.unit_responses(i, 4 * axis) = 1;
  }
  return model;
}

}  // namespace phynness::test
