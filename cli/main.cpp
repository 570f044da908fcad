// phynness: the one command. Messages go to stderr; exit status 0 success, 1 failure, 2 wrong usage or input.
#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/formats/version.hpp>

#include "commands.hpp"
#include "console.hpp"

int main(int argc, char** argv) {
  using namespace phynness;
  CLI::App app{
      "Precomputes the response of soft bodies with finite elements, condenses it into networks, and checks "
      "what\n"
      "they are worth. Start with: phynness run scenes/demo.toml -o out"};
  app.name("phynness");
  app.set_version_flag("--version", software_version());
  app.require_subcommand(1);
  cli::add_mesh_command(app);
  cli::add_precompute_command(app);
  cli::add_train_command(app);
  cli::add_validate_command(app);
  cli::add_eval_command(app);
  cli::add_solve_command(app);
  cli::add_info_command(app);
  cli::add_run_command(app);
  cli::install_stop_handler();

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return error.kind() == Error::Kind::input ? 2 : 1;
  } catch (const std::bad_alloc&) {
    fmt::print(
        stderr,
        "error: out of memory\n  remedy: use a coarser mesh, fewer output nodes or a larger machine\n");
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n  remedy: this is a defect; please report it with the scene\n",
               error.what());
    return 1;
  }
}
