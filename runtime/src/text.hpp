// Tokens of model.txt, read strictly from memory: no locale, no library number parser, every access
// bounds-checked.
#pragma once

#include <phynness/phynness.h>

#include <cstddef>
#include <cstdint>

#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// Magic, version, completeness, checksum; on success `length` is shortened to the text before the checksum
/// line.
/// @param wrong_byte  where a refused text is wrong, counted from 1; 0 for a good one
/// @return a status of phynness.h
int check_envelope(const char* text, std::size_t& length, std::size_t& wrong_byte);

/// The first defect sticks in status(); from then on every read returns 0 and consumes nothing.
class TextReader {
 public:
  TextReader(const char* text, std::size_t length) : _begin(text), _at(text), _end(text + length) {}

  int status() const { return _status; }
  bool good() const { return _status == PHN_OK; }
  void fail(int status) { fail_at(status, _token); }
  /// The same of what comes next.
  void fail_next(int status) { fail_at(status, _at == _end || *_at != ' ' ? _at : _at + 1); }
  /// The first defect, counted from 1 at the begin of the text; 0: none.
  std::size_t wrong_byte() const { return good() ? 0 : static_cast<std::size_t>(_wrong - _begin) + 1; }

  void keyword(const char* word);
  /// A token of 1 to 40 visible ASCII characters; it lies in the text. Length 0 if there is none.
  struct Word {
    const char* begin;
    std::size_t length;
  };
  Word word();
  /// What stands between a keyword and the end of its line, without the blank.
  Word rest_of_line();
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
  void fail_at(int status, const char* where) {
    if (good()) _wrong = where;
    if (good()) _status = status;
  }

  const char *_begin, *_at, *_end;
  const char *_token = _begin, *_wrong = _begin;  ///< where the last token begins, and the first defect
  int _status = PHN_OK;
  bool _line_start = true;
};

}  // namespace PHN_RUNTIME
