// Blocks of a report's sections (phynness/pages/report.hpp), and its section of errors.
#pragma once

#include <fmt/core.h>

#include <phynness/pages/report.hpp>
#include <phynness/validation/report.hpp>
#include <string>
#include <vector>

namespace phynness {
namespace report {

using Rows = std::vector<std::vector<std::string>>;

inline Json text(const std::string& words) { return {{"text", words}}; }
inline Json warning(const std::string& words) { return {{"warning", words}}; }
inline Json table(const Json& rows) { return {{"table", rows}}; }
inline Json folded(const std::string& title, const Json& rows) { return {{"folded", title}, {"table", rows}}; }
inline Json facts(const Rows& rows) { return {{"table", rows}, {"words", true}}; }
inline Json charts(const std::vector<Json>& all) { return {{"charts", all}}; }

inline std::string percent(double fraction) {
  const double value = 100 * fraction;
  return value > 0 && value < 0.005 ? fmt::format("{:.0e}", value) : fmt::format("{:.2f}", value);
}

}  // namespace report

report::Json error_section(const Validated& in);

}  // namespace phynness
