#include <algorithm>
#include <bit>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

/// Bytes of the character at the start of a text; 0: a control character, or no UTF-8.
std::size_t visible_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return (byte(0) >= 0x20 && byte(0) != 0x7F) || text[0] == '\n' || text[0] == '\t' ? 1 : 0;
  const auto n = static_cast<std::size_t>(std::countl_one(byte(0)));
  if (n < 2 || n > 4 || n > text.size()) return 0;
  char32_t code = byte(0) & (0xFFu >> (n + 1));
  for (std::size_t i = 1; i < n; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  // Without width, or change the direction of others.
  if ((code >= 0x200B && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) || (code >= 0x2060 && code <= 0x206F) ||
      code == 0xFEFF)
    return 0;
  // A longer form of a character and a half of a pair are no UTF-8.
  constexpr char32_t least[] = {0, 0, 0xA0, 0x800, 0x10000};
  return code < least[n] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF) ? 0 : n;
}

std::string shifted(std::string_view text, char first, char last, char to) {
  std::string out(text);
  for (char& c : out)
    if (c >= first && c <= last) c = static_cast<char>(c - first + to);
  return out;
}

}  // namespace

std::string upper(std::string_view text) { return shifted(text, 'a', 'z', 'A'); }
std::string lower(std::string_view text) { return shifted(text, 'A', 'Z', 'a'); }

std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto n = visible_bytes(text);
    const auto byte = static_cast<unsigned char>(text[0]);
    if (n > 0)
      out += text.substr(0, n);
    else
      out += {'\\', 'x', digits[byte >> 4], digits[byte & 0xF]};
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : printable(text))
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  return out;
}

std::string shortened(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return std::string(text);
  std::size_t end = most_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
  return std::string(text.substr(0, end)) + " ... (" + std::to_string(text.size()) + " bytes)";
}

}  // namespace phynness
