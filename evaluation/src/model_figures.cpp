#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <phynness/evaluation/model_figures.hpp>
#include <phynness/formats/error.hpp>

namespace phynness {
namespace {

/// One converged increment: displacement, force, and the displacement of the output nodes in one row.
struct TrainedState {
  Eigen::Vector3d d, f;
  Eigen::VectorXd u;
};

/// Up to the first increment without a result.
std::vector<TrainedState> states_of(const Ray& ray, const DatabaseHeader& header, bool only_first) {
  const auto n_output = static_cast<Eigen::Index>(header.sets.output.size());
  const Eigen::Vector3d direction = to_eigen(header.directions[static_cast<std::size_t>(ray.direction)]);
  std::vector<TrainedState> states;
  for (std::size_t i = 0; i < ray.status.size() && ray.status[i] == Status::converged; ++i) {
    states.push_back({header.magnitudes_m[i] * direction, Eigen::Map<const Eigen::Vector3d>(&ray.force[3 * i]),
                      Eigen::Map<const Eigen::VectorXd>(ray.displacement.data() + 3 * n_output * static_cast<int>(i),
                                                        3 * n_output)});
    if (only_first) break;
  }
  return states;
}

/// Force and displacements per metre, least squares over first increments.
struct LinearResponses {
  Eigen::Matrix3d force;
  Eigen::MatrixXd u;  ///< 3 n_output x 3
};

std::optional<LinearResponses> linear_responses(const std::vector<Ray>& rays, const DatabaseHeader& header) {
  Eigen::Matrix3d dd = Eigen::Matrix3d::Zero(), fd = dd;
  Eigen::MatrixXd ud = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(header.sets.output.size()), 3);
  double size = 0;
  for (const auto& ray : rays)
    for (const auto& state : states_of(ray, header, true)) {
      dd += state.d * state.d.transpose();
      fd += state.f * state.d.transpose();
      ud += state.u * state.d.transpose();
      size = std::max(size, state.d.squaredNorm());
    }
  const Eigen::FullPivLU<Eigen::Matrix3d> factors(dd);
  if (!(size > 0) || factors.rank() < 3) return std::nullopt;
  const Eigen::Matrix3d inverse = factors.inverse();
  return LinearResponses{fd * inverse, ud * inverse};
}

/// Sums of errors of one node, and their number.
struct Sums {
  double force = 0, displacement = 0, force_linear = 0, displacement_linear = 0, n = 0, largest_force = 0,
         largest_u = 0;

  void add_force(const TrainedState& state, const Vec3& said, const LinearResponses& linear) {
    force += (Eigen::Vector3d(said[0], said[1], said[2]) - state.f).norm();
    force_linear += (linear.force * state.d - state.f).norm();
    largest_force = std::max(largest_force, state.f.norm());
    n += 1;
  }

  void add_displacement(const TrainedState& state, const Points& said, const Eigen::VectorXd& linear,
                        const std::vector<char>& counts) {
    double errors = 0, errors_linear = 0, counted = 0;
    for (std::size_t o = 0; o < counts.size(); ++o) {
      if (!counts[o]) continue;
      const auto at = static_cast<Eigen::Index>(o);
      const Eigen::Vector3d truth = state.u.segment<3>(3 * at);
      errors += (said.row(at).transpose() - truth).norm();
      errors_linear += (linear.segment<3>(3 * at) - truth).norm();
      largest_u = std::max(largest_u, truth.norm());
      counted += 1;
    }
    if (counted == 0) return;
    displacement += errors / counted;
    displacement_linear += errors_linear / counted;
  }
};

std::vector<char> counted_output(const ActiveNodeModel& node, const std::vector<std::int32_t>& output) {
  std::vector<char> counts(output.size());
  for (std::size_t o = 0; o < output.size(); ++o)
    counts[o] = !std::binary_search(node.prescribed.begin(), node.prescribed.end(), output[o]);
  return counts;
}

std::optional<Sums> sums_of(const LoadedModel& model, const ActiveNodeModel& node, const std::vector<Ray>& rays,
                            const DatabaseHeader& header) {
  const auto linear = linear_responses(rays, header);
  if (!linear) return std::nullopt;
  const auto counts = counted_output(node, model.model().output);
  Sums sums;
  for (const auto& ray : rays)
    for (const auto& state : states_of(ray, header, false)) {
      const auto said = model.respond({node.node}, {Vec3{state.d[0], state.d[1], state.d[2]}});
      sums.add_force(state, *said.force_N[0], *linear);
      if (said.displacement_m.rows() > 0)
        sums.add_displacement(state, said.displacement_m, linear->u * state.d, counts);
    }
  return sums;
}

}  // namespace

DatabaseErrors errors_on_database(const LoadedModel& model, const Database& database, std::size_t most_nodes) {
  const auto& header = database.header();
  const auto& nodes = model.model().nodes;
  DatabaseErrors errors;
  const std::size_t n = std::min(most_nodes, nodes.size());
  for (std::size_t i = 0; i < n; ++i) {
    const auto& node = nodes[i * nodes.size() / n];
    const auto active = std::lower_bound(header.sets.active.begin(), header.sets.active.end(), node.node);
    const auto rays = database.rays(static_cast<std::int32_t>(active - header.sets.active.begin()));
    const auto sums = sums_of(model, node, rays, header);
    if (!sums || !(sums->largest_force > 0)) continue;
    ++errors.nodes;
    errors.force += sums->force / (sums->n * sums->largest_force);
    errors.force_linear += sums->force_linear / (sums->n * sums->largest_force);
    if (!(sums->largest_u > 0)) continue;
    errors.displacement = errors.displacement.value_or(0) + sums->displacement / (sums->n * sums->largest_u);
    errors.displacement_linear =
        errors.displacement_linear.value_or(0) + sums->displacement_linear / (sums->n * sums->largest_u);
  }
  const auto n_compared = std::max<double>(1, static_cast<double>(errors.nodes));
  for (auto* error : {&errors.force, &errors.force_linear}) *error /= n_compared;
  for (auto* error : {&errors.displacement, &errors.displacement_linear})
    if (*error) **error /= n_compared;
  return errors;
}

namespace {

/// The median over several batches of the mean time of a call in a batch [us].
template <typename Call>
double median_us(int batches, int calls, const Call& call) {
  std::vector<double> times;
  for (int b = 0; b < batches; ++b) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) call(i);
    const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
    times.push_back(spent.count() / calls);
  }
  std::nth_element(times.begin(), times.begin() + batches / 2, times.end());
  return times[static_cast<std::size_t>(batches / 2)];
}

}  // namespace

RuntimeSpeed measure_speed(const LoadedModel& model) {
  const auto nodes = model.runtime().active_nodes();
  if (nodes.size() == 0) return {};
  const double depth = model.runtime().info().max_displacement_m;
  std::vector<double> u(3 * static_cast<std::size_t>(model.runtime().n_output()));
  double f[3], sink = 0;
  // The displacement changes from call to call, as that of a moving hand.
  const auto displacement = [&](int i, double* d) {
    for (int k = 0; k < 3; ++k) d[k] = depth * 0.01 * ((i * (k + 3)) % 50);
  };
  RuntimeSpeed speed;
  speed.force_us = median_us(15, 200, [&](int i) {
    double d[3];
    displacement(i, d);
    model.data().force(nodes[static_cast<std::size_t>(i) % nodes.size()], d, f).ignore();
    sink += f[0];
  });
  // A tool stays at a node for many frames, so that the preparation of the node is not measured.
  std::vector<double> times;
  for (std::size_t b = 0; b < 7; ++b) {
    const auto node = nodes[b * nodes.size() / 7];
    model.data().prepare(node).ignore();
    times.push_back(median_us(1, 5, [&](int i) {
      double d[3];
      displacement(i, d);
      model.data().deform(node, d, u).ignore();
      sink += u[0];
    }));
  }
  std::nth_element(times.begin(), times.begin() + 3, times.end());
  if (model.data().deform(nodes[0], Vec3{}, u).ok()) speed.deformation_us = times[3];
  if (model.runtime().n_fields() > 0)
    speed.field_us = median_us(7, 5, [&](int i) {
      double d[3];
      displacement(i, d);
      const auto node = nodes[static_cast<std::size_t>(i) % nodes.size()];
      model.data().field(node, d, 0, u).ignore();
      sink += u[0];
    });
  volatile double keep = sink;  // prevents the compiler from removing the calls
  static_cast<void>(keep);
  return speed;
}

}  // namespace phynness
