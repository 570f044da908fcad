#include "eval_motion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>

#include "commands.hpp"
#include "streams.hpp"

namespace phynness::cli {
namespace {

static_assert(Motion::most_tools == PHN_MOST_COUPLED);

double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

struct Answer {
  std::vector<std::vector<std::optional<Vec3>>> force_N;  ///< as Motion::force_N
  std::vector<double> energy_J;                           ///< empty in families without energy
  std::vector<int> status;
};

/// A tool at a node alone has phn_force, which models without modes answer, too; all others are coupled.
int ask(const LoadedModel& model, const std::vector<phn_tool>& tools, std::vector<double>& forces, double& energy) {
  energy = 0;
  forces.assign(3 * tools.size(), 0.0);
  if (tools.empty()) return PHN_OK;
  const auto& first = tools.front();
  if (tools.size() == 1 && first.weights[0] == 1) {
    const Vec3 d{first.displacement[0], first.displacement[1], first.displacement[2]};
    Vec3 f{};
    const bool has_energy = model.runtime().info().has_energy != 0;
    const int status =
        has_energy ? model.data().force(first.nodes[0], d, f, energy) : model.data().force(first.nodes[0], d, f);
    std::copy(f.begin(), f.end(), forces.begin());
    if (status < 0) model.force(first.nodes[0], d);  // throws an error with the nearest active nodes
    return status;
  }
  phn_coupled coupled{};
  const int status = model.data().couple(tools, forces, &coupled);
  if (status < 0) model.couple(tools);  // throws an error with the reason
  energy = coupled.energy;
  return status;
}

Answer answer_of(const LoadedModel& model, const Motion& motion, const std::string& name) {
  Answer answer;
  const bool has_energy = model.runtime().info().has_energy != 0;
  std::vector<phn_tool> tools;
  std::vector<double> forces;
  for (std::size_t i = 0; i < motion.time_s.size(); ++i) {
    tools.clear();
    for (std::size_t t = 0; t < motion.tools.size(); ++t) {
      const auto& d = motion.displacement_m[i][t];
      if (!d) continue;
      auto& tool = tools.emplace_back();
      std::copy_n(motion.tools[t].nodes.begin(), 3, tool.nodes);
      std::copy_n(motion.tools[t].weights.begin(), 3, tool.weights);
      std::copy_n(d->begin(), 3, tool.displacement);
    }
    double energy = 0;
    int status = 0;
    try {
      status = ask(model, tools, forces, energy);
    } catch (const Error& error) {
      throw input_error(fmt::format("{}, step {}: {}", name, i, error.what()), "", "");
    }
    auto& row = answer.force_N.emplace_back(motion.tools.size());
    for (std::size_t t = 0, at = 0; t < motion.tools.size(); ++t)
      if (motion.displacement_m[i][t]) {
        row[t] = Vec3{forces[at], forces[at + 1], forces[at + 2]};
        at += 3;
      }
    if (has_energy) answer.energy_J.push_back(energy);
    answer.status.push_back(status);
  }
  return answer;
}

struct Comparison {
  double largest_force_N = 0, largest_difference_N = 0;
  std::size_t step = 0, compared = 0;  ///< step of the largest difference; forces that both hold
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
      ++result.compared;
      if (difference <= result.largest_difference_N) continue;
      result.largest_difference_N = difference;
      result.step = i;
    }
  return result;
}

json vectors(const std::vector<std::vector<std::optional<Vec3>>>& steps) {
  json all = json::array();
  for (const auto& step : steps) {
    auto& row = all.emplace_back(json::array());
    for (const auto& v : step) row.push_back(v ? json(*v) : json(nullptr));
  }
  return all;
}

json tools_json(const Motion& motion) {
  json tools = json::array();
  for (const auto& tool : motion.tools) {
    if (tool.weights[0] == 1) {
      tools.push_back({{"node", tool.nodes[0]}});
      continue;
    }
    json nodes = json::array(), weights = json::array();
    for (std::size_t k = 0; k < 3; ++k)
      if (tool.nodes[k] >= 0) {
        nodes.push_back(tool.nodes[k]);
        weights.push_back(tool.weights[k]);
      }
    tools.push_back({{"nodes", nodes}, {"weights", weights}});
  }
  return tools;
}

}  // namespace

void answer_motion(const LoadedModel& model, const Motion& motion, const std::string& name,
                   const std::optional<std::filesystem::path>& json_file) {
  const std::string hash = model.runtime().info().mesh_hash;
  if (!motion.mesh_hash.empty() && motion.mesh_hash != hash)
    throw input_error(name + ": the motion was recorded on another mesh",
                      fmt::format("mesh_hash {}, of the model {}", motion.mesh_hash, hash),
                      "give the model for which it was recorded, or remove mesh_hash if the nodes are the same");
  const auto answer = answer_of(model, motion, name);
  const auto compared = compare(answer, motion);
  const auto outside =
      std::count_if(answer.status.begin(), answer.status.end(), [](int s) { return (s & PHN_WARNING_OUTSIDE) != 0; });
  const auto unsettled =
      std::count_if(answer.status.begin(), answer.status.end(), [](int s) { return (s & PHN_WARNING_UNSETTLED) != 0; });
  const auto n = motion.time_s.size();
  print_result("{} steps of {} tool{} in {:.4g} s; largest force {:.6g} N; {} steps outside the trained range\n", n,
               motion.tools.size(), motion.tools.size() == 1 ? "" : "s", motion.time_s.back() - motion.time_s.front(),
               compared.largest_force_N, outside);
  if (unsettled > 0)
    message("warning: in {} steps tools are close together and pull apart; their points follow them in part\n",
            unsettled);
  json out{{"format", motion_format},
           {"mesh_hash", hash},
           {"level", model.data().level()},
           {"family", model.runtime().info().family},
           {"tools", tools_json(motion)},
           {"time_s", motion.time_s},
           {"displacement_m", vectors(motion.displacement_m)},
           {"force_N", vectors(answer.force_N)}};
  if (!answer.energy_J.empty()) out["energy_J"] = answer.energy_J;
  out["status"] = answer.status;
  if (compared.compared > 0) {
    // Undefined if all forces are 0, and infinite if they are much smaller than the difference.
    const double relative = compared.largest_difference_N / compared.largest_force_N;
    if (compared.largest_difference_N > 0)
      print_result("largest difference from the {} forces of the file: {:.3g} N (step {}){}\n", compared.compared,
                   compared.largest_difference_N, compared.step,
                   std::isfinite(relative) ? fmt::format(", {:.2g} of the largest force", relative) : "");
    else
      print_result("the {} forces of the file are repeated exactly\n", compared.compared);
    out["recorded"] = {{"forces", compared.compared},
                       {"largest_difference_N", compared.largest_difference_N},
                       {"step", compared.step},
                       {"of_largest_force", compared.largest_difference_N > 0 ? json(relative) : json(0.0)}};
  }
  write_json(json_file, out);
}

}  // namespace phynness::cli
