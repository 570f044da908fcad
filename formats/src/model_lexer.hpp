// Lines and tokens of model.txt for the host reader: strict, locale-free, every refusal names file and line.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <phynness/formats/error.hpp>
#include <string>
#include <string_view>

namespace phynness {

/// Walks over text in which tokens are separated by exactly one space and lines end with one newline.
class ModelLexer {
 public:
  /// @param text  must outlive the lexer
  ModelLexer(std::string_view text, std::string source_name) : _text(text), _source(std::move(source_name)) {}

  /// Next token of the line. @throws Error if the line has no further one
  std::string_view token(std::string_view what) {
    if (!_line_start) {
      if (_at >= _text.size() || _text[_at] != ' ') refuse("value missing", what);
      ++_at;
    }
    const std::size_t end = std::min(_text.find_first_of(" \n", _at), _text.size());
    const std::string_view found = _text.substr(_at, end - _at);
    if (found.empty()) refuse("value missing", what);
    _at = end;
    _line_start = false;
    return found;
  }

  void end_line() {
    if (_at >= _text.size() || _text[_at] != '\n')
      refuse("line holds more than it should", _text.substr(_at, 20));
    ++_at;
    ++_line;
    _line_start = true;
  }

  void keyword(std::string_view word) {
    const std::string_view found = token(word);
    if (found != word) refuse("expected '" + std::string(word) + "'", found);
  }

  /// Whether the next token of the line is this word. Reads nothing.
  bool next_is(std::string_view word) const {
    ModelLexer ahead = *this;
    return ahead.token(word) == word;
  }

  /// Everything up to the end of the line, the separating space excluded; may be empty.
  std::string rest_of_line() {
    if (_at < _text.size() && _text[_at] == ' ') ++_at;
    const std::size_t end = std::min(_text.find('\n', _at), _text.size());
    std::string found(_text.substr(_at, end - _at));
    _at = end;
    return found;
  }

  std::int32_t integer(std::string_view what, std::int64_t low, std::int64_t high) {
    const std::string_view found = token(what);
    const std::size_t n_digits = found.size() - (found.starts_with('-') ? 1 : 0);
    // One spelling for all readers: a sign only where numbers may be negative.
    if (n_digits > 10 || (found.starts_with('-') && low >= 0))
      refuse(std::string(what) + " is out of range", found);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error == std::errc::result_out_of_range) refuse(std::string(what) + " is out of range", found);
    if (error != std::errc{} || end != found.data() + found.size()) malformed(found);
    if (value < low || value > high) {
      refuse(std::string(what) + " is out of range " + std::to_string(low) + " ... " + std::to_string(high),
             found);
    }
    return static_cast<std::int32_t>(value);
  }

  /// Number of lines that follow; a count that the rest of the text cannot hold is refused before anything is
  /// allocated.
  std::int32_t count(std::string_view what, std::int64_t low = 0) {
    const std::int32_t n = integer(what, low, std::numeric_limits<std::int32_t>::max());
    if (static_cast<std::size_t>(n) > (_text.size() - _at) / 2) {
      refuse("count of '" + std::string(what) + "' is larger than the rest of the file", std::to_string(n));
    }
    return n;
  }

  /// Refuses n numbers that the rest of the text cannot hold, before anything is allocated.
  void require_room(std::string_view what, Eigen::Index n) const {
    if (static_cast<std::size_t>(n) > (_text.size() - _at) / 2)
      refuse("table '" + std::string(what) + "' is larger than the rest of the file", std::to_string(n));
  }

  /// Hexadecimal float as std::to_chars writes it, finite.
  double real(std::string_view what) {
    const std::string_view found = token(what);
    if (!is_hexadecimal_float(found)) malformed(found);
    double value = 0;
    const auto [end, error] =
        std::from_chars(found.data(), found.data() + found.size(), value, std::chars_format::hex);
    if (error != std::errc{} || end != found.data() + found.size()) malformed(found);
    const bool subnormal = value != 0 && std::abs(value) < std::numeric_limits<double>::min();
    if (subnormal && found.substr(found.find_first_of("01"), 1) == "1") malformed(found);
    return value;
  }

  /// As many numbers as `row` has.
  template <class Row>
  void reals(std::string_view what, Row&& row) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(row.size()); ++i) row[i] = real(what);
  }

  /// A line of a keyword and n numbers.
  Eigen::VectorXd vector_line(std::string_view key, Eigen::Index n, bool positive) {
    Eigen::VectorXd values(n);
    keyword(key);
    reals(key, values);
    if (positive && !(values.array() > 0).all()) refuse(std::string(key) + " must be positive", "");
    end_line();
    return values;
  }

  /// A line of a keyword and a number of lines that follow.
  std::int32_t count_line(std::string_view key, std::int64_t low = 0) {
    keyword(key);
    const std::int32_t n = count(key, low);
    end_line();
    return n;
  }

  bool at_end() const { return _at == _text.size(); }

  [[noreturn]] void refuse(const std::string& what, std::string_view value) const {
    throw input_error(
        _source + ":" + std::to_string(_line) + ": " + what, std::string(value),
        "write the model again with `phynness train`; the format is described in formats/model.md");
  }

 private:
  /// [-]d[.h...]p(+|-)n...: d 0 or 1, up to 13 digits h, up to 4 digits n; 0 leads only zero and subnormal
  /// numbers.
  static bool is_hexadecimal_float(std::string_view text) {
    const auto skip = [&](std::string_view allowed, std::size_t low, std::size_t high) {
      const std::size_t n = std::min(text.find_first_not_of(allowed), text.size());
      text.remove_prefix(n);
      return n >= low && n <= high;
    };
    if (text.starts_with('-')) text.remove_prefix(1);
    const bool subnormal = text.starts_with("0.") && text.find_first_not_of("0.") < text.find('p');
    const bool zero = text.starts_with('0') && !subnormal;
    if (!skip("01", 1, 1)) return false;
    if (text.starts_with('.')) {
      text.remove_prefix(1);
      if (!skip("0123456789abcdef", 1, 13)) return false;
    }
    if (!text.starts_with("p+") && !text.starts_with("p-")) return false;
    if (subnormal && text != "p-1022") return false;
    if (zero && text.find_first_not_of("0", 2) != std::string_view::npos) return false;
    text.remove_prefix(2);
    return skip("0123456789", 1, 4) && text.empty();
  }

  [[noreturn]] void malformed(std::string_view found) const {
    if (found.find(',') != std::string_view::npos) {
      refuse("number with a comma: a program with a comma locale wrote this file", found);
    }
    if (found.find("nan") != std::string_view::npos || found.find("inf") != std::string_view::npos) {
      refuse("number is not finite", found);
    }
    refuse("malformed number", found);
  }

  std::string_view _text;
  std::string _source;
  std::size_t _at = 0;
  int _line = 1;
  bool _line_start = true;
};

}  // namespace phynness
