// Lines and tokens of model.txt for the writer: exact, locale-free, nothing that is not finite.
#pragma once

#include <Eigen/Core>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <phynness/formats/error.hpp>
#include <string>
#include <string_view>

namespace phynness {

inline void require_writable(bool condition, const char* what) {
  if (!condition)
    throw failure(std::string("model cannot be written: ") + what, "",
                  "this is a defect of the program that made it");
}

/// Appends words, separated by single spaces, and lines; the counterpart of ModelLexer.
class ModelEmitter {
 public:
  ModelEmitter& word(std::string_view text) {
    separate();
    _out += text;
    return *this;
  }
  ModelEmitter& integer(std::int64_t value) { return word(std::to_string(value)); }
  ModelEmitter& real(double value) {
    if (!std::isfinite(value))
      throw failure("model holds a number that is not finite", "", "train again; if it stays, report it");
    char buffer[40];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::hex).ptr;
    return word({buffer, static_cast<std::size_t>(end - buffer)});
  }
  template <class Vector>
  ModelEmitter& reals(const Vector& values) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(values.size()); ++i) real(values[i]);
    return *this;
  }
  void end() {
    _out += '\n';
    _line_start = true;
  }
  /// A line of free text; control characters would break the lines and become spaces.
  void text(std::string_view key, const std::string& value) {
    word(key);
    if (!value.empty()) separate();
    for (const char c : value) _out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    end();
  }
  std::string& out() { return _out; }

 private:
  void separate() {
    if (!_line_start) _out += ' ';
    _line_start = false;
  }
  std::string _out;
  bool _line_start = true;
};

}  // namespace phynness
