// Reads a model.txt by the grammar of models. Every error names the file, the line, what is wrong, and the value.
#pragma once

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model_stores.hpp>
#include <phynness/schema/model_grammar.hpp>
#include <phynness/schema/text_reader.hpp>
#include <string_view>

namespace phynness {

class ModelReader : public ModelStores {
 public:
  /// @param body  the text before the checksum line; must outlive the reader
  ModelReader(std::string_view body, std::string source, const Model& model)
      : _body(body), _source(std::move(source)), _model(model), _in(body.data(), body.size()) {
    _in.rest_of_line();  // magic and version have already been checked
    end();
  }

  void keyword(const char* word) {
    _in.keyword(word);
    if (!_in.good()) refuse("expected '" + std::string(word) + "'", token());
  }
  void end() {
    _in.end_line();
    if (!_in.good()) refuse("unexpected text at the end of the line", _body.substr(_in.token_at(), 20));
  }
  void text(std::string& line) {
    const auto found = _in.rest_of_line();
    line.assign(found.begin, found.end);
    end();
  }
  void word(const char* what, std::string& word) {
    const auto found = _in.word(static_cast<std::size_t>(schema::longest_word));
    if (!_in.good()) refuse(std::string(what) + " is longer than 40 characters or not ASCII", token());
    word.assign(found.begin, found.end);
  }
  void family(Family& family);
  void real(const char* what, double& value, const schema::Bound& bound) {
    value = _in.real();
    if (!_in.good()) malformed();
    if (!(value >= bound.low && value <= bound.high)) refuse(std::string(what) + " " + bound.outside, token());
  }
  void integer(const char* what, std::int32_t& value, std::int32_t low, std::int32_t high) {
    value = _in.integer(low, high);
    if (_in.good()) return;
    if (_in.status() == PHN_ERROR_SYNTAX && !(low >= 0 && is_negative(token()))) malformed();
    refuse(std::string(what) + " is out of range " + std::to_string(low) + " ... " + std::to_string(high), token());
  }
  void count(const char* what, std::int32_t& n, std::int32_t low) {
    integer(what, n, low, schema::largest_integer);
    room(what, static_cast<std::uint64_t>(n));
  }
  void room(const char* what, std::uint64_t n) {
    _in.require_room(n);
    if (!_in.good())
      refuse("number of '" + std::string(what) + "' is larger than the rest of the file", std::to_string(n));
  }
  bool optional(const char* word, bool) { return _in.next_is(word); }
  void require(bool condition, const char* what) {
    if (!condition) refuse(what, token());
  }

  template <class Store>
  void shape(const char*, Store& store, std::int64_t n_rows, std::int64_t n_cols) {
    resize(store, n_rows, n_cols);
  }
  template <class Store>
  static double get(const Store&, std::int64_t, std::int64_t) {
    return 0;
  }
  template <class Store, class T>
  void set(Store& store, std::int64_t i, std::int64_t k, T value) {
    using Cell = std::remove_reference_t<decltype(cell(store, i, k))>;
    cell(store, i, k) = static_cast<Cell>(value);
  }
  /// Sets two symmetric entries; six numbers set the whole matrix.
  void set(Eigen::Matrix3d& symmetric, std::int64_t i, std::int64_t k, double value) {
    symmetric(i, k) = symmetric(k, i) = value;
  }
  using ModelStores::done;
  void done(RbfNetwork& network) {
    fill_centers(_model, network);
    if (!network.centers.allFinite()) refuse("a scaled center is not finite", "");
  }
  void require_end() {
    if (!_in.at_end()) refuse("unexpected text after the last line of the model", "");
  }

  [[noreturn]] void refuse(const std::string& what, std::string_view value) const {
    const auto line = 1 + std::count(_body.begin(), _body.begin() + static_cast<std::ptrdiff_t>(_in.token_at()), '\n');
    throw input_error(_source + ":" + std::to_string(line) + ": " + what, std::string(value),
                      "write the model again with `phynness train`; the format is described in formats/model.md");
  }

 private:
  std::string_view token() const {
    const auto found = _in.last_token();
    return {found.begin, found.length()};
  }
  static bool is_negative(std::string_view token) {
    return token.size() > 1 && token[0] == '-' && token.find_first_not_of("0123456789", 1) == std::string_view::npos;
  }
  [[noreturn]] void malformed() const {
    const auto found = token();
    const auto has = [&](std::string_view part) { return found.find(part) != std::string_view::npos; };
    if (found.empty()) refuse("a value is missing", "");
    if (has(",")) refuse("a number has a decimal comma; the file was written with a wrong locale", found);
    if (has("nan") || has("inf")) refuse("a number is not finite", found);
    refuse("malformed number", found);
  }

  std::string_view _body;
  std::string _source;
  const Model& _model;
  schema::TextReader _in;
};

}  // namespace phynness
