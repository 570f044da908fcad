#include "eval_queries.hpp"

#include <fmt/core.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <iterator>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <sstream>
#include <string_view>

#include "commands.hpp"
#include "console.hpp"
#include "streams.hpp"

namespace phynness::cli {
namespace {

struct Query {
  std::int32_t node = 0;
  Vec3 displacement_m{};
  std::size_t line = 0;  ///< in the file, starting with 1
};

/// A file of queries and the present line, for error messages.
struct Place {
  const std::filesystem::path& file;
  std::size_t line = 0;

  Error error(const std::string& what, const std::string& value, const std::string& remedy) const {
    return input_error(fmt::format("{}, line {}: {}", file.string(), line, what), value, remedy);
  }
};

/// Values between commas, without surrounding spaces.
std::vector<std::string_view> fields_of(std::string_view row) {
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at <= row.size();) {
    const auto end = std::min(row.find(',', at), row.size());
    auto field = row.substr(at, end - at);
    field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
    field.remove_suffix(field.size() - (field.find_last_not_of(' ') + 1));
    fields.push_back(field);
    at = end + 1;
  }
  return fields;
}

template <class Number>
bool parse(std::string_view field, Number& number) {
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), number);
  return code == std::errc{} && end == field.data() + field.size();
}

Query parse_row(std::string_view row, const Place& place) {
  const auto fields = fields_of(row);
  if (fields.size() != 4)
    throw place.error(fmt::format("a row must have 4 values, not {}", row.empty() ? 0 : fields.size()),
                      fmt::format("'{}'", row), fmt::format("write {}, without empty lines", queries_header));
  Query query;
  query.line = place.line;
  if (!parse(fields[0], query.node))
    throw place.error("a node must be an integer", fmt::format("'{}'", fields[0]),
                      "give the number of a node of the mesh, starting with 0");
  for (std::size_t k = 0; k < 3; ++k)
    if (!parse(fields[k + 1], query.displacement_m[k]) || !std::isfinite(query.displacement_m[k]))
      throw place.error("a displacement must be three finite numbers", fmt::format("'{}'", fields[k + 1]),
                        "write metres with a decimal point: 0.0,0.0,-0.01");
  const auto& d = query.displacement_m;
  if (std::hypot(d[0], d[1], d[2]) > largest_displacement_m)
    throw place.error(fmt::format("a displacement is longer than {:g} m", largest_displacement_m),
                      fmt::format("'{}'", row), "give displacements in metres");
  return query;
}

/// The next line without its end, which may be "\n" or "\r\n". @throws Error (input) if it is far longer than a query
bool next_line(std::istream& in, std::string& line, Place& place) {
  constexpr std::size_t most_bytes = 4096;
  line.clear();
  ++place.line;
  int c = in.get();
  if (c == std::istream::traits_type::eof()) return false;
  for (; c != std::istream::traits_type::eof() && c != '\n'; c = in.get()) {
    if (line.size() == most_bytes)
      throw place.error("a line is too long", fmt::format("more than {} bytes", most_bytes),
                        fmt::format("give a CSV file whose first line is {}", queries_header));
    line += static_cast<char>(c);
  }
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

std::vector<Query> read_queries(const std::filesystem::path& file) {
  constexpr std::uint64_t most_bytes = 1 << 30;  // some twenty million queries
  const auto remedy = fmt::format("give a CSV file whose first line is {}", queries_header);
  std::istringstream in(read_input_file(file, {"the file of queries", remedy, most_bytes, true}));
  Place place{file};
  std::string line;
  const bool has_header = next_line(in, line, place);
  // Spreadsheets write a byte order mark of UTF-8.
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
  if (!has_header || line != queries_header) {
    place.line = 1;
    throw place.error("the first line of a file of queries is wrong", fmt::format("'{}'", line),
                      fmt::format("make the first line {}", queries_header));
  }
  std::vector<Query> queries;
  while (next_line(in, line, place)) queries.push_back(parse_row(line, place));
  if (queries.empty())
    throw input_error("the file of queries has no rows", file.string(),
                      "write a row for each query below the first line");
  return queries;
}

/// Checks all nodes before anything is computed. @throws Error (input) if a node is not active
void check_nodes(const LoadedModel& model, const std::vector<Query>& queries, const std::filesystem::path& file) {
  for (const auto& query : queries) try {
      model.force(query.node, {0, 0, 0});
    } catch (const Error& error) {
      throw Place{file, query.line}.error(error.what(), "", "");
    }
}

}  // namespace

void answer_queries(const LoadedModel& model, const std::filesystem::path& file) {
  const auto queries = read_queries(file);
  check_nodes(model, queries, file);
  const bool has_energy = model.runtime().info().has_energy != 0;
  const bool has_bounds = model.has_bounds();
  std::string csv = fmt::format("{},fx_N,fy_N,fz_N{},status,trained_depth_m{}\n", queries_header,
                                has_energy ? ",energy_J" : "", has_bounds ? ",bound_N" : "");
  const auto out = std::back_inserter(csv);
  const auto start = std::chrono::steady_clock::now();
  Progress progress("eval", "queries");
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const auto& [node, d, line] = queries[i];
    Vec3 f{};
    double energy = 0;
    const rt::Status status = has_energy ? model.data().force(node, d, f, energy) : model.data().force(node, d, f);
    if (!status.ok())
      throw Place{file, line}.error(status.message(), fmt::format("node {}", node), "give a smaller displacement");
    fmt::format_to(out, "{},{},{},{},{},{},{},", node, d[0], d[1], d[2], f[0], f[1], f[2]);
    if (has_energy) fmt::format_to(out, "{},", energy);
    fmt::format_to(out, "{},{}", int{status}, model.trained_depth(node, d));
    const auto known = has_bounds ? model.error_bound(node, d) : std::nullopt;
    if (has_bounds) csv += ',';
    if (known) fmt::format_to(out, "{}", *known);
    csv += '\n';
    // No progress line for files that take less than two seconds.
    if (std::chrono::steady_clock::now() - start > std::chrono::seconds(2))
      progress.update(static_cast<std::int64_t>(i + 1), static_cast<std::int64_t>(queries.size()));
  }
  print_result("{}", csv);
}

}  // namespace phynness::cli
