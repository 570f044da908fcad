// Tables of queries for eval and solve: each row of a CSV file of displaced nodes gives a row of a CSV table of forces.
#pragma once

#include "commands.hpp"

namespace phynness::cli {

/// The first line of a file of independent queries, and of the motion of one tool.
inline constexpr const char *queries_header = "node,ux_m,uy_m,uz_m", *motion_header = "node,ux_m,uy_m,uz_m,time_s";

struct Query {
  std::int32_t node = 0;
  Vec3 displacement_m{};
  std::optional<double> time_s{};  ///< time in a motion
};

/// Adds --queries and --output.
struct QueryOptions {
  OptionalPath file, output;
  /// @param excluded  options that --queries excludes
  void add_to(CLI::App& command, const std::vector<std::string>& excluded);
};

/// The functions and texts that answer a file of queries.
struct QueryAnswers {
  std::string command;  ///< name in the progress line
  std::string columns;  ///< columns after those of the query: ",fx_N,fy_N,fz_N,..."
  /// @throws Error (input) if this query cannot be answered
  std::function<void(const Query&)> check;
  /// The columns of a motion, for which `answer` is called in the order of the rows.
  std::string motion_columns;
  /// The columns after those of the query, beginning with a comma; empty after a stop request.
  std::function<std::optional<std::string>(const Query&)> answer;
};

/// Checks all rows, answers them in order, and writes them to stdout or to OUTPUT.part, which is renamed when it is
/// complete. An early end keeps the finished rows there; SIGKILL may truncate the last line.
/// @throws Error (input) with the file and the line of the first invalid row, before anything is answered; (failure)
/// after a signal, with the number of rows that are finished and where they are; if the file cannot be written
void answer_queries(const QueryOptions& options, const QueryAnswers& answers);

}  // namespace phynness::cli
