#include "text.hpp"

#include <cstring>

namespace PHN_RUNTIME {
namespace {

constexpr char magic[] = "phynness-model ";
constexpr char first_line[] = "phynness-model 2\n";
constexpr std::size_t checksum_line_length = sizeof("checksum 0123456789abcdef\n") - 1;

}  // namespace

int check_envelope(const char* text, std::size_t& length, std::size_t& wrong_byte) {
  const std::size_t first = sizeof first_line - 1, magic_length = sizeof magic - 1;
  wrong_byte = 1;
  if (length < first) {
    const bool start_of_one = length > 0 && std::memcmp(text, first_line, length) == 0;
    if (start_of_one) wrong_byte = length + 1;
    return start_of_one ? PHN_ERROR_TRUNCATED : PHN_ERROR_NOT_A_MODEL;
  }
  if (std::memcmp(text, magic, magic_length) != 0) return PHN_ERROR_NOT_A_MODEL;
  wrong_byte = magic_length + 1;
  if (std::memcmp(text, first_line, first) != 0) return PHN_ERROR_VERSION;
  wrong_byte = length + 1;
  if (length < first + checksum_line_length || text[length - 1] != '\n') return PHN_ERROR_TRUNCATED;
  const std::size_t end = length - checksum_line_length;
  if (std::memcmp(text + end, "checksum ", 9) != 0) return PHN_ERROR_TRUNCATED;
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (std::size_t i = 0; i < end; ++i)
    hash = (hash ^ static_cast<unsigned char>(text[i])) * 0x100000001b3ULL;
  for (int i = 0; i < 16; ++i) {
    wrong_byte = end + 10;
    if (text[end + 9 + i] != "0123456789abcdef"[hash >> (60 - 4 * i) & 15]) return PHN_ERROR_CHECKSUM;
  }
  wrong_byte = 0;
  length = end;
  return PHN_OK;
}

TextReader::Token TextReader::token() {
  const Token none{_at, _at};
  if (!good()) return none;
  if (!_line_start) {
    if (_at == _end || *_at != ' ') {
      fail_next(PHN_ERROR_SYNTAX);
      return none;
    }
    ++_at;
  }
  _token = _at;
  Token found{_at, _at};
  while (found.end != _end && *found.end != ' ' && *found.end != '\n') ++found.end;
  if (found.begin == found.end) fail(PHN_ERROR_SYNTAX);
  _at = found.end;
  _line_start = false;
  return found;
}

void TextReader::keyword(const char* word) {
  const Token found = token();
  const std::size_t length = std::strlen(word);
  if (static_cast<std::size_t>(found.end - found.begin) != length ||
      std::memcmp(found.begin, word, length) != 0) {
    fail(PHN_ERROR_SYNTAX);
  }
}

TextReader::Word TextReader::rest_of_line() {
  if (good() && _at != _end && *_at == ' ') ++_at;
  const char* begin = _at;
  while (good() && _at != _end && *_at != '\n') ++_at;
  return {begin, static_cast<std::size_t>(_at - begin)};
}

TextReader::Word TextReader::word() {
  constexpr std::size_t longest = 40;
  const Token found = token();
  const auto length = static_cast<std::size_t>(found.end - found.begin);
  if (length < 1 || length > longest) fail(PHN_ERROR_SYNTAX);
  for (const char* c = found.begin; c != found.end && good(); ++c)
    if (*c <= 0x20 || *c >= 0x7f) fail(PHN_ERROR_SYNTAX);
  return good() ? Word{found.begin, length} : Word{nullptr, 0};
}

void TextReader::end_line() {
  if (!good()) return;
  if (_at == _end || *_at != '\n') return fail_next(PHN_ERROR_SYNTAX);
  ++_at;
  _line_start = true;
}

std::int32_t TextReader::integer(std::int32_t low, std::int32_t high) {
  const Token found = token();
  const bool negative = low < 0 && found.begin != found.end && *found.begin == '-';
  const char* first = negative ? found.begin + 1 : found.begin;
  if (first == found.end) fail(PHN_ERROR_SYNTAX);
  std::int64_t value = 0;
  // Ten digits cannot overflow 64 bits.
  for (const char* c = first; c != found.end && good(); ++c) {
    if (*c < '0' || *c > '9') fail(PHN_ERROR_SYNTAX);
    if (c - first < 10) value = 10 * value + (*c - '0');
  }
  if (found.end - first > 10) fail(PHN_ERROR_RANGE);
  if (negative) value = -value;
  if (good() && (value < low || value > high)) fail(PHN_ERROR_RANGE);
  return good() ? static_cast<std::int32_t>(value) : 0;
}

std::int32_t TextReader::count(std::int32_t low) {
  const std::int32_t n = integer(low, INT32_MAX);
  if (n > (_end - _at) / 2) fail(PHN_ERROR_RANGE);
  return good() ? n : 0;
}

void TextReader::require_room(std::uint64_t n) {
  if (n > static_cast<std::uint64_t>(_end - _at) / 2) fail(PHN_ERROR_RANGE);
}

double TextReader::real() {
  const Token found = token();
  const char* c = found.begin;
  const bool negative = c != found.end && *c == '-';
  if (negative) ++c;
  if (c == found.end || (*c != '0' && *c != '1')) {
    fail(PHN_ERROR_SYNTAX);
    return 0;
  }
  const bool leading_one = *c++ == '1';
  std::uint64_t fraction = 0;
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
      fraction = fraction << 4 | static_cast<std::uint64_t>(digit);
    }
    if (n_digits == 0) fail(PHN_ERROR_SYNTAX);
  }
  if (found.end - c < 3 || found.end - c > 6 || c[0] != 'p' || (c[1] != '+' && c[1] != '-'))
    fail(PHN_ERROR_SYNTAX);
  if (!good()) return 0;
  const bool negative_exponent = c[1] == '-';
  std::int32_t exponent = 0;
  for (c += 2; c != found.end; ++c) {
    if (*c < '0' || *c > '9') fail(PHN_ERROR_SYNTAX);
    exponent = 10 * exponent + (*c - '0');
  }
  if (negative_exponent) exponent = -exponent;
  fraction <<= 4 * (13 - n_digits);
  // The text mirrors the fields of an IEEE 754 double, so the value is assembled, not computed.
  std::uint64_t bits = fraction;
  if (leading_one) {
    if (exponent < -1022 || exponent > 1023) fail(PHN_ERROR_RANGE);
    bits |= static_cast<std::uint64_t>(exponent + 1023) << 52;
  } else if (exponent != (fraction == 0 ? 0 : -1022)) {
    fail(PHN_ERROR_SYNTAX);
  }
  if (!good()) return 0;
  bits |= static_cast<std::uint64_t>(negative) << 63;
  double value = 0;
  static_assert(sizeof value == sizeof bits, "double must be IEEE 754 binary64");
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

double TextReader::positive_real() {
  const double value = real();
  if (!(value > 0)) fail(PHN_ERROR_RANGE);
  return good() ? value : 1;
}

}  // namespace PHN_RUNTIME
