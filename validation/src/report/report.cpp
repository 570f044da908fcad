#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/formats/locking.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/trained_share.hpp>

#include "body_data.hpp"
#include "conservation.hpp"

namespace phynness {
namespace {

using namespace report;
using Rows = std::vector<std::vector<std::string>>;

/// The smallest noticeable difference of a force is about 10 % (paper, section 5; Allin et al. 2002).
constexpr double noticeable = 0.10;
constexpr std::size_t most_curves = 6, most_worst = 10;

std::string percent(double fraction) {
  const double value = 100 * fraction;
  return value > 0 && value < 0.005 ? fmt::format("{:.0e}", value) : fmt::format("{:.2f}", value);
}
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

struct Noticed {
  std::size_t n = 0, of = 0;
  std::string share() const { return fmt::format("{} of {}", n, of); }
};
/// Probes whose force is off by more than a person may notice, which is a fraction of the present force (Weber's law).
/// Forces below 1 % of the node's largest count as that: they are hardly felt.
Noticed noticed(const Validated& in, bool outside) {
  std::map<std::int32_t, double> largest;
  for (const auto& r : in.report.records)
    if (r.outside == outside) largest[r.node] = std::max(largest[r.node], to_eigen(r.finite_elements_N).norm());
  Noticed found;
  for (const auto& r : in.report.records) {
    if (r.outside != outside) continue;
    const double size = std::max(to_eigen(r.finite_elements_N).norm(), 0.01 * largest[r.node]);
    ++found.of;
    found.n += (to_eigen(r.model_N) - to_eigen(r.finite_elements_N)).norm() > noticeable * size;
  }
  return found;
}

Json text(const std::string& words) { return {{"text", words}}; }
Json warning(const std::string& words) { return {{"warning", words}}; }
Json table(const Json& rows) { return {{"table", rows}}; }
Json folded(const std::string& title, const Json& rows) { return {{"folded", title}, {"table", rows}}; }
Json facts(const Rows& rows) { return {{"table", rows}, {"words", true}}; }
Json charts(const std::vector<Json>& all) { return {{"charts", all}}; }

/// The verdict, warnings, and the table of the text output with its two heading rows in one.
Json verdict_first(const Validated& in) {
  Json lines = Json::array();
  for (const auto& line : verdict(in)) lines.push_back({line.title, line.sentence + "."});
  std::vector<Json> blocks{{{"list", lines}}};
  for (const auto& worse : worse_than_linear(in)) blocks.push_back(warning(worse.sentence() + "."));
  auto cells = summary_cells(in);
  for (std::size_t i = 0; i < cells[0].size(); ++i)
    cells[1][i] = cells[0][i].empty() ? cells[1][i] : cells[0][i] + " " + cells[1][i];
  cells.erase(cells.begin());
  blocks.push_back(table(cells));
  return section("", blocks);
}

Json modelled(const Validated& in) {
  const Scene& scene = in.scene;
  const Model& model = in.model.model();
  const double K_mu = scene.material.bulk_to_shear();
  const auto& family = model.family;
  std::vector<Json> blocks;
  if (const double ratio = expected_force_ratio(scene); ratio > warned_force_ratio)
    blocks.push_back(
        warning(fmt::format("{} tetrahedra lock at K/mu = {:.3g}: forces at a depth of one edge of the mesh are about "
                            "{}. The figures below "
                            "compare the model with these finite elements, not with the tissue. Elements p1-p1 and "
                            "taylor-hood do not lock.",
                            name(scene.solver.element), K_mu, ratio_in_words(ratio))));
  if (scene.probe.kind == ProbeKind::node)
    blocks.push_back(warning(
        "Each probe moves one node, so its force depends on the size of the mesh. The force of a patch converges "
        "with the mesh size."));
  blocks.push_back(
      facts({{"", "value"},
             {"law", name(scene.material.law)},
             {"shear modulus", fmt::format("{:.4g} Pa", scene.material.shear_modulus_Pa)},
             {"bulk over shear modulus, K/mu", fmt::format("{:.4g}", K_mu)},
             {"element", name(scene.solver.element)},
             {"mesh", fmt::format("{} nodes, {} {}", in.model.mesh().n_nodes(), in.model.mesh().n_cells(),
                                  in.model.mesh().cells.cols() == 3 ? "triangles of a shell" : "tetrahedra")},
             {"nodes fixed, active, output",
              fmt::format("{}, {}, {}", model.fixed.size(), model.nodes.size(), model.output.size())},
             {"probe", name(scene.probe.kind)},
             {"trained range R", fmt::format("{:.4g} mm", 1e3 * scene.probe.max_displacement_m)},
             {"directions, increments", fmt::format("{}, {}", model.directions.size(), scene.probe.increments)},
             {"family of the model", name(family)}}));
  return section("Scene", blocks);
}

Json solved(const Validated& in) {
  const auto& v = in.report;
  std::string nodes;
  for (std::size_t i = 0; i < std::min<std::size_t>(20, v.nodes.size()); ++i) nodes += fmt::format(" {}", v.nodes[i]);
  if (v.nodes.size() > 20) nodes += " ...";
  const auto [nearest, farthest] = std::ranges::minmax(v.fixed_distance_m);
  std::vector<Json> blocks{text(fmt::format(
      "{} new probes at {} active nodes ({}), {:.3g} to {:.3g} mm from the nearest fixed node. Directions are uniform "
      "on "
      "the sphere. Half of the depths are inside the trained range, half are outside, up to {:.2f} times the range. {} "
      "probes were solved inside, {} outside.",
      v.probes, v.nodes.size(), nodes.empty() ? "" : nodes.substr(1), 1e3 * nearest, 1e3 * farthest, v.outside_factor,
      v.solved_inside, v.solved_outside))};
  std::size_t short_rays = 0, rays = 0, incomplete = 0;
  for (const auto& node : in.model.model().nodes) {
    std::size_t here = 0;
    for (const double depth : node.trained_depth_m) {
      ++rays;
      here += depth < (1 - 1e-9) * in.scene.probe.max_displacement_m;
    }
    short_rays += here;
    incomplete += here > 0;
  }
  blocks.push_back(text(fmt::format(
      "{} of {} training rays ended before the full depth, at {} of {} nodes{}", short_rays, rays, incomplete,
      in.model.model().nodes.size(),
      short_rays > 0 ? "; their trained range is the reached depth, beyond which the runtime returns a warning."
                     : ".")));
  for (const auto& part : in.not_done()) blocks.push_back(warning(part));
  return section("Solved and failed probes", blocks);
}

/// How a row compares with the linear predictor and, for a force, with what a person may notice.
std::string verdict(const ErrorStatistics& model, const ErrorStatistics& linear, const std::optional<Noticed>& force) {
  const std::string words = model.mean < linear.mean ? "better than linear" : "worse than linear";
  if (!force) return words;
  return words + (force->n == 0 ? "; none is noticed" : fmt::format("; {} may be noticed", force->share()));
}

/// Errors beside their bounds, and the share of errors below their bound by tenths of the depth.
std::vector<Json> bound_plots(const Validated& in) {
  const auto& errors = in.report.to_range;
  const auto& samples = errors.bounds->samples;
  const double coverage = 100 * in.model.model().bounds.at(0).coverage;
  constexpr std::size_t n_parts = 10;
  constexpr double least = 1e-3;  // %; smaller values are shown as this
  std::vector<std::pair<double, double>> points, share;
  std::array<double, n_parts> held{}, drawn{};
  double largest = least;
  for (const auto& s : samples) {
    if (s.largest_N <= 0) continue;
    const double bound = std::max(least, 100 * s.bound_N / s.largest_N);
    points.emplace_back(bound, std::max(least, 100 * s.error_N / s.largest_N));
    largest = std::max(largest, bound);
    const double part = std::floor(static_cast<double>(n_parts) * s.depth_m / errors.range_m);
    const auto at = std::min(n_parts - 1, static_cast<std::size_t>(part));
    drawn[at] += 1;
    held[at] += s.error_N <= s.bound_N ? 1 : 0;
  }
  if (points.empty()) return {};
  for (std::size_t i = 0; i < n_parts; ++i)
    if (drawn[i] > 0)
      share.emplace_back(1e3 * errors.range_m * (static_cast<double>(i) + 0.5) / n_parts, 100 * held[i] / drawn[i]);
  const std::vector<std::pair<double, double>> wanted{{0, coverage}, {1e3 * errors.range_m, coverage}};
  return {charts(
      {chart("Errors below the line are below their bound", "bound, % of the node's largest force", "error, %",
             {{"probes to R", "points", 0, points}, {"error = bound", "line", 2, {{least, least}, {largest, largest}}}},
             {{"log_x", true}, {"log_y", true}}),
       chart("Share of errors below their bound", "depth, mm", "probes, %",
             {{"calibrated for", "dashes", 2, wanted}, {"probes to R", "joined", 0, share}}, {{"range", {50, 100}}})})};
}

/// Percentages of samples in each third of a decade, from the smallest to the largest sample. Samples below `least`
/// count as `least`.
std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least) {
  std::map<int, int> bins;
  for (const double sample : samples) ++bins[static_cast<int>(std::floor(3 * std::log10(std::max(sample, least))))];
  std::vector<std::pair<double, double>> steps;
  if (bins.empty()) return steps;
  steps.emplace_back(std::pow(10, bins.begin()->first / 3.0), 0);
  for (int bin = bins.begin()->first; bin <= bins.rbegin()->first; ++bin) {
    const auto found = bins.find(bin);
    const double share = found == bins.end() ? 0 : 100.0 * found->second / static_cast<double>(samples.size());
    steps.emplace_back(std::pow(10, bin / 3.0), share);
    steps.emplace_back(std::pow(10, (bin + 1) / 3.0), share);
  }
  steps.emplace_back(steps.back().first, 0);
  return steps;
}

/// Errors of the predictors, in a group of probes.
void add_rows(const Validated& in, bool outside, Rows& rows) {
  const auto of = [&](Predictor p) {
    const auto& errors = in.report.of(p);
    return (outside ? errors.outside : errors.inside).rows();
  };
  const auto model = of(Predictor::model), linear = of(Predictor::linear), zero = of(Predictor::zero);
  for (std::size_t i = 0; i < model.size(); ++i) {
    const auto& [title, m] = model[i];
    const auto &l = linear[i].second, &z = zero[i].second;
    if (m.n == 0) continue;
    rows.push_back({title + (outside ? ", outside" : ", inside"), percent(m.mean), percent(m.median), percent(m.p95),
                    percent(m.max), percent(l.mean), percent(l.p95), percent(l.max), percent(z.mean),
                    verdict(m, l, i == 0 ? std::optional(noticed(in, outside)) : std::nullopt)});
  }
}

/// Histograms of the errors of a group of probes; nothing if it has none.
std::vector<Json> histograms(const Validated& in, bool outside) {
  std::vector<double> force, force_linear, u, u_linear;
  for (const auto& r : in.report.records) {
    if (r.outside != outside) continue;
    force.push_back(100 * r.force_error);
    force_linear.push_back(100 * r.force_error_linear);
    u.push_back(100 * r.displacement_error);
    u_linear.push_back(100 * r.displacement_error_linear);
  }
  if (force.empty()) return {};
  const auto both = [&](const char* what, const std::vector<double>& model, const std::vector<double>& linear) {
    constexpr double least = 1e-3;
    return chart(
        fmt::format("{}, {} the trained range", what, outside ? "outside" : "inside"), "error (17) of a probe, %",
        "probes, %",
        {{"linear predictor", "dashes", 1, histogram(linear, least)}, {"model", "line", 0, histogram(model, least)}},
        {{"log_x", true}});
  };
  std::vector<Json> all{both("Force", force, force_linear)};
  if (in.report.of(Predictor::model).inside.displacement.n > 0) all.push_back(both("Displacement", u, u_linear));
  return {charts(all)};
}

Json errors(const Validated& in) {
  Rows rows{
      {"error in %", "model: mean", "median", "p95", "max", "linear: mean", "p95", "max", "zero: mean", "verdict"}};
  for (const bool outside : {false, true}) add_rows(in, outside, rows);
  const Model& model = in.model.model();
  std::vector<Json> blocks{
      folded("Errors inside and outside the trained range", rows),
      text(fmt::format(
          "A person may notice a force that is off by more than {:.0f} % of its own size (Allin et al. 2002).",
          100 * noticeable)),
      folded("Errors to R by warnings, depth and bounds", table_cells(in.report.to_range)),
      text(sentence(trained_share(model), model) + ".")};
  for (const auto& remark : remarks(in.report.to_range)) blocks.push_back(text(remark + "."));
  for (const auto& plots :
       {histograms(in, false), histograms(in, true), in.report.to_range.bounds ? bound_plots(in) : std::vector<Json>{}})
    blocks.insert(blocks.end(), plots.begin(), plots.end());
  return section("Errors", blocks);
}

/// The node, with the number of the case that the page's script shows on the body.
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
    rows.push_back({case_link(in, *r), fmt::format("{:.0f}", 1e3 * nearest), vector(r->displacement_m),
                    vector(r->finite_elements_N, unit.per_N), vector(r->model_N, unit.per_N), percent(r->force_error),
                    in.report.of(Predictor::model).inside.displacement.n > 0 ? percent(r->displacement_error) : "-"});
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
  const ForceUnit newton = unit_of(in);
  std::vector<Json> drawn;
  Rows rows{
      {"node", "depth, mm", fmt::format("finite elements, {}", newton.name), fmt::format("model, {}", newton.name)}};
  for (const auto* curve : shown) {
    const auto along = [&](const Vec3& f) {
      return newton.per_N * (f[0] * curve->direction[0] + f[1] * curve->direction[1] + f[2] * curve->direction[2]);
    };
    Curve model{"model", "line", 0, {}}, solves{"finite elements", "points", 2, {}},
        straight{"straight line", "dashes", 1, {}};
    const double deepest = curve->depth_m.back();
    constexpr int n = 120;
    for (int i = 0; i <= n; ++i) {
      const double s = deepest * i / n;
      const Vec3 d{s * curve->direction[0], s * curve->direction[1], s * curve->direction[2]};
      model.at.emplace_back(1e3 * s, along(in.model.force(curve->node, d)));
    }
    for (std::size_t i = 0; i < curve->depth_m.size(); ++i) {
      const double s = curve->depth_m[i];
      const Vec3 d{s * curve->direction[0], s * curve->direction[1], s * curve->direction[2]};
      solves.at.emplace_back(1e3 * s, along(curve->force_N[i]));
      rows.push_back({std::to_string(curve->node), fmt::format("{:.2f}", 1e3 * s),
                      fmt::format("{:.4g}", along(curve->force_N[i])),
                      fmt::format("{:.4g}", along(in.model.force(curve->node, d)))});
    }
    const double slope = along(curve->force_N[0]) / curve->depth_m[0];
    straight.at = {{0, 0}, {1e3 * deepest, slope * deepest}};
    const Vec3 unit{curve->direction[0] * 1e-3, curve->direction[1] * 1e-3, curve->direction[2] * 1e-3};
    drawn.push_back(chart(
        fmt::format("Node {}", curve->node), "depth, mm", fmt::format("force, {}", newton.name),
        {straight, model, solves},
        {{"caption", fmt::format("Direction {}; trained to {:.3g} mm", vector(unit, 1e3, "({:.2f} {:.2f} {:.2f})"),
                                 1e3 * in.model.trained_depth(curve->node, curve->direction))}}));
  }
  return section(
      "Force against depth",
      {text("The component of the force along the first random ray of a node, against depth. Solid: the model; dots: "
            "finite elements; dashed: the straight line through the first dot."),
       charts(drawn), folded("Figures of these curves", rows)});
}

Json picture(const Validated& in) {
  Rows rows{{"node", "probes", "error of force, mean %", "max %", "of displacement, mean %"}};
  std::map<std::int32_t, std::vector<const ProbeRecord*>> by_node;
  for (const auto& r : in.report.records)
    if (!r.outside) by_node[r.node].push_back(&r);
  for (const auto& [node, records] : by_node) {
    double force = 0, most = 0, u = 0;
    for (const auto* r : records) {
      force += r->force_error / static_cast<double>(records.size());
      u += r->displacement_error / static_cast<double>(records.size());
      most = std::max(most, r->force_error);
    }
    rows.push_back({std::to_string(node), std::to_string(records.size()), percent(force), percent(most), percent(u)});
  }
  std::vector<Json> blocks{text("Means over all probes inside the trained range.")};
  if (auto data = body_data(in); !data.is_null()) blocks.insert(blocks.begin(), Json{{"body", std::move(data)}});
  if (rows.size() <= 41) blocks.push_back(table(rows));
  return section("Distribution of the error on the body", blocks);
}

std::string correlation(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : "(too few probes)";
}

Json trust(const Validated& in) {
  constexpr int n_paths = 200;
  const Conservation c = closed_paths(in.model, n_paths, in.seed);
  const std::string work = fmt::format(
      "The work along {} closed paths of displacements inside the trained range, integrated from forces, is {:.1e} of "
      "the {} in the median and {:.1e} at most. {}",
      c.paths, c.median, c.has_energy ? "largest stored energy on the path" : "largest work |f . d| / 2 on the path",
      c.largest,
      c.has_energy ? "Forces are the gradient of a stored energy, so that no closed path gains energy."
                   : "This family has no stored energy: a closed path may gain or lose this work.");
  const std::string distance = fmt::format(
      "The rank correlation of the distance to the nearest trained displacement (phn_trust) with the error of the "
      "force "
      "is {} inside and {} outside the trained range.",
      correlation(in.report.distance_correlation_inside), correlation(in.report.distance_correlation_outside));
  return section("Conservation of energy and indicator of trust", {text(work), text(distance)});
}

Json cost(const Validated& in) {
  const auto& speed = in.report.speed;
  std::string deformation;
  if (in.report.of(Predictor::model).inside.displacement.n > 0)
    deformation =
        fmt::format(", a deformation of {} nodes in {:.1f} us", in.model.model().output.size(), speed.deformation_us);
  std::vector<Json> blocks{text(fmt::format(
      "On one core of the machine that wrote this report: a force in {:.2f} us{}. An increment of the finite elements "
      "took {:.1f} ms of one core, including all other work of this validation. The model has {} in the runtime's "
      "memory "
      "and {} as text.",
      speed.force_us, deformation, in.report.solve_ms_per_increment, bytes(in.model.memory_bytes()),
      bytes(in.model.text_bytes())))};
  const std::int32_t n_levels = in.model.runtime().n_levels();
  if (n_levels > 1) {
    const auto times = measure_levels(in.model);
    Rows rows{{"level", "centers of a force", "of a deformation", "modes", "force, us", "deformation, us",
               "error of force, %", "of displacement, %"}};
    for (std::int32_t l = 0; l < n_levels; ++l) {
      phn_level level;
      in.model.runtime().level_info(l, level).ignore();
      const auto& time = times[static_cast<std::size_t>(l)];
      rows.push_back({std::to_string(l), std::to_string(level.force_centers), std::to_string(level.deformation_centers),
                      std::to_string(level.modes), fmt::format("{:.2f}", time.force_us),
                      fmt::format("{:.2f}", time.deformation_us), percent(level.error_force),
                      percent(level.error_displacement)});
    }
    blocks.push_back(
        text("Times and errors of the levels. Errors are leave-one-out estimates from training, of the median node."));
    blocks.push_back(table(rows));
  } else {
    blocks.push_back({{"remark",
                       "The model has one level. phynness train --levels 4 adds smaller levels; phynness tune measures "
                       "families and sizes."}});
  }
  return section("Size and time", blocks);
}

Json origin(const Validated& in, const std::string& software) {
  return section("Origin of this report",
                 {facts({{"", "value"},
                         {"software", software},
                         {"scene", in.scene.source_name},
                         {"physics of the scene", in.model.model().physics_hash},
                         {"mesh", in.model.model().mesh_hash},
                         {"seed of the probes", std::to_string(in.seed)},
                         {"time of the solves", fmt::format("{:.0f} s", in.report.seconds)}})});
}

}  // namespace

std::string html_report(const Validated& in, const std::string& software) {
  std::vector<Json> sections{verdict_first(in), modelled(in), solved(in), errors(in), worst(in), curves(in)};
  if (in.report.of(Predictor::model).inside.displacement.n > 0) sections.push_back(picture(in));
  for (auto& last : {trust(in), cost(in), origin(in, software)}) sections.push_back(last);
  return page(in.scene.title.empty() ? "Model compared with finite elements" : in.scene.title, sections);
}

}  // namespace phynness
