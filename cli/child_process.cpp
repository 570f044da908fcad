#include "child_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <phynness/formats/error.hpp>
#include <thread>

#include "console.hpp"
#include "streams.hpp"

extern char** environ;

namespace phynness::cli {
namespace {

struct ProcessResult {
  bool started = false;
  int exit_status = 1;
};

ProcessResult execute(const std::vector<std::string>& arguments, bool quiet) {
  std::vector<char*> argv;
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  if (quiet)
    posix_spawn_file_actions_addopen(&streams, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  else if (results_are_on_stderr())
    posix_spawn_file_actions_adddup2(&streams, STDERR_FILENO, STDOUT_FILENO);
  const int code = posix_spawnp(&child, argv[0], &streams, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&streams);
  if (code != 0) return {};
  int status = 0;
  // Each signal is passed on. The first makes the child stop in an orderly way, the second kills it.
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    if (stop_requested()) kill(child, SIGTERM);
  return {true, WIFEXITED(status) ? WEXITSTATUS(status) : 1};
}

}  // namespace

std::string this_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

void prepare_environment(int ranks) {
  report_stdout_for_children();
  if (isatty(STDERR_FILENO)) setenv("PHYNNESS_PROGRESS", "1", 0);
  if (ranks <= 1) return;
  setenv("OMP_NUM_THREADS", "1", 0);
  if (geteuid() == 0) {  // Open MPI requires both variables
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  }
}

void run_child(const std::string& title, std::vector<std::string> arguments, int ranks, bool quiet) {
  if (ranks > 1) {
    std::vector<std::string> launcher{"mpirun", "-n", std::to_string(ranks)};
    if (ranks > static_cast<int>(std::thread::hardware_concurrency())) launcher.push_back("--oversubscribe");
    arguments.insert(arguments.begin(), launcher.begin(), launcher.end());
  }
  const auto result = execute(arguments, quiet);
  if (!result.started)
    throw failure("the program cannot be started", arguments[0], ranks > 1 ? "install Open MPI, or use --ranks 1" : "");
  if (result.exit_status != 0 && stop_requested())
    throw failure("interrupted in stage " + title, "finished results are kept",
                  "run the same command again to continue");
  if (result.exit_status == 2) throw input_error("stopped in stage " + title, "see the message above", "");
  if (result.exit_status != 0) throw failure("stopped in stage " + title, "see the message above", "");
}

}  // namespace phynness::cli
