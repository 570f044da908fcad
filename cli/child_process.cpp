#include "child_process.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "commands.hpp"

namespace phynness::cli {
namespace {

constexpr int not_started = 127;  // as of a shell

/// @return the exit status
int execute(const std::string& title, const std::vector<std::string>& arguments, bool quiet) {
  std::vector<char*> argv;
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) return not_started;
  if (child == 0) {
    // A stage ends in an orderly way when this process is gone, also after kill -9.
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    if (const int nowhere = quiet ? open("/dev/null", O_WRONLY) : -1; nowhere >= 0)
      dup2(nowhere, STDOUT_FILENO);
    else if (results_are_on_stderr())
      dup2(STDERR_FILENO, STDOUT_FILENO);
    execvp(argv[0], argv.data());
    _exit(not_started);
  }
  int status = 0;
  // Each signal is passed on. The first makes the child stop in an orderly way, the second kills it.
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    if (stop_requested()) kill(child, SIGTERM);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  if (!stop_requested()) message("error: {} was ended by signal {}\n", title, WTERMSIG(status));
  return 1;
}

}  // namespace

void leave_to_solver(char**) {}  // it is this program

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
  const int exit_status = execute(title, arguments, quiet);
  if (exit_status == not_started)
    throw failure("the program cannot be started", arguments[0], ranks > 1 ? "install Open MPI, or use --ranks 1" : "");
  if (stop_requested())
    throw failure("interrupted in stage " + title, "solved rays are kept",
                  "run the same command with --resume to continue");
  const std::string remedy = "when its cause is mended, run the same command with --resume";
  if (exit_status == 2) throw input_error("stopped in stage " + title, "see the message above", remedy);
  if (exit_status != 0) throw failure("stopped in stage " + title, "see the message above", remedy);
}

}  // namespace phynness::cli
