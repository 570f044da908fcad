// The results of a validation as JSON, text and HTML.
#pragma once

#include <phynness/formats/error.hpp>
#include <phynness/formats/figures.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/validation/relaxing_motions.hpp>
#include <phynness/validation/tools.hpp>
#include <string>
#include <vector>

namespace phynness {

/// The share of the displacements up to R that a model has trained.
struct TrainedShare {
  double all = 0;               ///< mean over all requested rays; 1 - EndSummary::share_of_volume() of the database
  std::vector<double> of_node;  ///< in the order of Model::nodes: mean over its rays of part_of_volume()
};
TrainedShare trained_share(const Model& model);
/// One line of the summary of a validation, by which a model is accepted or refused.
struct VerdictLine {
  std::string key;  ///< JSON key of the figures
  std::string title, sentence;
  ByName<double> figures;
};

/// A validation with all parts; finished = 0 if a part was not requested.
struct Validated {
  Scene scene;
  NamedOrgan model;
  std::uint64_t seed = 0;
  ValidationReport report{};
  PointReport points{}, rim{};  ///< tools between probed nodes, and at the rim of the probed part
  PairReport pairs{};
  MotionReport motions{};
  std::optional<NamedOrgan> body{};              ///< reduced body that is also compared at points and pairs
  std::optional<Error> no_points{}, no_pairs{};  ///< why a requested part was not done
  bool interrupted() const {
    return report.interrupted() || points.interrupted() || rim.interrupted() || pairs.interrupted() ||
           motions.interrupted();
  }
  /// Requested parts that were not done, and why.
  std::vector<std::string> not_done() const;
};

std::vector<VerdictLine> verdict(const Validated& validated);

/// Comparisons for probes at nodes, for points and for pairs.
std::vector<WorseThanLinear> worse_than_linear(const Validated& validated);
/// Sentences: where the model is worse than linear, and a bound that held less often than promised.
std::vector<std::string> warnings(const Validated& validated);

/// The table below the verdict, in percent, with two rows of headings.
std::vector<std::vector<std::string>> summary_cells(const Validated& validated);

/// The command that repeats the probes of a validation, with the words SCENE and MODEL_DIR for its inputs.
std::string validate_again(const Validated& validated);
/// The command that repeats the comparison with a finer solution; a sentence if there was no comparison.
std::string check_again(const FinerDistance& finer);

/// formats/validation.md
Json validation_figures(const Validated& validated);

/// Self-contained HTML in UTF-8 with its style, without scripts and references to other files or servers. It has a
/// light and a dark style and can be printed. @param software  versions of the software that computed it
std::string html_report(const Validated& validated, const std::string& software);

}  // namespace phynness
