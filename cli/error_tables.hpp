// Text output of `phynness validate`.
#pragma once

#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <phynness/validation/verdict.hpp>
#include <vector>

namespace phynness::cli {

/// One sentence for each line of the verdict.
void print_verdict(const Validated& validated);
/// The first column to the left, the others to the right.
void print_cells(const TableCells& rows);
/// Errors of the model, the linear predictor and the zero predictor, inside and outside of the trained range.
void print_table(const ValidationReport& report);
/// Errors of probes up to R by warnings, depth and nodes.
void print_to_range(const ErrorsToRange& errors);
/// Median errors, and the correlation of the error with the distance from the training data.
void print_summary(const ValidationReport& report);
/// One line for each mean error in which the model is worse than the linear predictor.
void print_worse(const std::vector<WorseThanLinear>& all);
/// Forces of some probes.
void print_examples(const ValidationReport& report);
void print_points(const PointReport& report);
void print_pairs(const PairReport& report);

}  // namespace phynness::cli
