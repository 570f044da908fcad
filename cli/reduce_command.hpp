// What the command reduce does in the program with the solver, and without it.
#pragma once

#include <phynness/training/reduction.hpp>

#include "commands.hpp"

namespace phynness::cli {

struct Reduced {
  ReducedBody body;
  ReductionReport report;
  json sizes = json::array();  ///< of each size that was tried: modes, cells, and errors of several tools
};

/// With the solver: has modes of solved states of several tools, compares the body with others, and grows until the
/// 95th percentile of the errors of two tools is at most the target, or larger bodies are not better.
/// @param target  a fraction; empty: the size of `spec` is the only one
/// @return nothing on other ranks than the first
std::optional<Reduced> reduced(const std::filesystem::path& database, const ReductionSpec& spec,
                               std::optional<double> target);

}  // namespace phynness::cli
