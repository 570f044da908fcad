#include <algorithm>
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/formats/tool.hpp>
#include <phynness/planning/model_size.hpp>
#include <random>

namespace phynness {
namespace {

/// Numbers with full mantissas, as a fit gives.
class Numbers {
 public:
  double next() { return static_cast<double>(_random() >> 11) * 0x1p-53 - 0.5; }
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = next();
    return m;
  }
  std::int32_t below(std::size_t n) { return static_cast<std::int32_t>(_random() % n); }

 private:
  std::mt19937_64 _random{1};
};

RbfNetwork network(int neurons, int n_inputs, const Model& model, Numbers& numbers) {
  RbfNetwork net;
  net.input_center = numbers.matrix(n_inputs, 1);
  net.input_half_range = numbers.matrix(n_inputs, 1).cwiseAbs();
  net.output_center = numbers.matrix(3, 1);
  net.output_half_range = numbers.matrix(3, 1).cwiseAbs();
  net.spread = 0.75;
  for (int i = 0; i < neurons; ++i) {
    net.center_displacement.push_back(numbers.below(static_cast<std::size_t>(model.displacements.rows())));
    if (n_inputs == 6) net.center_output.push_back(numbers.below(model.output.size()));
  }
  net.weights = numbers.matrix(neurons, 3);
  net.bias = numbers.matrix(3, 1);
  fill_centers(model, net);
  return net;
}

LinearResponse linear_response(std::size_t n_output, Numbers& numbers) {
  LinearResponse response;
  const Eigen::MatrixXd half = numbers.matrix(3, 3);
  response.stiffness = half + half.transpose();
  // Training rounds to float32 what was stored so.
  response.unit_responses =
      numbers.matrix(static_cast<Eigen::Index>(n_output), 9).cast<float>().cast<double>();
  return response;
}

ScaledTable table(Eigen::Index rows, Eigen::Index columns, Numbers& numbers) {
  return scaled_table(numbers.matrix(rows, columns));
}

/// As many of everything as the database allows.
void add_modes(const TrainingSpec& spec, const Model& model, ActiveNodeModel& node, Numbers& numbers) {
  const Eigen::Index states = model.displacements.rows(),
                     n_output = static_cast<Eigen::Index>(model.output.size());
  const auto n_centers = std::min<Eigen::Index>(spec.force_centers, states);
  const Eigen::MatrixXd half = numbers.matrix(3, 3).cast<float>().cast<double>();
  node.conservative.stiffness = half + half.transpose();
  node.conservative.coefficients = numbers.matrix(n_centers, 3).cast<float>().cast<double>();
  for (Eigen::Index i = 0; i < n_centers; ++i)
    node.conservative.centers.push_back(numbers.below(static_cast<std::size_t>(states)));
  const auto n_modes = std::min<Eigen::Index>(spec.modes, states);
  const auto n_near = n_modes > 0 ? std::min<Eigen::Index>(spec.near_nodes, n_output) : 0;
  for (Eigen::Index i = 0; i < n_near; ++i) node.modal.near.push_back(static_cast<std::int32_t>(i));
  node.modal.weights = table(static_cast<Eigen::Index>(model.shared.centers.size()) + 3, n_modes, numbers);
  node.modal.mixing = table(model.shared.modes.cols(), n_modes, numbers);
  node.modal.near_modes = table(3 * n_near, n_modes, numbers);
  for (const auto& field : model.fields) {
    ModalDeformation& of_node = node.fields.emplace_back();
    of_node.near = node.modal.near;
    of_node.weights = table(static_cast<Eigen::Index>(model.shared.centers.size()) + 9, n_modes, numbers);
    of_node.mixing = table(field.modes.cols(), n_modes, numbers);
    of_node.near_modes = table(n_near, n_modes, numbers);
  }
}

void add_shared_modes(const TrainingSpec& spec, const std::vector<Field>& fields, Model& model,
                      Numbers& numbers) {
  const auto states = model.displacements.rows();
  const Eigen::Index n_output = static_cast<Eigen::Index>(model.output.size());
  const bool deforms = spec.modes > 0;
  model.shared.modes =
      table(3 * n_output, deforms ? std::min<Eigen::Index>(spec.shared_modes, 3 * n_output) : 0, numbers);
  for (Eigen::Index i = 0; deforms && i < std::min<Eigen::Index>(spec.amplitude_centers, states); ++i)
    model.shared.centers.push_back(numbers.below(static_cast<std::size_t>(states)));
  for (std::size_t f = 0; deforms && f < fields.size(); ++f)
    model.fields.push_back({name(fields[f]), unit(fields[f]), degree(fields[f]), 1,
                            table(n_output, std::min<Eigen::Index>(spec.shared_modes, n_output), numbers)});
}

/// Half as many of everything for each level below the full one; training's least sizes change little.
template <class Count>
Count halved(Count full, std::size_t below) {
  const Count step = Count{1} << below;
  return (full + step - 1) / step;
}

void add_levels(const TrainingSpec& spec, Model& model, Numbers& numbers) {
  if (spec.levels < 2 || model.family == Family::linear) return;
  model.levels.resize(static_cast<std::size_t>(spec.levels));
  for (std::size_t l = 0; l < model.levels.size(); ++l) {
    auto& level = model.levels[l];
    level.error_force = std::abs(numbers.next());
    level.error_displacement = std::abs(numbers.next());
    const auto& centers = model.shared.centers;
    const auto n = static_cast<std::ptrdiff_t>(halved(centers.size(), model.levels.size() - 1 - l));
    if (l + 1 < model.levels.size()) level.centers.assign(centers.begin(), centers.begin() + n);
  }
}

void add_levels_of_node(const Model& model, ActiveNodeModel& node, Numbers& numbers) {
  for (std::size_t l = 0; l + 1 < model.levels.size(); ++l) {
    const std::size_t below = model.levels.size() - 1 - l;
    LevelResponse& level = node.levels.emplace_back();
    const auto first = [&](const RbfNetwork& net) {
      return FirstNeurons{numbers.matrix(halved(net.weights.rows(), below), 3), numbers.matrix(3, 1)};
    };
    if (model.family == Family::rbfn) {
      level.force = first(node.force);
      level.deformation = first(node.deformation);
      continue;
    }
    level.conservative = node.conservative;
    const auto n = halved(node.conservative.coefficients.rows(), below);
    level.conservative.centers.resize(static_cast<std::size_t>(n));
    level.conservative.coefficients.conservativeResize(n, 3);
    const auto n_centers = static_cast<Eigen::Index>(model.levels[l].centers.size());
    level.weights = table(n_centers + 3, halved(node.modal.weights.cols(), below), numbers);
    for (const auto& field : node.fields)
      level.field_weights.push_back(table(n_centers + 9, halved(field.weights.cols(), below), numbers));
  }
}

double text_bytes(const Scene& scene, const DatabaseHeader& header, std::size_t n_nodes) {
  Numbers numbers;
  Model model = model_of_database(header, scene.training.family, scene.title);
  model.displacements =
      numbers.matrix(static_cast<Eigen::Index>(header.directions.size() * header.magnitudes_m.size()), 3);
  if (model.family == Family::modal) add_shared_modes(scene.training, header.fields, model, numbers);
  add_levels(scene.training, model, numbers);
  const double radius = scene.probe.kind == ProbeKind::patch ? scene.probe.tool_radius_m : 0;
  const auto& active = header.sets.active;
  for (std::size_t k = 0; k < n_nodes; ++k) {
    ActiveNodeModel node;
    node.node =
        active[std::min(active.size() - 1, k * active.size() / n_nodes + active.size() / (2 * n_nodes))];
    for (int i = 0; i < 3; ++i) node.point[static_cast<std::size_t>(i)] = header.mesh.nodes(node.node, i);
    const auto tool =
        touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, node.node, radius);
    node.prescribed = tool.nodes;
    node.prescribed_weight = tool.weights;
    node.trained_depth_m.assign(header.directions.size(), model.max_displacement_m);
    if (model.family == Family::linear) {
      node.linear = linear_response(model.output.size(), numbers);
    } else if (model.family == Family::modal) {
      add_modes(scene.training, model, node, numbers);
    } else {
      node.force = network(scene.training.force_neurons, 3, model, numbers);
      node.deformation = network(scene.training.deformation_neurons, 6, model, numbers);
    }
    add_levels_of_node(model, node, numbers);
    model.nodes.push_back(std::move(node));
  }
  return static_cast<double>(write_model_text(model).size());
}

}  // namespace

ModelSize predict_model_size(const Scene& scene, const DatabaseHeader& header) {
  const double one = text_bytes(scene, header, 1);
  const double two = text_bytes(scene, header, 2);
  const auto n = static_cast<double>(header.sets.active.size());
  return {one + (n - 1) * (two - one), static_cast<double>(write_mesh_text(header.mesh).size())};
}

}  // namespace phynness
