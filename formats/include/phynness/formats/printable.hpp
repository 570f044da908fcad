// Text from files and command lines, made safe for a terminal or a page, and text of numbers.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <string_view>

namespace phynness {

/// The text as UTF-8 in which every character can be seen. Escaped by their bytes, as \x1b, are bytes that are no
/// UTF-8, control characters, which could change what a terminal shows, and characters without width or that change the
/// direction of others, by which two different names could look alike. Line breaks and tabs stay.
std::string printable(std::string_view text);

/// printable() as text or an attribute of HTML and XML.
std::string escaped(std::string_view text);

/// The beginning of a text that is too long for a message, with its length; a shorter text as it is.
std::string shortened(std::string_view text, std::size_t most_bytes);

/// The text with its letters a to z as capitals, and with A to Z as small letters.
std::string upper(std::string_view text);
std::string lower(std::string_view text);

/// A number by std::to_chars, independent of the locale; without a format the shortest text that is read back as the
/// same number.
template <class Number, class... Format>
std::string number_text(Number number, Format... format) {
  char digits[330];  // the largest double has 309 in fixed notation
  return {digits, std::to_chars(digits, digits + sizeof digits, number, format...).ptr};
}
/// "0.0123 m", for messages.
inline std::string length_text(double length_m) { return number_text(length_m, std::chars_format::general, 6) + " m"; }

/// "(x, y, z)" with six digits each, for messages.
inline std::string shown_text(const std::array<double, 3>& v) {
  const auto text = [&](std::size_t k) { return number_text(v[k], std::chars_format::general, 6); };
  return "(" + text(0) + ", " + text(1) + ", " + text(2) + ")";
}

}  // namespace phynness
