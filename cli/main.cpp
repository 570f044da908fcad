// The command `phynness`. Messages go to stderr. Exit status: 0 success, 1 failure, 2 wrong usage or input.
#include <phynness/formats/error.hpp>
#include <phynness/formats/version.hpp>
#include <sstream>

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
  cli::print_result("{}", results.str());
}

int end_with(const Error& error) {
  // Ranks other than the first have no text, so that the reason is printed once.
  if (*error.what() != 0) cli::message("error: {}\n", error.what());
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
  app.parse_complete_callback([&app] { cli::check_files(app); });
  try {
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
