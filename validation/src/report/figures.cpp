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

Json validation_figures(const Validated& v) {
  Json out = figures(v.report);
  out["by_node"] = columns_of_figures(v.report.to_range.nodes);
  out["interrupted"] = v.interrupted();
  out["model_hash"] = v.model.hash();
  out["mesh_hash"] = v.model.model().mesh_hash;
  out["conditions"] = conditions(v);
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
