// The figures of a validation for machines, and a report for persons: scene, solves, errors, worst cases, curves,
// distribution of the error on the body, conservation of energy, size and time.
#pragma once

#include <phynness/formats/figures.hpp>
#include <phynness/validation/verdict.hpp>

namespace phynness {

/// The command that repeats the probes of a validation, with the words SCENE and MODEL_DIR for its inputs.
std::string validate_again(const Validated& validated);
/// The command that repeats the comparison with a finer solution; a sentence if there was none.
std::string check_again(const FinerDistance& finer);

/// formats/validation.md
Json validation_figures(const Validated& validated);

/// Self-contained HTML in UTF-8 with its style and script, without references to other files or servers. It has a light
/// and a dark style and can be printed; its script draws it.
/// @param software  versions of the software that computed it
/// @throws Error (input) in a build without pages
std::string html_report(const Validated& validated, const std::string& software);

}  // namespace phynness
