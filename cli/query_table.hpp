// Many single tools at once, for eval and solve: a CSV file of displaced nodes is read, and a row of a CSV table of
// forces is written for each.
#pragma once

#include "commands.hpp"

namespace phynness::cli {

/// First line of a file of queries, one row for each, or of the motion of one tool, one row for each of its times.
inline constexpr const char *queries_header = "node,ux_m,uy_m,uz_m", *motion_header = "node,ux_m,uy_m,uz_m,time_s";

struct Query {
  std::int32_t node = 0;
  Vec3 displacement_m{};
  std::optional<double> time_s{};  ///< of a motion
};

/// Adds --queries and --output.
struct QueryOptions {
  OptionalPath file, output;
  /// @param excluded  options that ask or write something else
  void add_to(CLI::App& command, const std::vector<std::string>& excluded);
};

/// What answers a file of queries.
struct QueryAnswers {
  std::string command;  ///< for the line of progress
  std::string columns;  ///< of the table behind those of the query: ",fx_N,fy_N,fz_N,..."
  /// @throws Error (input) if this query cannot be answered
  std::function<void(const Query&)> check;
  /// Of a motion; `answer` is then called in its order.
  std::string motion_columns;
  /// Text of a row behind its query, beginning with a comma. Empty: the user wants an end.
  std::function<std::optional<std::string>(const Query&)> answer;
};

/// Checks all rows, answers them one after another, and writes each to stdout, or to OUTPUT.part, which gets its name
/// when it is complete. What ends the work before keeps the finished rows there; SIGKILL may cut the last line.
/// @throws Error (input) with the file and the line of the first invalid row, before anything is answered; (failure)
/// after a signal, with the number of rows that are finished and where they are; if the file cannot be written
void answer_queries(const QueryOptions& options, const QueryAnswers& answers);

}  // namespace phynness::cli
