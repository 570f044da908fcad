#include <fmt/core.h>

#include <phynness/embedding/embedding.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/probed_states.hpp>
#include <random>

#include "model_body.hpp"
#include "sections.hpp"

namespace phynness::extremes {
namespace {

using Eigen::Vector3d;

constexpr std::size_t n_probed = 10;

Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }
Vec3 array(const Vector3d& v) { return {v[0], v[1], v[2]}; }

/// Ten active nodes, distributed evenly over their list.
std::vector<std::int32_t> probed_nodes(const ModelBody& body) {
  const auto& active = body.data.header.sets.active;
  const std::size_t n = std::min(n_probed, active.size());
  std::vector<std::int32_t> nodes;
  for (std::size_t i = 0; i < n; ++i) nodes.push_back(active[(2 * i + 1) * active.size() / (2 * n)]);
  return nodes;
}

Eigen::Index position(const std::vector<std::int32_t>& list, std::int32_t node) {
  return std::lower_bound(list.begin(), list.end(), node) - list.begin();
}

Compared said(const LoadedModel& model, std::int32_t node, const Vec3& d) {
  const auto response = model.respond({node}, {d});
  Compared word;
  word.force = vector(*response.force_N[0]);
  word.u = response.displacement_m;
  return word;
}

Compared linear_theory(const RestResponse& rest, const std::vector<std::int32_t>& output, const Vec3& d) {
  const Eigen::VectorXd u = rest.sensitivity * vector(d);
  Compared word;
  word.force = rest.stiffness_N_per_m * vector(d);
  word.u = at_output(Eigen::Map<const Points>(u.data(), u.size() / 3, 3), output);
  return word;
}

}  // namespace

void rest(const SolverSession&) {
  const auto body = solve_body("demo.toml");
  const double R = body.scene.probe.max_displacement_m;
  fmt::print(
      "\nModels at very small displacements: the demo's liver ({} nodes, R = {:g} mm); {} nodes, six "
      "directions.\n"
      "Force at rest over the largest trained; |f - K d| / |K d|, K by finite elements at rest, mean and "
      "largest\n",
      body.mesh().n_nodes(), 1e3 * R, probed_nodes(body).size());
  fmt::print("{:<8}{:>12}", "family", "at rest");
  const double sizes[] = {1e-12, 1e-9, 1e-6, 1e-4, 1e-3};
  for (const double size : sizes) fmt::print("{:>24}", fmt::format("|d| = {:g} m", size));
  fmt::print("\n");
  for (const auto family : {Family::modal, Family::rbfn}) {
    const auto model = train_on(body.data, training_of(body.scene, family));
    ProbeSolver solver(body.scene, body.mesh(), body.data.header.sets);
    double at_rest = 0;
    std::vector<double> mean(std::size(sizes)), largest(std::size(sizes));
    int n = 0;
    for (const auto node : probed_nodes(body)) {
      const auto a = static_cast<std::size_t>(position(body.data.header.sets.active, node));
      at_rest = std::max(
          at_rest, vector(model.force(node, {0, 0, 0})).norm() / study::largest_force_N(body.data.probed[a].rays));
      solver.touch({node});
      const Eigen::Matrix3d K = solver.rest().stiffness_N_per_m;
      for (int k = 0; k < 3; ++k)
        for (const double sign : {1.0, -1.0}) {
          ++n;
          for (std::size_t i = 0; i < std::size(sizes); ++i) {
            const Vector3d d = sign * sizes[i] * Vector3d::Unit(k);
            const double error = (vector(model.force(node, array(d))) - K * d).norm() / (K * d).norm();
            mean[i] += error;
            largest[i] = std::max(largest[i], error);
          }
        }
    }
    fmt::print("{:<8}{:>12.1e}", name(family), at_rest);
    for (std::size_t i = 0; i < std::size(sizes); ++i)
      fmt::print("{:>24}", fmt::format("{:.2g}, {:.2g}", mean[i] / n, largest[i]));
    fmt::print("\n");
  }
}

void extrapolation(const SolverSession&) {
  constexpr double depth_m = 0.002;
  constexpr int n_directions = 6;
  const double factors[] = {1, 2, 5, 10};
  const auto body = solve_body("demo.toml", depth_m);
  const auto& output = body.data.header.sets.output;
  const auto modal = train_on(body.data, training_of(body.scene, Family::modal));
  const auto rbfn = train_on(body.data, training_of(body.scene, Family::rbfn));
  fmt::print(
      "\nBeyond the trained range: the demo's liver trained to {:g} mm, evaluated deeper; {} nodes, {} "
      "directions at\n"
      "random. Errors (17) of each depth, mean / p95 / max in %; probes that the finite elements solve\n",
      1e3 * depth_m, probed_nodes(body).size(), n_directions);
  const char* names[] = {"modal", "rbfn", "linear", "zero"};
  std::array<std::array<Errors, std::size(factors)>, std::size(names)> errors;
  std::array<int, std::size(factors)> solved{}, warned{};
  ProbeSolver solver(body.scene, body.mesh(), body.data.header.sets);
  std::mt19937_64 random(1);
  for (const auto node : probed_nodes(body)) {
    solver.touch({node});
    std::array<std::array<std::vector<Compared>, std::size(factors)>, std::size(names)> said_of;
    for (int j = 0; j < n_directions; ++j) {
      const Vec3 e = on_sphere(random);
      std::vector<double> depths;
      for (const double factor : factors) depths.push_back(factor * depth_m);
      solver.follow({e}, depths, false, [&](std::size_t i, const Response& r) {
        if (r.status != Status::converged) return false;
        ++solved[i];
        const Vec3 d{depths[i] * e[0], depths[i] * e[1], depths[i] * e[2]};
        phn_trusted trusted;
        warned[i] += modal.runtime().trust(node, d, trusted).outside();
        const Points u = at_output(r.displacement_m, output);
        Compared zero;
        zero.u = Points::Zero(u.rows(), 3);
        Compared all[] = {said(modal, node, d), said(rbfn, node, d), linear_theory(solver.rest(), output, d), zero};
        for (std::size_t k = 0; k < std::size(names); ++k) {
          all[k].force_FE = vector(r.force_N[0]);
          all[k].u_FE = u;
          said_of[k][i].push_back(std::move(all[k]));
        }
        return true;
      });
    }
    for (std::size_t k = 0; k < std::size(names); ++k)
      for (std::size_t i = 0; i < std::size(factors); ++i) errors[k][i].add_node(said_of[k][i], position(output, node));
  }
  fmt::print("{:<8}{:>6}{:>8}{:>9}{:>25}{:>25}\n", "", "|d|/R", "solved", "warned", "force", "displacement");
  for (std::size_t k = 0; k < std::size(names); ++k)
    for (std::size_t i = 0; i < std::size(factors); ++i)
      fmt::print("{:<8}{:>6g}{:>8}{:>9}{}{}\n", names[k], factors[i], solved[i], warned[i],
                 percent(errors[k][i].force()), percent(errors[k][i].displacement()));
}

void missing(const SolverSession& session) {
  const auto body = solve_body("demo.toml");
  const auto& active = body.data.header.sets.active;
  const auto whole = train_on(body.data, training_of(body.scene, Family::modal));
  const auto plan = plan_probes(whole, body.scene.probe.directions, 400, 1, n_probed);
  std::vector<NodeProbes> fresh;
  solve_probes(session, body.scene, whole, plan, {}, {},
               [&](std::size_t, NodeProbes&& found) { fresh.push_back(std::move(found)); });
  std::size_t inside = 0;
  for (const auto& node : fresh) inside += node.states[0].size();
  fmt::print(
      "\nRandom failed probes of each node: the demo's liver; {} new probes inside the range at {} "
      "nodes,\n"
      "errors (17), mean / p95 / max in %\n",
      inside, fresh.size());
  fmt::print("{:<8}{:<20}{:>25}{:>25}\n", "family", "failed rays", "force", "displacement");
  const auto print = [](const char* of, const std::string& what, const GroupErrors& e) {
    fmt::print("{:<8}{:<20}{}{}\n", of, what, percent(e.force), percent(e.displacement));
    std::fflush(stdout);
  };
  print("linear", "", linear_errors(fresh).inside);
  for (const auto family : {Family::modal, Family::rbfn})
    for (const double share : {0.0, 0.1, 0.5, 0.9}) {
      const auto data = study::with_failed_rays(body.data, share, 7);
      print(name(family), fmt::format("{:.0f} %", 100 * share),
            model_errors(train_on(data, training_of(body.scene, family)), fresh).inside);
    }
  // One of the probed nodes has no response.
  auto data = body.data;
  const auto lost = fresh[0].node;
  study::StudyData one;
  one.header = data.header;
  auto& node = data.probed[static_cast<std::size_t>(position(active, lost))];
  one.probed = {node};
  node = study::with_rays(one, {}).probed[0];
  const std::vector<NodeProbes> others(fresh.begin() + 1, fresh.end());
  for (const auto family : {Family::modal, Family::rbfn}) {
    const auto model = train_on(data, training_of(body.scene, family));
    print(name(family), "all of one node", model_errors(model, others).inside);
    double f[3];
    const double d[3] = {0, 0, 0.001};
    fmt::print("        at that node: {}\n", model.data().force(lost, d, f).message());
  }
}

void floats(const SolverSession&) {
  const auto body = solve_body("demo.toml");
  fmt::print(
      "\nIn float: images of the demo's models against the runtime's double at 2,000 golden queries, "
      "largest\n"
      "difference over the largest answer\n");
  fmt::print("{:<8}{:<24}{:>12}{:>14}{:>12}{:>14}\n", "family", "", "force", "displacement", "bytes", "double");
  const auto row = [&](const std::string& what, const TrainingSpec& spec) {
    const auto model = train_on(body.data, spec);
    const auto image = model_image(model.model(), {false, true}), exact = model_image(model.model(), {false, false});
    const auto queries = golden_queries(model, image, 2000), in_double = golden_queries(model, exact, 2000);
    fmt::print("{:<8}{:<24}{:>12.1e}{:>14.1e}{:>12}{:>14}\n", name(spec.family), what, queries.force_deviation,
               queries.deformation_deviation, image.bytes.size(),
               fmt::format("{:.0e}, {:.0e}", in_double.force_deviation, in_double.deformation_deviation));
    std::fflush(stdout);
  };
  row("as in the scene", training_of(body.scene, Family::modal));
  for (const double spread : {0.2, 0.75, 2.0, 5.0, 20.0}) {
    auto spec = training_of(body.scene, Family::rbfn);
    spec.force_spread = spec.deformation_spread = spread;
    row(fmt::format("both spreads {:g}", spread), spec);
  }
}

}  // namespace phynness::extremes
