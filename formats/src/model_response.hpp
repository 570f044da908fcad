// What model.txt says of an active node beyond its probes: networks or linear responses, as the family has
// it.
#pragma once

#include <phynness/formats/model.hpp>

#include "model_emitter.hpp"
#include "model_lexer.hpp"

namespace phynness {

/// @pre model.family is one that the format knows
/// @throws Error (failure) on what the format cannot hold
void write_response(ModelEmitter& writer, const Model& model, const ActiveNodeModel& node);

/// @pre the tables of the model (displacements, output) have been read
/// @throws Error (input) with file and line
void read_response(ModelLexer& lexer, const Model& model, ActiveNodeModel& node);

}  // namespace phynness
