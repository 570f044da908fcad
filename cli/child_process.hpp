// Stages of a longer run, each a process of its own: parallel ones under mpirun, training with threads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace phynness::cli {

/// This program, to be started again.
std::string this_program();

/// For all children: progress if a person sees stderr, and what Open MPI and BLAS want to be told.
void prepare_environment(int ranks);

/// Starts a program and waits for it; a signal is passed on.
/// @param title  of the stage, for messages
/// @param ranks  more than 1: under mpirun
/// @throws Error of the kind of the child's exit status (2: input), or (failure) if it cannot be started
void run_child(const std::string& title, std::vector<std::string> arguments, int ranks);

}  // namespace phynness::cli
