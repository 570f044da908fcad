#include "linear_points.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/training/modal_fit.hpp>

namespace phynness {
namespace {

/// Of the fields of linear points: modes that they share, and nodes near each with values of their own
/// (docs/decisions/between-points.md).
constexpr int n_rest_modes = 32, n_near_nodes = 12;

/// Largest number and size of the points from which the modes are computed.
constexpr std::int32_t most_basis_points = 500;
constexpr double most_basis_bytes = 5e8;

/// The three fields of a point as modes of unit size.
NodeModes unit_fields(const AtRest& response, std::int32_t n_output) {
  NodeModes fields;
  fields.modes = Eigen::Map<const Eigen::MatrixXd>(response.displacement.data(), 3 * Eigen::Index{n_output}, 3);
  fields.singular_values.setOnes(3);
  fields.largest_value = 1;
  fields.prescribed.assign(static_cast<std::size_t>(n_output), 0);
  return fields;
}

}  // namespace

void add_linear_points(Model& model, const DatabaseHeader& header, const RestReader& read, const TrainingSpec& spec) {
  const auto n_points = static_cast<std::int32_t>(header.sets.linear.size());
  const auto n_output = static_cast<std::int32_t>(model.output.size());
  // Without modes the model has forces only.
  const bool has_fields = n_output > 0 && (spec.modes > 0 || !schema::traits(model.family).has_modes);
  Eigen::MatrixXd basis(3 * Eigen::Index{n_output}, 0);
  if (has_fields) {
    const auto affordable =
        static_cast<std::int32_t>(std::min<double>(most_basis_points, most_basis_bytes / 72 / n_output));
    const std::int32_t n = std::clamp(affordable, std::min(n_points, n_rest_modes), n_points);
    std::vector<NodeModes> fields;
    for (std::int64_t i = 0; i < n; ++i)
      fields.push_back(unit_fields(read(static_cast<std::int32_t>((2 * i + 1) * n_points / (2 * n))), n_output));
    basis = shared_basis(fields, n_rest_modes, spec.seed);
  }
  model.rest_modes = scaled_table(basis);
  basis = model.rest_modes.values();
  for (std::int32_t i = 0; i < n_points; ++i) {
    const AtRest response = read(i);
    LinearPoint& point = model.linear_points.emplace_back();
    point.node = header.sets.linear[static_cast<std::size_t>(i)];
    const auto x = header.mesh.nodes.row(point.node);
    point.point = {x[0], x[1], x[2]};
    const Eigen::Map<const Eigen::Matrix3d> stiffness(response.stiffness_N_per_m.data());
    point.stiffness = (stiffness + stiffness.transpose()) / 2;
    MixedModes mixed{Eigen::MatrixXd(0, 3), {}, Eigen::MatrixXd(0, 3)};
    if (has_fields) {
      const NodeModes fields = unit_fields(response, n_output);
      if (!fields.modes.allFinite())
        throw failure("the database has a displacement that is not finite in a response at rest",
                      "node " + std::to_string(point.node), "precompute this database again");
      mixed = mix_modes(basis, fields, n_near_nodes);
    }
    point.mixing = scaled_table(mixed.mixing);
    point.near = mixed.near;
    point.near_modes = scaled_table(mixed.near_modes);
  }
}

}  // namespace phynness
