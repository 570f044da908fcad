// The command `phynness`. Messages go to stderr. Exit status: 0 success, 1 failure, 2 wrong usage or input.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <phynness/formats/error.hpp>
#include <phynness/formats/version.hpp>
#include <sstream>
#include <string_view>
#include <thread>

#include "command_files.hpp"
#include "commands.hpp"
#include "streams.hpp"
#include "usage_error.hpp"

namespace phynness {
namespace {

bool is_subcommand(const CLI::App& app, const std::string& word) {
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (command->get_name() == word) return true;
  return false;
}

void add_commands(CLI::App& app) {
  cli::mesh_command::add(app);
  cli::check_command::add(app);
  cli::plan_command::add(app);
  cli::precompute_command::add(app);
  cli::merge_command::add(app);
  cli::train_command::add(app);
  cli::calibrate_command::add(app);
  cli::validate_command::add(app);
  cli::tune_command::add(app);
  cli::eval_command::add(app);
  cli::bench_command::add(app);
  cli::solve_command::add(app);
  cli::export_command::add(app);
  cli::info_command::add(app);
  cli::show_command::add(app);
  cli::view_command::add(app);
  cli::run_command::add(app);
}

/// Prints help or the version, which CLI11 throws like errors.
void print_help(const CLI::App& app, const CLI::ParseError& call) {
  std::ostringstream results, messages;
  app.exit(call, results, messages);
  cli::write_stdout(results.str());
}

/// The commands whose ranks share the work. Under mpirun each rank of any other would write the same files.
constexpr std::string_view commands_for_ranks[] = {"precompute", "calibrate", "validate"};

/// MPI itself is not asked, because most commands do without it. @throws Error (input)
void refuse_ranks(const CLI::App& app) {
  const auto command = app.get_subcommands().at(0)->get_name();
  if (std::find(std::begin(commands_for_ranks), std::end(commands_for_ranks), command) != std::end(commands_for_ranks))
    return;
  for (const auto& [size, rank] : {std::pair{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                   {"PMI_SIZE", "PMI_RANK"},
                                   {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"}}) {
    const char *ranks = std::getenv(size), *own = std::getenv(rank);
    if (!ranks || std::atoi(ranks) < 2) continue;
    // The launcher ends the other ranks when the first has given the reason.
    if (own && std::atoi(own) > 0) std::this_thread::sleep_for(std::chrono::seconds(2));
    throw input_error(command + " must run as one process", fmt::format("{} ranks ({} = {})", ranks, size, ranks),
                      "start it without mpirun; run --ranks starts mpirun itself");
  }
}

int end_with(const Error& error) {
  // Ranks other than the first have no text, so that the reason is printed once.
  if (*error.what() != 0)
    cli::message("error: {}\n", error.what());
  else  // the launcher ends the first rank, which gives the reason, as soon as another one has ended
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
  add_commands(app);
  // Called after the whole line has been parsed and before the subcommand is executed.
  app.parse_complete_callback([&app] {
    refuse_ranks(app);
    cli::check_files(app);
  });
  try {
    cli::leave_to_solver(argv);
    if (argc > 1 && argv[1][0] != '-' && !is_subcommand(app, argv[1]))
      throw input_error("there is no such subcommand", argv[1], "phynness --help lists the subcommands");
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return end_with(cli::usage_error(app, error));
    print_help(app, error);
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
