#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/motion.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

static_assert(Motion::most_tools == PHN_MOST_COUPLED);

double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

/// @param where  the tool, for messages
/// @throws Error (input) unless the surface has a triangle with these nodes
void require_triangle(const Motion::Tool& tool, const std::string& where, const Mesh& mesh) {
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t) {
    const auto corners = mesh.surface.row(t);
    if (std::all_of(tool.nodes.begin(), tool.nodes.end(),
                    [&](auto node) { return node < 0 || (corners.array() == node).any(); }))
      return;
  }
  throw input_error(where + ": the surface has no triangle with these nodes",
                    fmt::format("{}, {}{}", tool.nodes[0], tool.nodes[1],
                                tool.nodes[2] < 0 ? "" : fmt::format(", {}", tool.nodes[2])),
                    "give nodes and weights as eval --point x,y,z --json writes them");
}

/// @throws Error (input) unless the mesh has the nodes of all tools, and those of each one are of one triangle
void require_places(const Motion& motion, const std::string& name, const Mesh& mesh) {
  for (std::size_t t = 0; t < motion.tools.size(); ++t) {
    const auto& tool = motion.tools[t];
    for (const auto node : tool.nodes)
      if (node >= mesh.n_nodes())
        throw input_error(name + ": the mesh has no such node", std::to_string(node),
                          "give the model for which the motion was recorded; its nodes are 0 to " +
                              std::to_string(mesh.n_nodes() - 1));
    if (tool.nodes[1] >= 0) require_triangle(tool, fmt::format("{}: tools[{}]", name, t), mesh);
  }
}

using Vectors = std::vector<std::vector<std::optional<Vec3>>>;  ///< [step][tool]

struct Answer {
  Vectors force_N;
  std::vector<double> energy_J;  ///< empty in families without energy
  std::vector<int> status;

  /// Steps whose status has this warning.
  auto warned(int warning) const {
    return std::ranges::count_if(status, [&](int s) { return (s & warning) != 0; });
  }
};

/// A tool at a node alone has phn_force, which models without modes answer, too; all others are coupled, as are those
/// of a body, which goes on from its deformation in the step before.
/// @throws Error (input) if the model cannot answer
int ask(const LoadedModel& model, const std::vector<phn_tool>& tools, std::vector<double>& forces, double& energy) {
  energy = 0;
  forces.assign(3 * tools.size(), 0.0);
  if (model.body() || tools.size() > 1 || (tools.size() == 1 && tools[0].weights[0] != 1)) {
    phn_coupled coupled{};
    const int status = model.data().couple(tools, forces, &coupled);
    if (status < 0) model.couple(tools);  // throws an error with the reason
    energy = coupled.energy;
    return status;
  }
  if (tools.empty()) return PHN_OK;
  const auto& [first, d] = std::pair{tools[0].nodes[0], std::to_array(tools[0].displacement)};
  const bool has_energy = model.runtime().info().has_energy != 0;
  Vec3 f{};
  const int status = has_energy ? model.data().force(first, d, f, energy) : model.data().force(first, d, f);
  forces.assign(f.begin(), f.end());
  if (status < 0) model.force(first, d);  // throws an error with the nearest active nodes
  return status;
}

Answer answer_of(const LoadedModel& model, const Motion& motion, const std::string& name) {
  Answer answer;
  std::vector<phn_tool> tools;
  std::vector<double> forces;
  for (std::size_t i = 0; i < motion.time_s.size(); ++i) try {
      tools.clear();
      for (std::size_t t = 0; t < motion.tools.size(); ++t) {
        const auto& [nodes, weights] = motion.tools[t];
        if (const auto& d = motion.displacement_m[i][t]) tools.push_back(tool_at({nodes, weights}, *d));
      }
      double energy = 0;
      answer.status.push_back(ask(model, tools, forces, energy));
      if (model.couples_with_energy()) answer.energy_J.push_back(energy);
      auto& row = answer.force_N.emplace_back(motion.tools.size());
      for (std::size_t t = 0, at = 0; t < row.size(); ++t)
        if (motion.displacement_m[i][t]) std::copy_n(&forces[3 * at++], 3, row[t].emplace().begin());
    } catch (const Error& error) {
      throw input_error(fmt::format("{}, step {}: {}", name, i, error.what()), "", "");
    }
  return answer;
}

struct Comparison {
  double largest_force_N = 0, largest_difference_N = 0;
  std::size_t step = 0, forces = 0;  ///< step of the largest difference; forces that both hold

  /// Undefined if all forces are 0, and infinite if they are much smaller than the difference.
  double of_largest_force() const { return largest_difference_N > 0 ? largest_difference_N / largest_force_N : 0; }
};

Comparison compare(const Answer& answer, const Motion& motion) {
  Comparison result;
  for (std::size_t i = 0; i < answer.force_N.size(); ++i)
    for (std::size_t t = 0; t < motion.tools.size(); ++t) {
      const auto& own = answer.force_N[i][t];
      if (!own) continue;
      result.largest_force_N = std::max(result.largest_force_N, length(*own));
      if (motion.force_N.empty() || !motion.force_N[i][t]) continue;
      const auto& f = *motion.force_N[i][t];
      const double difference = length({(*own)[0] - f[0], (*own)[1] - f[1], (*own)[2] - f[2]});
      ++result.forces;
      if (difference <= result.largest_difference_N) continue;
      result.largest_difference_N = difference;
      result.step = i;
    }
  return result;
}

json tool_json(const Motion::Tool& tool) {
  if (tool.weights[0] == 1) return record("node", tool.nodes[0]);
  const auto n = std::ranges::count_if(tool.nodes, [](auto node) { return node >= 0; });
  return record("nodes", std::vector(tool.nodes.begin(), tool.nodes.begin() + n), "weights",
                std::vector(tool.weights.begin(), tool.weights.begin() + n));
}

}  // namespace

void answer_motion(const LoadedModel& model, const Motion& motion, const std::string& name,
                   const OptionalPath& json_file) {
  const std::string hash = model.runtime().info().mesh_hash;
  if (!motion.mesh_hash.empty() && motion.mesh_hash != hash)
    throw input_error(name + ": the motion was recorded on another mesh",
                      fmt::format("mesh_hash {}, of the model {}", motion.mesh_hash, hash),
                      "give the model for which it was recorded, or remove mesh_hash if the nodes are the same");
  require_places(motion, name, model.mesh());
  const auto answer = answer_of(model, motion, name);
  const auto compared = compare(answer, motion);
  print_result("{} steps of {} tool{} in {:.4g} s; largest force {:.6g} N; {} steps outside the trained range\n",
               motion.time_s.size(), motion.tools.size(), motion.tools.size() == 1 ? "" : "s",
               motion.time_s.back() - motion.time_s.front(), compared.largest_force_N,
               answer.warned(PHN_WARNING_OUTSIDE));
  if (const auto unsettled = answer.warned(PHN_WARNING_UNSETTLED); unsettled > 0)
    message("warning: in {} steps tools are close together and pull apart; their points follow them in part\n",
            unsettled);
  json tools = json::array();
  for (const auto& tool : motion.tools) tools.push_back(tool_json(tool));
  json out = record("format", std::string(motion_format), "mesh_hash", hash, "level", model.level(), "family",
                    model.runtime().info().family, "tools", tools, "time_s", motion.time_s, "displacement_m",
                    figures(motion.displacement_m), "force_N", figures(answer.force_N));
  if (model.body()) out["body"] = model.body()->name();
  if (!answer.energy_J.empty()) out["energy_J"] = answer.energy_J;
  out["status"] = answer.status;
  if (compared.forces > 0) {
    const double relative = compared.of_largest_force();
    if (compared.largest_difference_N > 0)
      print_result("largest difference from the {} forces of the file: {:.3g} N (step {}){}\n", compared.forces,
                   compared.largest_difference_N, compared.step,
                   std::isfinite(relative) ? fmt::format(", {:.2g} of the largest force", relative) : "");
    else
      print_result("the {} forces of the file are repeated exactly\n", compared.forces);
    out["recorded"] = record("forces", compared.forces, "largest_difference_N", compared.largest_difference_N, "step",
                             compared.step, "of_largest_force", relative);
  }
  write_json(json_file, out);
}

}  // namespace phynness::cli
