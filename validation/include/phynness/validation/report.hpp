// One page that says what a model is worth: what was modelled and solved, errors, worst cases, curves, where
// on the body the error is, conservation, size and time.
#pragma once

#include <phynness/validation/validation.hpp>

namespace phynness {

struct ReportInput {
  const Scene& scene;
  const LoadedModel& model;
  const ValidationReport& validation;
  std::uint64_t seed = 0;
  std::string software;                 ///< versions of what computed it
  std::vector<std::string> not_done{};  ///< parts of the validation that were asked for and not done, and why
};

/// Plots are drawn by gnuplot. @throws Error (failure) if it is not there
void require_plots();

/// Self-contained HTML, UTF-8: style and vector plots inside, nothing from the network; light and dark,
/// printable.
/// @throws Error (failure) if gnuplot fails
std::string html_report(const ReportInput& input);

}  // namespace phynness
