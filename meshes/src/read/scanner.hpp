// Reads words, lines and binary values from the bytes of a mesh file; errors name the place.
#pragma once

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <string>
#include <string_view>

namespace phynness::meshes {

/// The remedy for a damaged file.
inline constexpr const char* again = "export the file again";

class Scanner {
 public:
  Scanner(std::string_view bytes, std::string source) : _bytes(bytes), _source(std::move(source)) {}

  bool at_end() const { return _position >= _bytes.size(); }
  std::size_t remaining() const { return _bytes.size() - _position; }
  const std::string& source() const { return _source; }

  /// @throws Error with the current line, and at most 60 characters of the value
  [[noreturn]] void fail(const std::string& what, std::string_view value = {}, const std::string& remedy = again) const;
  [[noreturn]] void truncated(const std::string& expected) const;

  /// The rest of the current line without its line break; moves past the break.
  std::string_view line();
  /// The next word separated by white space; empty at the end of the file.
  std::string_view word_or_end();
  /// The next word. @throws Error if the file ends
  std::string_view word(const char* expected);

  template <class Number>
  Number number(const char* expected) {
    return parse<Number>(word(expected), expected);
  }
  template <class Number>
  Number parse(std::string_view text, const char* expected) const {
    Number value{};
    if (!is_number(text, value))
      fail(std::string("expected a number for ") + expected, std::string(text.substr(0, 40)),
           "export the file again; it is damaged or of another format");
    return value;
  }
  /// Whether a text is a number in the range of its type; numbers that are too small are 0.
  template <class Number>
  static bool is_number(std::string_view text, Number& value) {
    if (text.starts_with('+')) text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range && (text.find("e-") != text.npos || text.find("E-") != text.npos)) {
      value = Number{};
      return true;
    }
    return error == std::errc{} && end == text.data() + text.size();
  }

  /// Binary value in the byte order of the file.
  template <class Value>
  Value raw(const char* expected, bool swap) {
    if (remaining() < sizeof(Value)) truncated(expected);
    char buffer[sizeof(Value)];
    std::memcpy(buffer, _bytes.data() + _position, sizeof buffer);
    if (swap)
      for (std::size_t i = 0; i < sizeof buffer / 2; ++i) std::swap(buffer[i], buffer[sizeof buffer - 1 - i]);
    _position += sizeof buffer;
    return std::bit_cast<Value>(buffer);
  }

  /// A number of items that take at least `bytes_each` bytes each. If the file is too short for them, it is refused
  /// before any allocation.
  std::size_t checked_count(std::int64_t count, std::size_t bytes_each, const char* what) const;

  void skip(std::size_t bytes, const char* expected);
  /// Moves past the next occurrence of a text. @return false if there is none
  bool skip_past(std::string_view text);

 private:
  void skip_white();

  std::string_view _bytes;
  std::string _source;
  std::size_t _position = 0;
};

}  // namespace phynness::meshes
