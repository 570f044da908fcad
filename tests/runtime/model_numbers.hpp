#pragma once

#include <phynness/formats/model.hpp>

namespace phynness::test {

/// Calls change_group(first, count) for every group of numbers of a model.
/// @return how many groups all nodes share; they come first
template <class Change>
std::size_t for_each_group(Model& model, Change change_group) {
  std::size_t n_groups = 0;
  const auto change = [&](double* first, std::size_t n) {
    change_group(first, n);
    ++n_groups;
  };
  const auto matrix = [&](auto& m) { change(m.data(), static_cast<std::size_t>(m.size())); };
  const auto network = [&](RbfNetwork& net) {
    for (auto* v : {&net.input_center, &net.input_half_range, &net.output_center, &net.output_half_range}) matrix(*v);
    change(&net.spread, 1);
    matrix(net.weights);
    matrix(net.bias);
  };
  const auto modes = [&](ModalDeformation& modal) {
    for (auto* table : {&modal.weights, &modal.mixing, &modal.near_modes}) matrix(table->scale);
  };
  for (Vec3& e : model.directions) change(e.data(), 3);
  change(&model.max_displacement_m, 1);
  matrix(model.displacements);
  matrix(model.fixed_points);
  matrix(model.output_points);
  matrix(model.shared.modes.scale);
  change(&model.shared.shape, 1);
  for (FieldModes& field : model.fields) {
    change(&field.scale, 1);
    matrix(field.modes.scale);
  }
  const std::size_t n_shared = n_groups;
  for (ActiveNodeModel& node : model.nodes) {
    change(node.point.data(), 3);
    change(node.prescribed_weight.data(), node.prescribed_weight.size());
    change(node.trained_depth_m.data(), node.trained_depth_m.size());
    network(node.force);
    network(node.deformation);
    matrix(node.linear.stiffness);
    matrix(node.linear.unit_responses);
    change(&node.conservative.shape, 1);
    matrix(node.conservative.stiffness);
    matrix(node.conservative.coefficients);
    modes(node.modal);
    for (ModalDeformation& field : node.fields) modes(field);
    for (ScaledTable& bound : node.bounds) matrix(bound.scale);
    for (LevelResponse& level : node.levels) {
      for (FirstNeurons* first : {&level.force, &level.deformation}) {
        matrix(first->weights);
        matrix(first->bias);
      }
      change(&level.conservative.shape, 1);
      matrix(level.conservative.coefficients);
      matrix(level.weights.scale);
      for (ScaledTable& weights : level.field_weights) matrix(weights.scale);
    }
  }
  return n_shared;
}

}  // namespace phynness::test
