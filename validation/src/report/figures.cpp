#include <fmt/core.h>

#include <algorithm>
#include <phynness/validation/report.hpp>

namespace phynness {
namespace {

Json conditions(const Validated& v) {
  const Scene& scene = v.scene;
  return {{"law", name(scene.material.law)},
          {"element", name(scene.solver.element)},
          {"bulk_to_shear", scene.material.bulk_to_shear()},
          {"probe", name(scene.probe.kind)},
          {"max_displacement_m", scene.probe.max_displacement_m},
          {"outside_factor", v.report.outside_factor},
          {"nodes", v.report.nodes},
          {"fixed_distances_m", v.report.fixed_distance_m},
          {"level", v.model.data().level()},
          {"seed", v.seed}};
}

}  // namespace

std::string validate_again(const Validated& in) {
  std::string line = fmt::format("phynness validate SCENE MODEL_DIR --probes {} --nodes {} --seed {}", in.report.probes,
                                 in.report.nodes.size(), in.seed);
  if (in.model.data().level() + 1 < in.model.runtime().n_levels())
    line += fmt::format(" --level {}", in.model.data().level());
  if (in.points.finished > 0) line += fmt::format(" --points {}", in.points.finished);
  if (in.pairs.finished > 0) line += fmt::format(" --pairs {} --pair-depth {}", in.pairs.finished, in.pairs.depth_m);
  if (in.body) line += " --body BODY.txt";
  return line;
}

std::string check_again(const FinerDistance& finer) {
  if (!finer.is_measured) return "not compared; phynness check SCENE does it";
  return fmt::format("phynness check SCENE --reference {} --probes {} --seconds 1e7 --details", finer.reference,
                     std::max({1, finer.probes, finer.solved}));
}

Json validation_figures(const Validated& v) {
  Json out = figures(v.report);
  out["by_node"] = columns_of_figures(v.report.to_range.nodes);
  out["interrupted"] = v.interrupted();
  out["model_hash"] = v.model.hash();
  out["mesh_hash"] = v.model.model().mesh_hash;
  out["conditions"] = conditions(v);
  out["commands"] = {{"errors", validate_again(v)}, {"distance", check_again(v.model.model().finer)}};
  if (const auto& finer = v.model.model().finer; finer.is_measured) out["finer"] = figures(finer);
  for (const auto& line : verdict(v))
    if (!line.figures.empty()) out["verdict"][line.key] = figures(line.figures);
  out["worse_than_linear"] = figures(worse_than_linear(v));
  if (v.points.finished > 0) out["points"] = figures(v.points);
  if (v.pairs.finished > 0) out["pairs"] = figures(v.pairs);
  if (v.no_points) out["points"] = {{"not_done", v.no_points->what()}};
  if (v.no_pairs) out["pairs"] = {{"not_done", v.no_pairs->what()}};
  return out;
}

}  // namespace phynness
