// The stages of `phynness run`: their processes, and the record of finished stages, so that --resume repeats only those
// whose keys of the scene or whose inputs have changed. Solver stages run under mpirun, training uses threads.
#pragma once

#include <filesystem>
#include <map>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness::cli {

/// Path of this executable.
std::string this_program();

/// Sets environment variables for all children: progress lines if stderr is a terminal, one BLAS thread per rank, and
/// permission for Open MPI to run as root.
void prepare_environment(int ranks);

/// Starts a program and waits for its end. Signals are passed on to it.
/// @param title  name of the stage, for messages
/// @param ranks  if greater than 1, the program is started with mpirun
/// @param quiet  its stdout is not shown; its messages on stderr are
/// @throws Error (input) if the exit status is 2, (failure) for any other status except 0, or if it cannot be started
void run_child(const std::string& title, std::vector<std::string> arguments, int ranks, bool quiet);

class RunStages {
 public:
  /// @param same_rays  false if the database does not have all rays of the scene yet
  RunStages(const std::filesystem::path& folder, const Scene& scene, bool same_rays);

  /// Whether an earlier run has finished the stage, and nothing that it depends on has changed.
  bool has(const std::string& stage) const;
  /// Removes a stage and later ones from the record, with their files, so that the folder remains consistent.
  void invalidate(const std::string& stage);
  void mark_finished(const std::string& stage);

 private:
  void write() const;

  std::filesystem::path _folder;
  std::map<std::string, std::string> _wanted, _finished;  ///< hash by stage
};

}  // namespace phynness::cli
