#include "study_models.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/training/spread_search.hpp>

#include "fixed_shapes.hpp"

namespace phynness::study {
namespace {

/// The same numbers as in training.
constexpr std::size_t n_center_nodes = 12, n_search_nodes = 5;

template <class T>
std::vector<T> some_of(const std::vector<T>& all, std::size_t wanted) {
  std::vector<T> some;
  const std::size_t n = std::min(wanted, all.size());
  for (std::size_t i = 0; i < n; ++i) some.push_back(all[(2 * i + 1) * all.size() / (2 * n)]);
  return some;
}

/// train() throws the same error.
void require_a_node(const Model& model) {
  if (model.nodes.empty()) throw input_error("no active node has a converged increment", "", "");
}

}  // namespace

StudiedModal train_modal(const StudyData& data, const TrainingSpec& spec, const ForcedShapes& forced) {
  const TrainingTables tables = training_tables(data.header);
  StudiedModal studied;
  Model& model = studied.model;
  model = model_of_database(data.header, Family::modal, "");
  model.displacements = tables.displacements;
  std::vector<NodeModes> basis;
  for (const auto* list : {&data.others, &data.probed})
    for (const auto& node : *list) basis.push_back(node_modes(tables, node.tool, node.rays, spec.modes));
  model.shared.modes = scaled_table(shared_basis(basis, spec.shared_modes, spec.seed));
  const auto some = some_of(basis, n_center_nodes);
  const auto centers = forced.amplitude > 0
                           ? amplitude_centers_of_shape(tables, some, spec.amplitude_centers, forced.amplitude)
                           : choose_amplitude_centers(tables, some, spec.amplitude_centers);
  model.shared.centers = centers.row;
  model.shared.shape = centers.shape;
  for (const auto& node : data.probed) {
    NodeFit fit;
    fit.states = force_states(tables, node.rays);
    if (fit.states.row.empty()) continue;
    const double R = tables.magnitudes_m.back();
    fit.force = forced.force > 0 ? fit_conservative_of_shape(fit.states, R, spec.force_centers, forced.force)
                                 : fit_conservative(fit.states, R, spec.force_centers);
    fit.modes = node_modes(tables, node.tool, node.rays, spec.modes);
    fit.modal = fit_modal(tables, model.shared, fit.modes, spec.near_nodes);
    auto described = describe_node(tables, node.node, node.point, node.tool, node.rays);
    described.conservative = fit.force.network;
    described.modal = fit.modal.deformation;
    model.nodes.push_back(std::move(described));
    studied.fits.push_back(std::move(fit));
  }
  require_a_node(model);
  return studied;
}

Model train_rbfn(const StudyData& data, TrainingSpec spec, double& diagonal_ratio) {
  const TrainingTables tables = training_tables(data.header);
  Model model = model_of_database(data.header, Family::rbfn, "");
  model.displacements = tables.displacements;
  std::vector<SearchNode> search;
  for (const auto& node : some_of(data.others, n_search_nodes)) search.push_back({node.node, node.tool, node.rays});
  if (!(spec.force_spread > 0)) spec.force_spread = search_force_spread(tables, search, spec);
  if (!(spec.deformation_spread > 0)) spec.deformation_spread = search_deformation_spread(tables, search, spec);
  // As in training if no node has enough points for a search.
  if (!(spec.force_spread > 0)) spec.force_spread = 1;
  if (!(spec.deformation_spread > 0)) spec.deformation_spread = 1;
  diagonal_ratio = 1;
  for (const auto& node : data.probed) {
    auto training = train_node(tables, node.node, node.point, node.tool, node.rays, spec);
    if (!training.trained) continue;
    diagonal_ratio = std::max({diagonal_ratio, training.force.diagonal_ratio, training.deformation.diagonal_ratio});
    model.nodes.push_back(std::move(training.model));
  }
  require_a_node(model);
  return model;
}

Model without_response(const Database& database, double tool_radius_m) {
  const auto& header = database.header();
  const auto statuses = database.statuses();
  const TrainingTables tables = training_tables(header);
  Model model = model_of_database(header, Family::modal, "");
  model.displacements = tables.displacements;
  model.shared.modes = scaled_table(Eigen::MatrixXd(3 * static_cast<Eigen::Index>(header.sets.output.size()), 0));
  auto status = statuses.begin();
  for (const auto node : header.sets.active) {
    std::vector<Ray> rays(header.directions.size());
    for (auto& ray : rays) {
      const auto next = status + tables.n_increments;
      ray.status.assign(status, next);
      status = next;
    }
    if (converged_increments(tables, rays).empty()) continue;
    const auto x = header.mesh.nodes.row(node);
    auto described = describe_node(
        tables, node, {x[0], x[1], x[2]},
        touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, at_node(node), tool_radius_m), rays);
    described.conservative.coefficients.resize(0, 3);
    described.modal.weights = scaled_table(Eigen::MatrixXd(3, 0));
    model.nodes.push_back(std::move(described));
  }
  return model;
}

LoadedModel loaded(const Model& model, const Mesh& mesh) { return LoadedModel(model, mesh, "the study's model"); }

}  // namespace phynness::study
