// Tools that `phynness solve` refuses are refused by `phynness eval`, too.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/tool.hpp>
#include <vector>

namespace phynness::cli {

/// A model does not contain the radius of its patches, but the weights that follow from it. A model of patches so small
/// that each holds only its own node cannot be told from one of single nodes, and nothing is refused.
/// @throws Error (input) if a patch moves what another one touches, or if one between nodes holds none of them
void refuse_as_solve(const LoadedModel& loaded, const std::vector<SurfacePoint>& places);

}  // namespace phynness::cli
