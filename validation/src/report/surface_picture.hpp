// The surface seen from both sides, coloured by a number at each output node.
#pragma once

#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness::report {

/// Two views along the body's shortest axis and a scale of colours, as SVG. @param value  per output node, >=
/// 0
/// @param marks  output positions that get a dot; @param unit of the scale
std::string surface_picture(const Model& model, const std::vector<double>& value,
                            const std::vector<std::int32_t>& marks, const std::string& unit);

}  // namespace phynness::report
