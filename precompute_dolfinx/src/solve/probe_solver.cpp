#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/probe_solver.hpp>

#include "discretization.hpp"
#include "nodal_fields.hpp"
#include "ray_solver.hpp"
#include "relaxing_body.hpp"
#include "scaling.hpp"

namespace phynness {
namespace {

Mesh without_dimension(const Mesh& mesh, double length_m) {
  Mesh scaled = mesh;
  scaled.nodes /= length_m;
  return scaled;
}

FormSet forms_of(const Scene& scene, const Scaling& scaling) {
  std::vector<Material> regions;
  for (const auto& region : scene.regions) regions.push_back(region.material);
  return form_set(scene.material, scene.solver.element, scaling.modulus_Pa, scene.mesh.thickness_m / scaling.length_m,
                  regions);
}

}  // namespace

struct ProbeSolver::Impl {
  Impl(const Scene& s, const Mesh& mesh, const NodeSets& sets)
      : scene(s),
        scaling(Scaling::of(mesh, s.material)),
        body(without_dimension(mesh, scaling.length_m), forms_of(s, scaling), cell_regions(s, mesh)),
        fixed(fixed_points(body, sets.fixed)),
        equilibrium(body, fixed_dofs(body, fixed), s.solver),
        rays(body, equilibrium, s.solver),
        fields(body, s.database.fields) {
    if (!hold_the_body(mesh, sets.fixed))
      throw input_error("the fixed nodes do not hold the body", std::to_string(sets.fixed.size()) + " fixed nodes",
                        "fix at least three nodes that are not on one line");
  }

  Scene scene;
  Scaling scaling;
  Discretization body;
  std::vector<char> fixed;
  Equilibrium equilibrium;
  RaySolver rays;
  NodalFields fields;
  std::size_t n_tools = 0;
  bool has_factors_at_rest = false;  ///< the factors are those of the untouched body at rest
  RaySolver::Rest rest;
  RestResponse rest_SI;
  struct Motion {
    RelaxingBody relaxing;
    std::vector<double> state;
    Eigen::VectorXd q;  ///< parameters
    double time_s = 0;
  };
  std::optional<Motion> motion;

  double radius() const { return scene.probe.tool_radius_m / scaling.length_m; }

  /// @throws Error (input) unless the node is of the surface and free
  void check_touched(std::int32_t node) const {
    const auto value = "node " + std::to_string(node);
    if (node < 0 || node >= body.n_nodes())
      throw input_error("the mesh has no such node", value,
                        "give a number from 0 to " + std::to_string(body.n_nodes() - 1));
    if (!body.on_surface(node))
      throw input_error("the touched node is inside the body", value, "touch a node of the surface");
    if (fixed[node]) throw input_error("the touched node is fixed", value, "touch a node that can move");
  }

  /// Prescribes the tools and computes their responses at rest.
  void touch(const std::vector<SurfacePoint>& tools) {
    has_factors_at_rest = false;
    equilibrium.prescribe(tool_constraint(body, tools, radius(), fixed));
    n_tools = tools.size();
    rest = rays.rest();
    rest_SI.stiffness_N_per_m = rest.tangent * scaling.stiffness_N_per_m();
    rest_SI.sensitivity = of_nodes(rest.sensitivity);
  }

  void check_touched(const SurfacePoint& point) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (point.weights[k] > 0 && !(point.weights[k] < 1 && fixed.at(static_cast<std::size_t>(point.nodes[k]))))
        check_touched(point.nodes[k]);
  }

  RestResponse single_tool_at_rest(const SurfacePoint& point) {
    check_touched(point);
    if (!has_factors_at_rest) {
      equilibrium.prescribe({});
      n_tools = 0;
      rest = rays.rest();
      has_factors_at_rest = true;
    }
    const auto weights = mean_weights(body, point, radius(), fixed);
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(body.n_dofs(), 3);
    for (int p = 0; p < body.n_points(); ++p)
      for (int k = 0; k < 3; ++k) loads(body.dofs(p)[k], k) = weights[static_cast<std::size_t>(p)];
    const Eigen::MatrixXd change = equilibrium.load_response(loads);
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Constant(std::nan(""));
    if (change.size() > 0) stiffness = Eigen::Matrix3d(loads.transpose() * change).inverse();
    if (!stiffness.allFinite())
      throw failure("the response at rest could not be computed", "node " + std::to_string(point.nodes[0]),
                    "write [probe] elsewhere = \"none\", which leaves it out");
    return {0.5 * (stiffness + stiffness.transpose()) * scaling.stiffness_N_per_m(), of_nodes(change * stiffness)};
  }

  /// Rows of the nodes, in their order, of derivatives of the state.
  Eigen::MatrixXd of_nodes(const Eigen::MatrixXd& of_dofs) const {
    Eigen::MatrixXd rows(3 * body.n_nodes(), of_dofs.cols());
    for (int i = 0; i < body.n_nodes(); ++i)
      for (int k = 0; k < 3; ++k) rows.row(3 * i + k) = of_dofs.row(body.dofs(i)[k]);
    return rows;
  }

  void set_zero(Response& response) const {
    response.force_N.assign(n_tools, Vec3{});
    response.displacement_m = Points::Zero(body.n_nodes(), 3);
    response.fields.setZero(body.n_nodes(), static_cast<Eigen::Index>(scene.database.fields.size()));
  }

  Points displacement(std::span<const double> state) const {
    Points u(body.n_nodes(), 3);
    for (int i = 0; i < body.n_nodes(); ++i)
      for (int k = 0; k < 3; ++k) u(i, k) = scaling.length_m * state[body.dofs(i)[k]];
    return u;
  }

  /// Three dimensionless parameters for each tool.
  Eigen::VectorXd parameters(const std::vector<Vec3>& displacement_m) const {
    return Eigen::VectorXd::Map(displacement_m.front().data(), 3 * std::ssize(displacement_m)) / scaling.length_m;
  }

  /// Forces of the tools, from three dimensionless forces for each tool.
  std::vector<Vec3> forces_N(const Eigen::VectorXd& force) const {
    std::vector<Vec3> forces(n_tools);
    Eigen::VectorXd::Map(forces.front().data(), force.size()) = force * scaling.force_N();
    return forces;
  }

  /// Fields in their units: stresses and energy densities have the unit of moduli.
  Eigen::MatrixXd fields_of(std::span<const double> state) const {
    return scaling.modulus_Pa * fields.at_nodes(body, state);
  }
};

ProbeSolver::ProbeSolver(const Scene& scene, const Mesh& mesh, const NodeSets& sets)
    : _impl(std::make_unique<Impl>(scene, mesh, sets)) {}
ProbeSolver::~ProbeSolver() = default;
ProbeSolver::ProbeSolver(ProbeSolver&&) noexcept = default;

int ProbeSolver::n_dofs() const { return _impl->body.n_dofs(); }
void ProbeSolver::recover() {
  _impl->has_factors_at_rest = false;
  _impl->equilibrium.recover();
}
void ProbeSolver::set_stop(std::function<bool()> stop, double patience_s) {
  _impl->equilibrium.set_stop(std::move(stop), patience_s);
}
SolverCounts ProbeSolver::counts() const { return _impl->equilibrium.counts(); }

void ProbeSolver::check_touched(std::int32_t node) const { _impl->check_touched(node); }

void ProbeSolver::touch(const std::vector<std::int32_t>& nodes) {
  std::vector<SurfacePoint> points;
  for (const auto node : nodes) points.push_back(at_node(node));
  touch_points(points);
}

void ProbeSolver::touch_points(const std::vector<SurfacePoint>& points) {
  for (const auto& point : points) _impl->check_touched(point);
  _impl->touch(points);
}

RestResponse ProbeSolver::single_tool_at_rest(const SurfacePoint& point) { return _impl->single_tool_at_rest(point); }

const RestResponse& ProbeSolver::rest() const { return _impl->rest_SI; }

Eigen::MatrixXd ProbeSolver::linear_fields(const std::vector<Vec3>& displacement_m) const {
  // The strains near a tool are then about 1e-4, at which the effects of rounding and of nonlinearity are both small.
  constexpr double small = 1e-5;
  const auto& s = *_impl;
  const Eigen::VectorXd change = s.rest.sensitivity * s.parameters(displacement_m);
  double largest = 0;
  for (int i = 0; i < s.body.n_nodes(); ++i)
    for (const auto dof : s.body.dofs(i)) largest = std::max(largest, std::abs(change[dof]));
  const double scale = small / largest;
  std::vector<double> state(static_cast<std::size_t>(change.size()));
  Eigen::Map<Eigen::VectorXd>(state.data(), change.size()) = scale * change;
  Eigen::MatrixXd fields = s.fields_of(state);
  for (std::size_t f = 0; f < s.scene.database.fields.size(); ++f)
    fields.col(static_cast<Eigen::Index>(f)) *= std::pow(scale, -degree(s.scene.database.fields[f]));
  return fields;
}

RayEnd ProbeSolver::follow(const std::vector<Vec3>& displacement_m, const std::vector<double>& s_values, bool tangents,
                           const std::function<bool(std::size_t, const Response&)>& on_response,
                           const RayLimits& limits) {
  auto& s = *_impl;
  if (displacement_m.size() != s.n_tools) throw std::logic_error("follow: one displacement per touched tool");
  const Eigen::VectorXd direction = s.parameters(displacement_m);

  PathLimits path_limits{limits, limits.max_force_N / s.scaling.force_N()};
  auto end = s.rays.follow(
      s.rest, direction, s_values, tangents,
      [&](std::size_t i, const PathStep& step, const PathPoint& point) {
        Response response;
        response.status = step.status;
        response.iterations = step.iterations;
        response.cutbacks = step.cutbacks;
        if (step.status == Status::converged) {
          response.fields = s.fields_of(point.state);
          if (!response.fields.allFinite()) response.status = Status::not_finite;
        }
        if (response.status != Status::converged) {
          s.set_zero(response);
          return on_response(i, response);
        }
        response.force_N = s.forces_N(point.force);
        response.energy_J = point.energy * s.scaling.energy_J();
        response.tangent_N_per_m = point.tangent * s.scaling.stiffness_N_per_m();
        response.negative_pivots = point.negative_pivots;
        response.min_jacobian = point.min_jacobian;
        response.displacement_m = s.displacement(point.state);
        return on_response(i, response);
      },
      path_limits);
  end.energy_lost_J *= s.scaling.energy_J();
  return end;
}

RayLimits ProbeSolver::limits_of_rays() const {
  const ProbeSpec& probe = _impl->scene.probe;
  const double resolution_m = std::ldexp(probe.max_displacement_m / probe.increments, -fold_halvings);
  return {true, probe.stop_at_fold, resolution_m, probe.min_jacobian, probe.max_force_N};
}

Response ProbeSolver::solve(const std::vector<Vec3>& displacement_m, int increments, bool tangents) {
  const bool at_rest = std::all_of(displacement_m.begin(), displacement_m.end(), [](const Vec3& d) {
    return d == Vec3{0, 0, 0};
  });
  Response last;
  if (at_rest) {
    _impl->set_zero(last);
    last.negative_pivots = _impl->rest.negative_pivots;
    if (tangents) last.tangent_N_per_m = _impl->rest_SI.stiffness_N_per_m;
    return last;
  }
  std::vector<double> s_values;
  for (int i = 1; i <= increments; ++i) s_values.push_back(static_cast<double>(i) / increments);
  int iterations = 0, cutbacks = 0;
  follow(displacement_m, s_values, tangents, [&](std::size_t, const Response& response) {
    iterations += response.iterations;
    cutbacks += response.cutbacks;
    last = response;
    return response.status == Status::converged;
  });
  last.iterations = iterations;
  last.cutbacks = cutbacks;
  return last;
}

void ProbeSolver::begin_motion(const Relaxation& relaxation) {
  auto& s = *_impl;
  if (!has_relaxation(s.scene.solver.element))
    throw input_error("a body that relaxes is not solved with this element", name(s.scene.solver.element),
                      "use element = \"P1\", \"p1-p1\" or \"es-p1-p1\", whose cells have one strain each");
  s.motion.emplace(Impl::Motion{{s.body, s.scene.material, relaxation},
                                std::vector<double>(static_cast<std::size_t>(s.body.n_dofs()), 0.0),
                                Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * s.n_tools))});
}

Status ProbeSolver::move(const TimeStep& step, std::vector<Vec3>& force_N) {
  auto& s = *_impl;
  auto& [relaxing, state, q, time_s] = s.motion.value();
  const double dt_s = step.time_s - time_s;
  if (!(dt_s > 0) || !std::isfinite(dt_s))
    throw input_error("the times of a motion must ascend from above 0", number_text(step.time_s) + " s",
                      "sort the steps by time; the body is at rest before");
  if (!step.places.empty()) s.equilibrium.prescribe(tool_constraint(s.body, step.places, s.radius(), s.fixed));
  const double longest = s.scene.probe.max_displacement_m / s.scene.probe.increments / s.scaling.length_m;
  const double least = std::ldexp(1.0, -s.scene.solver.max_cutbacks);
  const Eigen::VectorXd change = s.parameters(step.displacement_m) - q;
  s.body.set_extra_energy(&relaxing);
  const struct End {  // also of an exception
    Discretization& body;
    ~End() { body.set_extra_energy(nullptr); }
  } end{s.body};
  const auto& constraint = s.equilibrium.constraint();
  Eigen::VectorXd force;
  double part = 1 / std::max(1.0, std::ceil(change.lpNorm<Eigen::Infinity>() / longest));
  for (double done = 0; done < 1;) {
    part = std::min(part, 1 - done);
    auto trial = state;
    as_vector(trial) += s.rest.sensitivity * (part * change);
    constraint.complete(trial, constraint.G * (q + part * change));
    relaxing.begin_step(part * dt_s);
    const auto outcome = s.equilibrium.solve(trial);
    if (outcome.status != Status::converged) {
      if ((part /= 2) < least / 64) return outcome.status;
      continue;
    }
    relaxing.end_step(trial);
    state = std::move(trial);
    q += part * change;
    force = outcome.force;
    done = done + part > 1 - 1e-9 ? 1 : done + part;
  }
  time_s = step.time_s;
  force_N = s.forces_N(force);
  return Status::converged;
}

}  // namespace phynness
