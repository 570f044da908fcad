// Small models of round tools, whose images have a surface.
#pragma once

#include "../runtime/small_model.hpp"

namespace phynness::test {

/// Nodes 3, 5, 8 and 15 have round tools; node 12 lies between three of them, nodes 0 and 1 are fixed.
inline Model small_round_model(Family family) {
  Model model = family == Family::linear ? small_linear_model() : with_bound_between(small_model_of(family));
  for (ActiveNodeModel& node : model.nodes) node.moves_mean = true;
  model.probe_triangles.resize(1, 3);
  model.probe_triangles << 0, 1, 2;
  model.covered.resize(4, 4);
  model.covered << 3, 0, schema::whole_weight, 0, 5, 0, 0, schema::whole_weight, 8, 0, 0, 0, 12, 0, 20000, 30000;
  return model;
}

/// The same with linear points, on triangles of their own.
inline Model small_model_touched_anywhere(Family family) {
  Model model = with_linear_points(small_round_model(family));
  model.surface.conservativeResize(6, 3);
  model.surface.bottomRows(2) << 3, 10, 11, 10, 13, 11;
  return model;
}

}  // namespace phynness::test
