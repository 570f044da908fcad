// What the script of a report needs to draw the body.
#pragma once

#include <phynness/validation/report.hpp>

namespace phynness::report {

/// BodyData of web/report/src/data.ts; null if the model has no surface or no displacements.
Json body_data(const Validated& validated);

}  // namespace phynness::report
