// Many single tools at once, for eval and solve: a CSV file of displaced nodes is read block by block, and a CSV table
// of forces is written in the order of its rows. The memory does not depend on the number of rows.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <phynness/formats/selector.hpp>
#include <string>
#include <vector>

#include "commands.hpp"

namespace phynness::cli {

/// First line of a file of queries; one row for each query follows.
inline constexpr const char* queries_header = "node,ux_m,uy_m,uz_m";

struct Query {
  std::int32_t node = 0;
  Vec3 displacement_m{};
};

/// Adds --queries and --output.
struct QueryOptions {
  std::optional<std::filesystem::path> file, output;
  void add_to(CLI::App& command);
  /// @param others  other options that are given and write or ask something else, for the message; "": none
  /// @throws Error (input) if tools or such options are given together with --queries, or --output without it
  void check(const ToolOptions& tool, const std::string& others) const;
};

/// What answers a file of queries.
struct QueryAnswers {
  std::string command;  ///< for the line of progress
  std::string columns;  ///< of the table behind those of the query: ",fx_N,fy_N,fz_N,..."
  /// @throws Error (input) if this query cannot be answered
  std::function<void(const Query&)> check;
  /// Takes the text of a row behind its query, beginning with a comma. @return false: the work shall end
  using Take = std::function<bool(std::size_t row, std::string text)>;
  /// Answers the rows of a block in any order.
  std::function<void(const std::vector<Query>& block, const Take& take)> answer;
};

/// Checks all rows, answers them block by block, and writes the table to stdout or to a file that has its name only
/// when it is complete. A signal ends the work and keeps the finished rows, on stdout or in OUTPUT.part.
/// @throws Error (input) with the file and the line of the first invalid row, before anything is answered; (failure)
/// after a signal, with the number of rows that are finished and where they are
void answer_queries(const QueryOptions& options, const QueryAnswers& answers);

}  // namespace phynness::cli
