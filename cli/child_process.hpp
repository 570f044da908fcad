// Child processes for the stages of `phynness run`. Solver stages run in parallel under mpirun, training uses threads.
#pragma once

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

}  // namespace phynness::cli
