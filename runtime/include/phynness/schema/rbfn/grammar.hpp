// Sections of a model.txt of family rbfn; `io` is described in model_grammar.hpp.
#pragma once

#include <phynness/schema/grammar_lines.hpp>

namespace phynness::schema {

/// The paper's networks of Gaussians, equations (11)-(12).
struct RbfnGrammar {
  static constexpr Family family = Family::rbfn;

  /// @param n_inputs  3: displacement; 6: displacement and coordinates of an output node
  template <class IO, class Model, class Network>
  static void network(IO& io, Model& model, Network& net, const char* key, int32_t n_inputs) {
    const int32_t n = count_line(io, key, io.rows(net.weights));
    row_line(io, "input_center", net.input_center, n_inputs, any_number);
    row_line(io, "input_half_range", net.input_half_range, n_inputs, positive);
    row_line(io, "output_center", net.output_center, 3, any_number);
    row_line(io, "output_half_range", net.output_half_range, 3, positive);
    real_line(io, "spread", net.spread, width);
    row_line(io, "bias", net.bias, 3, any_number);
    const bool deforms = n_inputs == 6;
    io.shape("displacement of a center", net.center_displacement, n, 1);
    io.shape("output node of a center", net.center_output, deforms ? n : 0, 1);
    io.shape("weight", net.weights, n, 3);
    const auto n_displacements = static_cast<int32_t>(io.rows(model.displacements));
    const auto n_output = static_cast<int32_t>(io.rows(model.output));
    for (int32_t i = 0; i < n && io.good(); ++i) {
      integer(io, "displacement of a center", net.center_displacement, i, 0, 0, n_displacements - 1);
      if (deforms) integer(io, "output node of a center", net.center_output, i, 0, 0, n_output - 1);
      for (int32_t k = 0; k < 3; ++k) number(io, "weight", net.weights, i, k, any_number);
      io.end();
    }
    io.done(net);
  }

  template <class IO, class Network, class First>
  static void first_neurons(IO& io, const char* key, Network& full, First& first) {
    const int32_t n = count_line(io, key, io.rows(first.weights));
    io.require(n <= io.rows(full.weights), "a level has more neurons than its model");
    row_line(io, "bias", first.bias, 3, any_number);
    rows_of_numbers(io, "weight", first.weights, n, 3, any_number);
    io.done(first);
  }

  template <class IO, class Model>
  static void shared(IO&, Model&) {}
  template <class IO, class Model, class Level>
  static void level(IO&, Model&, Level&) {}
  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    network(io, model, node.force, "force", 3);
    network(io, model, node.deformation, "deformation", 6);
  }
  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO& io, Model&, Node& node, Level&, NodeLevel& level) {
    first_neurons(io, "force", node.force, level.force);
    first_neurons(io, "deformation", node.deformation, level.deformation);
  }
};

}  // namespace phynness::schema
