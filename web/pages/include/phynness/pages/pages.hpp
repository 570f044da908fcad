// The page of `phynness view`, which the build makes from web/view with Node and embeds here.
#pragma once

#include <string>

namespace phynness {

/// Empty in a build without Node.
std::string embedded_page();

/// Why embedded_page() is empty, and what to do about it, for messages.
std::string missing_pages_remedy();

/// The page with `json`, compressed, in its element with id phynness-data.
/// @throws Error (failure) if the page has no such element, or the text is larger than 4 GB
std::string page_with_data(const std::string& page, const std::string& json);

}  // namespace phynness
