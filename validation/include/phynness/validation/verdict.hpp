// What a validation says first: the figures by which a model is accepted or refused, once for text, HTML and JSON.
#pragma once

#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

struct VerdictLine {
  std::string key;  ///< of its figures in the JSON
  std::string title, sentence;
  std::vector<std::pair<std::string, double>> figures;  ///< not a number: not defined
};

/// A validation with its parts; points and pairs that were not requested have finished = 0.
struct Validated {
  const Scene& scene;
  const LoadedModel& model;
  const ValidationReport& report;
  const PointReport& points;
  const PairReport& pairs;
};

std::vector<VerdictLine> verdict(const Validated& validated);

/// Of the probes at nodes, of points and of pairs.
std::vector<WorseThanLinear> worse_than_linear(const Validated& validated);

/// The table below the verdict: two rows of headings, and at most ten rows that differ from each other.
TableCells summary_cells(const Validated& validated);

}  // namespace phynness
