// A report on the accuracy of a model: scene, solves, errors, worst cases, curves, distribution of the error on the
// body, conservation of energy, size and time.
#pragma once

#include <phynness/validation/verdict.hpp>

namespace phynness {

struct ReportInput : Validated {
  std::uint64_t seed = 0;
  std::string software;                 ///< versions of the software that computed it
  std::vector<std::string> not_done{};  ///< requested parts of the validation that were not done, and why
};

/// Self-contained HTML in UTF-8 with its style and script, without references to other files or servers. It has a light
/// and a dark style and can be printed. Tables are complete without the script, which draws curves and the body.
std::string html_report(const ReportInput& input);

}  // namespace phynness
