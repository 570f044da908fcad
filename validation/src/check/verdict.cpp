#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/database.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/locking.hpp>
#include <phynness/validation/report.hpp>

namespace phynness {
namespace {

/// The 95th percentile of the errors of two tools from which on a body is not fit for them.
constexpr double largest_p95 = 0.25;

/// Of fewer than 20 errors p95 is the largest.
bool has_p95(const ErrorStatistics& errors) { return errors.p95 < errors.max; }

/// "0.20 % on average, below 0.80 % in 95 % of 100"; of few errors "at most 0.80 % in all 2".
std::string in_words(const ErrorStatistics& errors, const char* of = "") {
  return fmt::format("{} %{} on average, {} {} % in {} {}", in_percent(errors.mean), of,
                     has_p95(errors) ? "below" : "at most", in_percent(errors.p95), has_p95(errors) ? "95 % of" : "all",
                     errors.n);
}

VerdictLine of_model(const Validated& v) {
  const auto& e = v.report.to_range;
  const auto wrong_share = [](const ProbeStatistics& group) {
    return group.model.force.n > 0 ? group.model.wrong : undefined;
  };
  const double wrong_of_all = wrong_share(e.all), wrong_without_warning = wrong_share(e.unflagged),
               wrong_with_warning = wrong_share(e.flagged);
  const auto& force = e.all.model.force;
  std::string text = "no force was compared", by_warning;
  if (!std::isnan(wrong_without_warning) && !std::isnan(wrong_with_warning))
    by_warning = in_percent(wrong_without_warning) + " % of those without a warning, ";
  if (!std::isnan(wrong_with_warning)) by_warning += in_percent(wrong_with_warning) + " % of those with a warning; ";
  if (const auto& linear = e.all.linear; force.n > 0)
    text = fmt::format(
        "{} probes at {} of {} active nodes (linear predictor: {} %); {} % of the forces are wrong by more than a "
        "tenth of their own size ({}linear predictor: {} %)",
        in_words(force, " of the node's largest force"), v.report.nodes.size(), v.model.model().nodes.size(),
        in_percent(linear.force.mean), in_percent(wrong_of_all), by_warning, in_percent(linear.wrong));
  if (const auto& between = v.points.all; between.model.force.n > 0)
    text += fmt::format(". Between probed points: {} (linear predictor: {} %)", in_words(between.model.force),
                        in_percent(between.linear.force.mean));
  return {"off_by_a_tenth",
          "Force error of the model where it was probed, compared with its own finite elements",
          text,
          {{"share", wrong_of_all},
           {"share_without_warning", wrong_without_warning},
           {"share_with_warning", wrong_with_warning}}};
}

VerdictLine of_finite_elements(const Validated& v) {
  const auto& finer = v.model.model().finer;
  const auto& model_error = v.report.to_range.all.model.force;
  const double ratio = expected_force_ratio(v.scene);
  std::string text = finer.is_measured ? finer.sentence()
                                       : fmt::format("not measured ({}); phynness check SCENE does it",
                                                     v.scene.validation.check_probes == 0 ? "check_probes = 0"
                                                                                          : "no check, or it failed");
  if (finer.is_measured && finer.probes > 0 && model_error.n > 0)
    text += finer.mean > model_error.mean && finer.p95 > model_error.p95
                ? ". This error is larger than that of the model and limits the accuracy"
            : finer.mean < model_error.mean && finer.p95 < model_error.p95
                ? ". The error of the model is larger and limits the accuracy"
                : ". Both errors limit the accuracy";
  if (ratio > warned_force_ratio)
    text += fmt::format(
        ". {} locks at K/mu = {:.3g}{}", name(v.scene.solver.element), most_locked(v.scene).bulk_to_shear(),
        finer.is_measured && finer.probes > 0 ? "" : ": forces are estimated to be " + ratio_in_words(ratio));
  return {"mesh_and_element",
          "Force error of these finite elements, compared with finer ones",
          text,
          {{"expected_ratio", ratio}}};
}

VerdictLine worst_node(const Validated& v) {
  VerdictLine line{"worst_node", "Largest force error of the model", "no probe was solved", {}};
  const auto& worst = v.report.to_range.worst;
  if (!worst) return line;
  if (!worst->flagged && v.report.to_range.flagged.model.force.n > 0) line.title += " without a warning";
  const auto at = v.model.mesh().nodes.row(worst->node);
  const ForceUnit unit = worst->largest_N >= 1 ? ForceUnit{1, "N"} : force_unit(worst->largest_N);
  line.sentence = fmt::format(
      "{:.3g} {} at node {} ({:.1f}, {:.1f}, {:.1f}) mm, where the error is {:.3g} {} on average and the largest force "
      "{:.3g} {}{}",
      unit.per_N * worst->error_N, unit.name, worst->node, 1e3 * at[0], 1e3 * at[1], 1e3 * at[2],
      unit.per_N * worst->mean_error_N, unit.name, unit.per_N * worst->largest_N, unit.name,
      worst->flagged ? " (the runtime warns of all probes)" : "");
  for (const auto& [where, points] :
       {std::pair{"; between probed points {} % of the largest force there, at ({:.1f}, {:.1f}, {:.1f}) mm", &v.points},
        {"; at the rim of the probed part {} %, at ({:.1f}, {:.1f}, {:.1f}) mm", &v.rim}})
    if (points->worst)
      line.sentence += fmt::format(fmt::runtime(where), in_percent(points->worst->error), 1e3 * points->worst->at_m[0],
                                   1e3 * points->worst->at_m[1], 1e3 * points->worst->at_m[2]);
  line.figures = {{"node", worst->node},
                  {"x_m", at[0]},
                  {"y_m", at[1]},
                  {"z_m", at[2]},
                  {"error_N", worst->error_N},
                  {"mean_error_N", worst->mean_error_N},
                  {"largest_force_N", worst->largest_N}};
  return line;
}

VerdictLine of_two_tools(const Validated& v) {
  const auto &unflagged = v.pairs.unflagged, &flagged = v.pairs.flagged;
  const auto &force = unflagged.model.force, &linear = unflagged.linear.force, &warned = flagged.model.force;
  std::string text = "all pairs have a warning";
  if (force.n > 0)
    text = fmt::format("{} pairs (linear predictor: {} %, {} {} %)", in_words(force), in_percent(linear.mean),
                       has_p95(linear) ? "below" : "at most", in_percent(linear.p95));
  if (warned.n > 0)
    text += fmt::format("; {} % on average in {} pairs with a warning, such as near tools (linear predictor: {} %)",
                        in_percent(warned.mean), warned.n, in_percent(flagged.linear.force.mean));
  if (const auto& answers = v.pairs.answers; answers.bounded > 0)
    text +=
        fmt::format("; the bound held for {:.0f} % of {} forces",
                    100 * static_cast<double>(answers.covered) / static_cast<double>(answers.bounded), answers.bounded);
  return {
      "two_tools",
      fmt::format("Force error of the {} with two tools, both {:.3g} mm deep ({} of the trained depth), compared with "
                  "finite elements",
                  v.pairs.by_body ? "reduced body" : "model", 1e3 * v.pairs.depth_m, pair_depth_in_words),
      text,
      {}};
}

VerdictLine of_bound(const Validated& v, const BoundCoverage& measured) {
  const auto& e = v.report.to_range;
  const auto size = [](double bound_N, double force_N, const char* over = "") {
    const ForceUnit unit = force_unit(bound_N);
    std::string text = fmt::format("{:.3g} {} in the median{}", unit.per_N * bound_N, unit.name, over);
    return force_N > 0 ? fmt::format("{}, {} % of the median force", text, in_percent(bound_N / force_N)) : text;
  };
  std::string between;
  if (const auto& answers = v.points.answers; answers.bounded > 0)
    between =
        fmt::format(". Between probed points: {}; it held for {:.0f} % of {}",
                    size(ErrorStatistics::of(answers.bounds_N).median, ErrorStatistics::of(answers.forces_N).median),
                    100 * static_cast<double>(answers.covered) / static_cast<double>(answers.bounded), answers.bounded);
  return {"bounds",
          "Bound of the model's force error",
          size(e.median_bound_N, e.median_force_N, " over these probes") + "; it " +
              held_in_words(measured, promised_coverage(v.model.model())) + between,
          {{"median_bound_N", e.median_bound_N}, {"median_force_N", e.median_force_N}}};
}

/// @return null without a bound of the distance from the model's own elements, with which validate compares
const BoundCoverage* measured_bound(const Validated& v) {
  const auto& model = v.model.model();
  const auto& measured = v.report.to_range.bounds;
  const bool own = !model.bounds.empty() && model.bounds[0].reference == 0;
  return own && measured && measured->states > 0 ? &*measured : nullptr;
}

VerdictLine not_covered(const Validated& v) {
  const auto share = trained_share(v.model.model());
  const auto& e = v.report.to_range;
  std::string worst_covered;
  const auto least_covered = std::min_element(share.of_node.begin(), share.of_node.end());
  if (least_covered != share.of_node.end() && *least_covered < 1)
    worst_covered =
        fmt::format(" ({} % at node {}, the worst)", in_percent(1 - *least_covered),
                    v.model.model().nodes[static_cast<std::size_t>(least_covered - share.of_node.begin())].node);
  const double untrained = std::max(0.0, 1 - share.all);
  const std::size_t active = v.model.model().nodes.size(), probed = v.report.nodes.size();
  std::string text = fmt::format(
      "{} % of the displacements of probed nodes to {:.4g} mm{}{}, which have no training data and give a "
      "warning",
      in_percent(untrained), 1e3 * e.range_m, worst_covered,
      v.scene.probe.directions == Directions::hemisphere ? ", and all that point outward" : "");
  const double linear = touched_area(v.model.model(), v.model.mesh()).linear;
  if (linear > 0)
    text += fmt::format("; {} % of the free surface, which the model answers as the body at rest, with a warning",
                        in_percent(linear));
  if (!e.unreached.empty())
    text += fmt::format("; {} of {} probes have no finite element solution, {} of them without a warning",
                        e.unreached.size(), e.all.probes,
                        std::ranges::count_if(e.unreached, [](const auto& p) { return !p.flagged; }));
  if (v.points.failed > 0) text += fmt::format("; {} displacements of points were not solved", v.points.failed);
  if (v.pairs.failed > 0) text += fmt::format("; {} pairs were not solved", v.pairs.failed);
  if (v.points.finished == 0)
    text += "; tools between nodes were not compared (--points, if three active nodes are near enough)";
  if (v.pairs.finished == 0 && (v.scene.probe.tools > 1 || !v.model.has_round_tools()))
    text += "; two tools at a time were not compared (--pairs)";
  return {"not_covered",
          "Not covered",
          text,
          {{"share_of_volume", untrained},
           {"probes", static_cast<double>(e.unreached.size())},
           {"nodes", static_cast<double>(active - probed)},
           {"active_nodes", static_cast<double>(active)}}};
}

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
          {"level", v.model.level()},
          {"seed", v.seed}};
}

/// The number of requested directions. The depth is 0 for directions that are not requested (hemisphere) and for those
/// whose first increment failed.
std::ptrdiff_t n_requested(const ActiveNodeModel& node, double range_m) {
  const auto& depths = node.trained_depth_m;
  const auto n_short = std::ranges::count_if(depths, [&](double depth) { return depth < range_m; });
  return std::ssize(depths) -
         std::clamp(n_short - node.n_incomplete, std::ptrdiff_t{0}, std::ranges::count(depths, 0.0));
}

}  // namespace

std::vector<std::string> Validated::not_done() const {
  std::vector<std::string> parts;
  for (const auto& [part, reason] : {std::pair{"--points", &no_points}, std::pair{"--pairs", &no_pairs}})
    if (*reason) parts.push_back(fmt::format("{} was not done: {}", part, (*reason)->what()));
  return parts;
}

std::vector<VerdictLine> verdict(const Validated& v) {
  std::vector<VerdictLine> lines{of_model(v), of_finite_elements(v), worst_node(v)};
  if (const auto* measured = measured_bound(v)) lines.push_back(of_bound(v, *measured));
  if (v.pairs.finished > 0) lines.push_back(of_two_tools(v));
  lines.push_back(not_covered(v));
  return lines;
}

std::vector<WorseThanLinear> worse_than_linear(const Validated& v) {
  auto all = worse_than_linear(v.report);
  for (const auto& part : {worse_than_linear(v.points, SurfacePart::probed), worse_than_linear(v.rim, SurfacePart::rim),
                           worse_than_linear(v.pairs)})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<std::string> warnings(const Validated& v) {
  std::vector<std::string> all;
  const auto remedy = [&] { return larger_body(v.body->body_info().n_modes, v.body->body_info().n_cells); };
  for (const auto& worse : worse_than_linear(v)) {
    std::string text = worse.sentence();
    if (worse.is_of_body())
      text += "; " + remedy();
    else if (worse.range == std::string_view("rim")) {
      const auto& body = v.rim.body;
      const bool is_of_force = worse.what == std::string_view("force");
      const bool body_is_better = body && (is_of_force ? body->force : body->displacement).mean < worse.linear;
      text += "; the runtime warns there: probe more of the surface";
      if (body_is_better) text += ", or use the reduced body";
    }
    all.push_back(text);
  }
  if (const auto& force = v.pairs.unflagged.model.force; v.body && v.pairs.by_body && force.p95 > largest_p95) {
    const auto& size = v.body->body_info();
    all.push_back(
        fmt::format("the force error of the reduced body with two tools is {} % {}; its {} modes and {} cells may be "
                    "too few: {}",
                    in_percent(force.p95), has_p95(force) ? "or more in 5 % of the pairs" : "in the worst pair",
                    size.n_modes, size.n_cells, remedy()));
  }
  if (const auto* measured = measured_bound(v);
      measured && is_below_promise(*measured, promised_coverage(v.model.model())))
    all.push_back(fmt::format(
        "the bound of the model's force error held for {:.0f} % of the errors, less than the {:.0f} % that calibration "
        "promised; more calibration_rays in [validation] make it safer",
        100 * measured->all, 100 * promised_coverage(v.model.model())));
  return all;
}

std::vector<std::vector<std::string>> summary_cells(const Validated& v) {
  const auto& e = v.report.to_range;
  std::vector<std::vector<std::string>> cells{{"", "", "force", "", "", "over", "displ.", "", "", "linear", "linear"},
                                              {fmt::format("to {:.4g} mm, in %", 1e3 * e.range_m), "probes", "mean",
                                               "p95", "max", "10 %", "mean", "p95", "max", "force", "displ."}};
  const auto shown = [](const ErrorStatistics& s, double value) { return s.n > 0 ? in_percent(value) : "-"; };
  const auto add = [&](const std::string& title, const ProbeStatistics& errors, std::int64_t of_group = -1) {
    if (errors.probes == 0 || errors.probes == of_group) return;
    const auto &f = errors.model.force, &u = errors.model.displacement;
    const auto &lf = errors.linear.force, &lu = errors.linear.displacement;
    cells.push_back({title, std::to_string(errors.solved), shown(f, f.mean), shown(f, f.p95), shown(f, f.max),
                     shown(f, errors.model.wrong), shown(u, u.mean), shown(u, u.p95), shown(u, u.max),
                     shown(lf, lf.mean), shown(lu, lu.mean)});
  };
  add("all", e.all);
  add("without a warning", e.unflagged, e.all.probes);
  add("with a warning", e.flagged, e.all.probes);
  add(fmt::format("deeper, to {:.3g} mm", 1e3 * v.report.outside_factor * e.range_m), e.beyond);
  const auto add_body = [&](const std::optional<PointErrors>& errors) {
    if (!errors) return;
    const auto &f = errors->force, &u = errors->displacement;
    cells.push_back({"  by the reduced body", std::to_string(f.n), shown(f, f.mean), shown(f, f.p95), shown(f, f.max),
                     "-", shown(u, u.mean), shown(u, u.p95), shown(u, u.max), "-", "-"});
  };
  add("tools between nodes", v.points.all);
  add_body(v.points.body);
  add("at the rim", v.rim.all);
  add_body(v.rim.body);
  add(v.pairs.by_body ? "two tools, reduced body" : "two tools", v.pairs.unflagged);
  add("two tools, with a warning", v.pairs.flagged);
  return cells;
}

std::string validate_again(const Validated& in) {
  std::string line = fmt::format("phynness validate SCENE MODEL_DIR --probes {} --nodes {} --seed {}", in.report.probes,
                                 in.report.nodes.size(), in.seed);
  if (!in.model.is_of_full_level()) line += fmt::format(" --level {}", in.model.level());
  if (in.points.finished > 0 || in.model.has_round_tools()) line += fmt::format(" --points {}", in.points.finished);
  if (in.pairs.finished > 0) line += fmt::format(" --pairs {}", in.pairs.finished);
  if (in.body) line += " --body BODY.txt";
  return line;
}

std::string check_again(const FinerDistance& finer) {
  if (!finer.is_measured) return "not compared; phynness check SCENE does it";
  return fmt::format("phynness check SCENE --reference {} --probes {} --seconds 1e7", finer.reference,
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
  if (v.rim.finished > 0) out["rim"] = figures(v.rim);
  if (v.pairs.finished > 0) out["pairs"] = figures(v.pairs);
  if (v.motions.finished > 0) out["motions"] = figures(v.motions);
  if (v.no_points) out["points"] = {{"not_done", v.no_points->what()}};
  if (v.no_pairs) out["pairs"] = {{"not_done", v.no_pairs->what()}};
  return out;
}

TrainedShare trained_share(const Model& model) {
  TrainedShare share;
  double all = 0, rays = 0;
  for (const auto& node : model.nodes) {
    double sum = 0;
    for (const double depth : node.trained_depth_m) sum += part_of_volume(depth, model.max_displacement_m);
    const auto n = static_cast<double>(n_requested(node, model.max_displacement_m));
    share.of_node.push_back(n > 0 ? sum / n : 0);
    all += sum;
    rays += n;
  }
  share.all = rays > 0 ? all / rays : 0;
  return share;
}

}  // namespace phynness
