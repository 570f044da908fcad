// What a validation says first: the figures by which a model is accepted or refused, once for text, HTML and JSON.
#pragma once

#include <phynness/formats/error.hpp>
#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <string>
#include <vector>

namespace phynness {

struct VerdictLine {
  std::string key;  ///< of its figures in the JSON
  std::string title, sentence;
  ByName<double> figures;
};

/// A validation with its parts; points and pairs that were not requested have finished = 0.
struct Validated {
  Scene scene;
  LoadedModel model;
  std::uint64_t seed = 0;
  ValidationReport report{};
  PointReport points{};
  PairReport pairs{};
  std::optional<LoadedBody> body{};              ///< with which points and pairs are compared, too
  std::optional<Error> no_points{}, no_pairs{};  ///< why this requested part was not done
  bool interrupted() const { return report.interrupted() || points.interrupted() || pairs.interrupted(); }
  /// Requested parts that were not done, and why.
  std::vector<std::string> not_done() const;
};

std::vector<VerdictLine> verdict(const Validated& validated);

/// Of the probes at nodes, of points and of pairs.
std::vector<WorseThanLinear> worse_than_linear(const Validated& validated);

/// The table below the verdict: two rows of headings, and at most ten rows that differ from each other.
TableCells summary_cells(const Validated& validated);

}  // namespace phynness
