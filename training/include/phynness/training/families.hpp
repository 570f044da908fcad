// What each family of models does with a database, with its sizes and with its report: one row of a table for each,
// which commands, tuning and training ask. A family's row and all it does lie in its own folder (src/rbfn, src/linear,
// src/modal); its sections in a model.txt are its grammar (phynness/schema/model_grammar.hpp).
#pragma once

#include <memory>
#include <phynness/training/training.hpp>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

class FamilyTraining;
struct TrainingTables;

struct FamilyOperations {
  Family family;
  const char* about;         ///< what it is, for --help
  const char* option_words;  ///< which options of sizes are its own; empty: none
  /// @throws Error (input) on impossible sizes
  void (*check)(const TrainingSpec& spec);
  std::unique_ptr<FamilyTraining> (*training)(const DatabaseHeader& header, const TrainingTables& tables,
                                              const TrainingSpec& spec);
  /// Sizes that tuning tries, from small to large.
  std::vector<TrainingSpec> (*candidates)(const TrainingSpec& spec);
  std::string (*model_name)(const TrainingSpec& spec);
  std::vector<std::pair<std::string, int>> (*sizes)(const TrainingSpec& spec);
  /// Whether any node has a deformation; a modal model may have forces only.
  bool (*has_deformation)(const Model& model);
  /// Sizes of a model in a line.
  std::string (*describe)(const Model& model);
  /// What was trained and how well, line by line.
  std::vector<std::string> (*summary)(const Model& model, const TrainingReport& report);
  /// The same for machines; none in family rbfn, whose figures every report has.
  std::vector<std::pair<std::string, double>> (*figures)(const TrainingReport& report);
};

const FamilyOperations& operations(Family family);
/// In the order in which they are tried and told: the recommended ones first.
const std::vector<const FamilyOperations*>& every_family();

}  // namespace phynness
