// What the study of models finds, as tables and as JSON.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

#include "error_parts.hpp"
#include "single_precision.hpp"

namespace phynness::study {

/// A node whose largest force is so many times the median node's holds states beyond a snap.
inline constexpr double snap_ratio = 5;

struct Row {
  std::string family, name;
  std::string refused;        ///< why there is no model; empty: there is one
  PredictorErrors all, calm;  ///< calm: at nodes that do not snap
  /// By node: mean of force and of displacement inside, in the order of the probes.
  std::vector<std::array<double, 2>> by_node;
  bool finite = true;  ///< every force and displacement that was asked for
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
/// @param snaps  per entry of `parts`
void print_parts(const std::string& name, const std::vector<ErrorParts>& parts, const std::vector<char>& snaps);

nlohmann::json to_json(const PredictorErrors& e);
nlohmann::json to_json(const Row& r);
nlohmann::json to_json(const ErrorParts& p);

}  // namespace phynness::study
