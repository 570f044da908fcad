// The subcommands that need dolfinx, in the program without it: the program with the solver executes them. In a build
// without dolfinx they report that they are missing.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "reduce_command.hpp"

namespace phynness::cli {
namespace {

void add_refusal(CLI::App& app, const std::string& name) {
  auto* command = app.add_subcommand(name, "(not in this build, because it needs dolfinx)");
  command->allow_extras();
  command->callback([name] {
    throw input_error("this build has no finite element solver", "phynness " + name,
                      "build with -DPHYNNESS_WITH_DOLFINX=ON on a machine that has dolfinx");
  });
}

}  // namespace

#define PHYNNESS_REFUSE(name) \
  void name##_command::add(CLI::App& app) { add_refusal(app, #name); }
PHYNNESS_SOLVER_COMMANDS(PHYNNESS_REFUSE)

std::optional<Reduced> reduced(const std::filesystem::path& database, const ReductionSpec& spec, std::optional<double>,
                               int) {
  message("note: without a finite element solver there are no modes of several tools, and errors are not known\n");
  Progress progress("reduce", "steps");
  Reduced made;
  made.body = reduce(Database::open(database), {}, spec, made.report, progress.counter());
  return made;
}

void exec_solver_program(char** argv) {
#define PHYNNESS_NAME(name) #name,
  constexpr std::string_view commands[] = {PHYNNESS_SOLVER_COMMANDS(PHYNNESS_NAME) "reduce"};
  // Help and the version are texts of all subcommands together.
  if (!PHYNNESS_SOLVER || (argv[1] && argv[1][0] != '-' && std::ranges::find(commands, argv[1]) == std::end(commands)))
    return;
  const auto program = std::filesystem::read_symlink("/proc/self/exe").replace_filename("phynness-solver");
  execv(program.c_str(), argv);
  throw failure("the program with the solver cannot be started", program.string() + ": " + std::strerror(errno),
                "cmake --install lays it beside the program phynness; keep them together");
}

}  // namespace phynness::cli
