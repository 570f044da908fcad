// The figures of a validation for machines, and a report for persons: scene, solves, errors, worst cases, curves,
// distribution of the error on the body, size and time.
#pragma once

#include <phynness/formats/error.hpp>
#include <phynness/formats/figures.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/validation/relaxing_motions.hpp>
#include <phynness/validation/tools.hpp>
#include <string>
#include <vector>

namespace phynness {

/// How much of the probes up to R of a scene a model has trained.
struct TrainedShare {
  double all = 0;               ///< mean over all requested rays; 1 - EndSummary::share_of_volume() of the database
  std::vector<double> of_node;  ///< in the order of Model::nodes: mean over its rays of part_of_volume()
};
TrainedShare trained_share(const Model& model);
/// What a validation says first: figures by which a model is accepted or refused, once for text, HTML and JSON.
struct VerdictLine {
  std::string key;  ///< of its figures in the JSON
  std::string title, sentence;
  ByName<double> figures;
};

/// A validation with its parts; points and pairs that were not requested have finished = 0.
struct Validated {
  Scene scene;
  NamedOrgan model;
  std::uint64_t seed = 0;
  ValidationReport report{};
  PointReport points{}, rim{};  ///< tools between probed nodes, and at the rim of the probed part
  PairReport pairs{};
  MotionReport motions{};
  std::optional<NamedOrgan> body{};              ///< with which points and pairs are compared, too
  std::optional<Error> no_points{}, no_pairs{};  ///< why this requested part was not done
  bool interrupted() const {
    return report.interrupted() || points.interrupted() || rim.interrupted() || pairs.interrupted() ||
           motions.interrupted();
  }
  /// Requested parts that were not done, and why.
  std::vector<std::string> not_done() const;
};

std::vector<VerdictLine> verdict(const Validated& validated);

/// Of the probes at nodes, of points and of pairs.
std::vector<WorseThanLinear> worse_than_linear(const Validated& validated);

/// The table below the verdict, in percent: two rows of headings, and rows that differ from each other.
std::vector<std::vector<std::string>> summary_cells(const Validated& validated);

/// The command that repeats the probes of a validation, with the words SCENE and MODEL_DIR for its inputs.
std::string validate_again(const Validated& validated);
/// The command that repeats the comparison with a finer solution; a sentence if there was none.
std::string check_again(const FinerDistance& finer);

/// formats/validation.md
Json validation_figures(const Validated& validated);

/// Self-contained HTML in UTF-8 with its style, without scripts and references to other files or servers. It has a
/// light and a dark style and can be printed. @param software  versions of the software that computed it
std::string html_report(const Validated& validated, const std::string& software);

}  // namespace phynness
