// HTML elements of reports.
#pragma once

#include <string>
#include <vector>

namespace phynness::report {

/// The printable text with escapes, for use between tags and in attributes.
std::string escaped(const std::string& text);

/// Numbers are not broken across lines; words are, so that wide tables fit the page.
enum class CellKind { numbers, words };

/// A table. Cells are HTML. The first row is the head. Columns after the first are aligned to the right.
std::string table(const std::vector<std::vector<std::string>>& rows, CellKind kind = CellKind::numbers);

/// A section with a heading.
std::string section(const std::string& title, const std::string& body);

/// A complete page that loads nothing from elsewhere. Its script, which the build embeds if it has Node, draws the
/// plots and, from `data`, the body; without it the page says how to get it.
/// @param data  JSON (web/report/src/data.ts); empty: none
std::string page(const std::string& title, const std::string& body, const std::string& data = "");

}  // namespace phynness::report
