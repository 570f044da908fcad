#include "query_table.hpp"

#include <fmt/core.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/text_file.hpp>
#include <vector>

#include "console.hpp"

namespace phynness::cli {
namespace {

/// The rows of a file of queries, one after another, and the place of the present one for messages.
class QueryReader {
 public:
  /// @throws Error (input) unless the file can be read and has the right first line
  explicit QueryReader(const std::filesystem::path& file) : _file(file) {
    const auto remedy = fmt::format("give a CSV file whose first line is {}", queries_header);
    require_input_file(file, {"the file of queries", remedy, std::numeric_limits<std::uint64_t>::max(), true});
    _in.open(file, std::ios::binary);
    const bool has_header = next_line();
    // Spreadsheets write a byte order mark of UTF-8.
    if (_line.starts_with("\xEF\xBB\xBF")) _line.erase(0, 3);
    if (!has_header || _line != queries_header)
      throw error("the first line of a file of queries is wrong", fmt::format("'{}'", _line),
                  fmt::format("make the first line {}", queries_header));
  }

  /// Empty: the file has no more rows. @throws Error (input) with the line
  std::optional<Query> next() {
    if (!next_line()) return {};
    return parsed();
  }

  Error error(const std::string& what, const std::string& value, const std::string& remedy) const {
    return input_error(fmt::format("{}, line {}: {}", _file.string(), _number, what), value, remedy);
  }

 private:
  /// The next line without its end, which may be "\n" or "\r\n".
  bool next_line() {
    constexpr std::size_t most_bytes = 4096;
    ++_number;
    if (!std::getline(_in, _line)) return false;
    if (_line.size() >= most_bytes)
      throw error("a line is too long", fmt::format("more than {} bytes", most_bytes),
                  fmt::format("give a CSV file whose first line is {}", queries_header));
    if (const auto at = _line.find('\0'); at != std::string::npos)
      throw error("the file of queries holds a zero byte, which no text has", fmt::format("byte {} of the line", at),
                  "it is damaged or no text file: write or copy it again");
    if (_line.ends_with('\r')) _line.pop_back();
    return true;
  }

  Query parsed() const {
    const auto fields = fields_of(_line);
    if (fields.size() != 4)
      throw error(fmt::format("a row must have 4 values, not {}", _line.empty() ? 0 : fields.size()),
                  fmt::format("'{}'", _line), fmt::format("write {}, without empty lines", queries_header));
    Query query;
    if (!parse_number(fields[0], query.node))
      throw error("a node must be an integer", fmt::format("'{}'", fields[0]),
                  "give the number of a node of the mesh, starting with 0");
    auto& d = query.displacement_m;
    for (std::size_t k = 0; k < 3; ++k)
      if (!parse_number(fields[k + 1], d[k]) || !std::isfinite(d[k]))
        throw error("a displacement must be three finite numbers", fmt::format("'{}'", fields[k + 1]),
                    "write metres with a decimal point: 0.0,0.0,-0.01");
    if (std::hypot(d[0], d[1], d[2]) > largest_displacement_m)
      throw error(fmt::format("a displacement is longer than {:g} m", largest_displacement_m),
                  fmt::format("'{}'", _line), "give displacements in metres");
    return query;
  }

  std::filesystem::path _file;
  std::ifstream _in;
  std::string _line;
  std::size_t _number = 0;
};

/// @return the number of rows. @throws Error (input) with the line of the first that cannot be answered
std::int64_t check_rows(const std::filesystem::path& file, const std::function<void(const Query&)>& check) {
  QueryReader reader(file);
  std::int64_t n = 0;
  for (; const auto query = reader.next(); ++n) try {
      check(*query);
    } catch (const Error& error) {
      throw reader.error(error.what(), "", "");
    }
  if (n == 0)
    throw input_error("the file of queries has no rows", file.string(),
                      "write a row for each query below the first line");
  return n;
}

/// The table that is written. A file is filled in OUTPUT.part, which stays there unless the table is complete. A row
/// leaves the process at once, so that one that is killed loses none.
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
  void put() {
    if (_file) _file->put();
  }
  /// Leaves the table so that nobody takes it for a complete one. @return where the rows are
  std::string leave(const std::string& how_much) {
    if (_file) return "in " + _part.string();
    add(fmt::format("interrupted: {}\n", how_much));
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
      fmt::format("CSV file of many queries, instead of --node; its first line is {}; writes a CSV table of forces",
                  queries_header));
  add_path(command, "-o,--output", output, PathKind::file, "file of the table of --queries (default: stdout)")
      ->needs(queries);
  for (const auto& option : excluded) queries->excludes(command.get_option(option));
}

void answer_queries(const QueryOptions& options, const QueryAnswers& answers) {
  const auto total = check_rows(*options.file, answers.check);
  install_stop_handler();
  Table table(options.output, answers.columns);
  Progress progress(answers.command, "rows");
  QueryReader reader(*options.file);
  const auto start = std::chrono::steady_clock::now();
  std::int64_t finished = 0;
  while (!stop_requested() && !table.is_lost()) {
    const auto query = reader.next();
    const auto answer = query ? answers.answer(*query) : std::nullopt;
    if (!answer) break;
    const auto& [node, d] = *query;
    table.add(fmt::format("{},{},{},{}{}\n", node, d[0], d[1], d[2], *answer));
    ++finished;
    // No progress line for files that take less than two seconds.
    if (std::chrono::steady_clock::now() - start > std::chrono::seconds(2)) progress.update(finished, total);
  }
  if (table.is_lost()) return;  // finish_streams() reports it
  if (stop_requested() && finished < total) {
    const auto how_much = fmt::format("{} of {} rows are finished", finished, total);
    throw failure(
        answers.command + " was interrupted", fmt::format("{}, {}", how_much, table.leave(how_much)),
        "run the command again; to keep these rows, give that file another name and the command the other rows");
  }
  if (finished != total)
    throw failure("the file of queries was changed while it was read", options.file->string(),
                  "run the command again when nothing writes to it");
  table.put();
}

}  // namespace phynness::cli
