// Writes a model whose sizes are known but whose numbers are not: these are random, with as many digits as fitted ones.
#include <algorithm>
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/formats/tool.hpp>
#include <phynness/planning/planning.hpp>
#include <phynness/schema/family.hpp>
#include <random>

namespace phynness {
namespace {

std::mt19937_64 generator;

/// In [-0.7, 0.7), which most fitted numbers are; the factor gives them all their digits.
Eigen::MatrixXd numbers(std::int64_t rows, std::int64_t cols) {
  return Eigen::MatrixXd::NullaryExpr(
      rows, cols, [] { return 0.7 * (std::ldexp(static_cast<double>(generator() >> 10), -53) - 1); });
}
/// Training rounds some numbers to float.
Eigen::MatrixXd floats(std::int64_t rows, std::int64_t cols) {
  return numbers(rows, cols).cast<float>().cast<double>();
}
ScaledTable table(std::int64_t rows, std::int64_t cols) { return scaled_table(numbers(rows, cols)); }

/// `n` integers below `end`.
std::vector<std::int32_t> indices(std::int64_t n, std::int64_t end) {
  std::vector<std::int32_t> all(static_cast<std::size_t>(n));
  for (auto& index : all) index = static_cast<std::int32_t>(generator() % static_cast<std::uint64_t>(end));
  return all;
}

RbfNetwork network(int n, int n_inputs, const Model& model) {
  RbfNetwork net;
  net.input_center = numbers(n_inputs, 1);
  net.input_half_range = numbers(n_inputs, 1).cwiseAbs();
  net.output_center = numbers(3, 1);
  net.output_half_range = numbers(3, 1).cwiseAbs();
  net.bias = numbers(3, 1);
  net.center_displacement = indices(n, model.displacements.rows());
  if (n_inputs == 6) net.center_output = indices(n, static_cast<std::int64_t>(model.output.size()));
  net.weights = numbers(n, 3);
  fill_centers(model, net);
  return net;
}

ConservativeNetwork force(std::int64_t n, const Model& model) {
  const Eigen::Matrix3d half = floats(3, 3);
  return {.stiffness = half + half.transpose(),
          .centers = indices(n, model.displacements.rows()),
          .coefficients = floats(n, 3)};
}

ModalDeformation modes(std::int64_t n_basis, std::int64_t n_shared, std::int64_t n_near, int components, std::int64_t m,
                       const Model& model) {
  ModalDeformation all{table(n_basis, m), table(n_shared, m), {}, table(components * n_near, m)};
  const auto n_output = static_cast<std::int64_t>(model.output.size());
  for (std::int64_t i = 0; i < n_near; ++i) all.near.push_back(static_cast<std::int32_t>(i * n_output / n_near));
  return all;
}

/// Halves all numbers for each level below the full one; the smallest sizes of training have little influence.
std::int64_t halved(std::int64_t full, std::size_t below) {
  const std::int64_t step = std::int64_t{1} << below;
  return (full + step - 1) / step;
}

/// The largest numbers that the database allows.
void plan_shared(const TrainingSpec& spec, const std::vector<Field>& fields, Model& model) {
  const auto n_output = static_cast<std::int64_t>(model.output.size()), states = model.displacements.rows();
  const auto shared = [&](std::int64_t rows) { return std::min<std::int64_t>(spec.shared_modes, rows); };
  const bool deforms = schema::traits(model.family).has_modes && spec.modes > 0;
  const std::int64_t n_centers = deforms ? std::min<std::int64_t>(spec.amplitude_centers, states) : 0;
  model.shared = {table(3 * n_output, deforms ? shared(3 * n_output) : 0), indices(n_centers, states)};
  for (std::size_t f = 0; deforms && f < fields.size(); ++f)
    model.fields.push_back({name(fields[f]), unit(fields[f]), degree(fields[f]), 1, table(n_output, shared(n_output))});
  if (spec.levels < 2 || !schema::traits(model.family).has_levels) return;
  model.levels.resize(static_cast<std::size_t>(spec.levels));
  for (std::size_t l = 0; l < model.levels.size(); ++l)
    model.levels[l] = {0.1, 0.1, indices(halved(n_centers, model.levels.size() - 1 - l), states)};
}

void plan_response(const TrainingSpec& spec, const Model& model, ActiveNodeModel& node) {
  const auto n_output = static_cast<std::int64_t>(model.output.size()), states = model.displacements.rows();
  const auto n_centers = static_cast<std::int64_t>(model.shared.centers.size());
  const std::int64_t m = std::min<std::int64_t>(spec.modes, states);
  const std::int64_t n_near = m > 0 ? std::min<std::int64_t>(spec.near_nodes, n_output) : 0;
  const std::int64_t n_force = std::min<std::int64_t>(spec.force_centers, states);
  node.force = network(spec.force_neurons, 3, model);
  node.deformation = network(spec.deformation_neurons, 6, model);
  node.conservative = force(n_force, model);
  node.linear = {node.conservative.stiffness, floats(n_output, 9)};
  node.modal = modes(n_centers + schema::n_linear_terms, model.shared.modes.cols(), n_near, 3, m, model);
  for (const auto& field : model.fields)
    node.fields.push_back(modes(n_centers + schema::n_field_terms, field.modes.cols(), n_near, 1, m, model));
  for (std::size_t l = 0; l + 1 < model.levels.size(); ++l) {
    const std::size_t below = model.levels.size() - 1 - l;
    const auto n_of_level = static_cast<std::int64_t>(model.levels[l].centers.size());
    const std::int64_t m_of_level = halved(m, below);
    LevelResponse& level = node.levels.emplace_back();
    level.force = {numbers(halved(spec.force_neurons, below), 3), numbers(3, 1)};
    level.deformation = {numbers(halved(spec.deformation_neurons, below), 3), numbers(3, 1)};
    level.conservative = force(halved(n_force, below), model);
    level.weights = table(n_of_level + schema::n_linear_terms, m_of_level);
    for (std::size_t f = 0; f < model.fields.size(); ++f)
      level.field_weights.push_back(table(n_of_level + schema::n_field_terms, m_of_level));
  }
}

}  // namespace

Model sized_model(const Scene& scene, const DatabaseHeader& header, std::size_t n_nodes) {
  generator.seed(1);
  Model model = model_of_database(header, scene.training.family, scene.title);
  model.displacements =
      model.max_displacement_m * numbers(std::ssize(header.directions) * std::ssize(header.magnitudes_m), 3);
  plan_shared(scene.training, header.fields, model);
  const auto& active = header.sets.active;
  for (std::size_t k = 0; k < std::min(n_nodes, active.size()); ++k) {
    ActiveNodeModel& node = model.nodes.emplace_back();
    node.node = active[k * active.size() / n_nodes + active.size() / (2 * n_nodes)];
    for (int i = 0; i < 3; ++i) node.point[static_cast<std::size_t>(i)] = header.mesh.nodes(node.node, i);
    const auto tool = touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, node.node, scene.probe);
    node.moves_mean = tool.mean;
    node.prescribed = tool.nodes;
    node.prescribed_weight = tool.weights;
    node.trained_depth_m.assign(header.directions.size(), model.max_displacement_m);
    plan_response(scene.training, model, node);
  }
  return model;
}

ModelSize predict_model_size(const Scene& scene, const DatabaseHeader& header) {
  const auto text_bytes = [&](std::size_t n_nodes) {
    return static_cast<double>(write_model_text(sized_model(scene, header, n_nodes)).size());
  };
  const double one = text_bytes(1), two = text_bytes(2);
  const auto n = static_cast<double>(header.sets.active.size());
  return {one + (n - 1) * (two - one), static_cast<double>(write_mesh_text(header.mesh).size())};
}

}  // namespace phynness
