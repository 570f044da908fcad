#include <fmt/core.h>

#include <charconv>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "shown_response.hpp"
#include "streams.hpp"

namespace phynness::cli::show_command {
namespace {

struct Options {
  std::filesystem::path database, output;
  std::int32_t node = 0;
  int direction = 0;
  std::string increment;
};

/// Whether the file is a collection of all increments. @throws Error (input) if its extension is unknown
bool is_collection(const std::filesystem::path& file) {
  const auto extension = file.extension();
  if (extension != ".pvd" && extension != ".vtu")
    throw input_error("the format of the output is unknown", file.string(),
                      "give -o a name that ends in .pvd (all increments) or in .vtu (one increment)");
  return extension == ".pvd";
}

/// Empty: all increments.
std::optional<int> wanted_increment(const std::string& word) {
  if (word.empty() || word == "all") return {};
  int number = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (code != std::errc{} || end != word.data() + word.size())
    throw input_error("--increment is neither a number nor 'all'", "'" + word + "'",
                      "give for example --increment 3, or --increment all");
  return number;
}

void write_collection(const ShownResponse& shown, const std::filesystem::path& file) {
  std::vector<std::string> names;
  std::vector<double> times;
  for (std::size_t i = 0; i < shown.states.size(); ++i) {
    names.push_back(fmt::format("{}-{:04d}.vtu", file.stem().string(), shown.increments[i]));
    times.push_back(shown.states[i].time);
    declare_output("--output", file.parent_path() / names.back());
  }
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  for (std::size_t i = 0; i < shown.states.size(); ++i)
    files.emplace_back(file.parent_path() / names[i], vtu_text(shown.grid, shown.states[i]));
  // The last to get its name, so that it never refers to a missing file.
  files.emplace_back(file, pvd_text(names, times));
  write_text_files(files);
}

void run(const Options& options) {
  const bool all = is_collection(options.output);
  if (!all && options.increment == "all")
    throw input_error("this format can only hold one increment", options.output.string(),
                      "write all increments to a file that ends in .pvd");
  const auto database = Database::open(options.database);
  auto shown = shown_response(database, options.node, options.direction, wanted_increment(options.increment));
  if (!all) {
    shown.states.erase(shown.states.begin(), shown.states.end() - 1);
    shown.increments.erase(shown.increments.begin(), shown.increments.end() - 1);
  }
  for (const auto& note : shown.notes) message("note: {}\n", note);
  const auto& header = database.header();
  const auto& e = header.directions[static_cast<std::size_t>(options.direction)];
  const auto title =
      fmt::format("node {}, direction {} ({:.3g} {:.3g} {:.3g})", options.node, options.direction, e[0], e[1], e[2]);
  if (all)
    write_collection(shown, options.output);
  else
    write_text_file(options.output, vtu_text(shown.grid, shown.states.back()));
  const auto& cells = shown.grid.cells;
  print_result(
      "{}: {} points, {} {}, {} increment{} to {:.4g} m -> {}\n", title, shown.grid.points.rows(), cells.rows(),
      cells.cols() == 4   ? "tetrahedra"
      : cells.cols() == 3 ? "triangles"
                          : "vertices",
      shown.states.size(), shown.states.size() == 1 ? "" : "s", shown.states.back().time, options.output.string());
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("show", "Write a stored response for ParaView: PVD or VTU");
  add_path(*command, "DATABASE", options->database, InputKind::whole, "finished database.h5")->required();
  command->add_option("--node", options->node, "number of an active node, starting with 0")->required();
  command->add_option("--direction", options->direction, "number of the direction, starting with 0")->required();
  command->add_option("--increment", options->increment,
                      "number of the increment, starting with 1, or all (default: all in .pvd, the last "
                      "converged one in .vtu)");
  add_path(
      *command, "-o,--output", options->output, OutputKind::file,
      "file to write: .pvd (with .vtu files in the same folder) or .vtu; its time is the prescribed displacement [m]")
      ->required();
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::show_command
