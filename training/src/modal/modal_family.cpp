// Family modal: conservative forces, modes of the deformation, scalar fields.
#include <fmt/core.h>

#include <phynness/formats/error.hpp>

#include "family_training.hpp"
#include "levels.hpp"
#include "threads.hpp"

namespace phynness {
namespace {

/// Largest and smallest number of nodes from whose modes the shared modes are computed.
constexpr std::int32_t max_basis_nodes = 500, min_basis_nodes = 20;
constexpr double max_basis_bytes = 1e9;

/// Number of nodes whose amplitudes determine the centers.
constexpr std::int32_t n_center_nodes = 12;

void check_modal(const TrainingSpec& spec) {
  if (spec.force_centers < 1 || spec.amplitude_centers < 0 || spec.modes < 0 || spec.shared_modes < 0 ||
      spec.near_nodes < 0 || spec.modes > largest_mode_count || spec.shared_modes > largest_mode_count)
    throw input_error("a number of centers, modes or near nodes is impossible", "",
                      "use at least 1 for force_centers, at most " + std::to_string(largest_mode_count) +
                          " for modes and shared_modes, and no negative number");
}

class ModalTraining : public FamilyTraining {
 public:
  ModalTraining(const DatabaseHeader& header, const TrainingTables& tables, const TrainingSpec& spec)
      : _header(header), _tables(tables), _spec(spec) {
    if (tables.output.empty()) _spec.modes = 0;
  }

  void prepare(const NodeReader& read, int threads) override {
    _levels.resize(_spec.levels > 1 ? static_cast<std::size_t>(_spec.levels) : 0);
    if (_spec.modes == 0) {
      _shared.modes = scaled_table(Eigen::MatrixXd(3 * static_cast<Eigen::Index>(_tables.output.size()), 0));
      return;
    }
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    const auto components = static_cast<double>(3 + _header.fields.size());
    const double bytes_per_node = 8.0 * components * static_cast<double>(_tables.output.size()) * _spec.modes;
    const auto affordable =
        static_cast<std::int32_t>(std::min<double>(max_basis_nodes, max_basis_bytes / (bytes_per_node + 1)));
    const std::int32_t n = std::min(n_active, std::max(min_basis_nodes, affordable));
    std::vector<NodeModes> nodes(static_cast<std::size_t>(n));
    std::vector<std::vector<NodeModes>> of_field(_header.fields.size(), nodes);
    for_each_index(n, threads, [&](std::int32_t i) {
      const SearchNode read_node = read((2 * i + 1) * static_cast<std::int64_t>(n_active) / (2 * n));
      nodes[static_cast<std::size_t>(i)] = node_modes(_tables, read_node.tool, read_node.rays, _spec.modes);
      for (std::size_t f = 0; f < of_field.size(); ++f)
        of_field[f][static_cast<std::size_t>(i)] = field_modes(_tables, read_node.rays, f, 1, _spec.modes);
    });
    _shared.modes = scaled_table(shared_basis(nodes, _spec.shared_modes, _spec.seed));
    std::vector<NodeModes> some;
    const std::int32_t n_some = std::min(n, n_center_nodes);
    for (std::int32_t i = 0; i < n_some; ++i)
      some.push_back(std::move(nodes[static_cast<std::size_t>((2 * i + 1) * n / (2 * n_some))]));
    const auto chosen = choose_amplitude_centers(_tables, some, _spec.amplitude_centers);
    _shared.centers = chosen.row;
    _shared.shape = chosen.shape;
    _amplitude_left_out = chosen.left_out_error;
    const int n_centers = static_cast<int>(chosen.order.size());
    for (int l = 0; l < static_cast<int>(_levels.size()); ++l) {
      const int below = _spec.levels - 1 - l;
      _levels[static_cast<std::size_t>(l)] = {
          first_sorted(chosen.order, level_size(n_centers, below, least_amplitude_centers)),
          level_size(_spec.modes, below, least_modes)};
    }
    for (std::size_t f = 0; f < of_field.size(); ++f) share_field(_header.fields[f], of_field[f]);
  }

  void train(const SearchNode& read, const Vec3& point, bool, NodeOutcome& outcome) const override {
    const ForceStates forces = force_states(_tables, read.rays);
    outcome.conservative = fit_conservative(forces, _tables.magnitudes_m.back(), _spec.force_centers, _spec.levels);
    outcome.model = describe_node(_tables, read.node, point, read.tool, read.rays);
    outcome.model.conservative = std::move(outcome.conservative.network);
    auto& levels = outcome.model.levels;
    levels.resize(_levels.empty() ? 0 : _levels.size() - 1);
    for (auto& level : outcome.conservative.levels) outcome.force_errors.push_back(level.left_out_error);
    for (std::size_t l = 0; l < levels.size(); ++l)
      levels[l].conservative = std::move(outcome.conservative.levels[l].network);
    if (_spec.modes == 0) {
      outcome.model.modal.weights = scaled_table(Eigen::MatrixXd(3, 0));
      for (auto& level : levels) level.weights = outcome.model.modal.weights;
      return;
    }
    const NodeModes modes = node_modes(_tables, read.tool, read.rays, _spec.modes);
    outcome.modal = fit_modal(_tables, _shared, modes, _spec.near_nodes, 0, _levels);
    outcome.model.modal = std::move(outcome.modal.deformation);
    for (const auto& level : outcome.modal.levels) outcome.displacement_errors.push_back(level.left_out_error);
    for (std::size_t l = 0; l < levels.size(); ++l) levels[l].weights = std::move(outcome.modal.levels[l].weights);
    for (std::size_t f = 0; f < _fields.size(); ++f) {
      const auto& field = _fields[f];
      const NodeModes values = field_modes(_tables, read.rays, f, field.scale, _spec.modes);
      outcome.fields.push_back(
          fit_modal(_tables, _shared_of_field[f], values, _spec.near_nodes, field.degree, _levels));
      for (std::size_t l = 0; l < levels.size(); ++l)
        levels[l].field_weights.push_back(std::move(outcome.fields.back().levels[l].weights));
      outcome.model.fields.push_back(std::move(outcome.fields.back().deformation));
    }
  }

  void add(TrainingReport& report, const NodeOutcome& outcome) const override {
    ModalQuality& sum = report.modal;
    sum.force_training += outcome.conservative.training_error;
    sum.force_left_out += outcome.conservative.left_out_error;
    sum.truncation += outcome.modal.truncation_error;
    sum.regression += outcome.modal.regression_error;
    sum.fields.resize(outcome.fields.size());
    for (std::size_t f = 0; f < outcome.fields.size(); ++f) {
      sum.fields[f].truncation += outcome.fields[f].truncation_error;
      sum.fields[f].regression += outcome.fields[f].regression_error;
    }
  }

  void finish(Model& model, TrainingReport& report) const override {
    for (std::size_t l = 0; l + 1 < _levels.size(); ++l) model.levels[l].centers = _levels[l].centers;
    for (double* mean : {&report.modal.force_training, &report.modal.force_left_out, &report.modal.truncation,
                         &report.modal.regression})
      *mean /= report.n_networks;
    report.modal.amplitude_left_out = _amplitude_left_out;
    model.shared = _shared;
    for (std::size_t f = 0; f < _fields.size(); ++f) {
      for (auto* mean : {&report.modal.fields[f].truncation, &report.modal.fields[f].regression})
        *mean /= report.n_networks;
      model.fields.push_back(_fields[f]);
      model.fields.back().modes = _shared_of_field[f].modes;
    }
  }

 private:
  /// Computes the shared modes of a field; its centers and kernel are those of the displacement.
  void share_field(Field field, const std::vector<NodeModes>& nodes) {
    FieldModes modes{name(field), unit(field), degree(field), 0, {}};
    for (const auto& node : nodes) modes.scale = std::max(modes.scale, node.largest_value);
    if (!(modes.scale > 0)) modes.scale = 1;
    _fields.push_back(std::move(modes));
    _shared_of_field.push_back(
        {scaled_table(shared_basis(nodes, _spec.shared_modes, _spec.seed)), _shared.centers, _shared.shape});
  }

  const DatabaseHeader& _header;
  const TrainingTables& _tables;
  TrainingSpec _spec;
  SharedModes _shared;
  std::vector<FieldModes> _fields;  ///< their modes are in _shared_of_field
  std::vector<SharedModes> _shared_of_field;
  std::vector<AmplitudeLevel> _levels;  ///< empty with a single level
  double _amplitude_left_out = 0;
};

std::string model_name(const TrainingSpec& spec) {
  return fmt::format("modal {} of {} modes, {} centers", spec.modes, spec.shared_modes, spec.force_centers);
}

std::string describe_modal(const Model& model) {
  const auto size = sizes_of(model);
  return fmt::format("{} force centers and {} modes each, {} shared modes, {} amplitude centers; trained to {:.4g} m",
                     size.force_centers, size.modes, size.shared_modes, size.amplitude_centers,
                     model.max_displacement_m);
}

std::vector<TrainingFigure> figures_of_modal(const TrainingReport& report) {
  const auto& q = report.modal;
  return {{"force_training_error", "mean error (17) of the force on the training states", q.force_training},
          {"force_left_out_error", "with a direction left out", q.force_left_out},
          {"truncation_error", "of the displacement by truncation", q.truncation},
          {"regression_error", "by regression", q.regression},
          {"amplitude_left_out_error", "of the amplitudes with a direction left out", q.amplitude_left_out}};
}

}  // namespace

const FamilyOperations modal_operations = {
    Family::modal,
    "conservative forces and modes",
    check_modal,
    make_training<ModalTraining>,
    {{"modes", &TrainingSpec::modes},
     {"shared_modes", &TrainingSpec::shared_modes},
     {"near_nodes", &TrainingSpec::near_nodes},
     {"amplitude_centers", &TrainingSpec::amplitude_centers},
     {"force_centers", &TrainingSpec::force_centers}},
    // On the liver of docs/howto/own-organ.md memory and time of a deformation grow by factors of 1.1 to 1.7 between
    // successive sizes. The number of force centers is limited to two thirds of the states of a database, which is 104
    // for 26 directions with 6 increments; larger numbers only take effect with more increments.
    {{3, 12, 8, 20, 20},
     {4, 24, 16, 26, 24},
     {4, 40, 20, 30, 30},
     {6, 40, 20, 52, 40},
     {8, 64, 24, 52, 60},
     {12, 64, 24, 80, 80},
     {16, 64, 40, 80, 80},
     {20, 96, 60, 104, 100},
     {24, 120, 80, 156, 120}},
    model_name,
    describe_modal,
    figures_of_modal};

}  // namespace phynness
