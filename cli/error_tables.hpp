// What `phynness validate` says to persons.
#pragma once

#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <vector>

namespace phynness::cli {

/// Errors of model, linear and zero predictor, inside the trained range and beyond.
void print_table(const ValidationReport& report, const std::vector<FieldModes>& fields);
/// Medians, and what the distance from what was trained is worth.
void print_summary(const ValidationReport& report);
/// Some probes with their forces.
void print_examples(const ValidationReport& report);
void print_points(const PointReport& report);
void print_pairs(const PairReport& report);

}  // namespace phynness::cli
