#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/report.hpp>

#include "blocks.hpp"

namespace phynness {

using namespace report;

namespace {

constexpr std::size_t most_curves = 6, most_worst = 10;

std::string bytes(std::size_t n) {
  return n < 1'000'000 ? fmt::format("{:.1f} kB", 1e-3 * static_cast<double>(n))
                       : fmt::format("{:.2f} MB", 1e-6 * static_cast<double>(n));
}
std::string vector(const Vec3& v, double scale = 1e3, const char* format = "{:.2f} {:.2f} {:.2f}") {
  return fmt::format(fmt::runtime(format), scale * v[0], scale * v[1], scale * v[2]);
}
ForceUnit unit_of(const Validated& in) {
  double largest = 0;
  for (const auto& r : in.report.records)
    for (const double x : r.finite_elements_N) largest = std::max(largest, std::abs(x));
  return force_unit(largest);
}

/// The verdict, warnings, and the table of the text output with its two heading rows in one.
Json verdict_first(const Validated& in) {
  Json lines = Json::array();
  for (const auto& line : verdict(in)) lines.push_back({line.title, line.sentence + "."});
  std::vector<Json> blocks{{{"list", lines}}};
  for (const auto& sentence : warnings(in)) blocks.push_back(warning(sentence + "."));
  auto cells = summary_cells(in);
  for (std::size_t i = 0; i < cells[0].size(); ++i)
    cells[1][i] = cells[0][i].empty() ? cells[1][i] : cells[0][i] + " " + cells[1][i];
  cells.erase(cells.begin());
  blocks.push_back(table(cells));
  return section("", blocks);
}

/// What was modelled and solved, and how to repeat it.
Json conditions(const Validated& in, const std::string& software) {
  const Scene& scene = in.scene;
  const Model& model = in.model.model();
  const auto& v = in.report;
  std::vector<Json> blocks;
  if (scene.probe.kind == ProbeKind::node)
    blocks.push_back(warning(
        "Each probe moves one node, so its force depends on the size of the mesh. The force of a patch converges "
        "with the mesh size."));
  for (const auto& part : in.not_done()) blocks.push_back(warning(part));
  const auto [nearest, farthest] = std::ranges::minmax(v.fixed_distance_m);
  const auto area = touched_area(model, in.model.mesh());
  blocks.push_back(facts(
      {{"", "value"},
       {"law", name(scene.material.law)},
       {"shear modulus", fmt::format("{:.4g} Pa", scene.material.shear_modulus_Pa)},
       {"bulk over shear modulus, K/mu", fmt::format("{:.4g}", scene.material.bulk_to_shear())},
       {"element", name(scene.solver.element)},
       {"mesh", fmt::format("{} nodes, {} {}", in.model.mesh().n_nodes(), in.model.mesh().n_cells(),
                            in.model.mesh().cells.cols() == 3 ? "triangles of a shell" : "tetrahedra")},
       {"nodes fixed, active, output",
        fmt::format("{}, {}, {}", model.fixed.size(), model.nodes.size(), model.output.size())},
       {"area nonlinear, linear", fmt::format("{:.1f} %, {:.1f} %", 100 * area.nonlinear, 100 * area.linear)},
       {"probe", name(scene.probe.kind)},
       {"trained range R", fmt::format("{:.4g} mm", 1e3 * scene.probe.max_displacement_m)},
       {"directions, increments", fmt::format("{}, {}", name(scene.probe.directions), scene.probe.increments)},
       {"family of the model", name(model.family)},
       {"probes", fmt::format("{} at {} nodes, {:.3g} to {:.3g} mm from the nearest fixed node; {} solved inside the "
                              "trained range, {} outside to {:.2f} of it",
                              v.probes, v.nodes.size(), 1e3 * nearest, 1e3 * farthest, v.solved_inside,
                              v.solved_outside, v.outside_factor)},
       {"figures of the model", validate_again(in)},
       {"distance to a finer solution", check_again(model.finer)},
       {"time of the solves", fmt::format("{:.0f} s", v.seconds)},
       {"software", software},
       {"scene, physics, mesh", fmt::format("{}, {}, {}", scene.source_name, model.physics_hash, model.mesh_hash)}}));
  Rows regions{{"part", "cells", "volume in mL", "share off in %", "shear modulus in Pa", "K/mu"}};
  for (const RegionFigures& r : region_figures(scene, in.model.mesh()))
    regions.push_back({r.name, std::to_string(r.cells), fmt::format("{:.4g}", 1e6 * r.volume_m3),
                       fmt::format("{:.2g}", 100 * r.off), fmt::format("{:.4g}", r.shear_modulus_Pa),
                       fmt::format("{:.4g}", r.bulk_to_shear)});
  if (regions.size() > 1) blocks.push_back(facts(regions));
  return section("Scene and probes", blocks);
}

/// The node, with the number of the case of which there is a picture.
Json case_link(const Validated& in, const ProbeRecord& record) {
  const auto& shown = in.report.shown;
  const auto found = std::find_if(shown.begin(), shown.end(), [&](const auto& state) {
    return state.node == record.node && state.displacement_m == record.displacement_m;
  });
  if (found == shown.end()) return std::to_string(record.node);
  return {{"text", std::to_string(record.node)}, {"case", found - shown.begin()}};
}

Json worst(const Validated& in) {
  std::vector<const ProbeRecord*> records;
  for (const auto& r : in.report.records)
    if (!r.outside) records.push_back(&r);
  std::stable_sort(records.begin(), records.end(),
                   [](const auto* a, const auto* b) { return a->force_error > b->force_error; });
  records.resize(std::min(records.size(), most_worst));
  const ForceUnit unit = unit_of(in);
  std::vector<Json> rows{{"node", "distance to the fixed nodes, mm", "displacement, mm",
                          fmt::format("finite elements, {}", unit.name), fmt::format("model, {}", unit.name),
                          "error of force, %", "error of displacement, %"}};
  const auto& points = in.model.mesh().nodes;
  for (const auto* r : records) {
    double nearest = 1e300;
    for (const auto fixed : in.model.model().fixed)
      nearest = std::min(nearest, (points.row(fixed) - points.row(r->node)).norm());
    rows.push_back(
        {case_link(in, *r), fmt::format("{:.0f}", 1e3 * nearest), vector(r->displacement_m),
         vector(r->finite_elements_N, unit.per_N), vector(r->model_N, unit.per_N), in_percent(r->force_error),
         in.report.of(Predictor::model).inside.displacement.n > 0 ? in_percent(r->displacement_error) : "-"});
  }
  return section("Largest errors of force inside the trained range", {table(rows)});
}

Json curves(const Validated& in) {
  std::vector<const ForceCurve*> chosen;
  for (const auto& curve : in.report.curves)
    if (curve.depth_m.size() > 2) chosen.push_back(&curve);
  // Curves are distributed evenly over the nodes and not selected by their error.
  std::vector<const ForceCurve*> shown;
  for (std::size_t i = 0; i < std::min(most_curves, chosen.size()); ++i)
    shown.push_back(chosen[i * chosen.size() / std::min(most_curves, chosen.size())]);
  const ForceUnit unit = unit_of(in);
  std::vector<Json> charts_of_nodes;
  for (const auto* curve : shown) {
    const auto component = [&](const Vec3& f) {
      return unit.per_N * (f[0] * curve->direction[0] + f[1] * curve->direction[1] + f[2] * curve->direction[2]);
    };
    Curve model{"model", "line", 0, {}}, solutions{"finite elements", "points", 2, {}},
        initial_slope{"straight line", "dashes", 1, {}};
    const double deepest = curve->depth_m.back();
    constexpr int n = 120;
    const auto model_force = [&](double s) {
      const auto& e = curve->direction;
      return component(in.model.force(curve->node, {s * e[0], s * e[1], s * e[2]}));
    };
    for (int i = 0; i <= n; ++i) model.at.emplace_back(1e3 * deepest * i / n, model_force(deepest * i / n));
    for (std::size_t i = 0; i < curve->depth_m.size(); ++i) {
      const double s = curve->depth_m[i];
      solutions.at.emplace_back(1e3 * s, component(curve->force_N[i]));
    }
    const double slope = component(curve->force_N[0]) / curve->depth_m[0];
    initial_slope.at = {{0, 0}, {1e3 * deepest, slope * deepest}};
    charts_of_nodes.push_back(
        chart(fmt::format("Node {}", curve->node), "depth, mm", fmt::format("force, {}", unit.name),
              {initial_slope, model, solutions},
              {{"caption",
                fmt::format("Direction {}; trained to {:.3g} mm", vector(curve->direction, 1, "({:.2f} {:.2f} {:.2f})"),
                            1e3 * in.model.trained_depth(curve->node, curve->direction))}}));
  }
  return section(
      "Force against depth",
      {text("The component of the force along the first random ray of a node, against depth. Solid: the model; dots: "
            "finite elements; dashed: the straight line through the first dot."),
       charts(charts_of_nodes)});
}

Json cost(const Validated& in) {
  const auto& speed = in.report.speed;
  std::string deformation;
  if (in.report.of(Predictor::model).inside.displacement.n > 0)
    deformation =
        fmt::format(", a deformation of {} nodes in {:.1f} us", in.model.model().output.size(), speed.deformation_us);
  if (!in.model.model().fields.empty()) deformation += fmt::format(", a field in {:.1f} us", speed.field_us);
  const Json times = text(fmt::format(
      "The runtime on this machine, one core: a force in {:.2f} us{}. An increment of the finite elements "
      "took {:.1f} ms of one core, including all other work of this validation. The model has {} in the runtime's "
      "memory and {} as text.",
      speed.force_us, deformation, in.report.solve_ms_per_increment, bytes(in.model.organ().constant_bytes()),
      bytes(in.model.text().size())));
  return section("Size and time", {times});
}

}  // namespace

std::string html_report(const Validated& in, const std::string& software) {
  std::vector<Json> sections{verdict_first(in), error_section(in), worst(in), curves(in)};
  if (const auto pictures = body_pictures(in); !pictures.empty())
    sections.push_back(
        section("Distribution of the error on the body",
                {Json{{"pictures", pictures}},
                 text("Means over all probes up to the depth; of the displacements, over those inside the "
                      "trained range.")}));
  for (auto& last : {cost(in), conditions(in, software)}) sections.push_back(last);
  return page(in.scene.title.empty() ? "Model compared with finite elements" : in.scene.title, sections);
}

}  // namespace phynness
