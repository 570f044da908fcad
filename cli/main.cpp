// The command `phynness`. Messages go to stderr. Exit status: 0 success, 1 failure, 2 wrong usage or input.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <phynness/formats/version.hpp>
#include <sstream>
#include <string_view>
#include <thread>

#include "commands.hpp"

namespace phynness {
namespace {

/// The name in CLI11's message "MODEL_DIR is required"; empty for other messages.
std::string missing_name(const CLI::ParseError& error) {
  constexpr std::string_view end = " is required";
  const std::string_view text = error.what();
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::RequiredError) || !text.ends_with(end)) return "";
  return std::string(text.substr(0, text.size() - end.size()));
}

/// Converts an error of CLI11. @param app  state after the failed parse
Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const auto commands = app.get_subcommands();
  const std::string command = commands.empty() ? "phynness" : "phynness " + commands.back()->get_name();
  const auto extras = app.remaining(true);
  // A misspelt required option gives a missing option and two unknown words; the error contains both.
  const auto extra_words = fmt::format("{}", fmt::join(extras, " "));
  const auto missing = missing_name(error);
  if (missing == "A subcommand")
    return input_error("a subcommand is missing", extras.empty() ? "" : "not known: " + extra_words,
                       "phynness --help lists the subcommands");
  if (!missing.empty())
    return input_error("an argument is missing", missing + (extras.empty() ? "" : " (not known: " + extra_words + ")"),
                       fmt::format("add {}; {} --help describes it", missing, command));
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError))
    return input_error(command + " has no such option, or takes fewer arguments", extra_words,
                       command + " --help lists its arguments and options");
  return input_error("the command line cannot be used", error.what(),
                     command + " --help lists the options and the values that they take");
}

/// The commands whose ranks share the work. Under mpirun each rank of any other would write the same files.
constexpr std::string_view commands_for_ranks[] = {"precompute", "calibrate", "reduce", "validate"};

/// Refuses to run on several ranks, which environment variables tell without MPI. @throws Error (input)
void refuse_ranks(const CLI::App& app) {
  const auto command = app.get_subcommands().at(0)->get_name();
  if (std::ranges::find(commands_for_ranks, command) != std::end(commands_for_ranks)) return;
  for (const auto& [size, rank] : {std::pair{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                   {"PMI_SIZE", "PMI_RANK"},
                                   {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"}}) {
    const char *ranks = std::getenv(size), *own = std::getenv(rank);
    if (!ranks || std::atoi(ranks) < 2) continue;
    // The launcher ends the other ranks after the first one has printed the reason.
    if (own && std::atoi(own) > 0) std::this_thread::sleep_for(std::chrono::seconds(2));
    throw input_error(command + " must run as one process", fmt::format("{} ranks ({} = {})", ranks, size, ranks),
                      "start it without mpirun; run --ranks starts mpirun itself");
  }
}

int end_with(const Error& error) {
  // Only the first rank has a message, so that the reason is printed once.
  if (*error.what() != 0)
    cli::message("error: {}\n", error.what());
  else  // the first rank needs time for its message, because the launcher ends it when another one ends
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  return error.kind() == Error::Kind::input ? 2 : 1;
}

/// @return the exit status
int run_command_line(int argc, char** argv) {
  CLI::App app{
      "Precomputes the response of soft bodies with finite elements, trains networks on it, and measures their\n"
      "errors. Start with: phynness run scenes/demo.toml -o out"};
  app.name("phynness");
  app.set_version_flag("--version", software_version());
  app.require_subcommand(1);
#define PHYNNESS_ADD(name) cli::name##_command::add(app);
  PHYNNESS_COMMANDS(PHYNNESS_ADD)
  // The callback is called after parsing and before the subcommand is executed.
  app.parse_complete_callback([&app] {
    refuse_ranks(app);
    cli::check_files();
  });
  try {
    cli::exec_solver_program(argv);
    const auto names = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(names).empty())
      throw input_error("there is no such subcommand", argv[1], "phynness --help lists the subcommands");
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return end_with(usage_error(app, error));
    std::ostringstream results, messages;  // help or the version, which CLI11 throws like errors
    app.exit(error, results, messages);
    cli::write_stdout(results.str());
    return 0;
  } catch (const Error& error) {
    return end_with(error);
  } catch (const std::bad_alloc&) {
    cli::message("error: out of memory\n  remedy: use a coarser mesh, fewer output nodes or a larger machine\n");
    return 1;
  } catch (const std::exception& error) {
    cli::message("error: {}\n  remedy: this is a defect; please report it together with the scene\n", error.what());
    return 1;
  } catch (...) {  // gmsh throws strings
    cli::message("error: a library failed without a message\n  remedy: please report it together with the scene\n");
    return 1;
  }
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  phynness::cli::prepare_streams();
  return phynness::cli::finish_streams(phynness::run_command_line(argc, argv));
}
