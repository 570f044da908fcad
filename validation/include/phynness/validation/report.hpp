// The figures of a validation for machines, and a report for persons: scene, solves, errors, worst cases, curves,
// distribution of the error on the body, conservation of energy, size and time.
#pragma once

#include <phynness/formats/figures.hpp>
#include <phynness/validation/verdict.hpp>

namespace phynness {

/// formats/validation.md
Json validation_figures(const Validated& validated);

/// Self-contained HTML in UTF-8 with its style and script, without references to other files or servers. It has a light
/// and a dark style and can be printed; its script draws it.
/// @param software  versions of the software that computed it
/// @throws Error (input) in a build without pages
std::string html_report(const Validated& validated, const std::string& software);

}  // namespace phynness
