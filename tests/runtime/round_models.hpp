// Models of round tools at nodes 3, 5 and 8 of small_model.hpp.
#pragma once

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

/// The same without an active node 12; it has coordinates between the three.
inline Model covered_model_of(Family family) {
  Model model = round_model_of(family);
  model.probe_triangles.resize(1, 3);
  model.probe_triangles << 0, 1, 2;
  model.covered.resize(4, 4);
  model.covered << 3, 0, schema::whole_weight, 0, 5, 0, 0, schema::whole_weight, 8, 0, 0, 0, 12, 0, 20000, 30000;
  return model;
}

}  // namespace phynness::test
