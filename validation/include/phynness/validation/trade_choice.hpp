// The row of a comparison of elements and meshes that is recommended.
#pragma once

#include <phynness/validation/discretization.hpp>

namespace phynness {

/// Whether only the scene itself was compared, beside which there is nothing to choose.
bool is_alone(const TradeReport& report);

/// Of the rows within the limit the one whose database needs the least time.
/// @param error  largest mean error, as a fraction. @return null: there is none, or the scene is_alone()
const TradeRow* chosen_row(const TradeReport& report, double error);

}  // namespace phynness
