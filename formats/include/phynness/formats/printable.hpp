// Text from files and command lines, made safe for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace phynness {

/// Length of a mark at the start of `text` that changes the direction of the text around it, so that a name could look
/// like another one (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069 in UTF-8); 0: none.
inline std::size_t direction_mark(std::string_view text) {
  if (text.substr(0, 2) == "\xD8\x9C") return 2;
  if (text.size() < 3 || text[0] != '\xE2') return 0;
  const unsigned last = static_cast<unsigned char>(text[2]);
  const bool is_mark = text[1] == '\x80'   ? last == 0x8E || last == 0x8F || (last >= 0xAA && last <= 0xAE)
                       : text[1] == '\x81' ? last >= 0xA6 && last <= 0xA9
                                           : false;
  return is_mark ? 3 : 0;
}

/// Control characters, which could end a message early or change what a terminal shows, as \x1b and the like, and marks
/// of direction, by their bytes. Line breaks and tabs stay, and so does every other character of UTF-8.
inline std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  const auto escape = [&](unsigned code) {
    out += "\\x";
    out += digits[code >> 4];
    out += digits[code & 0xF];
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const unsigned byte = static_cast<unsigned char>(text[i]);
    const unsigned next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F) {
      escape(byte);
    } else if (byte == 0xC2 && next >= 0x80 && next <= 0x9F) {  // U+0080 to U+009F, in UTF-8
      escape(next);
      ++i;
    } else if (const std::size_t mark = direction_mark(text.substr(i)); mark > 0) {
      for (const char c : text.substr(i, mark)) escape(static_cast<unsigned char>(c));
      i += mark - 1;
    } else {
      out += text[i];
    }
  }
  return out;
}

/// The beginning of a text that is too long for a message, with its length; a shorter text as it is.
inline std::string shortened(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return std::string(text);
  std::size_t end = most_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
  return std::string(text.substr(0, end)) + " ... (" + std::to_string(text.size()) + " bytes)";
}

}  // namespace phynness
