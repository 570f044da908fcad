// A model small enough to damage byte by byte, with everything that the format can hold: several active
// nodes, a patch, failed and missing directions, networks of different sizes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <ostream>
#include <phynness/formats/model.hpp>

namespace phynness {

/// How the test runner names a case.
inline void PrintTo(Family family, std::ostream* out) { *out << name(family); }

}  // namespace phynness

namespace phynness::test {

/// q of docs/theory.md.
inline double q(const Eigen::Vector3d& y, double s) { return std::sqrt(y.squaredNorm() + s * s); }

/// Repeatable numbers in [-1, 1].
class Numbers {
 public:
  double next() {
    _state = _state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(_state >> 11) * 0x1p-52 - 1;
  }
  /// Three numbers. The order in which a compiler evaluates the arguments of a function is not defined, so that
  /// Vector3d(next(), next(), next()) differs between compilers.
  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    for (int k = 2; k >= 0; --k) v[k] = next();
    return v;
  }

 private:
  std::uint64_t _state = 42;
};

inline RbfNetwork random_network(const Model& model, int n_neurons, bool deforms, Numbers& numbers) {
  RbfNetwork net;
  const int n_inputs = deforms ? 6 : 3;
  net.input_center.resize(n_inputs);
  net.input_half_range.resize(n_inputs);
  for (int k = 0; k < n_inputs; ++k) {
    net.input_center[k] = 0.001 * numbers.next();
    net.input_half_range[k] = (k < 3 ? 0.01 : 0.05) * (1 + 0.1 * numbers.next());
  }
  net.output_center = numbers.vector() * 0.001;
  net.output_half_range = (Eigen::Vector3d::Constant(1.1) + numbers.vector()) * 0.01;
  net.spread = 0.8;
  net.bias = numbers.vector();
  net.weights.resize(n_neurons, 3);
  for (int i = 0; i < n_neurons; ++i) {
    net.center_displacement.push_back(i % static_cast<int>(model.displacements.rows()));
    if (deforms) net.center_output.push_back((3 * i + 1) % static_cast<int>(model.output.size()));
    for (int k = 0; k < 3; ++k) net.weights(i, k) = 3 * numbers.next();
  }
  fill_centers(model, net);
  return net;
}

/// 20 mesh nodes; fixed 0, 1; output 2 ... 13; active 3, 5, 8 (a patch with 7 and 9) and 15, which is no output node.
inline Model small_model(int n_deformation = 9, int n_force = 5) {
  Numbers numbers;
  Model model;
  model.title = "small, for tests";
  model.mesh_hash = "0123456789abcdef";
  model.physics_hash = "fedcba9876543210";
  model.software_version = "test";
  const double s = 1 / std::sqrt(2.0);
  model.directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-s, 0, -s}};
  model.max_displacement_m = 0.01;
  model.displacements.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) model.displacements(i, k) = (i % 2 == 0 ? 0.005 : 0.01) * model.directions[i / 2][k];
  model.n_mesh_nodes = 20;
  model.fixed = {0, 1};
  model.fixed_points.resize(2, 3);
  model.fixed_points << 0.01, 0.02, 0.03, -0.02, 0.01, 0.04;
  model.output_points.resize(12, 3);
  for (int i = 0; i < 12; ++i) {
    model.output.push_back(i + 2);
    for (int k = 0; k < 3; ++k) model.output_points(i, k) = 0.05 * numbers.next();
  }
  model.surface.resize(4, 3);
  model.surface << 3, 5, 8, 5, 3, 0, 8, 5, 12, 1, 0, 3;
  for (const std::int32_t number : {3, 5, 8, 15}) {
    ActiveNodeModel& node = model.nodes.emplace_back();
    node.node = number;
    for (int k = 0; k < 3; ++k)
      node.point[k] = number < 14 ? model.output_points(number - 2, k) : 0.05 * numbers.next();
    node.prescribed = {number};
    node.prescribed_weight = {1};
    if (number == 8) {
      node.prescribed = {7, 8, 9};
      node.prescribed_weight = {0.25, 1, 0.5};
    }
    node.trained_depth_m = {0.01, 0.01, 0.01, 0.01};
    if (number == 5) {
      node.trained_depth_m[1] = 0.005;
      node.n_incomplete = 1;
    }
    node.force = random_network(model, n_force, false, numbers);
    node.deformation = random_network(model, n_deformation, true, numbers);
  }
  return model;
}

/// The same nodes and probes with linear responses instead of networks; at prescribed nodes the response is the weight.
inline Model small_linear_model() {
  Numbers numbers;
  Model model = small_model(0, 0);
  model.family = Family::linear;
  for (ActiveNodeModel& node : model.nodes) {
    node.force = node.deformation = RbfNetwork();
    Eigen::Matrix3d& stiffness = node.linear.stiffness;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) stiffness(i, j) = stiffness(j, i) = (i == j ? 60 : 0) + 20 * numbers.next();
    node.linear.unit_responses.resize(static_cast<Eigen::Index>(model.output.size()), 9);
    for (Eigen::Index o = 0; o < node.linear.unit_responses.rows(); ++o) {
      for (int i = 0; i < 9; ++i) node.linear.unit_responses(o, i) = 0.5 * numbers.next();
      for (std::size_t i = 0; i < node.prescribed.size(); ++i) {
        if (node.prescribed[i] != model.output[static_cast<std::size_t>(o)]) continue;
        node.linear.unit_responses.row(o).setZero();
        for (int axis = 0; axis < 3; ++axis) node.linear.unit_responses(o, 4 * axis) = node.prescribed_weight[i];
      }
    }
  }
  return model;
}

inline ScaledTable random_table(Eigen::Index n_rows, Eigen::Index n_columns, double size, Numbers& numbers) {
  Eigen::MatrixXd values(n_rows, n_columns);
  for (Eigen::Index r = 0; r < n_rows; ++r)
    for (Eigen::Index c = 0; c < n_columns; ++c) values(r, c) = size * numbers.next();
  return scaled_table(values);
}

/// The same nodes and probes with a potential and modes. Coefficients are floats as training writes them, but
/// at node 5; node 8's near nodes meet its patch; node 15 has no near nodes.
inline Model small_modal_model(int n_modes = 3, int n_force = 5, int n_shared = 6, int n_amplitudes = 4) {
  Numbers numbers;
  Model model = small_model(0, 0);
  model.family = Family::modal;
  model.shared.modes = random_table(3 * static_cast<Eigen::Index>(model.output.size()), n_shared, 0.5, numbers);
  for (int i = 0; i < n_amplitudes; ++i) model.shared.centers.push_back((3 * i + 1) % 8);
  for (ActiveNodeModel& node : model.nodes) {
    node.force = node.deformation = RbfNetwork();
    ConservativeNetwork& force = node.conservative;
    force.shape = 0.3;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        force.stiffness(i, j) = force.stiffness(j, i) = (i == j ? 60 : 0) + 20 * numbers.next();
    force.coefficients.resize(n_force, 3);
    for (int i = 0; i < n_force; ++i) {
      force.centers.push_back((3 * i + 2) % 8);
      for (int k = 0; k < 3; ++k) {
        const double b = 0.05 * numbers.next();
        force.coefficients(i, k) = node.node == 5 ? b : static_cast<float>(b);
      }
    }
    ModalDeformation& modal = node.modal;
    modal.weights = random_table(n_amplitudes + 3, n_modes, 0.01, numbers);
    modal.mixing = random_table(n_shared, n_modes, 1, numbers);
    if (node.node == 3) modal.near = {0, 1, 2, 4};
    if (node.node == 5) modal.near = {3};
    if (node.node == 8) modal.near = {5, 7, 8, 11};
    modal.near_modes = random_table(3 * static_cast<Eigen::Index>(modal.near.size()), n_modes, 1, numbers);
  }
  return model;
}

/// The same with two fields: one of degree 1 with fewer shared modes, one of degree 2 with none near. Node 15
/// has no modes of the second.
inline Model small_field_model() {
  Numbers numbers;
  Model model = small_modal_model();
  const auto n_output = static_cast<Eigen::Index>(model.output.size());
  const auto n_basis = static_cast<Eigen::Index>(model.shared.centers.size()) + 9;
  model.fields = {{"von-mises-stress", "Pa", 1, 1234.5, random_table(n_output, 4, 0.5, numbers)},
                  {"energy-density", "J/m^3", 2, 0.75, random_table(n_output, 6, 0.5, numbers)}};
  for (ActiveNodeModel& node : model.nodes)
    for (const auto& field : model.fields) {
      const Eigen::Index n_modes = field.degree == 2 && node.node == 15 ? 0 : 5;
      ModalDeformation& of_node = node.fields.emplace_back();
      if (field.degree == 1) of_node.near = {1, 4, 6};
      of_node.weights = random_table(n_basis, n_modes, 1, numbers);
      of_node.mixing = random_table(field.modes.cols(), n_modes, 1, numbers);
      of_node.near_modes = random_table(static_cast<Eigen::Index>(of_node.near.size()), n_modes, 1, numbers);
    }
  return model;
}

/// Smaller networks beside those of a model: fewer centers, modes and neurons, other numbers.
inline Model with_levels(Model model, int n_levels = 3) {
  Numbers numbers;
  model.levels.resize(static_cast<std::size_t>(n_levels));
  const auto share = [&](Eigen::Index full, int level) {
    return static_cast<int>((full * (level + 1) + n_levels - 1) / n_levels);
  };
  for (int l = 0; l < n_levels; ++l) {
    auto& level = model.levels[static_cast<std::size_t>(l)];
    level.error_force = 0.5 / (l + 1);
    level.error_displacement = 0.25 / (l + 1);
    if (l + 1 == n_levels) break;
    const int n_centers = share(static_cast<Eigen::Index>(model.shared.centers.size()), l);
    if (model.family == Family::modal)
      level.centers.assign(model.shared.centers.rbegin(), model.shared.centers.rbegin() + n_centers);
    for (ActiveNodeModel& node : model.nodes) {
      LevelResponse& response = node.levels.emplace_back();
      const auto first = [&](const RbfNetwork& net, FirstNeurons& neurons) {
        const int n = share(net.weights.rows(), l);
        neurons.weights = random_table(n, 3, 3, numbers).values();
        neurons.bias = numbers.vector();
      };
      if (model.family == Family::rbfn) {
        first(node.force, response.force);
        first(node.deformation, response.deformation);
        continue;
      }
      ConservativeNetwork& force = response.conservative;
      force = node.conservative;
      force.centers.resize(static_cast<std::size_t>(share(node.conservative.coefficients.rows(), l)));
      force.coefficients.conservativeResize(static_cast<Eigen::Index>(force.centers.size()), 3);
      force.coefficients *= 0.75;
      force.stiffness *= 1.25;
      const auto weights = [&](const ModalDeformation& modal, int n_terms, double size) {
        return random_table(n_centers + n_terms, share(modal.weights.cols(), l), size, numbers);
      };
      response.weights = weights(node.modal, 3, 0.01);
      for (const auto& field : node.fields) response.field_weights.push_back(weights(field, 9, 1));
    }
  }
  return model;
}

/// Bounds of the force's error that grow along each direction; some entries are negative, which counts as 0.
inline Model with_bounds(Model model) {
  Numbers numbers;
  model.bounds = {{0.95, 1000, 50}};
  for (ActiveNodeModel& node : model.nodes) {
    Eigen::MatrixXd values(model.displacements.rows(), 1);
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      values(i, 0) = model.displacements.row(i).norm() * (1 + 1.1 * numbers.next());
    node.bounds = {scaled_table(values)};
  }
  return model;
}

/// The same with a bound of tools between nodes.
inline Model with_bound_between(Model model) {
  model = with_bounds(std::move(model));
  model.bounds[0].between = {-1, 0.4, 0.2, 0.3};
  return model;
}

/// Linear points at nodes 11 and 13, node 10 between them and the first two active nodes; more covered nodes than the
/// model has.
inline Model with_linear_points(Model model) {
  Numbers numbers;
  const auto n_active = static_cast<std::int32_t>(model.nodes.size());
  model.rest_modes = random_table(3 * static_cast<Eigen::Index>(model.output.size()), 2, 0.5, numbers);
  for (const std::int32_t node : {11, 13}) {
    LinearPoint& point = model.linear_points.emplace_back();
    point.node = node;
    for (int k = 0; k < 3; ++k) point.point[static_cast<std::size_t>(k)] = model.output_points(node - 2, k);
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        point.stiffness(i, j) = point.stiffness(j, i) = (i == j ? 40 : 0) + 20 * numbers.next();
    point.mixing = random_table(2, 3, 1, numbers);
    if (node == 11) point.near = {1, 9};
    point.near_modes = random_table(3 * static_cast<Eigen::Index>(point.near.size()), 3, 1, numbers);
  }
  model.outer_triangles.resize(2, 3);
  model.outer_triangles << 0, 1, n_active, n_active + 1, n_active, 1;
  const auto before = model.covered;
  const auto first = static_cast<std::int32_t>(model.probe_triangles.rows());
  std::map<std::int32_t, std::array<std::int32_t, 3>> rows = {
      {10, {first, 20000, 30000}}, {11, {first, 0, 0}}, {13, {first + 1, schema::whole_weight, 0}}};
  for (const auto& row : before.rowwise()) rows[row[0]] = {row[1], row[2], row[3]};
  model.covered.resize(std::ssize(rows), 4);
  Eigen::Index i = 0;
  for (const auto& [node, row] : rows) model.covered.row(i++) << node, row[0], row[1], row[2];
  return model;
}

/// What a level is, as a model of its own.
inline Model level_alone(const Model& model, std::size_t l) {
  Model alone = model;
  alone.levels.clear();
  for (ActiveNodeModel& node : alone.nodes) {
    const auto levels = node.levels;
    node.levels.clear();
    if (l + 1 == model.levels.size()) continue;
    const LevelResponse& level = levels[l];
    const auto cut = [](const FirstNeurons& first, RbfNetwork& net) {
      const auto n = first.weights.rows();
      net.weights = first.weights;
      net.bias = first.bias;
      net.centers.conservativeResize(n, net.centers.cols());
      net.center_displacement.resize(static_cast<std::size_t>(n));
      if (!net.center_output.empty()) net.center_output.resize(static_cast<std::size_t>(n));
    };
    if (model.family == Family::rbfn) {
      cut(level.force, node.force);
      cut(level.deformation, node.deformation);
      continue;
    }
    node.conservative = level.conservative;
    const auto first_modes = [](const ScaledTable& weights, ModalDeformation& modal) {
      modal.weights = weights;
      for (ScaledTable* table : {&modal.mixing, &modal.near_modes}) {
        table->scale = Eigen::VectorXd(table->scale.head(weights.cols()));
        table->entries.conservativeResize(table->entries.rows(), weights.cols());
      }
    };
    first_modes(level.weights, node.modal);
    for (std::size_t f = 0; f < node.fields.size(); ++f) first_modes(level.field_weights[f], node.fields[f]);
  }
  if (model.family == Family::modal && l + 1 < model.levels.size()) alone.shared.centers = model.levels[l].centers;
  return alone;
}

/// Every family, for claims about all of them.
inline Model small_model_of(Family family) {
  if (family == Family::linear) return small_linear_model();
  return family == Family::modal ? small_modal_model() : small_model();
}

}  // namespace phynness::test
