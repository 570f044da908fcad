// Text output of `phynness validate`.
#include <algorithm>
#include <phynness/validation/report.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

/// The first column to the left, the others to the right, in lines of whole groups of columns, of which the first
/// heading has a colon. A row of one cell is a heading of those below it.
void print_cells(const TableCells& rows) {
  constexpr std::size_t most = 100;
  const auto& headings = rows.front();
  const std::size_t n = headings.size();
  std::vector<std::size_t> widths(n);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size() && row.size() == n; ++i) widths[i] = std::max(widths[i], row[i].size());
  for (std::size_t first = 1, end = 1; first < n; first = end) {
    std::size_t i = first;
    for (std::size_t width = widths[0]; i < n && (i == first || width + 2 + widths[i] <= most); ++i) {
      width += 2 + widths[i];
      if (i + 1 == n || headings[i + 1].find(": ") != std::string::npos) end = i + 1;
    }
    if (end == first) end = i;  // a group that is wider than a line
    for (const auto& row : rows) {
      std::string line = fmt::format("{:<{}}", row[0], widths[0]);
      for (i = first; i < end && row.size() == n; ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
      print_result("{}\n", line.erase(line.find_last_not_of(' ') + 1));
    }
  }
}

/// Texts and tables of a section of the report.
void print_section(const json& section) {
  print_result("\n{}\n", section.at("title").get<std::string>());
  for (const auto& block : section.at("blocks")) {
    for (const char* words : {"text", "warning", "remark", "folded"})
      if (block.contains(words)) print_result("{}\n", block[words].get<std::string>());
    if (!block.contains("table")) continue;
    TableCells rows;
    for (const auto& row : block["table"]) {
      auto& cells = rows.emplace_back();
      for (const auto& cell : row) cells.push_back((cell.is_object() ? cell["text"] : cell).get<std::string>());
    }
    if (!block.contains("words")) print_cells(rows);
    for (std::size_t i = 1; i < rows.size() && block.contains("words"); ++i)
      print_result("  {:<32}{}\n", rows[i][0], rows[i][1]);
  }
}

}  // namespace

void print_validation(const Validated& v) {
  for (const auto& line : verdict(v)) print_result("{}: {}.\n", line.title, line.sentence);
  for (const auto& worse : worse_than_linear(v)) print_result("warning: {}\n", worse.sentence());
  for (const auto& part : v.not_done()) print_result("{}\n", part);
  print_cells(summary_cells(v));
}

void print_details(const Validated& v, int ranks) {
  for (const auto& section : report_tables(v)) print_section(section);
  print_result("\n{} on {} rank{}\n", duration(v.report.seconds), ranks, ranks == 1 ? "" : "s");
}

}  // namespace phynness::cli
