// mesh, precompute, train, validate in one go: each a subcommand of its own in a process of its own, so that
// the parallel stages run under mpirun while training uses threads.
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <thread>

#include "commands.hpp"
#include "console.hpp"

extern char** environ;

namespace phynness::cli {
namespace {

struct Options {
  std::filesystem::path scene, output;
  int ranks = 1;
  bool resume = false;
};

struct ProcessResult {
  bool started = false;
  int exit_status = 1;
};

ProcessResult execute(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  const int code = posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ);
  if (code != 0) return {};
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    if (stop_requested()) kill(child, SIGTERM);
  return {true, WIFEXITED(status) ? WEXITSTATUS(status) : 1};
}

void stage(const char* title, std::vector<std::string> arguments, int ranks) {
  fmt::print("\n== {}\n", title);
  std::fflush(stdout);
  if (ranks > 1) {
    std::vector<std::string> launcher{"mpirun", "-n", std::to_string(ranks)};
    if (ranks > static_cast<int>(std::thread::hardware_concurrency())) launcher.push_back("--oversubscribe");
    arguments.insert(arguments.begin(), launcher.begin(), launcher.end());
  }
  const auto result = execute(arguments);
  if (!result.started)
    throw failure("cannot start", arguments[0], ranks > 1 ? "install Open MPI, or use --ranks 1" : "");
  if (result.exit_status == 2)
    throw input_error(std::string("stopped in ") + title, "see the message above", "");
  if (result.exit_status != 0) throw failure(std::string("stopped in ") + title, "see the message above", "");
}

void set_environment(int ranks) {
  if (isatty(STDERR_FILENO)) setenv("PHYNNESS_PROGRESS", "1", 0);
  if (ranks <= 1) return;
  setenv("OMP_NUM_THREADS", "1", 0);
  if (geteuid() == 0) {  // Open MPI wants to be told twice
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  }
}

void run(const Options& options) {
  std::error_code code;
  std::filesystem::create_directories(options.output, code);
  if (code) throw input_error("cannot make the output folder", options.output.string(), code.message());
  const auto self = std::filesystem::read_symlink("/proc/self/exe").string();
  const auto in = [&](const char* name) { return (options.output / name).string(); };
  const auto scene = options.scene.string();
  set_environment(options.ranks);

  stage("mesh", {self, "mesh", scene, "-o", in("mesh.msh"), "--json", in("mesh.json")}, 1);
  std::vector<std::string> precompute{self,     "precompute",         scene, "-o", in("database.h5"),
                                      "--json", in("precompute.json")};
  if (options.resume) precompute.push_back("--resume");
  stage("precompute", precompute, options.ranks);
  stage("train", {self, "train", scene, in("database.h5"), "-o", in("model"), "--json", in("train.json")}, 1);
  stage("validate", {self, "validate", scene, in("model"), "--json", in("validate.json")}, options.ranks);
  fmt::print(
      "\nwritten to {}: mesh.msh, database.h5, model/ (model.txt, mesh.txt: what a controller needs), "
      "*.json\n",
      options.output.string());
}

}  // namespace

void add_run_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command =
      app.add_subcommand("run", "The whole pipeline: mesh, precompute, train, validate -> OUT_DIR");
  command->add_option("SCENE", options->scene, "scene file (formats/scene.md)")->required();
  command->add_option("-o,--output", options->output, "folder for everything that is written")->required();
  command->add_option("--ranks", options->ranks, "processes for the finite element stages (mpirun)")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  command->add_flag("--resume", options->resume, "go on with an unfinished database in OUT_DIR");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli
