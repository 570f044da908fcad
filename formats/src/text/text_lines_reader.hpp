// Reads a model.txt, mesh.txt or body.txt by its grammar. Every error names the file, the line, what is wrong, and the
// value.
#pragma once

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model_stores.hpp>
#include <phynness/schema/model_grammar.hpp>
#include <phynness/schema/text_reader.hpp>
#include <string_view>

namespace phynness {

/// The lines between the first and the last one, if these are as they should be.
/// @param kind  "model", "mesh" or "body", for messages
/// @throws Error (input) if the text is of another kind or version, truncated, or corrupted
template <std::size_t size>
std::string_view checked_lines(const char (&first_line)[size], std::string_view text, const std::string& source,
                               const std::string& kind) {
  std::size_t length = text.size(), wrong_byte = 0;
  const int status = schema::check_envelope(first_line, text.data(), length, wrong_byte);
  if (status == PHN_OK) return text.substr(size - 1, length - (size - 1));
  const bool is_body = kind == "body";
  const auto refuse = [&](const std::string& what, std::string value, const std::string& remedy) {
    throw input_error(source + ": " + what, std::move(value), remedy);
  };
  if (status == PHN_ERROR_NOT_A_MODEL)
    refuse("not a phynness " + kind, std::string(text.substr(0, std::min(text.find('\n'), std::size_t{20}))),
           "give a " + kind + ".txt" + (is_body ? " of phynness reduce" : " or a model directory"));
  if (status == PHN_ERROR_VERSION) {
    const std::string line(text.substr(0, std::min(text.find('\n'), std::size_t{40})));
    if (!line.empty() && line.back() == '\r')
      refuse("the line endings of the " + kind + " file were changed", "CR LF", "copy it again in binary mode");
    refuse("the " + kind + " file has another version of the format", line,
           std::string("make it anew with: phynness ") +
               (is_body ? "reduce DATABASE -o body.txt" : "train SCENE DATABASE -o MODEL_DIR"));
  }
  if (status == PHN_ERROR_TRUNCATED)
    refuse("the " + kind + " file is truncated",
           std::to_string(text.size()) + " bytes without a checksum line at the end", "copy it again");
  const std::size_t end = text.size() - schema::checksum_line_length;
  refuse("the " + kind + " file is corrupted: its checksum is wrong",
         std::string(text.substr(end + 9, 16)) + " instead of " + hash_of(text.substr(0, end)),
         "copy it again; it cannot be edited by hand");
  return {};
}

class TextLinesReader : public ModelStores {
 public:
  /// @param lines   checked_lines(); must outlive the reader
  /// @param remedy  for lines that the grammar does not have
  TextLinesReader(std::string_view lines, std::string source, const char* remedy)
      : _lines(lines), _source(std::move(source)), _remedy(remedy), _in(lines.data(), lines.size()) {}

  void keyword(const char* word) {
    _in.keyword(word);
    if (!_in.good()) refuse("expected '" + std::string(word) + "'", token());
  }
  void end() {
    _in.end_line();
    if (!_in.good()) refuse("unexpected text at the end of the line", _lines.substr(_in.token_at(), 20));
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
  void family(Family& family) {
    const auto found = _in.rest_of_line();
    const std::string_view word{found.begin, found.length()};
    const auto* const known = std::find(std::begin(schema::family_words), std::end(schema::family_words), word);
    if (known == std::end(schema::family_words)) refuse("the family of the model is unknown to this version", word);
    family = static_cast<Family>(known - schema::family_words);
  }
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
  void require_end() {
    if (!_in.at_end()) refuse("unexpected text after the last line", "");
  }

  [[noreturn]] void refuse(const std::string& what, std::string_view value) const {
    const auto line =
        2 + std::count(_lines.begin(), _lines.begin() + static_cast<std::ptrdiff_t>(_in.token_at()), '\n');
    throw input_error(_source + ":" + std::to_string(line) + ": " + what, std::string(value), _remedy);
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

  std::string_view _lines;
  std::string _source;
  const char* _remedy;
  schema::TextReader _in;
};

}  // namespace phynness
