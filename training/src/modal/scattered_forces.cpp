#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/training/node_training.hpp>
#include <phynness/training/scattered_forces.hpp>

namespace phynness {
namespace {

using Eigen::Index;

/// Forces at rest may be noise up to this fraction of the largest force.
constexpr double most_at_rest = 0.05;
constexpr std::size_t fewest_displacements = 6;

void check(const Points& d, const Points& f) {
  if (d.rows() != f.rows())
    throw input_error("every displacement needs a force",
                      std::to_string(d.rows()) + " displacements and " + std::to_string(f.rows()) + " forces",
                      "give arrays with the same number of rows");
  for (const auto& [what, numbers] : {std::pair("displacement", &d), std::pair("force", &f)})
    for (Index i = 0; i < numbers->rows(); ++i)
      if (!numbers->row(i).allFinite())
        throw input_error(std::string("a ") + what + " is not finite", "row " + std::to_string(i),
                          "leave this row out");
  if (d.rows() == 0) return;
  const double largest = f.rowwise().norm().maxCoeff();
  for (Index i = 0; i < d.rows(); ++i)
    if (d.row(i).isZero(0) && f.row(i).norm() > most_at_rest * largest)
      throw input_error("the force at rest is not zero", "row " + std::to_string(i),
                        "measure displacements from where the force vanishes, or subtract this force from all");
  if (d.cwiseProduct(f).sum() < 0)
    throw input_error("the forces point against the displacements", "",
                      "give the forces that hold the displacements, "
                      "which are the negative of reactions");
}

/// The rows but those at rest, by nearest direction and length; some of each direction if they are too many.
std::vector<std::vector<Index>> rows_by_direction(const Points& d, const std::vector<Vec3>& directions) {
  std::vector<std::vector<Index>> rows(directions.size());
  std::size_t n = 0;
  for (Index i = 0; i < d.rows(); ++i) {
    if (d.row(i).isZero(0)) continue;
    const auto along = [&](const Vec3& e) { return d.row(i).dot(to_eigen(e)); };
    const auto nearest = std::max_element(directions.begin(), directions.end(),
                                          [&](const Vec3& a, const Vec3& b) { return along(a) < along(b); });
    rows[static_cast<std::size_t>(nearest - directions.begin())].push_back(i);
    ++n;
  }
  const std::size_t stride = (n + max_training_states - 1) / max_training_states;
  for (auto& some : rows) {
    std::stable_sort(some.begin(), some.end(),
                     [&](Index i, Index j) { return d.row(i).squaredNorm() < d.row(j).squaredNorm(); });
    std::vector<Index> kept;
    for (std::size_t i = 0; i < some.size(); ++i)
      if ((some.size() - 1 - i) % std::max<std::size_t>(1, stride) == 0) kept.push_back(some[i]);
    some = std::move(kept);
  }
  return rows;
}

}  // namespace

ScatteredFit fit_scattered(const Points& d, const Points& f, int max_centers, const std::string& title) {
  check(d, f);
  ScatteredFit result;
  Model& model = result.model;
  model.directions = exploratory_directions(Directions::twenty_six);
  const auto rows = rows_by_direction(d, model.directions);
  std::size_t increments = 0, n = 0;
  for (const auto& some : rows) increments = std::max(increments, some.size()), n += some.size();
  if (n < fewest_displacements)
    throw input_error("there are too few displacements", std::to_string(n),
                      "give at least " + std::to_string(fewest_displacements) + " that are not zero");
  const double R = std::sqrt(d.rowwise().squaredNorm().maxCoeff());

  ActiveNodeModel node;
  node.prescribed = {0};
  node.prescribed_weight = {1};
  ForceStates states;
  states.x.resize(static_cast<Index>(n), 3);
  states.force.resize(static_cast<Index>(n), 3);
  model.displacements.resize(static_cast<Index>(rows.size() * increments), 3);
  for (std::size_t k = 0, state = 0; k < rows.size(); ++k) {
    const auto& some = rows[k];
    node.trained_depth_m.push_back(some.empty() ? 0 : d.row(some.back()).norm());
    // What is left of the block of a direction repeats its deepest displacement.
    for (std::size_t i = 0; i < increments; ++i) {
      const auto row = static_cast<Index>(k * increments + i);
      model.displacements.row(row) = some.empty() ? Eigen::RowVector3d(R * to_eigen(model.directions[k]).transpose())
                                                  : Eigen::RowVector3d(d.row(some[std::min(i, some.size() - 1)]));
      if (i >= some.size()) continue;
      states.x.row(static_cast<Index>(state)) = d.row(some[i]) / R;
      states.force.row(static_cast<Index>(state++)) = f.row(some[i]);
      states.row.push_back(static_cast<std::int32_t>(row));
      states.direction.push_back(static_cast<std::int32_t>(k));
    }
  }
  result.fitted = static_cast<std::int64_t>(n);
  result.fit = fit_conservative(states, R, max_centers);
  node.conservative = result.fit.network;
  node.modal.weights = scaled_table(Eigen::MatrixXd(3, 0));

  model.family = Family::modal;
  model.title = title;
  model.mesh_hash = model.physics_hash = "none";
  model.software_version = software_version();
  model.max_displacement_m = R;
  model.n_mesh_nodes = 1;
  model.output = {0};
  model.output_points = Points::Zero(1, 3);
  model.fixed_points.resize(0, 3);
  model.surface.resize(0, 3);
  model.shared.modes = scaled_table(Eigen::MatrixXd(3, 0));
  model.nodes.push_back(std::move(node));
  return result;
}

}  // namespace phynness
