// The reduction of the command reduce, with the solver and without it.
#pragma once

#include <phynness/training/reduction.hpp>

#include "commands.hpp"

namespace phynness::cli {

struct Reduced {
  ReducedBody body;
  ReductionReport report;
  json sizes = json::array();  ///< modes, cells and errors of several tools for each size that was tried
};

/// Reduces a database. With the solver the body also has modes from solved states of several tools, is compared with
/// other states, and grows until the 95th percentile of the errors of two tools reaches the target, and that of three
/// twice the target if `tools` is three or more, or until they stop to improve.
/// @param target  a fraction; empty: the size of `spec` is the only one
/// @param tools   0: as many as the scene in the database has
/// @return nothing on other ranks than the first
std::optional<Reduced> reduced(const std::filesystem::path& database, const ReductionSpec& spec,
                               std::optional<double> target, int tools);

/// Time of the first body, to which larger ones add if its errors are too large.
/// @param increment_s  of an increment of one tool
/// @param points       cells, and edges of es-p1-p1
double reduction_s(double increment_s, std::int64_t points, int tools, int ranks);

}  // namespace phynness::cli
