#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/relaxing_motions.hpp>

#include "shared_work.hpp"

namespace phynness {
namespace {

constexpr double common_depth_m = 0.005, least_Hz = 0.1, most_Hz = 5;
constexpr int depths_of_ray = 24;
constexpr std::size_t n_values = 7;  ///< numbers that ranks exchange for a motion: its index, and MotionResult

/// The fractions of the depth and of the slide over time.
struct Motion {
  const char* name;
  std::vector<double> time_s{}, depth_fraction{}, slide{};
  void add_segment(double seconds, double to, int steps, double slide_by = 0) {
    const double t = time_s.empty() ? 0 : time_s.back(), from = depth_fraction.empty() ? 0 : depth_fraction.back(),
                 at = slide.empty() ? 0 : slide.back();
    for (int i = 1; i <= steps; ++i) {
      time_s.push_back(t + seconds * i / steps);
      depth_fraction.push_back(from + (to - from) * i / steps);
      slide.push_back(at + slide_by * i / steps);
    }
  }
};

std::vector<Motion> motions_of(double frequency_Hz, double slowest_s, bool several_tools) {
  Motion step{"step and hold"}, ramp{"ramp"}, sine{"sine"}, palpation{"palpation"}, slide{"slide"};
  step.add_segment(0.06, 1, 6);
  for (int i = 0; i < 20; ++i)
    step.add_segment(0.02 * std::pow(3 * slowest_s / 0.02, (i + 1) / 20.0) - step.time_s.back() + 0.08, 1, 1);
  ramp.add_segment(2, 1, 24);
  for (int i = 1; i <= 2 * depths_of_ray; ++i) {
    const double turn = static_cast<double>(i) / depths_of_ray;
    sine.add_segment(1 / (depths_of_ray * frequency_Hz), (1 - std::cos(2 * std::numbers::pi * turn)) / 2, 1);
  }
  palpation.add_segment(0.3, 1, 8);
  palpation.add_segment(1, 1, 6);
  palpation.add_segment(0.3, 0, 8);
  palpation.add_segment(1, 0, 4);
  slide.add_segment(0.3, 1, 8);
  slide.add_segment(1, 1, 10, 1);
  if (several_tools) return {sine, palpation};
  return {step, ramp, sine, palpation, slide};
}

/// The errors of a motion at a place; negative values are undefined.
struct MotionResult {
  double model = -1, convolved = -1, elastic = -1, area = -1, convolved_area = -1, warned = 0;
};

/// Forces of all tools, one row per time step.
using Forces = Eigen::MatrixXd;

double mean_error(const Forces& of, const Forces& solved) {
  return (of - solved).rowwise().norm().mean() / solved.rowwise().norm().maxCoeff();
}
/// Work of the last cycle. @param d  displacements, in the layout of the forces
double loop_work(const Forces& forces, const Eigen::MatrixXd& d) {
  double work = 0;
  for (Eigen::Index i = forces.rows() - depths_of_ray; i < forces.rows(); ++i)
    work += (forces.row(i) + forces.row(i - 1)).dot(d.row(i) - d.row(i - 1)) / 2;
  return work;
}

class MotionComparison {
 public:
  MotionComparison(const Scene& scene, const NamedOrgan& model)
      : _scene(scene),
        _model(model),
        _solver(scene, model.mesh(), {model.model().fixed, active_of(model), model.model().output}),
        _normals(node_normals(model.mesh())) {}
  ProbeSolver& solver() { return _solver; }

  /// A direction near the inward normal.
  Eigen::Vector3d direction(std::int32_t node, std::mt19937_64& random) const {
    constexpr double widest = 0.5;  // tangent of the angle
    const Eigen::Vector3d normal = _normals.row(node);
    return (widest * uniform(random) * normal.cross(to_eigen(random_direction(random))) - normal).normalized();
  }

  /// Elastic forces of the finite elements at rest and at 1 ... 24 parts of the depth; empty if one is not solved.
  Forces ray(const std::vector<std::int32_t>& nodes, const std::vector<Vec3>& depth_m) {
    _solver.touch(nodes);
    Forces rows = Forces::Zero(depths_of_ray + 1, static_cast<Eigen::Index>(3 * nodes.size()));
    std::vector<double> fractions;
    for (int i = 1; i <= depths_of_ray; ++i) fractions.push_back(static_cast<double>(i) / depths_of_ray);
    std::size_t solved = 0;
    _solver.follow(depth_m, fractions, false, [&](std::size_t i, const Response& response) {
      if (response.status != Status::converged) return false;
      copy_to_row(response.force_N, rows.row(static_cast<Eigen::Index>(i) + 1));
      return ++solved < fractions.size();
    });
    return solved == fractions.size() ? rows : Forces{};
  }

  /// @param elastic_ray  result of ray(). @return values of -1 if the finite elements do not converge
  MotionResult evaluate(const Motion& motion, const NamedOrgan& organ, const std::vector<std::int32_t>& nodes,
                        const std::vector<Vec3>& depth_m, const Forces& elastic_ray) {
    const auto n = static_cast<Eigen::Index>(motion.time_s.size()), width = static_cast<Eigen::Index>(3 * nodes.size());
    Forces solved(n, width), relaxing(n, width), elastic(n, width), convolved(n, width), d(n, width);
    std::vector<phn_relaxing> history(nodes.size());
    const phn_relaxation& terms = organ.organ().relaxation();
    const Eigen::Vector3d tangent = to_eigen(depth_m[0]).unitOrthogonal();
    const bool slides = motion.slide.back() > 0;
    MotionResult result;
    organ.organ().reset().ignore();
    _solver.touch(nodes);
    _solver.begin_motion(_scene.relaxation);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      std::vector<phn_tool> tools;
      TimeStep step{motion.time_s[at], {}};
      for (std::size_t t = 0; t < nodes.size(); ++t) {
        step.displacement_m.push_back(to_array(motion.depth_fraction[at] * to_eigen(depth_m[t])));
        tools.push_back(tool_at(nodes[t], step.displacement_m.back()));
        if (!slides) continue;
        const Eigen::RowVector3d point =
            _model.mesh().nodes.row(nodes[t]) +
            motion.slide[at] * std::max(_scene.probe.tool_radius_m, common_depth_m) * tangent.transpose();
        if (!organ.organ().nearest(Vec3{point[0], point[1], point[2]}, tools.back()).ok()) return {};
        std::ranges::copy(step.displacement_m.back(), tools.back().displacement);
        SurfacePoint place;
        for (std::size_t k = 0; k < 3; ++k) {
          place.nodes[k] = tools.back().nodes[k];
          place.weights[k] = tools.back().weights[k];
        }
        step.places.push_back(place);
      }
      std::vector<Vec3> forces;
      if (_solver.move(step, forces) != Status::converged) return {};
      copy_to_row(forces, solved.row(i));
      copy_to_row(step.displacement_m, d.row(i));
      const auto response = organ.hold(tools);
      Eigen::VectorXd force(width);
      for (std::size_t t = 0; t < nodes.size(); ++t)
        force.segment<3>(static_cast<Eigen::Index>(3 * t)) = to_eigen(*response.force_N[t]);
      elastic.row(i) = force;
      const double dt_s = motion.time_s[at] - (at > 0 ? motion.time_s[at - 1] : 0);
      const Organ::Status status = organ.organ().relax(tools, dt_s, {force.data(), static_cast<std::size_t>(width)});
      result.warned += status.relaxation() ? 1.0 / static_cast<double>(n) : 0;
      relaxing.row(i) = force;
      if (elastic_ray.size() == 0) continue;
      const double x = motion.depth_fraction[at] * depths_of_ray;
      const auto below = std::min(static_cast<Eigen::Index>(x), Eigen::Index{depths_of_ray} - 1);
      Eigen::VectorXd interpolated = elastic_ray.row(below) + (x - static_cast<double>(below)) *
                                                                  (elastic_ray.row(below + 1) - elastic_ray.row(below));
      for (std::size_t t = 0; t < nodes.size(); ++t)
        phn_relax(&terms, &history[t], interpolated.data() + 3 * t, nullptr, dt_s, interpolated.data() + 3 * t);
      convolved.row(i) = interpolated;
    }
    result.model = mean_error(relaxing, solved);
    result.elastic = mean_error(elastic, solved);
    if (elastic_ray.size() > 0 && !slides) result.convolved = mean_error(convolved, solved);
    if (motion.name == std::string_view("sine")) {
      const double solved_work = loop_work(solved, d);
      const auto error = [&](const Forces& of) { return std::abs(loop_work(of, d) / solved_work - 1); };
      result.area = error(relaxing);
      if (result.convolved >= 0) result.convolved_area = error(convolved);
    }
    return result;
  }

 private:
  static NodeList active_of(const NamedOrgan& model) {
    const auto nodes = model.active_nodes();
    return {nodes.begin(), nodes.end()};
  }
  static Vec3 to_array(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
  static void copy_to_row(const std::vector<Vec3>& vectors, Forces::RowXpr row) {
    for (std::size_t t = 0; t < vectors.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) row[static_cast<Eigen::Index>(3 * t + k)] = vectors[t][k];
  }

  const Scene& _scene;
  const NamedOrgan& _model;
  ProbeSolver _solver;
  Points _normals;
};

/// @throws Error (input) unless the relaxation of a model or a body is that of the scene
void require_terms(const Scene& scene, const phn_relaxation& relaxation, const std::string& name, const char* remedy) {
  const auto& terms = scene.relaxation.terms;
  bool same = relaxation.n_terms == terms.rows();
  for (Eigen::Index i = 0; same && i < terms.rows(); ++i)
    same = relaxation.g[i] == terms(i, 0) && relaxation.tau_s[i] == terms(i, 1);
  if (!same) throw input_error("the relaxation is not that of the scene", name, remedy);
}

void add(double value, double& sum, double& worst) {
  if (value < 0) return;
  sum = (std::isnan(sum) ? 0 : sum) + value;
  worst = std::isnan(worst) ? value : std::max(worst, value);
}

}  // namespace

MotionReport validate_motions(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                              const NamedOrgan* body, std::int64_t places, std::uint64_t seed,
                              const OnProgress& progress, const ShouldStop& stop) {
  if (scene.relaxation.empty())
    throw input_error("nothing relaxes", scene.source_name,
                      "add relaxation to [material] of the scene, and train the model with it");
  require_terms(scene, model.organ().relaxation(), model.name(), "train the model with this scene");
  if (body)
    require_terms(scene, body->organ().relaxation(), body->name(), "make the body with phynness reduce --scene SCENE");
  const auto start = std::chrono::steady_clock::now();
  MotionReport report;
  report.places = places;
  std::vector<double> depths{std::min(common_depth_m, scene.probe.max_displacement_m)};
  if (scene.probe.max_displacement_m > common_depth_m) depths.push_back(scene.probe.max_displacement_m);
  const double slowest_s = scene.relaxation.terms.col(1).maxCoeff();
  for (const int n_tools : {1, 2})
    for (const double depth : depths)
      for (const auto& motion : motions_of(1, slowest_s, n_tools > 1))
        if (n_tools == 1 || body)
          report.motions.push_back(
              {motion.name + (", " + number_text(1e3 * depth)) + " mm" + (n_tools > 1 ? ", two tools" : ""), {}});
  MotionComparison comparison(scene, model);
  comparison.solver().set_stop(stop);
  comparison.solver().begin_motion(scene.relaxation);  // refuses other elements
  std::vector<double> values;
  const auto finished = distribute(session, places, progress, stop, [&](std::size_t place) {
    std::mt19937_64 random(seed * 1'000'003 + place);
    const auto active = model.active_nodes();
    std::vector<std::int32_t> nodes{random_element(active, random)};
    const double frequency_Hz =
        least_Hz *
        std::pow(most_Hz / least_Hz, static_cast<double>(place) / std::max(1.0, static_cast<double>(places - 1)));
    std::vector<double> place_values;
    double number = 0;
    for (const int n_tools : {1, 2}) {
      if (n_tools == 2 && !body) break;
      while (std::ssize(nodes) < n_tools) {
        const auto other = random_element(active, random);
        if (other != nodes[0]) nodes.push_back(other);
      }
      std::vector<Eigen::Vector3d> directions;
      for (const auto node : nodes) directions.push_back(comparison.direction(node, random));
      for (const double depth : depths) {
        std::vector<Vec3> depth_m;
        for (const auto& e : directions) depth_m.push_back({depth * e[0], depth * e[1], depth * e[2]});
        const auto or_empty = [&](auto&& work) {
          try {
            return work();
          } catch (const Interrupted&) {
            throw;
          } catch (const std::exception&) {
            comparison.solver().recover();
            return decltype(work()){};
          }
        };
        const Forces ray = or_empty([&] { return comparison.ray(nodes, depth_m); });
        for (const auto& motion : motions_of(frequency_Hz, slowest_s, n_tools > 1)) {
          const MotionResult j =
              or_empty([&] { return comparison.evaluate(motion, n_tools > 1 ? *body : model, nodes, depth_m, ray); });
          place_values.insert(place_values.end(),
                              {number++, j.model, j.convolved, j.elastic, j.area, j.convolved_area, j.warned});
        }
      }
    }
    values.insert(values.end(), place_values.begin(), place_values.end());
  });
  report.finished = session.total(finished);
  const auto all = session.gather(values);
  double unused = undefined;
  for (std::size_t i = 0; i + n_values <= all.size(); i += n_values) {
    auto& errors = report.motions[static_cast<std::size_t>(all[i])].second;
    ++(all[i + 1] < 0 ? errors.failed : errors.places);
    add(all[i + 1], errors.mean, errors.worst);
    add(all[i + 2], errors.convolved_mean, errors.convolved_worst);
    add(all[i + 3], errors.elastic, unused);
    add(all[i + 4], errors.area_mean, errors.area_worst);
    add(all[i + 5], errors.convolved_area, unused);
    errors.warned += all[i + 6];
  }
  for (auto& [name, errors] : report.motions)
    for (double* sum : {&errors.mean, &errors.convolved_mean, &errors.elastic, &errors.area_mean,
                        &errors.convolved_area, &errors.warned})
      *sum /= static_cast<double>(std::max<std::int64_t>(errors.places, 1));
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

std::vector<std::vector<std::string>> MotionReport::cells() const {
  const auto percent = [](double value) {
    return std::isnan(value) ? std::string("-") : number_text(100 * value, std::chars_format::fixed, 2);
  };
  std::vector<std::vector<std::string>> rows{{"relaxing, % of largest", "places", "mean", "worst", "convolved",
                                              "elastic", "area", "worst", "conv.", "warned"}};
  for (const auto& [name, e] : motions)
    rows.push_back({name, number_text(e.places), percent(e.mean), percent(e.worst), percent(e.convolved_mean),
                    percent(e.elastic), percent(e.area_mean), percent(e.area_worst), percent(e.convolved_area),
                    percent(e.warned)});
  return rows;
}

}  // namespace phynness
