// Tokens of model.txt, read strictly from memory: no locale, no library number parser, every access
// bounds-checked.
#pragma once

#include <phynness/phynness.h>

#include <cstddef>
#include <cstdint>

#include "strict_arithmetic.hpp"

namespace phynness::runtime {

/// Magic, version, completeness, checksum; on success `length` is shortened to the text before the checksum
/// line.
/// @return a status of phynness.h
int check_envelope(const char* text, std::size_t& length);

/// The first defect sticks in status(); from then on every read returns 0 and consumes nothing.
class TextReader {
 public:
  TextReader(const char* text, std::size_t length) : _at(text), _end(text + length) {}

  int status() const { return _status; }
  bool good() const { return _status == PHN_OK; }
  void fail(int status) {
    if (good()) _status = status;
  }

  void keyword(const char* word);
  void rest_of_line();
  /// A token of 1 to 40 visible ASCII characters; it lies in the text. Length 0 if there is none.
  struct Word {
    const char* begin;
    std::size_t length;
  };
  Word word();
  void end_line();
  bool at_end() const { return _at == _end; }

  /// A sign is read only where `low` is negative.
  std::int32_t integer(std::int32_t low, std::int32_t high);
  /// A number of lines that follow; more than the text can hold is refused.
  std::int32_t count(std::int32_t low);
  /// Refuses n numbers that the rest of the text cannot hold.
  void require_room(std::uint64_t n);
  /// Hexadecimal float [-]h[.h...]p(+|-)d..., at most 13 digits after the point; always finite.
  double real();
  double positive_real();

 private:
  struct Token {
    const char *begin, *end;
  };
  Token token();

  const char *_at, *_end;
  int _status = PHN_OK;
  bool _line_start = true;
};

}  // namespace phynness::runtime
