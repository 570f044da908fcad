#include <algorithm>
#include <cmath>
#include <cstdint>
#include <phynness/formats/error.hpp>
#include <phynness/studies/measure.hpp>
#include <phynness/training/network_fit.hpp>

#include "fine_surface.hpp"
#include "median_time.hpp"

namespace phynness {
namespace {

using bench::median_us;

/// A displacement that changes from call to call, as that of a moving hand.
Vec3 displacement(const Model& model, int i) {
  Vec3 d{};
  for (int k = 0; k < 3; ++k) d[static_cast<std::size_t>(k)] = model.max_displacement_m * 0.01 * ((i * (k + 3)) % 50);
  return d;
}

FineSurface fine_surface(const NamedOrgan& model, int levels) {
  FineSurface surface(model.organ().model(), levels);
  if (surface.status() < 0)
    throw input_error("the surface cannot be subdivided", phn_status_message(surface.status()),
                      "use a scene whose output nodes are the whole surface");
  return surface;
}

/// A deformation of a prepared node.
class Deformation {
 public:
  explicit Deformation(const NamedOrgan& model)
      : _model(model), _node(model.model().nodes[model.model().nodes.size() / 2].node) {
    field.resize(3 * model.model().output.size());
    const phn_tool tool = tool_at(_node, Vec3{});
    phn_prepare(_model.organ().model(), _model.organ().data(), &tool);
  }
  void at(int i) {
    const phn_tool tool = tool_at(_node, displacement(_model.model(), i));
    phn_deform(_model.organ().model(), _model.organ().data(), &tool, field.data());
  }
  std::vector<double> field;

 private:
  const NamedOrgan& _model;
  std::int32_t _node;
};

double force_us(const NamedOrgan& model) {
  const auto& nodes = model.model().nodes;
  Vec3 f{};
  return median_us([&](int i) {
    const Vec3 d = displacement(model.model(), i);
    model.organ().hold(tool_at(nodes[static_cast<std::size_t>(i) % nodes.size()].node, d), f).ignore();
  });
}

/// (11)-(12) evaluated at every vertex by a plain loop, as timed in the paper.
double every_vertex_us(const RbfNetwork& network, const Model& model, const float* points, std::int32_t n) {
  Eigen::VectorXd inputs(6);
  volatile double keep = 0;
  return median_us([&](int i) {
    const Vec3 d = displacement(model, i);
    inputs.head(3) << d[0], d[1], d[2];
    double sum = 0;
    for (std::int32_t v = 0; v < n; ++v) {
      inputs.tail(3) << points[3 * v], points[3 * v + 1], points[3 * v + 2];
      sum += evaluate(network, inputs)[0];
    }
    keep = sum;
  });
}

}  // namespace

RuntimeTimes measure_runtime(const NamedOrgan& networks, const NamedOrgan& ours, int n_levels) {
  RuntimeTimes times;
  Deformation of_networks(networks), of_ours(ours);
  times.force_us = force_us(networks);
  times.ours_force_us = force_us(ours);
  times.deformation_us = median_us([&](int i) { of_networks.at(i); });
  times.ours_deformation_us = median_us([&](int i) { of_ours.at(i); });
  const auto& model = networks.model();
  const auto& node = model.nodes[model.nodes.size() / 2];
  for (const auto& one : model.nodes) {
    times.neurons = std::max(times.neurons, static_cast<int>(one.deformation.weights.rows()));
    times.force_neurons = std::max(times.force_neurons, static_cast<int>(one.force.weights.rows()));
  }
  for (int level = 0; level < n_levels; ++level) {
    FineSurface surface = fine_surface(networks, level);
    SurfaceLevel row{surface.n_vertices(), surface.n_triangles(), 0, 0, 0};
    row.network_us = median_us([&](int i) {
      of_networks.at(i);
      surface.deform(of_networks.field.data());
    });
    row.ours_us = median_us([&](int i) {
      of_ours.at(i);
      surface.deform(of_ours.field.data());
    });
    row.every_vertex_us = every_vertex_us(node.deformation, model, surface.points().data(), surface.n_vertices());
    times.levels.push_back(row);
  }
  std::vector<float> points(model.output_points.size());
  for (Eigen::Index i = 0; i < model.output_points.size(); ++i)
    points[static_cast<std::size_t>(i)] = static_cast<float>(model.output_points.data()[i]);
  times.deformation_plain_us =
      every_vertex_us(node.deformation, model, points.data(), static_cast<std::int32_t>(model.output.size()));
  return times;
}

SurfaceShape surface_at(const NamedOrgan& model, int level) {
  const FineSurface surface = fine_surface(model, level);
  SurfaceShape shape;
  shape.points = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(surface.points().data(),
                                                                                            surface.n_vertices(), 3)
                     .cast<double>();
  shape.triangles = Eigen::Map<const Triangles>(surface.triangles(), surface.n_triangles(), 3);
  return shape;
}

}  // namespace phynness
