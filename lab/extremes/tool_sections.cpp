#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <phynness/meshes/meshes.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <random>

#include "model_body.hpp"
#include "sections.hpp"

namespace phynness::extremes {
namespace {

using Eigen::Vector3d;

SurfacePoint held(const phn_tool& tool) {
  SurfacePoint point;
  for (std::size_t k = 0; k < 3; ++k) {
    point.nodes[k] = tool.nodes[k];
    point.weights[k] = tool.weights[k];
  }
  return point;
}

Vector3d total(const std::vector<std::optional<Vec3>>& forces) {
  Vector3d sum(0, 0, 0);
  for (const auto& f : forces) sum += Vector3d((*f)[0], (*f)[1], (*f)[2]);
  return sum;
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[v.size() / 2];
}

double largest(const std::vector<double>& v) {
  double most = 0;
  for (const double x : v) most = std::max(most, x);
  return most;
}

/// Two points of a triangle of active corners at the distance `apart_m`.
bool place(const LoadedModel& model, std::mt19937_64& random, double apart_m, phn_tool (&pair)[2]) {
  const auto& m = model.model();
  const auto active = [&](std::int32_t node) {
    return std::any_of(m.nodes.begin(), m.nodes.end(), [&](const auto& n) { return n.node == node; });
  };
  const auto t = static_cast<Eigen::Index>(uniform(random) * static_cast<double>(m.surface.rows()));
  Eigen::Matrix3d x;
  for (int k = 0; k < 3; ++k) {
    if (!active(m.surface(t, k))) return false;
    x.col(k) = model.mesh().nodes.row(m.surface(t, k)).transpose();
  }
  const double s = std::sqrt(uniform(random)), q = uniform(random), angle = 2 * M_PI * uniform(random);
  const Vector3d along = (x.col(1) - x.col(0)).normalized(),
                 across = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).cross(along).normalized();
  Vector3d at[2];
  at[0] = x * Vector3d(1 - s, s * (1 - q), s * q);
  at[1] = at[0] + apart_m * (std::cos(angle) * along + std::sin(angle) * across);
  for (int i = 0; i < 2; ++i) {
    double point[3];
    if (!model.runtime().nearest(at[i], pair[i], point).ok()) return false;
    for (int k = 0; k < 3; ++k)
      if (pair[i].weights[k] > 0 && !active(pair[i].nodes[k])) return false;
    // For a point outside of the triangle the nearest point of the surface is a different one.
    if (i == 1) {
      double first[3];
      phn_tool again;
      model.runtime().nearest(at[0], again, first).ignore();
      const double d = (Vector3d::Map(point) - Vector3d::Map(first)).norm();
      if (apart_m > 0 && std::abs(d / apart_m - 1) > 0.3) return false;
    }
  }
  return true;
}

}  // namespace

void tools(const SolverSession&) {
  constexpr int n_pairs = 30;
  constexpr double depth_m = 0.005;
  const auto body = solve_body("demo.toml");
  const auto model = train_on(body.data, training_of(body.scene, Family::modal));
  ProbeSolver solver(body.scene, body.mesh(), body.data.header.sets);
  fmt::print(
      "\nTwo tools closer than an edge ({:.0f} mm on average): the demo's liver, family modal, {} pairs of points at "
      "random, both {:g} mm\n"
      "deep. Together: both tools have the same displacement; apart: random displacements. "
      "Unsettled by\n"
      "status; larger force of the two tools over that of one tool alone, median and largest; error of the summed "
      "force over\n"
      "the finite elements', median and largest, in %, of the pairs that these solve\n",
      1e3 * measure_quality(body.mesh()).mean_edge_m, n_pairs, 1e3 * depth_m);
  fmt::print("{:<10}{:>10}{:>11}{:>20}{:>9}{:>20}\n", "", "distance", "unsettled", "over one tool", "solved",
             "error, %");
  for (const bool together : {true, false})
    for (const double apart_m : {0.0, 1e-6, 1e-4, 1e-3, 0.005, 0.01, 0.02, 0.04}) {
      std::mt19937_64 random(3);
      int unsettled = 0, solved = 0;
      std::vector<double> over, error;
      for (int pair = 0; pair < n_pairs;) {
        phn_tool tool[2];
        if (!place(model, random, apart_m, tool)) continue;
        ++pair;
        const Vec3 e = on_sphere(random), other = on_sphere(random);
        for (int k = 0; k < 3; ++k) {
          tool[0].displacement[k] = depth_m * e[static_cast<std::size_t>(k)];
          tool[1].displacement[k] = depth_m * (together ? e : other)[static_cast<std::size_t>(k)];
        }
        const auto both = model.couple({tool[0], tool[1]});
        unsettled += (both.status & PHN_WARNING_UNSETTLED) != 0;
        double alone = 0, worse = 0;
        for (int i = 0; i < 2; ++i) {
          const auto& f = *both.force_N[static_cast<std::size_t>(i)];
          worse = std::max(worse, Vector3d(f[0], f[1], f[2]).norm());
          alone = std::max(alone, total(model.couple({tool[i]}).force_N).norm());
        }
        over.push_back(worse / alone);
        const bool one_place = together && apart_m < 1e-5;
        if (!together && apart_m < 1e-3)
          continue;  // the body cannot have such different displacements at this distance
        std::vector<SurfacePoint> points{held(tool[0])};
        std::vector<Vec3> moved{e};
        if (!one_place) {
          points.push_back(held(tool[1]));
          moved.push_back(together ? e : other);
        }
        for (auto& d : moved) d = {depth_m * d[0], depth_m * d[1], depth_m * d[2]};
        solver.touch_points(points);
        const auto truth = solver.solve(moved, body.scene.probe.increments);
        if (truth.status != Status::converged) continue;
        ++solved;
        Vector3d sum(0, 0, 0);
        for (const auto& f : truth.force_N) sum += Vector3d(f[0], f[1], f[2]);
        error.push_back((total(both.force_N) - sum).norm() / sum.norm());
      }
      fmt::print("{:<10}{:>10}{:>11}{:>20}{:>9}{:>20}\n", together ? "together" : "apart",
                 fmt::format("{:g} mm", 1e3 * apart_m), unsettled,
                 fmt::format("{:.2f}, {:.3g}", median(over), largest(over)), solved,
                 error.empty() ? "-" : fmt::format("{:.3g}, {:.3g}", 100 * median(error), 100 * largest(error)));
      std::fflush(stdout);
    }
}

}  // namespace phynness::extremes
