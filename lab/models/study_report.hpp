// Results of the study of models as tables and as JSON.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

#include "error_parts.hpp"
#include "single_precision.hpp"

namespace phynness::study {

/// A node snaps if its largest force exceeds that of the median node by this factor.
inline constexpr double snap_ratio = 5;

struct Row {
  std::string family, name;
  std::string refused;        ///< reason why there is no model; empty: there is a model
  PredictorErrors all, calm;  ///< calm: at nodes that do not snap
  /// Per node: mean errors of force and displacement inside the trained range, in the order of the probes.
  std::vector<std::array<double, 2>> by_node;
  bool finite = true;  ///< all evaluated forces and displacements are finite
  // modal
  double smallest_shape = 0, largest_shape = 0, amplitude_shape = 0;
  double cancellation = 0, force_condition = 0, amplitude_condition = 0;
  SinglePrecision single;
  // rbfn
  double diagonal_ratio = 0;
};

void print_head();
/// @param by_node  as in Row
void print_errors(const std::string& name, const PredictorErrors& all, const PredictorErrors& calm,
                  const std::vector<std::array<double, 2>>& by_node);
void print_row(const Row& row);
/// Conditioning and single precision.
void print_numbers(const std::vector<Row>& rows);
/// @param snaps  flags for the entries of `parts`
void print_parts(const std::string& name, const std::vector<ErrorParts>& parts, const std::vector<char>& snaps);

nlohmann::json to_json(const PredictorErrors& e);
nlohmann::json to_json(const Row& r);
nlohmann::json to_json(const ErrorParts& p);

}  // namespace phynness::study
