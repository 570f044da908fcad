// What model.txt says of an active node beyond its probes: networks, linear responses or modes, as the
// family has it.
#pragma once

#include <phynness/formats/model.hpp>

#include "model_emitter.hpp"
#include "model_lexer.hpp"

namespace phynness {

/// @pre model.family is one that the format knows
/// @throws Error (failure) on what the format cannot hold
void write_response(ModelEmitter& writer, const Model& model, const ActiveNodeModel& node);

/// The part that all active nodes share, between the tables and the active nodes; nothing but in family modal.
void write_shared(ModelEmitter& writer, const Model& model);
void read_shared(ModelLexer& lexer, Model& model);

/// @pre the tables of the model (displacements, output, shared part) have been read
/// @throws Error (input) with file and line
void read_response(ModelLexer& lexer, const Model& model, ActiveNodeModel& node);

}  // namespace phynness
