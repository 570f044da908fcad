#include <fmt/core.h>

#include <cmath>
#include <phynness/phynness_surface.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <random>

#include "model_body.hpp"
#include "sections.hpp"

namespace phynness::extremes {
namespace {

using Eigen::RowVector3d;

/// The same responses of a body at another place.
study::StudyData moved(study::StudyData data, const RowVector3d& by) {
  data.header.mesh.nodes.rowwise() += by;
  data.header.mesh_hash = mesh_hash(data.header.mesh);
  for (auto& node : data.probed)
    for (int k = 0; k < 3; ++k) node.point[static_cast<std::size_t>(k)] = data.header.mesh.nodes(node.node, k);
  return data;
}

/// Subdivided once, at rest.
struct FineSurface {
  explicit FineSurface(const LoadedModel& model) : surface(model.runtime(), 1) {}
  Eigen::MatrixXd points() const {
    return Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(surface.points().data(),
                                                                                      surface.n_vertices(), 3)
        .cast<double>();
  }
  rt::Surface surface;
};

double largest_difference(const LoadedModel& here, const LoadedModel& there, bool force) {
  std::mt19937_64 random(5);
  double difference = 0, size = 0;
  for (int i = 0; i < 300; ++i) {
    const auto& nodes = here.model().nodes;
    const auto node = nodes[static_cast<std::size_t>(uniform(random) * static_cast<double>(nodes.size()))].node;
    const Vec3 e = on_sphere(random);
    const double d = here.model().max_displacement_m * uniform(random);
    const auto a = here.respond({node}, {{d * e[0], d * e[1], d * e[2]}}),
               b = there.respond({node}, {{d * e[0], d * e[1], d * e[2]}});
    const auto vector = [](const ModelResponse& r) {
      return RowVector3d((*r.force_N[0])[0], (*r.force_N[0])[1], (*r.force_N[0])[2]);
    };
    difference = std::max(difference, force ? (vector(a) - vector(b)).norm()
                                            : (a.displacement_m - b.displacement_m).cwiseAbs().maxCoeff());
    size = std::max(size, force ? vector(a).norm() : a.displacement_m.cwiseAbs().maxCoeff());
  }
  return difference / size;
}

}  // namespace

void far_models(const SolverSession&) {
  const auto body = solve_body("demo.toml");
  fmt::print(
      "\nModels far from the origin: the demo's responses with a moved mesh, trained there; largest "
      "difference\n"
      "over the largest answer at 300 displacements, and of points of the once subdivided surface at rest\n");
  fmt::print("{:<10}{:<14}{:>12}{:>14}{:>18}\n", "family", "away", "force", "displacement", "fine surface");
  for (const auto family : {Family::modal, Family::rbfn}) {
    const auto spec = training_of(body.scene, family);
    const auto here = train_on(body.data, spec);
    const auto fine = FineSurface(here).points();
    for (const double away_m : {1.0, 1e3, 1e6, 1e9}) {
      const RowVector3d by(away_m, -away_m, away_m);
      const auto there = train_on(moved(body.data, by), spec);
      const double off = ((FineSurface(there).points().rowwise() - by) - fine).cwiseAbs().maxCoeff();
      fmt::print("{:<10}{:<14}{:>12.1e}{:>14.1e}{:>18}\n", name(family), fmt::format("{:g} m", away_m),
                 largest_difference(here, there, true), largest_difference(here, there, false),
                 fmt::format("{:.1e} m", off));
      std::fflush(stdout);
    }
  }
}

}  // namespace phynness::extremes
