#include "run_stages.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "commands.hpp"

namespace phynness::cli {
namespace {

/// A stage, its file, and the keys of the scene that it reads. It also depends on all previous stages. mesh, precompute
/// and check themselves compare existing files with the scene.
struct StageRow {
  const char* stage;
  const char* file;
  std::vector<std::string> keys;  ///< whole keys, or sections with a dot
};
const std::vector<StageRow>& stage_rows() {
  static const std::vector<StageRow> rows{
      // physics: all keys of the physics hash, [mesh] among them
      {"precompute", nullptr, {"physics", "database.", "probe.elsewhere"}},
      {"check", nullptr, {"validation.check_probes"}},  // training writes its result into the model
      {"train", "train.json", {"title", "training.", "material.relaxation"}},
      {"calibrate", "calibrate.json", {"validation.calibration_rays"}},
      {"reduce", "body.txt", {"probe.tools"}},
      {"calibrate body", "calibrate_body.json", {}},
      {"validate", "validate.json", {"validation.probes", "validation.seed"}},
      {"page", "organ.html", {}}};
  return rows;
}

/// The values of the keys of a stage.
std::string values_of(const StageRow& row, const Scene& scene) {
  std::string text;
  for (const auto& key : row.keys) {
    if (key == "physics") text += physics_summary(scene);
    if (key == "title") text += "title = " + scene.title + "\n";
    std::istringstream lines(other_settings(scene));
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with(key)) text += line + "\n";
  }
  return text;
}

std::string hash_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return hash_of(std::string(std::istreambuf_iterator<char>(in), {}));
}

constexpr int exec_failed = 127;  // the exit status of a shell in this case

/// @return the exit status
int execute(const std::string& title, const std::vector<std::string>& arguments, bool quiet) {
  std::vector<char*> argv;
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) return exec_failed;
  if (child == 0) {
    // The kernel ends the stage in an orderly way when this process ends, also after kill -9.
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    if (const int null_device = quiet ? open("/dev/null", O_WRONLY) : -1; null_device >= 0)
      dup2(null_device, STDOUT_FILENO);
    else if (results_are_on_stderr())
      dup2(STDERR_FILENO, STDOUT_FILENO);
    execvp(argv[0], argv.data());
    _exit(exec_failed);
  }
  int status = 0;
  // Each signal is passed on: the first one requests an orderly end, the second one kills the child.
  while (waitpid(child, &status, 0) < 0 && errno == EINTR)
    if (stop_requested()) kill(child, SIGTERM);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  if (!stop_requested()) message("error: {} was ended by signal {}\n", title, WTERMSIG(status));
  return 1;
}

}  // namespace

RunStages::RunStages(const std::filesystem::path& folder, const Scene& scene, bool same_rays) : _folder(folder) {
  Fnv1a64 hash;
  hash.add(software_version());
  for (const auto& row : stage_rows()) {
    hash.add(std::string(row.stage) + "\n" + values_of(row, scene));
    _wanted[row.stage] = hash.hex();
  }
  std::ifstream in(folder / "stages.json");
  const auto stored = json::parse(in, nullptr, false);
  if (!same_rays || !stored.is_object() || !stored.contains("stages") || !stored.contains("model")) return;
  const auto& stages = stored["stages"];
  if (stored["model"] != hash_of_file(folder / "model/model.txt") || !stages.is_object()) return;
  const bool bounded = !schema::traits(scene.training.family).proportional;
  for (const auto& row : stage_rows()) {
    const std::string_view stage = row.stage;
    if (!bounded && stage == "calibrate") continue;
    if (scene.probe.tools == 1 && (stage == "reduce" || stage == "calibrate body")) continue;
    const std::string stored_hash =
        stages.contains(row.stage) && stages[row.stage].is_string() ? stages[row.stage] : "";
    if (stored_hash != _wanted[row.stage] || (row.file && !std::filesystem::exists(folder / row.file))) return;
    _finished[row.stage] = stored_hash;
  }
}

bool RunStages::has(const std::string& stage) const { return _finished.contains(stage); }

void RunStages::invalidate(const std::string& stage) {
  bool is_after = false;
  for (const auto& row : stage_rows()) {
    is_after = is_after || row.stage == stage;
    if (!is_after) continue;
    _finished.erase(row.stage);
    if (row.file) std::filesystem::remove(_folder / row.file);
  }
  write();
}

void RunStages::mark_finished(const std::string& stage) {
  _finished[stage] = _wanted.at(stage);
  write();
}

void RunStages::write() const {
  write_text_file(_folder / "stages.json",
                  record("stages", _finished, "model", hash_of_file(_folder / "model/model.txt")).dump(2) + "\n");
}

void exec_solver_program(char**) {}  // it is this program

std::string this_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

void prepare_environment(int ranks) {
  if (isatty(STDERR_FILENO)) setenv("PHYNNESS_PROGRESS", "1", 0);
  if (ranks <= 1) return;
  setenv("OMP_NUM_THREADS", "1", 0);
  // The first rank of reduce computes on threads; Open MPI (4; 5) binds each rank to one core otherwise.
  setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 0);
  setenv("PRTE_MCA_hwloc_default_binding_policy", "none", 0);
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
  if (exit_status == exec_failed)
    throw failure("the program cannot be started", arguments[0], ranks > 1 ? "install Open MPI, or use --ranks 1" : "");
  if (stop_requested())
    throw failure("interrupted in stage " + title,
                  title == "precompute" ? "solved rays are kept" : "the results of earlier stages are kept",
                  "run the same command with --resume to continue");
  const std::string remedy = "when its cause is mended, run the same command with --resume";
  if (exit_status == 2) throw input_error("stopped in stage " + title, "see the message above", remedy);
  if (exit_status != 0) throw failure("stopped in stage " + title, "see the message above", remedy);
}

}  // namespace phynness::cli
