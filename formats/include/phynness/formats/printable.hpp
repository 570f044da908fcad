// Text from files and command lines, made safe for a terminal or a page.
#pragma once

#include <string>
#include <string_view>

namespace phynness {

/// The text as UTF-8 in which every character can be seen. Escaped by their bytes, as \x1b, are bytes that are no
/// UTF-8, control characters, which could change what a terminal shows, and characters without width or that change the
/// direction of others, by which two different names could look alike. Line breaks and tabs stay.
std::string printable(std::string_view text);

/// The beginning of a text that is too long for a message, with its length; a shorter text as it is.
std::string shortened(std::string_view text, std::size_t most_bytes);

}  // namespace phynness
