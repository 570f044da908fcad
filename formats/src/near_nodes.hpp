#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>

namespace phynness::scene_detail {

/// Those of `candidates`, in their order, that lie within `distance` of one of `targets`. Takes n log n steps.
NodeList near_nodes(const Points& nodes, const NodeList& candidates, NodeList targets, double distance);

}  // namespace phynness::scene_detail
