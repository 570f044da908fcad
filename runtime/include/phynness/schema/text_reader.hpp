// Tokens of model.txt, read strictly from memory: no locale, no library number parser, every access bounds-checked.
#pragma once

#include <phynness/phynness.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

namespace phynness::schema {

/// First word and first line of the format; the number is its version.
inline constexpr char model_magic[] = "phynness-model ", model_first_line[] = "phynness-model 4\n";
/// Length of the last line: "checksum " and the hash of the text before it.
inline constexpr size_t checksum_line_length = sizeof("checksum 0123456789abcdef\n") - 1;

/// Checks identity, version, completeness and checksum. On success `length` becomes the length before the checksum
/// line.
/// @param first_line  a word and the version, one digit
/// @param wrong_byte  position of the first error, counted from 1; 0 for a valid text
/// @return a status of phynness.h
template <size_t size>
int check_envelope(const char (&first_line)[size], const char* text, size_t& length, size_t& wrong_byte);

/// Reads tokens until the first error, which status() keeps. After an error every read returns 0 and consumes nothing.
class TextReader {
 public:
  TextReader(const char* text, size_t length) : _begin(text), _at(text), _end(text + length) {}

  int status() const { return _status; }
  bool good() const { return _status == PHN_OK; }
  void fail(int status) {
    if (good()) _status = status;
  }
  /// Fails at the next token instead of the last one.
  void fail_next(int status) {
    if (!good()) return;
    const char* next = _at == _end || *_at != ' ' ? _at : _at + 1;
    _token = {next, next};
    fail(status);
  }
  /// Position of the first error, counted from 1; 0: no error.
  size_t wrong_byte() const { return good() ? 0 : token_at() + 1; }
  /// Offset at which the last token begins; after an error, the wrong token.
  size_t token_at() const { return static_cast<size_t>(_token.begin - _begin); }

  struct Token {
    const char *begin, *end;
    size_t length() const { return static_cast<size_t>(end - begin); }
  };
  Token last_token() const { return _token; }

  void keyword(const char* word);
  /// Whether the next token of the line is this word. Consumes nothing.
  bool next_is(const char* word) const;
  /// The text up to the end of the line without the separating space; may be empty.
  Token rest_of_line();
  /// A token of 1 to `longest` visible ASCII characters, as a part of the text; empty after an error.
  Token word(size_t longest);
  void end_line();
  bool at_end() const { return _at == _end; }

  /// An integer between `low` and `high`; a sign is accepted only if `low` is negative.
  int32_t integer(int32_t low, int32_t high);
  /// The number of lines that follow; an error if the rest of the text cannot hold them.
  int32_t count(int32_t low);
  /// An error if the rest of the text cannot hold n numbers.
  void require_room(uint64_t n) {
    if (n > static_cast<uint64_t>(_end - _at) / 2) fail(PHN_ERROR_RANGE);
  }
  /// Hexadecimal float [-]h[.h...]p(+|-)d..., at most 13 digits after the point; always finite.
  double real();

 private:
  Token token();
  static bool equal(const Token& token, const char* word) {
    const size_t length = strlen(word);
    return token.length() == length && memcmp(token.begin, word, length) == 0;
  }

  const char *_begin, *_at, *_end;
  Token _token{_begin, _begin};
  int _status = PHN_OK;
  bool _line_start = true;
};

template <size_t size>
int check_envelope(const char (&first_line)[size], const char* text, size_t& length, size_t& wrong_byte) {
  constexpr size_t first = size - 1, magic_length = first - 2;
  const auto refuse = [&](int status, size_t at) {
    wrong_byte = at + 1;
    return status;
  };
  if (length < first) {
    const bool start_of_one = length > 0 && memcmp(text, first_line, length) == 0;
    return start_of_one ? refuse(PHN_ERROR_TRUNCATED, length) : refuse(PHN_ERROR_NOT_A_MODEL, 0);
  }
  if (memcmp(text, first_line, magic_length) != 0) return refuse(PHN_ERROR_NOT_A_MODEL, 0);
  if (memcmp(text, first_line, first) != 0) return refuse(PHN_ERROR_VERSION, magic_length);
  if (length < first + checksum_line_length || text[length - 1] != '\n') return refuse(PHN_ERROR_TRUNCATED, length);
  const size_t end = length - checksum_line_length;
  if (memcmp(text + end, "checksum ", 9) != 0) return refuse(PHN_ERROR_TRUNCATED, length);
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (size_t i = 0; i < end; ++i) hash = (hash ^ static_cast<unsigned char>(text[i])) * 0x100000001b3ULL;
  for (int i = 0; i < 16; ++i)
    if (text[end + 9 + static_cast<size_t>(i)] != "0123456789abcdef"[hash >> (60 - 4 * i) & 15])
      return refuse(PHN_ERROR_CHECKSUM, end + 9);
  wrong_byte = 0;
  length = end;
  return PHN_OK;
}

inline TextReader::Token TextReader::token() {
  if (!good()) return {_at, _at};
  _token = {_at, _at};
  if (!_line_start) {
    if (_at == _end || *_at != ' ') {
      fail_next(PHN_ERROR_SYNTAX);
      return _token;
    }
    ++_at;
  }
  _token = {_at, _at};
  while (_token.end != _end && *_token.end != ' ' && *_token.end != '\n') ++_token.end;
  if (_token.begin == _token.end) fail(PHN_ERROR_SYNTAX);
  _at = _token.end;
  _line_start = false;
  return _token;
}

inline void TextReader::keyword(const char* word) {
  if (!equal(token(), word)) fail(PHN_ERROR_SYNTAX);
}

inline bool TextReader::next_is(const char* word) const {
  TextReader ahead = *this;
  return equal(ahead.token(), word);
}

inline TextReader::Token TextReader::rest_of_line() {
  if (good() && !_line_start && _at != _end && *_at == ' ') ++_at;
  Token line{_at, _at};
  while (good() && line.end != _end && *line.end != '\n') ++line.end;
  _at = line.end;
  return line;
}

inline TextReader::Token TextReader::word(size_t longest) {
  const Token found = token();
  if (found.length() < 1 || found.length() > longest) fail(PHN_ERROR_SYNTAX);
  for (const char* c = found.begin; c != found.end && good(); ++c)
    if (*c <= 0x20 || *c >= 0x7f) fail(PHN_ERROR_SYNTAX);
  return good() ? found : Token{_at, _at};
}

inline void TextReader::end_line() {
  if (!good()) return;
  if (_at == _end || *_at != '\n') return fail_next(PHN_ERROR_SYNTAX);
  ++_at;
  _line_start = true;
}

inline int32_t TextReader::integer(int32_t low, int32_t high) {
  const Token found = token();
  const bool negative = low < 0 && found.begin != found.end && *found.begin == '-';
  const char* first = negative ? found.begin + 1 : found.begin;
  if (first == found.end) fail(PHN_ERROR_SYNTAX);
  int64_t value = 0;
  // Ten digits cannot overflow 64 bits.
  for (const char* c = first; c != found.end && good(); ++c) {
    if (*c < '0' || *c > '9') fail(PHN_ERROR_SYNTAX);
    if (c - first < 10) value = 10 * value + (*c - '0');
  }
  if (found.end - first > 10) fail(PHN_ERROR_RANGE);
  if (negative) value = -value;
  if (good() && (value < low || value > high)) fail(PHN_ERROR_RANGE);
  return good() ? static_cast<int32_t>(value) : 0;
}

inline int32_t TextReader::count(int32_t low) {
  const int32_t n = integer(low, INT32_MAX);
  if (n > (_end - _at) / 2) fail(PHN_ERROR_RANGE);
  return good() ? n : 0;
}

inline double TextReader::real() {
  const Token found = token();
  const char* c = found.begin;
  const bool negative = c != found.end && *c == '-';
  if (negative) ++c;
  if (c == found.end || (*c != '0' && *c != '1')) {
    fail(PHN_ERROR_SYNTAX);
    return 0;
  }
  const bool leading_one = *c++ == '1';
  uint64_t fraction = 0;
  int n_digits = 0;
  if (c != found.end && *c == '.') {
    for (++c; c != found.end && *c != 'p'; ++c, ++n_digits) {
      int digit = 0;
      if (*c >= '0' && *c <= '9') {
        digit = *c - '0';
      } else if (*c >= 'a' && *c <= 'f') {
        digit = *c - 'a' + 10;
      } else {
        fail(PHN_ERROR_SYNTAX);
      }
      if (n_digits == 13) fail(PHN_ERROR_SYNTAX);
      if (!good()) return 0;
      fraction = fraction << 4 | static_cast<uint64_t>(digit);
    }
    if (n_digits == 0) fail(PHN_ERROR_SYNTAX);
  }
  if (found.end - c < 3 || found.end - c > 6 || c[0] != 'p' || (c[1] != '+' && c[1] != '-')) fail(PHN_ERROR_SYNTAX);
  if (!good()) return 0;
  const bool negative_exponent = c[1] == '-';
  int32_t exponent = 0;
  for (c += 2; c != found.end; ++c) {
    if (*c < '0' || *c > '9') fail(PHN_ERROR_SYNTAX);
    exponent = 10 * exponent + (*c - '0');
  }
  if (negative_exponent) exponent = -exponent;
  fraction <<= 4 * (13 - n_digits);
  // The text mirrors the fields of an IEEE 754 double, so the value is assembled, not computed.
  uint64_t bits = fraction;
  if (leading_one) {
    if (exponent < -1022 || exponent > 1023) fail(PHN_ERROR_RANGE);
    bits |= static_cast<uint64_t>(exponent + 1023) << 52;
  } else if (exponent != (fraction == 0 ? 0 : -1022)) {
    fail(PHN_ERROR_SYNTAX);
  }
  if (!good()) return 0;
  bits |= static_cast<uint64_t>(negative) << 63;
  double value = 0;
  memcpy(&value, &bits, sizeof value);
  static_assert(sizeof value == sizeof bits, "double must be IEEE 754 binary64");
  return value;
}

}  // namespace phynness::schema
