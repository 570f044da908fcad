// Table of the operations of each family of models: training, sizes and reports. Commands, tuning and training use it.
// The row of a family and its functions are in the folder of the family (src/rbfn, src/linear, src/modal). The grammar
// of a family defines its sections in model.txt (phynness/schema/model_grammar.hpp).
#pragma once

#include <memory>
#include <phynness/training/training.hpp>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

class FamilyTraining;
struct TrainingTables;

/// A figure of a trained model, in text and JSON.
struct TrainingFigure {
  const char *key, *title;
  double value;  ///< an error as a fraction
};

struct FamilyOperations {
  Family family;
  const char* about;  ///< description for --help
  /// @throws Error (input) on impossible sizes
  void (*check)(const TrainingSpec& spec);
  std::unique_ptr<FamilyTraining> (*training)(const DatabaseHeader& header, const TrainingTables& tables,
                                              const TrainingSpec& spec);
  std::vector<std::pair<const char*, int TrainingSpec::*>> sizes;  ///< with their keys
  std::vector<std::vector<int>> candidates;                        ///< sizes that tuning tries, in ascending order
  std::string (*model_name)(const TrainingSpec& spec);
  /// Sizes of a model in one line.
  std::string (*describe)(const Model& model);
  /// Of a trained model; empty in family rbfn, whose figures are part of every report.
  std::vector<TrainingFigure> (*figures)(const TrainingReport& report);
};

/// What tuning tries: the candidates of a family with everything else as given.
std::vector<TrainingSpec> candidates(const FamilyOperations& family, const TrainingSpec& given);

/// The sizes of a model: the largest of all nodes, 0 for those of other families.
TrainingSpec sizes_of(const Model& model);

const FamilyOperations& operations(Family family);
/// All families, the recommended ones first.
const std::vector<const FamilyOperations*>& every_family();

}  // namespace phynness
