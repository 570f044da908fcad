// Family rbfn: the networks of section 2.2 of the paper.
#include <fmt/core.h>

#include <phynness/formats/error.hpp>

#include "family_training.hpp"

namespace phynness {
namespace {

/// Number of nodes in a search for the spread, distributed evenly over the list of active nodes.
constexpr std::int32_t n_search_nodes = 5;

/// Spread if no node has enough points for a search.
constexpr double fallback_spread = 1.0;

void check_rbfn(const TrainingSpec& spec) {
  if (spec.samples < 1)
    throw input_error("samples must be at least 1", std::to_string(spec.samples),
                      "use for example 5000, as in the paper");
  if (spec.deformation_neurons < 1 || spec.force_neurons < 1)
    throw input_error("a network needs at least one neuron", "",
                      "use for example 200 for deformation and 60 for force, as in the paper");
  if (!(spec.target_mse >= 0))
    throw input_error("target_mse must not be negative", std::to_string(spec.target_mse), "use 0");
}

class RbfnTraining : public FamilyTraining {
 public:
  RbfnTraining(const DatabaseHeader& header, const TrainingTables& tables, const TrainingSpec& spec)
      : _header(header), _tables(tables), _spec(spec) {}

  /// Searches the spreads that are not given.
  void prepare(const NodeReader& read, int) override {
    if (_spec.deformation_spread > 0 && _spec.force_spread > 0) return;
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    const std::int32_t n = std::min(n_active, n_search_nodes);
    std::vector<SearchNode> nodes;
    for (std::int32_t i = 0; i < n; ++i) nodes.push_back(read((2 * i + 1) * n_active / (2 * n)));
    if (!(_spec.force_spread > 0)) _spec.force_spread = search_force_spread(_tables, nodes, _spec);
    if (!(_spec.deformation_spread > 0)) _spec.deformation_spread = search_deformation_spread(_tables, nodes, _spec);
    if (!(_spec.force_spread > 0)) _spec.force_spread = fallback_spread;
    if (!(_spec.deformation_spread > 0)) _spec.deformation_spread = fallback_spread;
  }

  void train(const SearchNode& read, const Vec3& point, bool estimate_errors, NodeOutcome& outcome) const override {
    NodeTraining training = train_node(_tables, read.node, point, read.tool, read.rays, _spec, estimate_errors);
    outcome.force_mse = training.force.mse.back();
    outcome.deformation_mse = training.deformation.mse.back();
    for (const auto& level : training.force.levels)
      if (estimate_errors) outcome.force_errors.push_back(level.left_out_error);
    for (const auto& level : training.deformation.levels)
      if (estimate_errors) outcome.displacement_errors.push_back(level.left_out_error);
    outcome.model = std::move(training.model);
  }

  void add(TrainingReport& report, const NodeOutcome& outcome) const override {
    report.mean_force_mse += outcome.force_mse;
    report.mean_deformation_mse += outcome.deformation_mse;
  }

  void finish(Model&, TrainingReport& report) const override {
    report.mean_force_mse /= report.n_networks;
    report.mean_deformation_mse /= report.n_networks;
    report.force_spread = _spec.force_spread;
    report.deformation_spread = _spec.deformation_spread;
  }

 private:
  const DatabaseHeader& _header;
  const TrainingTables& _tables;
  TrainingSpec _spec;
};

std::string model_name(const TrainingSpec& spec) {
  return fmt::format("rbfn {} neurons, {} for force", spec.deformation_neurons, spec.force_neurons);
}

std::string describe_rbfn(const Model& model) {
  const auto size = sizes_of(model);
  const auto spreads = model.nodes.empty() ? std::pair{0.0, 0.0}
                                           : std::pair{model.nodes[0].deformation.spread, model.nodes[0].force.spread};
  return fmt::format("{} neurons for deformation, {} for force, spread {:.3g} and {:.3g}; trained to {:.4g} m",
                     size.deformation_neurons, size.force_neurons, spreads.first, spreads.second,
                     model.max_displacement_m);
}

}  // namespace

const FamilyOperations rbfn_operations = {
    Family::rbfn,
    "the paper's networks",
    check_rbfn,
    make_training<RbfnTraining>,
    {{"deformation_neurons", &TrainingSpec::deformation_neurons}, {"force_neurons", &TrainingSpec::force_neurons}},
    // The paper's numbers of neurons, and half and twice of them.
    {{25, 25}, {50, 50}, {100, 100}, {200, 100}, {300, 100}, {400, 100}},
    model_name,
    describe_rbfn,
    [](const TrainingReport&) { return std::vector<TrainingFigure>{}; }};

}  // namespace phynness
