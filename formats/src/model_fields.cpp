// Scalar fields in model.txt: writer and reader of FIELDS in formats/model.md.
#include "model_response.hpp"

namespace phynness {
namespace {

constexpr std::size_t longest_word = 40;
/// Products of two components of a displacement, beside its three components.
constexpr Eigen::Index n_even = 6;

bool is_word(std::string_view text) {
  return !text.empty() && text.size() <= longest_word &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

ModesShape modes_shape(const Model& model, std::size_t field) {
  return {static_cast<Eigen::Index>(model.shared.centers.size()) + 3 + n_even,
          model.fields[field].modes.cols(), 1};
}

std::string read_word(ModelLexer& lexer, std::string_view what) {
  const std::string word(lexer.token(what));
  if (!is_word(word)) lexer.refuse(std::string(what) + " is longer than 40 characters or not ASCII", word);
  return word;
}

}  // namespace

void write_fields(ModelEmitter& w, const Model& model) {
  if (model.fields.empty()) return;
  require_writable(model.family == Family::modal, "fields in a family that has none");
  require_writable(static_cast<int>(model.fields.size()) <= largest_field_count, "too many fields");
  w.word("fields").integer(static_cast<std::int64_t>(model.fields.size())).end();
  for (const auto& field : model.fields) {
    require_writable(is_word(field.name) && is_word(field.unit), "name or unit of a field is no word");
    require_writable(field.degree == 1 || field.degree == 2, "degree of a field");
    require_writable(field.scale > 0 && field.scale <= largest_linear_entry, "scale of a field");
    require_writable(field.modes.rows() == static_cast<Eigen::Index>(model.output.size()) &&
                         field.modes.cols() <= largest_mode_count,
                     "shared modes of a field do not fit the output nodes, or are too many");
    w.word("field").word(field.name).word(field.unit).end();
    w.word("degree").integer(field.degree).end();
    w.word("scale").real(field.scale).end();
    w.word("shared_modes").integer(field.modes.cols()).end();
    write_table(w, "modes", field.modes);
  }
}

void read_fields(ModelLexer& lexer, Model& model) {
  if (model.family != Family::modal || !lexer.next_is("fields")) return;
  lexer.keyword("fields");
  model.fields.resize(static_cast<std::size_t>(lexer.integer("fields", 1, largest_field_count)));
  lexer.end_line();
  for (auto& field : model.fields) {
    lexer.keyword("field");
    field.name = read_word(lexer, "name of a field");
    field.unit = read_word(lexer, "unit of a field");
    lexer.end_line();
    lexer.keyword("degree");
    field.degree = lexer.integer("degree", 1, 2);
    lexer.end_line();
    field.scale = lexer.vector_line("scale", 1, true)[0];
    if (!(field.scale <= largest_linear_entry)) lexer.refuse("scale of a field is beyond 1e100", field.name);
    lexer.keyword("shared_modes");
    const auto n_modes = lexer.integer("modes", 0, largest_mode_count);
    lexer.end_line();
    field.modes = read_table(lexer, "modes", static_cast<Eigen::Index>(model.output.size()), n_modes);
  }
}

void write_node_fields(ModelEmitter& w, const Model& model, const ActiveNodeModel& node) {
  require_writable(node.fields.size() == model.fields.size(),
                   "an active node has other fields than the model");
  for (std::size_t f = 0; f < node.fields.size(); ++f)
    write_modes(w, "field", modes_shape(model, f), node.fields[f]);
}

void read_node_fields(ModelLexer& lexer, const Model& model, ActiveNodeModel& node) {
  node.fields.resize(model.fields.size());
  for (std::size_t f = 0; f < node.fields.size(); ++f)
    read_modes(lexer, "field", modes_shape(model, f), model.output_points.rows(), node.fields[f]);
}

}  // namespace phynness
