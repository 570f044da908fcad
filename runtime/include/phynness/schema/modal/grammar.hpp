// Sections of a model.txt of family modal; `io` is described in model_grammar.hpp.
#pragma once

#include <phynness/schema/grammar_lines.hpp>

namespace phynness::schema {

/// Conservative forces, modes of the deformation, scalar fields.
struct ModalGrammar {
  static constexpr Family family = Family::modal;

  template <class IO, class Model>
  static void fields(IO& io, Model& model) {
    if (!io.optional("fields", io.rows(model.fields) > 0)) return;
    const int32_t n = size_line(io, "fields", io.rows(model.fields), 1, largest_field_count);
    io.shape("fields", model.fields, n, 1);
    for (int32_t f = 0; f < n && io.good(); ++f) {
      auto& field = io.item(model.fields, f);
      io.keyword("field");
      io.word("name of a field", field.name);
      io.word("unit of a field", field.unit);
      io.end();
      integer_line(io, "degree", field.degree, 1, 2);
      real_line(io, "scale", field.scale, field_scale);
      const int32_t n_modes = size_line(io, "shared_modes", io.cols(field.modes.entries), 0, largest_mode_count);
      table(io, "modes", field.modes, io.rows(model.output), n_modes);
      io.done(field);
    }
  }

  template <class IO, class Model>
  static void shared(IO& io, Model& model) {
    auto& modes = model.shared.modes;
    const int32_t n_modes = size_line(io, "shared_modes", io.cols(modes.entries), 0, largest_mode_count);
    table(io, "modes", modes, 3 * io.rows(model.output), n_modes);
    const int32_t n = count_line(io, "amplitude_centers", io.rows(model.shared.centers));
    real_line(io, "shape", model.shared.shape, width);
    amplitude_centers(io, model, model.shared.centers, n);
    io.done(model.shared);
    fields(io, model);
  }

  template <class IO, class Model, class Level>
  static void level(IO& io, Model& model, Level& level) {
    const int32_t n = count_line(io, "amplitude_centers", io.rows(level.centers));
    io.require(n <= io.rows(model.shared.centers), "a level has more centers than its model");
    if (io.good()) amplitude_centers(io, model, level.centers, n);
  }

  template <class IO, class Model, class Force>
  static void force(IO& io, Model& model, Force& force) {
    const int32_t n = count_line(io, "force", io.rows(force.centers));
    real_line(io, "shape", force.shape, width);
    stiffness_line(io, force.stiffness);
    io.shape("displacement of a center", force.centers, n, 1);
    io.shape("coefficient", force.coefficients, n, 3);
    const auto n_displacements = static_cast<int32_t>(io.rows(model.displacements));
    for (int32_t i = 0; i < n && io.good(); ++i) {
      integer(io, "displacement of a center", force.centers, i, 0, 0, n_displacements - 1);
      for (int32_t k = 0; k < 3; ++k) number(io, "coefficient", force.coefficients, i, k, linear_entry);
      io.end();
    }
    io.done(force);
  }

  /// @param components  rows for each output node: 3 for displacements, 1 for a scalar field
  template <class IO, class Model, class Modes>
  static void modes(IO& io, Model& model, const char* key, Modes& modes, int64_t n_basis, int64_t n_shared,
                    int32_t components) {
    const int32_t m = size_line(io, key, io.cols(modes.weights.entries), 0, largest_mode_count);
    table(io, "weights", modes.weights, n_basis, m);
    mixed_modes(io, model, modes, n_shared, m, components);
  }

  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    const int64_t n_centers = io.rows(model.shared.centers), n_fields = io.rows(model.fields);
    force(io, model, node.conservative);
    modes(io, model, "deformation", node.modal, n_centers + n_linear_terms, io.cols(model.shared.modes.entries), 3);
    io.shape("fields", node.fields, n_fields, 1);
    for (int64_t f = 0; f < n_fields && io.good(); ++f)
      modes(io, model, "field", io.item(node.fields, f), n_centers + n_field_terms,
            io.cols(io.item(model.fields, f).modes.entries), 1);
  }

  /// Number of modes, and weights of the amplitudes. A node has modes at every level or at none.
  template <class IO, class Full, class Weights>
  static void level_weights(IO& io, const char* key, Full& full, Weights& weights, int64_t n_basis) {
    const auto n_full = static_cast<int32_t>(io.cols(full.weights.entries));
    io.keyword(key);
    auto n = static_cast<int32_t>(io.cols(weights.entries));
    io.integer("modes of a level", n, n_full > 0 ? 1 : 0, n_full);
    io.end();
    table(io, "weights", weights, n_basis, n);
  }

  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO& io, Model& model, Node& node, Level& level, NodeLevel& of_node) {
    force(io, model, of_node.conservative);
    io.require(io.rows(of_node.conservative.centers) <= io.rows(node.conservative.centers),
               "a level has more force centers than its model");
    const int64_t n_centers = io.rows(level.centers), n_fields = io.rows(model.fields);
    level_weights(io, "deformation", node.modal, of_node.weights, n_centers + n_linear_terms);
    io.shape("fields", of_node.field_weights, n_fields, 1);
    for (int64_t f = 0; f < n_fields && io.good(); ++f)
      level_weights(io, "field", io.item(node.fields, f), io.item(of_node.field_weights, f), n_centers + n_field_terms);
  }
};

}  // namespace phynness::schema
