// The surface seen from both sides, coloured by a value at each output node.
#pragma once

#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness::report {

/// Two views along the shortest axis of the body and a scale of colours, as SVG.
/// @param value  per output node, >= 0
/// @param marks  positions of output nodes that are marked by rings
/// @param unit   of the values
std::string surface_picture(const Model& model, const std::vector<double>& value,
                            const std::vector<std::int32_t>& marks, const std::string& unit);

}  // namespace phynness::report
