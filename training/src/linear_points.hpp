// Points of the surface that were not probed, with their responses at rest.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>

namespace phynness {

/// Gives the response at rest of a point, an index of NodeSets::linear.
using RestReader = std::function<AtRest(std::int32_t point)>;

/// Adds the linear points of a database to a trained model of any family.
/// @param spec  seed; `modes` = 0: a modal model has no fields, nor have these points
/// @throws Error (failure) if a displacement is not finite
void add_linear_points(Model& model, const DatabaseHeader& header, const RestReader& read, const TrainingSpec& spec);

}  // namespace phynness
