// Family linear: unit responses, exact for bodies of the linear law.
#include <fmt/core.h>

#include "family_training.hpp"

namespace phynness {
namespace {

class LinearFamilyTraining : public FamilyTraining {
 public:
  LinearFamilyTraining(const DatabaseHeader&, const TrainingTables& tables, const TrainingSpec&) : _tables(tables) {}

  void train(const SearchNode& read, const Vec3& point, bool, NodeOutcome& outcome) const override {
    LinearTraining training = train_linear_node(_tables, read.node, point, read.tool, read.rays);
    outcome.model = std::move(training.model);
    outcome.linear = training.quality;
  }

  void add(TrainingReport& report, const NodeOutcome& outcome) const override {
    LinearQuality& worst = report.linear;
    const LinearQuality& q = outcome.linear;
    worst.displacement_residual = std::max(worst.displacement_residual, q.displacement_residual);
    worst.force_residual = std::max(worst.force_residual, q.force_residual);
    worst.energy_residual = std::max(worst.energy_residual, q.energy_residual);
    worst.asymmetry = std::max(worst.asymmetry, q.asymmetry);
  }

  void finish(Model&, TrainingReport&) const override {}

 private:
  const TrainingTables& _tables;
};

std::string describe_linear(const Model& model) {
  return fmt::format("a 3 x 3 stiffness and three unit responses each; trained to {:.4g} m, exact beyond",
                     model.max_displacement_m);
}

std::vector<TrainingFigure> figures_of_linear(const TrainingReport& report) {
  const LinearQuality& q = report.linear;
  return {{"displacement_residual", "deviation of displacements from linear ones", q.displacement_residual},
          {"force_residual", "of forces", q.force_residual},
          {"energy_residual", "of energies", q.energy_residual},
          {"asymmetry", "asymmetry of the stiffness", q.asymmetry}};
}

}  // namespace

const FamilyOperations linear_operations = {Family::linear,
                                            "unit responses, for the linear law",
                                            [](const TrainingSpec&) {},
                                            make_training<LinearFamilyTraining>,
                                            {},
                                            {{}},
                                            [](const TrainingSpec&) { return std::string("linear"); },
                                            describe_linear,
                                            figures_of_linear};

}  // namespace phynness
