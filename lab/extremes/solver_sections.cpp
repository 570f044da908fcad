#include <fmt/core.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>

#include "robustness/rays.hpp"
#include "sections.hpp"

namespace phynness::extremes {
namespace {

using Eigen::Vector3d;
using robustness::Body;

const Element elements[] = {element_named("P1"), element_named("P2"), element_named("p1-p1"),
                            element_named("taylor-hood")};
constexpr double edge_m = 0.1, h_m = edge_m / robustness::elements_along_edge;

/// A round tool of twice the element size, because the force of a single node does not converge under refinement.
Body pressed(Body body, double size_m = h_m) {
  body.scene.probe.kind = ProbeKind::patch;
  body.scene.probe.tool_radius_m = 2 * h_m;
  if (size_m != h_m) {
    body.scene.mesh.target_size_m = size_m;
    body.mesh = make_mesh(body.scene).mesh;
    body.sets = resolve_selections(body.scene, body.mesh);
  }
  return body;
}

/// The surface node nearest to the center of the top face.
std::int32_t top(const Mesh& mesh) {
  const auto nodes = surface_nodes(mesh.surface);
  const Eigen::RowVector3d low = mesh.nodes.colwise().minCoeff(), high = mesh.nodes.colwise().maxCoeff();
  const Eigen::RowVector3d middle((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]);
  std::int32_t nearest = nodes[0];
  for (const auto node : nodes)
    if ((mesh.nodes.row(node) - middle).norm() < (mesh.nodes.row(nearest) - middle).norm()) nearest = node;
  return nearest;
}

Vec3 times(double s, const Vec3& e) { return {s * e[0], s * e[1], s * e[2]}; }
Vector3d force(const Response& r) { return Vector3d::Map(r.force_N[0].data()); }

/// f . d / |d|^2 of the center of the top face, displaced inward by half an element; NaN if it does not converge.
double stiffness_N_per_m(const Body& body) {
  ProbeSolver solver(body.scene, body.mesh, body.sets);
  solver.touch({top(body.mesh)});
  const auto r = solver.solve({{0, 0, -h_m / 2}}, 3);
  return r.status == Status::converged ? -force(r).z() / (h_m / 2) : std::nan("");
}

}  // namespace

void incompressibility(const SolverSession&) {
  fmt::print(
      "\nNearly incompressible: cube of 10 cm, h = 2 cm, patch of 2 h in the middle of the top. Stiffness "
      "felt "
      "at h/2,\nover that of taylor-hood with h/2 (N/m); rays of 26 directions that reach h\n");
  fmt::print("{:<16}{:>9}{:>11}", "law", "K/mu", "reference");
  for (const auto element : elements) fmt::print("{:>22}", name(element));
  fmt::print("\n");
  const auto row = [](Law law, double ratio) {
    const double reference =
        stiffness_N_per_m(pressed(robustness::cube(law, element_named("taylor-hood"), ratio), h_m / 2));
    fmt::print("{:<16}{:>9.0f}{:>11.1f}", name(law), ratio, reference);
    for (const auto element : elements) {
      auto body = pressed(robustness::cube(law, element, ratio));
      const double felt = stiffness_N_per_m(body);
      if (element == element_named("P2") && ratio > 200) {  // minutes per ray
        fmt::print("{:>14.2f}{:>6} %", felt / reference, "-");
      } else {
        body.scene.probe.max_displacement_m = h_m;
        body.scene.probe.increments = 3;
        const auto tally = robustness::follow_rays(body, {top(body.mesh)});
        fmt::print("{:>14.2f}{:>6.0f} %", felt / reference, 100.0 * tally.full() / tally.rays);
      }
      std::fflush(stdout);
    }
    fmt::print("\n");
  };
  for (const double ratio : {10.0, 200.0, 1e3, 1e4, 1e5}) row(law_named("neo-hookean"), ratio);
  row(law_named("mooney-rivlin"), 100e3 / 4.4);
}

void displacements(const SolverSession&) {
  fmt::print(
      "\nDisplacements from a billionth of an element to the body's half: the same tool, neo-Hookean, K/mu = "
      "200;\n"
      "|f| / |K d| with K the stiffness at rest, and increments of at most h/3; pushed, pulled, slid\n");
  fmt::print("{:<14}{:>12}", "element", "|d| / h");
  for (const char* way : {"push", "pull", "slide"}) fmt::print("{:>18}{:>12}", way, "iterations");
  fmt::print("\n");
  for (const auto element : {element_named("P1"), element_named("p1-p1"), element_named("taylor-hood")}) {
    const auto body = pressed(robustness::cube(law_named("neo-hookean"), element, 200));
    ProbeSolver solver(body.scene, body.mesh, body.sets);
    solver.touch({top(body.mesh)});
    const Eigen::Matrix3d K = solver.rest().stiffness_N_per_m;
    for (const double size : {1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 2.0, 2.5, 4.0, 8.0}) {
      fmt::print("{:<14}{:>12g}", name(element), size);
      for (const Vec3& e : {Vec3{0, 0, -1}, Vec3{0, 0, 1}, Vec3{1, 0, 0}}) {
        const auto d = times(size * h_m, e);
        const auto r = solver.solve({d}, std::max(1, static_cast<int>(std::ceil(3 * size))));
        if (r.status == Status::converged)
          fmt::print("{:>18.9f}{:>12}", force(r).norm() / (K * Vector3d(d[0], d[1], d[2])).norm(), r.iterations);
        else
          fmt::print("{:>18}{:>12}", name(r.status), r.iterations);
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
  }
}

void origin(const SolverSession&) {
  fmt::print(
      "\nFar from the origin: the cube of 10 cm written as a file there and imported; largest difference of "
      "the\n"
      "force of the same tool at h/2 (three directions) from that at the origin, relative\n");
  fmt::print("{:<14}", "away");
  for (const auto element : elements) fmt::print("{:>14}", name(element));
  fmt::print("\n");
  const auto file = std::filesystem::temp_directory_path() / fmt::format("phynness_extremes_{}.msh", getpid());
  const auto forces = [&](Element element, double away_m) {
    auto body = pressed(robustness::cube(law_named("neo-hookean"), element, 200));
    body.scene.solver.relative_tolerance = 1e-11;
    body.mesh.nodes.rowwise() += Eigen::RowVector3d(away_m, -away_m, away_m);
    write_msh(body.mesh, nullptr, file);
    body.scene.mesh = {};
    body.scene.mesh.file = file;
    body.mesh = make_mesh(body.scene).mesh;
    ProbeSolver solver(body.scene, body.mesh, body.sets);
    solver.touch({top(body.mesh)});
    std::vector<Vector3d> all;
    for (const Vec3& e : {Vec3{0, 0, -1}, Vec3{0.6, 0, -0.8}, Vec3{0, 0.8, 0.6}}) {
      const auto r = solver.solve({times(h_m / 2, e)}, 3);
      if (r.status != Status::converged) throw failure("not converged", name(r.status), "");
      all.push_back(force(r));
    }
    return all;
  };
  for (const double away_m : {1.0, 1e3, 1e6, 1e9, 1e12, 1e15}) {
    fmt::print("{:<14}", fmt::format("{:g} m", away_m));
    for (const auto element : elements) {
      try {
        const auto here = forces(element, 0), there = forces(element, away_m);
        double largest = 0;
        for (std::size_t i = 0; i < here.size(); ++i)
          largest = std::max(largest, (there[i] - here[i]).norm() / here[i].norm());
        fmt::print("{:>14.1e}", largest);
      } catch (const Error& error) {
        const std::string text = error.what();
        fmt::print("  {}", text.substr(0, text.find('\n')));
      }
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
  std::filesystem::remove(file);
}

void slivers(const SolverSession&) {
  fmt::print(
      "\nBad cells: the cube with five inner cells flattened to a quality; the same tool at h/2, K/mu = "
      "200.\n"
      "Difference of the force from that with quality 0.02, relative; outcome where it did not converge\n");
  fmt::print("{:<12}{:>8}", "quality", "cells");
  for (const auto element : elements) fmt::print("{:>14}", name(element));
  fmt::print("\n");
  std::vector<double> with_002(std::size(elements));
  for (const double quality : {0.02, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
    fmt::print("{:<12g}", quality);
    for (std::size_t i = 0; i < std::size(elements); ++i) {
      auto body = pressed(robustness::cube(law_named("neo-hookean"), elements[i], 200));
      const int n = robustness::add_slivers(body.mesh, 5, quality);
      if (i == 0) fmt::print("{:>8}", n);
      ProbeSolver solver(body.scene, body.mesh, body.sets);
      solver.touch({top(body.mesh)});
      const auto r = solver.solve({{0, 0, -h_m / 2}}, 3);
      if (r.status != Status::converged) {
        fmt::print("{:>14}", name(r.status));
      } else {
        const double felt = -force(r).z();
        if (quality == 0.02) with_002[i] = felt;
        fmt::print("{:>14.1e}", std::abs(felt / with_002[i] - 1));
      }
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}

}  // namespace phynness::extremes
