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

/// The part that all active nodes share, between the tables and the active nodes; nothing but in family
/// modal.
void write_shared(ModelEmitter& writer, const Model& model);
void read_shared(ModelLexer& lexer, Model& model);

/// @pre the tables of the model (displacements, output, shared part) have been read
/// @throws Error (input) with file and line
void read_response(ModelLexer& lexer, const Model& model, ActiveNodeModel& node);

/// The levels of a model, nothing where it has one; and the smaller ones of an active node, after its full response.
void write_levels(ModelEmitter& writer, const Model& model);
void read_levels(ModelLexer& lexer, Model& model);
void write_level_responses(ModelEmitter& writer, const Model& model, const ActiveNodeModel& node);
void read_level_responses(ModelLexer& lexer, const Model& model, ActiveNodeModel& node);

/// The force of a modal model.
void write_conservative(ModelEmitter& writer, const Model& model, const ConservativeNetwork& force);
void read_conservative(ModelLexer& lexer, const Model& model, ConservativeNetwork& force);

/// Tables of scaled integers; formats/model.md, TABLE.
void write_table(ModelEmitter& writer, std::string_view key, const ScaledTable& table);
ScaledTable read_table(ModelLexer& lexer, std::string_view key, Eigen::Index rows, Eigen::Index cols);

/// How many rows the tables of an active node's modes have.
struct ModesShape {
  Eigen::Index n_basis, n_shared, components;  ///< of weights; of mixing; for each near node
};
void write_modes(ModelEmitter& writer, std::string_view key, const ModesShape& shape,
                 const ModalDeformation& modal);
void read_modes(ModelLexer& lexer, std::string_view key, const ModesShape& shape, Eigen::Index n_output,
                ModalDeformation& modal);

/// The fields of a model, nothing where it has none; and those of an active node.
void write_fields(ModelEmitter& writer, const Model& model);
void read_fields(ModelLexer& lexer, Model& model);
void write_node_fields(ModelEmitter& writer, const Model& model, const ActiveNodeModel& node);
void read_node_fields(ModelLexer& lexer, const Model& model, ActiveNodeModel& node);

}  // namespace phynness
