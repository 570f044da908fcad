// Levels in model.txt: writer and reader of LEVEL and LEVEL_RESPONSE in formats/model.md.
#include <cmath>

#include "model_response.hpp"

namespace phynness {
namespace {

/// Kernels of a field's amplitudes beside their centers.
constexpr Eigen::Index n_field_terms = 9;

double read_error(ModelLexer& lexer, std::string_view what) {
  const double error = lexer.real(what);
  if (!(error >= 0 && error <= largest_linear_entry)) lexer.refuse("error of a level is negative or beyond 1e100", what);
  return error;
}

void write_first_neurons(ModelEmitter& w, std::string_view key, const RbfNetwork& full, const FirstNeurons& first) {
  require_writable(first.weights.cols() == 3 && first.weights.rows() <= full.weights.rows(),
                   "a level has more neurons than its model");
  w.word(key).integer(first.weights.rows()).end();
  w.word("bias").reals(first.bias).end();
  for (Eigen::Index i = 0; i < first.weights.rows(); ++i) w.reals(first.weights.row(i)).end();
}

FirstNeurons read_first_neurons(ModelLexer& lexer, std::string_view key, const RbfNetwork& full) {
  FirstNeurons first;
  const std::int32_t n = lexer.count_line(key);
  if (n > full.weights.rows()) lexer.refuse("a level has more neurons than its model", std::to_string(n));
  first.bias = lexer.vector_line("bias", 3, false);
  first.weights.resize(n, 3);
  for (std::int32_t i = 0; i < n; ++i) {
    lexer.reals("weight", first.weights.row(i));
    lexer.end_line();
  }
  return first;
}

void write_weights(ModelEmitter& w, std::string_view key, Eigen::Index n_rows, const ModalDeformation& full,
                   const ScaledTable& weights) {
  const Eigen::Index n_full = full.weights.cols();
  require_writable(weights.rows() == n_rows && weights.cols() <= n_full && (weights.cols() > 0 || n_full == 0),
                   "weights of a level do not fit its centers or the modes of the node");
  w.word(key).integer(weights.cols()).end();
  write_table(w, "weights", weights);
}

ScaledTable read_weights(ModelLexer& lexer, std::string_view key, Eigen::Index n_rows, const ModalDeformation& full) {
  const Eigen::Index n_full = full.weights.cols();
  lexer.keyword(key);
  const auto n = lexer.integer("modes of a level", n_full > 0 ? 1 : 0, n_full);
  lexer.end_line();
  return read_table(lexer, "weights", n_rows, n);
}

}  // namespace

void write_levels(ModelEmitter& w, const Model& model) {
  if (model.levels.empty()) return;
  require_writable(model.family != Family::linear, "levels in a family that has none");
  require_writable(model.levels.size() >= 2 && model.levels.size() <= static_cast<std::size_t>(largest_level_count),
                   "one level or too many");
  w.word("levels").integer(static_cast<std::int64_t>(model.levels.size())).end();
  for (const auto& level : model.levels) {
    require_writable(level.error_force >= 0 && level.error_force <= largest_linear_entry &&
                         level.error_displacement >= 0 && level.error_displacement <= largest_linear_entry,
                     "error of a level");
    w.word("level").real(level.error_force).real(level.error_displacement).end();
    if (model.family != Family::modal || &level == &model.levels.back()) continue;
    require_writable(level.centers.size() <= model.shared.centers.size(), "a level has more centers than its model");
    w.word("amplitude_centers").integer(static_cast<std::int64_t>(level.centers.size())).end();
    for (const auto center : level.centers) w.integer(center).end();
  }
}

void read_levels(ModelLexer& lexer, Model& model) {
  if (model.family == Family::linear || !lexer.next_is("levels")) return;
  lexer.keyword("levels");
  model.levels.resize(static_cast<std::size_t>(lexer.integer("levels", 2, largest_level_count)));
  lexer.end_line();
  for (auto& level : model.levels) {
    lexer.keyword("level");
    level.error_force = read_error(lexer, "force");
    level.error_displacement = read_error(lexer, "displacement");
    lexer.end_line();
    if (model.family != Family::modal || &level == &model.levels.back()) continue;
    level.centers.resize(lexer.count_line("amplitude_centers"));
    if (level.centers.size() > model.shared.centers.size())
      lexer.refuse("a level has more centers than its model", std::to_string(level.centers.size()));
    for (auto& center : level.centers) {
      center = lexer.integer("displacement of a center", 0, model.displacements.rows() - 1);
      lexer.end_line();
    }
  }
}

void write_level_responses(ModelEmitter& w, const Model& model, const ActiveNodeModel& node) {
  require_writable(node.levels.size() + 1 == std::max<std::size_t>(1, model.levels.size()),
                   "an active node has other levels than the model");
  for (std::size_t l = 0; l < node.levels.size(); ++l) {
    const LevelResponse& level = node.levels[l];
    if (model.family == Family::rbfn) {
      write_first_neurons(w, "force", node.force, level.force);
      write_first_neurons(w, "deformation", node.deformation, level.deformation);
      continue;
    }
    require_writable(level.conservative.centers.size() <= node.conservative.centers.size(),
                     "a level has more force centers than its model");
    write_conservative(w, model, level.conservative);
    const auto n_centers = static_cast<Eigen::Index>(model.levels[l].centers.size());
    write_weights(w, "deformation", n_centers + 3, node.modal, level.weights);
    require_writable(level.field_weights.size() == node.fields.size(), "a level has other fields than its model");
    for (std::size_t f = 0; f < node.fields.size(); ++f)
      write_weights(w, "field", n_centers + n_field_terms, node.fields[f], level.field_weights[f]);
  }
}

void read_level_responses(ModelLexer& lexer, const Model& model, ActiveNodeModel& node) {
  if (model.levels.empty()) return;
  node.levels.resize(model.levels.size() - 1);
  for (std::size_t l = 0; l < node.levels.size(); ++l) {
    LevelResponse& level = node.levels[l];
    if (model.family == Family::rbfn) {
      level.force = read_first_neurons(lexer, "force", node.force);
      level.deformation = read_first_neurons(lexer, "deformation", node.deformation);
      continue;
    }
    read_conservative(lexer, model, level.conservative);
    if (level.conservative.centers.size() > node.conservative.centers.size())
      lexer.refuse("a level has more force centers than its model", std::to_string(level.conservative.centers.size()));
    const auto n_centers = static_cast<Eigen::Index>(model.levels[l].centers.size());
    level.weights = read_weights(lexer, "deformation", n_centers + 3, node.modal);
    for (const auto& field : node.fields)
      level.field_weights.push_back(read_weights(lexer, "field", n_centers + n_field_terms, field));
  }
}

}  // namespace phynness
