// Sections of a model.txt of family linear; `io` is described in model_grammar.hpp.
#pragma once

#include <phynness/schema/grammar_lines.hpp>

namespace phynness::schema {

/// Unit responses of a linear body.
struct LinearGrammar {
  static constexpr Family family = Family::linear;

  template <class IO, class Model>
  static void shared(IO&, Model&) {}
  template <class IO, class Model, class Level>
  static void level(IO&, Model&, Level&) {}
  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    stiffness_line(io, node.linear.stiffness);
    io.keyword("unit_responses");
    io.end();
    rows_of_numbers(io, "unit response", node.linear.unit_responses, io.rows(model.output), 9, linear_entry);
    io.done(node.linear);
  }
  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO&, Model&, Node&, Level&, NodeLevel&) {}
};

}  // namespace phynness::schema
