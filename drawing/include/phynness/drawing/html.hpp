// The little HTML that a report needs.
#pragma once

#include <string>
#include <vector>

namespace phynness::report {

/// Text as it may stand between tags and in attributes.
std::string escaped(const std::string& text);

/// Numbers stay on one line; words break, so that wide tables fit the page.
enum class CellKind { numbers, words };

/// Cells are HTML already. The first row is the head; columns after the first are numbers and set to the
/// right.
std::string table(const std::vector<std::vector<std::string>>& rows, CellKind kind = CellKind::numbers);

/// A section with a heading.
std::string section(const std::string& title, const std::string& body);

/// A whole page.
std::string page(const std::string& title, const std::string& body);

}  // namespace phynness::report
