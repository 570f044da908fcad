#include "query_table.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/text_file.hpp>
#include <sstream>
#include <vector>

#include "console.hpp"

namespace phynness::cli {
namespace {

/// @param check  called with each row. @throws Error (input) with the line of the first that cannot be answered
std::vector<Query> read_queries(const std::filesystem::path& file, const std::function<void(const Query&)>& check) {
  const auto remedy = fmt::format("give a CSV file whose first line is {}", queries_header);
  std::istringstream in(
      read_input_file(file, {"the file of queries", remedy, std::numeric_limits<std::uint64_t>::max(), true}));
  std::vector<Query> queries;
  std::string line;
  std::size_t number = 0;
  const auto error = [&](const std::string& what, std::string_view value, const std::string& to_do) {
    return input_error(fmt::format("{}, line {}: {}", file.string(), number, what), fmt::format("'{}'", value), to_do);
  };
  const auto next_line = [&] {  // its end may be "\n" or "\r\n"
    ++number;
    if (!std::getline(in, line)) return false;
    if (line.ends_with('\r')) line.pop_back();
    return true;
  };
  const bool has_header = next_line();
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // spreadsheets write a byte order mark
  const bool moves = has_header && line == motion_header;
  if (!moves && (!has_header || line != queries_header))
    throw error("the first line of a file of queries is wrong", line,
                fmt::format("make the first line {}, or of a motion {}", queries_header, motion_header));
  const char* const header = moves ? motion_header : queries_header;
  const std::size_t n_fields = moves ? 5 : 4;
  while (next_line()) {
    const auto fields = fields_of(line);
    if (fields.size() != n_fields)
      throw error(fmt::format("a row must have {} values, not {}", n_fields, line.empty() ? 0 : fields.size()), line,
                  fmt::format("write {}, without empty lines", header));
    Query query;
    if (!parse_number(fields[0], query.node))
      throw error("a node must be an integer", fields[0], "give the number of a node of the mesh, starting with 0");
    auto& d = query.displacement_m;
    for (std::size_t k = 0; k < 3; ++k)
      if (!parse_number(fields[k + 1], d[k]) || !std::isfinite(d[k]))
        throw error("a displacement must be three finite numbers", fields[k + 1],
                    "write metres with a decimal point: 0.0,0.0,-0.01");
    if (std::hypot(d[0], d[1], d[2]) > largest_displacement_m)
      throw error(fmt::format("a displacement is longer than {:g} m", largest_displacement_m), line,
                  "give displacements in metres");
    if (moves) {
      const double before = queries.empty() ? 0 : *queries.back().time_s;
      if (!parse_number(fields[4], query.time_s.emplace()) || !(*query.time_s > before) || *query.time_s > 1e9)
        throw error("a time must be above 0 s, later than that of the row before, and at most 1e9 s", fields[4],
                    "sort the rows by time; the body is at rest at the time 0, which has no row");
    }
    try {
      check(query);
    } catch (const Error& invalid) {
      throw input_error(fmt::format("{}, line {}: {}", file.string(), number, invalid.what()), "", "");
    }
    queries.push_back(query);
  }
  if (queries.empty())
    throw input_error("the file of queries has no rows", file.string(),
                      "write a row for each query below the first line");
  return queries;
}

/// The output table. A file is written as OUTPUT.part until the table is complete. Every row is written at once, so
/// that a killed process loses none.
class Table {
 public:
  Table(const OptionalPath& output, const std::string& columns) {
    if (output) _part = _file.emplace(*output).keep();
    add(fmt::format("{}{}\n", queries_header, columns));
  }

  void add(const std::string& text) {
    if (_file)
      _file->append(text);
    else
      _lost = !write_stdout(text);
  }
  bool is_lost() const { return _lost; }
  void finish() {
    if (_file) _file->put();
  }
  /// Marks the table as incomplete. @return where the rows are
  std::string mark_incomplete(const std::string& progress_text) {
    if (_file) return "in " + _part.string();
    add(fmt::format("interrupted: {}\n", progress_text));
    return "on stdout, whose last line says so";
  }

 private:
  std::optional<GrowingTextFile> _file;
  std::filesystem::path _part;
  bool _lost = false;
};

}  // namespace

void QueryOptions::add_to(CLI::App& command, const std::vector<std::string>& excluded) {
  auto* queries = add_path(
      command, "--queries", file, PathKind::input,
      fmt::format("CSV file of many queries, instead of --node; its first line is {}, or of the motion of one tool\n"
                  "{}, whose forces relax; writes a CSV table of forces",
                  queries_header, motion_header));
  add_path(command, "-o,--output", output, PathKind::file, "file of the table of --queries (default: stdout)")
      ->needs(queries);
  for (const auto& option : excluded) queries->excludes(command.get_option(option));
}

void answer_queries(const QueryOptions& options, const QueryAnswers& answers) {
  const auto queries = read_queries(*options.file, answers.check);
  const auto total = std::ssize(queries);
  const bool moves = queries.front().time_s.has_value();
  install_stop_handler();
  Table table(options.output, (moves ? ",time_s" : "") + (moves ? answers.motion_columns : answers.columns));
  Progress progress(answers.command, "rows");
  const auto start = std::chrono::steady_clock::now();
  std::int64_t finished = 0;
  for (const auto& query : queries) {
    if (stop_requested() || table.is_lost()) break;
    const auto row = answers.answer(query);
    if (!row) break;
    const auto& [node, d, time_s] = query;
    table.add(fmt::format("{},{},{},{}{}{}\n", node, d[0], d[1], d[2], moves ? fmt::format(",{}", *time_s) : "", *row));
    ++finished;
    // No progress line for files that take less than two seconds.
    if (std::chrono::steady_clock::now() - start > std::chrono::seconds(2)) progress.update(finished, total);
  }
  if (table.is_lost()) return;  // finish_streams() reports it
  if (finished < total) {
    const auto progress_text = fmt::format("{} of {} rows are finished", finished, total);
    throw failure(
        answers.command + " was interrupted",
        fmt::format("{}, {}", progress_text, table.mark_incomplete(progress_text)),
        "run the command again; to keep these rows, give that file another name and the command the other rows");
  }
  table.finish();
}

}  // namespace phynness::cli
