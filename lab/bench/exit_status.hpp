// Exit status of studies and benchmarks, as of the command: 0, 1 for a failure, 2 for wrong input, with the reason on
// stderr.
#pragma once

#include <cstdio>
#include <exception>
#include <phynness/formats/error.hpp>

namespace phynness::bench {

/// @param run  returns its own status or throws an exception
inline int exit_status(int (*run)(int, char**), int argc, char** argv) {
  try {
    const int status = run(argc, argv);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
    throw failure("results could not be written to stdout", "", "redirect stdout to a file that can be written");
  } catch (const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return error.kind() == Error::Kind::input ? 2 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}

}  // namespace phynness::bench
