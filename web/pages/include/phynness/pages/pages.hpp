// The interactive parts of the HTML files that phynness writes. The build makes them from web/view and web/report with
// Node and embeds them here.
#pragma once

#include <optional>
#include <string>

namespace phynness {

/// A file that the build has made: "view.html" (the page of `phynness view`) or "report.html".
/// @return nothing in a build without Node
std::optional<std::string> embedded_page(const std::string& name);

/// Why embedded_page() returns nothing, and what to do about it, for messages.
std::string missing_pages_remedy();

/// JSON as the content of an HTML element <script type="application/json">. Every "<" becomes \u003c, so that no text
/// in it can end the element.
std::string json_for_html(const std::string& json);

/// The page with `json` in its element with id phynness-data.
/// @throws Error (failure) if the page has no such element
std::string page_with_data(const std::string& page, const std::string& json);

}  // namespace phynness
