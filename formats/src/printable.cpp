#include <algorithm>
#include <array>
#include <bit>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

/// First and last of the characters that are escaped: control characters, Unicode's Default_Ignorable_Code_Point
/// (DerivedCoreProperties.txt), separators of lines and paragraphs, and marks of annotations.
constexpr std::array<char32_t, 2> invisible[] = {
    {0, 0x08},        {0x0B, 0x1F},     {0x7F, 0x9F},       {0xAD, 0xAD},       {0x34F, 0x34F},
    {0x61C, 0x61C},   {0x115F, 0x1160}, {0x17B4, 0x17B5},   {0x180B, 0x180F},   {0x200B, 0x200F},
    {0x2028, 0x202E}, {0x2060, 0x206F}, {0x3164, 0x3164},   {0xFE00, 0xFE0F},   {0xFEFF, 0xFEFF},
    {0xFFA0, 0xFFA0}, {0xFFF0, 0xFFFB}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF}};

/// The character at the start of a text.
struct Character {
  std::size_t bytes;
  bool visible;
};

Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  constexpr Character no_utf8{1, false};
  const auto ones = static_cast<std::size_t>(std::countl_one(byte(0)));  // 0, or the number of bytes from 2 to 4
  if (ones == 1 || ones > 4 || ones > text.size()) return no_utf8;
  char32_t code = byte(0) & (0xFFu >> (ones + (ones > 0 ? 1 : 0)));
  for (std::size_t i = 1; i < ones; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return no_utf8;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  constexpr char32_t least[] = {0, 0, 0x80, 0x800, 0x10000};  // a longer form of a character is no UTF-8
  if (code < least[ones] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return no_utf8;
  return {std::max<std::size_t>(ones, 1),
          std::none_of(std::begin(invisible), std::end(invisible),
                       [&](const auto& range) { return code >= range[0] && code <= range[1]; })};
}

}  // namespace

std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto [bytes, visible] = first_of(text);
    for (const char c : text.substr(0, bytes)) {
      const auto byte = static_cast<unsigned char>(c);
      if (visible)
        out += c;
      else
        out += {'\\', 'x', digits[byte >> 4], digits[byte & 0xF]};
    }
    text.remove_prefix(bytes);
  }
  return out;
}

std::string shortened(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return std::string(text);
  std::size_t end = most_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
  return std::string(text.substr(0, end)) + " ... (" + std::to_string(text.size()) + " bytes)";
}

}  // namespace phynness
