// Blocks of a report's sections (phynness/pages/report.hpp), and parts of it.
#pragma once

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

/// Pictures of the errors on the body, and of the worst cases; none if the model has no surface or no displacements.
std::vector<Json> body_pictures(const Validated& validated);

}  // namespace report

/// Errors of the model inside and outside the trained range, of tools between nodes, and how bounds hold.
report::Json error_section(const Validated& in);

}  // namespace phynness
