// Many single-tool queries of a model at once: a CSV file of displaced nodes in, a CSV of forces out.
#pragma once

#include <filesystem>
#include <phynness/evaluation/loaded_model.hpp>

namespace phynness::cli {

/// First line of a file of queries; then a row for each query.
inline constexpr const char* queries_header = "node,ux_m,uy_m,uz_m";

/// Answers every row as a single tool at its node and prints the answers to stdout as CSV, in the order of the rows:
/// node,ux_m,uy_m,uz_m,fx_N,fy_N,fz_N,energy_J,status,trained_depth_m. Families that store no energy have no energy_J.
/// @throws Error (input) naming the file and the line of the first bad row; then nothing has been printed
void answer_queries(const LoadedModel& model, const std::filesystem::path& file);

}  // namespace phynness::cli
