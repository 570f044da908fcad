// What the script of a report needs to draw the body (web/report/src/data.ts).
#pragma once

#include <phynness/validation/report.hpp>
#include <string>

namespace phynness::report {

/// JSON; empty if the model has no surface or no displacements.
std::string body_data(const ReportInput& input);

}  // namespace phynness::report
