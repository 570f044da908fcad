// Models of round tools at nodes 3, 5 and 8 of small_model.hpp.
#pragma once

#include <algorithm>

#include "small_model.hpp"

namespace phynness::test {

/// With node 0, which is fixed, the nodes form two triangles.
inline Model round_model_of(Family family) {
  Model model = family == Family::linear ? small_linear_model() : with_bound_between(small_model_of(family));
  for (ActiveNodeModel& node : model.nodes) {
    node.moves_mean = node.node < 14;
    if (node.moves_mean) node.prescribed = {3, 5, 8};
    if (node.moves_mean) node.prescribed_weight = {0.25, 0.5, 0.25};
  }
  return model;
}

/// The same without an active node 12; it lies between the three.
inline Model covered_model_of(Family family) {
  Model model = round_model_of(family);
  model.probe_triangles.resize(1, 3);
  model.probe_triangles << 0, 1, 2;
  model.covered.resize(4, 4);
  model.covered << 3, 0, schema::whole_weight, 0, 5, 0, 0, schema::whole_weight, 8, 0, 0, 0, 12, 0, 20000, 30000;
  const auto point = [&](std::int32_t node) {
    return model.output_points.row(std::ranges::lower_bound(model.output, node) - model.output.begin());
  };
  const double first = 20000 / 65535.0, second = 30000 / 65535.0;
  point(12) = first * point(3) + (1 - first) * (second * point(5) + (1 - second) * point(8));
  for (auto& node : model.nodes)
    if (family == Family::rbfn) fill_centers(model, node.deformation);
  return model;
}

}  // namespace phynness::test
