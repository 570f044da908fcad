#include "scanner.hpp"

#include <algorithm>

namespace phynness::meshes {
namespace {

bool is_white(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }

}  // namespace

void Scanner::fail(const std::string& what, std::string_view value, const std::string& remedy) const {
  const auto end = _bytes.begin() + static_cast<std::ptrdiff_t>(std::min(_position, _bytes.size()));
  const auto line = 1 + std::count(_bytes.begin(), end, '\n');
  throw input_error(_source + ":" + std::to_string(line) + ": " + what, std::string(value.substr(0, 60)), remedy);
}

void Scanner::truncated(const std::string& expected) const {
  fail("the file is truncated: it ends before " + expected, "", "copy or export the file again");
}

void Scanner::skip_white() {
  while (_position < _bytes.size() && is_white(_bytes[_position])) ++_position;
}

std::string_view Scanner::line() {
  const std::size_t end = std::min(_bytes.find('\n', _position), _bytes.size());
  std::string_view text = _bytes.substr(_position, end - _position);
  _position = std::min(end + 1, _bytes.size());
  if (text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

std::string_view Scanner::word_or_end() {
  skip_white();
  const std::size_t begin = _position;
  while (_position < _bytes.size() && !is_white(_bytes[_position])) ++_position;
  return _bytes.substr(begin, _position - begin);
}

std::string_view Scanner::word(const char* expected) {
  const std::string_view text = word_or_end();
  if (text.empty()) truncated(expected);
  return text;
}

std::size_t Scanner::checked_count(std::int64_t count, std::size_t bytes_each, const char* what) const {
  if (count < 0) fail(std::string("negative number of ") + what, std::to_string(count));
  if (static_cast<std::uint64_t>(count) > remaining() / bytes_each)
    fail("the file is truncated: it declares " + std::to_string(count) + " " + what + " but is too short for them",
         std::to_string(remaining()) + " bytes remain", "copy or export the file again");
  return static_cast<std::size_t>(count);
}

bool Scanner::skip_past(std::string_view text) {
  const auto at = _bytes.find(text, _position);
  if (at != _bytes.npos) _position = at + text.size();
  return at != _bytes.npos;
}

void Scanner::skip(std::size_t bytes, const char* expected) {
  if (remaining() < bytes) truncated(expected);
  _position += bytes;
}

}  // namespace phynness::meshes
