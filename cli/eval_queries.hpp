// Evaluation of many single tools: a CSV file of displaced nodes is read, and a CSV table of forces is printed.
#pragma once

#include <filesystem>
#include <phynness/evaluation/loaded_model.hpp>

namespace phynness::cli {

/// First line of a file of queries; one row for each query follows.
inline constexpr const char* queries_header = "node,ux_m,uy_m,uz_m";

/// Evaluates every row as a single tool at its node and prints a CSV table to stdout in the order of the rows:
/// node,ux_m,uy_m,uz_m,fx_N,fy_N,fz_N,energy_J,status,trained_depth_m. energy_J is omitted in families without energy.
/// @throws Error (input) with the file and the line of the first invalid row; nothing is printed then
void answer_queries(const LoadedModel& model, const std::filesystem::path& file);

}  // namespace phynness::cli
