// Text output of `phynness validate`.
#include <algorithm>
#include <phynness/validation/report.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

/// The first column to the left, the others to the right.
void print_cells(const TableCells& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  for (const auto& row : rows) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
    print_result("{}\n", line.erase(line.find_last_not_of(' ') + 1));
  }
}

}  // namespace

void print_validation(const Validated& v) {
  for (const auto& line : verdict(v)) print_result("{}: {}.\n", line.title, line.sentence);
  for (const auto& worse : worse_than_linear(v)) print_result("warning: {}\n", worse.sentence());
  for (const auto& part : v.not_done()) print_result("{}\n", part);
  print_cells(summary_cells(v));
}

}  // namespace phynness::cli
