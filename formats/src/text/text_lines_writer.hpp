// Writes a model.txt or a mesh.txt by its grammar: exact, independent of the locale, and without text that a reader
// would refuse.
#pragma once

#include <charconv>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model_stores.hpp>
#include <phynness/schema/model_grammar.hpp>
#include <string_view>

namespace phynness {

class TextLinesWriter : public ModelStores {
 public:
  explicit TextLinesWriter(std::string first_line) : _out(std::move(first_line)) {}
  /// The whole text, with its checksum.
  std::string finished() {
    const std::string hash = hash_of(_out);
    return std::move(_out) + "checksum " + hash + "\n";
  }

  void keyword(std::string_view word) { put(word); }
  void end() {
    _out += '\n';
    _line_start = true;
  }
  /// Control characters, such as line breaks, are replaced by spaces.
  void text(const std::string& line) {
    if (!line.empty()) put("");
    for (const char c : line) _out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    end();
  }
  void word(const char* what, const std::string& word) {
    bool visible = !word.empty() && word.size() <= static_cast<std::size_t>(schema::longest_word);
    for (const char c : word) visible = visible && c > 0x20 && c < 0x7f;
    require(visible, what);
    put(word);
  }
  void family(Family family) { put(name(family)); }
  void real(const char* what, double value, const schema::Bound& bound) {
    if (!std::isfinite(value))
      throw failure("a number of the model or its mesh is not finite", what,
                    "train again; if the error persists, please report it");
    if (!(value >= bound.low && value <= bound.high)) refuse(std::string(what) + " " + bound.outside);
    char buffer[40];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::hex).ptr;
    put({buffer, static_cast<std::size_t>(end - buffer)});
  }
  void integer(const char* what, std::int32_t value, std::int32_t low, std::int32_t high) {
    if (value < low || value > high)
      refuse(std::string(what) + " is out of range " + std::to_string(low) + " ... " + std::to_string(high));
    put(std::to_string(value));
  }
  void count(const char* what, std::int32_t n, std::int32_t low) { integer(what, n, low, schema::largest_integer); }
  void require(bool condition, const char* what) {
    if (!condition) refuse(what);
  }

  template <class Store>
  void shape(const char* what, const Store& store, std::int64_t n_rows, std::int64_t n_cols) {
    if (rows(store) != n_rows || (n_rows > 0 && cols(store) != n_cols))
      refuse("number of " + std::string(what) + ": " + std::to_string(rows(store)) + " x " +
             std::to_string(cols(store)) + " instead of " + std::to_string(n_rows) + " x " + std::to_string(n_cols));
  }

  [[noreturn]] static void refuse(const std::string& what) {
    throw failure("the model or its mesh cannot be written: " + what, "",
                  "this is a defect of the program; please report it");
  }

 protected:
  void put(std::string_view text) {
    if (!_line_start) _out += ' ';
    _line_start = false;
    _out += text;
  }

 private:
  std::string _out;
  bool _line_start = true;
};

}  // namespace phynness
