#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <phynness/drawing/html.hpp>
#include <phynness/drawing/plots.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/locking.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/trained_share.hpp>

#include "body_data.hpp"
#include "conservation.hpp"

namespace phynness {
namespace {

using namespace report;

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
ForceUnit unit_of(const ReportInput& in) {
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
Noticed noticed(const ReportInput& in, bool outside) {
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

/// The verdict, warnings, and the table of the text output with its two heading rows in one.
std::string verdict_first(const ReportInput& in) {
  std::string out = "<ul>\n";
  for (const auto& line : verdict(in))
    out += "<li><strong>" + escaped(line.title) + "</strong>: " + escaped(line.sentence) + ".</li>\n";
  out += "</ul>\n";
  for (const auto& worse : worse_than_linear(in))
    out += "<p class=\"warning\">" + escaped(worse.sentence()) + ".</p>\n";
  auto cells = summary_cells(in);
  for (std::size_t i = 0; i < cells[0].size(); ++i)
    cells[1][i] = cells[0][i].empty() ? cells[1][i] : cells[0][i] + " " + cells[1][i];
  cells.erase(cells.begin());
  return out + table(cells);
}

std::string folded(const std::string& title, const std::string& body) {
  return "<details><summary>" + title + "</summary>\n" + body + "</details>\n";
}

std::string modelled(const ReportInput& in) {
  const Scene& scene = in.scene;
  const Model& model = in.model.model();
  const double K_mu = scene.material.bulk_to_shear();
  const auto& family = model.family;
  std::string out;
  if (const double ratio = expected_force_ratio(scene); ratio > warned_force_ratio)
    out += fmt::format(
        "<p class=\"warning\">{} tetrahedra lock at K/mu = {:.3g}: forces at a depth of one edge of the mesh are about "
        "{}. The figures below compare the model with these finite elements, not with the tissue. Elements p1-p1 and "
        "taylor-hood do not lock.</p>\n",
        name(scene.solver.element), K_mu, ratio_in_words(ratio));
  if (scene.probe.kind == ProbeKind::node)
    out +=
        "<p class=\"warning\">Each probe moves one node, so its force depends on the size of the mesh. The force "
        "of a patch converges with the mesh size.</p>\n";
  out += table({{"", "value"},
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
                {"family of the model", name(family)}},
               CellKind::words);
  return section("Scene", out);
}

std::string solved(const ReportInput& in) {
  const auto& v = in.report;
  std::string nodes;
  for (std::size_t i = 0; i < std::min<std::size_t>(20, v.nodes.size()); ++i) nodes += fmt::format(" {}", v.nodes[i]);
  if (v.nodes.size() > 20) nodes += " ...";
  const auto [nearest, farthest] = std::ranges::minmax(v.fixed_distance_m);
  std::string out = fmt::format(
      "<p>{} new probes at {} active nodes ({}), {:.3g} to {:.3g} mm from the nearest fixed node. Directions are "
      "uniform on the sphere. Half of the depths are inside the trained range, half are outside, up to {:.2f} times "
      "the range. {} probes were solved inside, {} outside.</p>\n",
      v.probes, v.nodes.size(), nodes.empty() ? "" : nodes.substr(1), 1e3 * nearest, 1e3 * farthest, v.outside_factor,
      v.solved_inside, v.solved_outside);
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
  out += fmt::format(
      "<p>{} of {} training rays ended before the full depth, at {} of {} nodes{}</p>\n", short_rays, rays, incomplete,
      in.model.model().nodes.size(),
      short_rays > 0 ? "; their trained range is the reached depth, beyond which the runtime returns a warning." : ".");
  for (const auto& part : in.not_done) out += "<p class=\"warning\">" + escaped(part) + "</p>\n";
  return section("Solved and failed probes", out);
}

/// How a row compares with the linear predictor and, for a force, with what a person may notice.
std::string verdict(const ErrorStatistics& model, const ErrorStatistics& linear, const std::optional<Noticed>& force) {
  const std::string words = model.mean < linear.mean ? "better than linear" : "worse than linear";
  if (!force) return words;
  return words + (force->n == 0 ? "; none is noticed" : fmt::format("; {} may be noticed", force->share()));
}

/// Errors beside their bounds, and the share of errors below their bound by tenths of the depth.
std::string bound_plots(const ReportInput& in) {
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
  if (points.empty()) return "";
  for (std::size_t i = 0; i < n_parts; ++i)
    if (drawn[i] > 0)
      share.emplace_back(1e3 * errors.range_m * (static_cast<double>(i) + 0.5) / n_parts, 100 * held[i] / drawn[i]);
  const std::vector<std::pair<double, double>> wanted{{0, coverage}, {1e3 * errors.range_m, coverage}};
  return "<div class=\"plots\">\n<figure>" +
         plot({"Errors below the line are below their bound",
               "bound, % of the node's largest force",
               "error, %",
               true,
               {{"probes to R", Mark::points, 0, points},
                {"error = bound", Mark::line, 2, {{least, least}, {largest, largest}}}},
               true}) +
         "</figure>\n<figure>" +
         plot({"Share of errors below their bound",
               "depth, mm",
               "probes, %",
               false,
               {{"calibrated for", Mark::dashes, 2, wanted}, {"probes to R", Mark::joined_points, 0, share}},
               false,
               50,
               100}) +
         "</figure>\n</div>\n";
}

std::string errors(const ReportInput& in) {
  std::vector<std::vector<std::string>> rows{
      {"error in %", "model: mean", "median", "p95", "max", "linear: mean", "p95", "max", "zero: mean", "verdict"}};
  for (const bool outside : {false, true}) {
    using Member = const ErrorStatistics& (*)(const GroupErrors&);
    const auto row = [&](const char* what, Member member, bool of_force = false) {
      const auto of = [&](Predictor p) -> const ErrorStatistics& {
        const auto& e = in.report.of(p);
        return member(outside ? e.outside : e.inside);
      };
      const auto &m = of(Predictor::model), &l = of(Predictor::linear), &z = of(Predictor::zero);
      if (m.n == 0) return;
      rows.push_back({std::string(what) + (outside ? ", outside" : ", inside"), percent(m.mean), percent(m.median),
                      percent(m.p95), percent(m.max), percent(l.mean), percent(l.p95), percent(l.max), percent(z.mean),
                      "<span class=\"verdict\">" +
                          verdict(m, l, of_force ? std::optional(noticed(in, outside)) : std::nullopt) + "</span>"});
    };
    row(
        "force (17)", [](const GroupErrors& e) -> const ErrorStatistics& { return e.force; }, true);
    row("displacement (17)", [](const GroupErrors& e) -> const ErrorStatistics& { return e.displacement; });
    row("most moved tenth", [](const GroupErrors& e) -> const ErrorStatistics& { return e.displacement_moving; });
    row("field, relative L2", [](const GroupErrors& e) -> const ErrorStatistics& { return e.field_l2; });
  }
  const Model& model = in.model.model();
  std::string out =
      folded("Errors inside and outside the trained range",
             table(rows) + fmt::format("<p>A person may notice a force that is off by more than {:.0f} % of "
                                       "its own size (Allin et al. 2002).</p>\n",
                                       100 * noticeable)) +
      folded("Errors to R by warnings, depth and bounds", table(table_cells(in.report.to_range)));
  out += "<p>" + escaped(sentence(trained_share(model), model)) + ".</p>\n";
  for (const auto& remark : remarks(in.report.to_range)) out += "<p>" + escaped(remark) + ".</p>\n";
  for (const bool outside : {false, true}) {
    std::vector<double> force, force_linear, u, u_linear;
    for (const auto& r : in.report.records) {
      if (r.outside != outside) continue;
      force.push_back(100 * r.force_error);
      force_linear.push_back(100 * r.force_error_linear);
      u.push_back(100 * r.displacement_error);
      u_linear.push_back(100 * r.displacement_error_linear);
    }
    if (force.empty()) continue;
    const char* where = outside ? "outside the trained range" : "inside the trained range";
    const auto both = [&](const char* what, const std::vector<double>& model, const std::vector<double>& linear) {
      constexpr double least = 1e-3;
      return "<figure>" +
             plot({fmt::format("{}, {}", what, where),
                   "error (17) of a probe, %",
                   "probes, %",
                   true,
                   {{"linear predictor", Mark::dashes, 1, histogram(linear, least)},
                    {"model", Mark::line, 0, histogram(model, least)}}}) +
             "</figure>\n";
    };
    out += "<div class=\"plots\">\n" + both("Force", force, force_linear);
    if (in.report.of(Predictor::model).inside.displacement.n > 0) out += both("Displacement", u, u_linear);
    out += "</div>\n";
  }
  if (in.report.to_range.bounds) out += bound_plots(in);
  return section("Errors", out);
}

/// The node, with the number of the case that the page's script shows on the body.
std::string case_link(const ReportInput& in, const ProbeRecord& record) {
  const auto& shown = in.report.shown;
  const auto found = std::find_if(shown.begin(), shown.end(), [&](const auto& state) {
    return state.node == record.node && state.displacement_m == record.displacement_m;
  });
  if (found == shown.end()) return std::to_string(record.node);
  return fmt::format("<span data-case=\"{}\">{}</span>", found - shown.begin(), record.node);
}

std::string worst(const ReportInput& in) {
  std::vector<const ProbeRecord*> records;
  for (const auto& r : in.report.records)
    if (!r.outside) records.push_back(&r);
  std::stable_sort(records.begin(), records.end(),
                   [](const auto* a, const auto* b) { return a->force_error > b->force_error; });
  records.resize(std::min(records.size(), most_worst));
  const ForceUnit unit = unit_of(in);
  std::vector<std::vector<std::string>> rows{
      {"node", "distance to the fixed nodes, mm", "displacement, mm", fmt::format("finite elements, {}", unit.name),
       fmt::format("model, {}", unit.name), "error of force, %", "error of displacement, %"}};
  const auto& points = in.model.mesh().nodes;
  for (const auto* r : records) {
    double nearest = 1e300;
    for (const auto fixed : in.model.model().fixed)
      nearest = std::min(nearest, (points.row(fixed) - points.row(r->node)).norm());
    rows.push_back({case_link(in, *r), fmt::format("{:.0f}", 1e3 * nearest), vector(r->displacement_m),
                    vector(r->finite_elements_N, unit.per_N), vector(r->model_N, unit.per_N), percent(r->force_error),
                    in.report.of(Predictor::model).inside.displacement.n > 0 ? percent(r->displacement_error) : "-"});
  }
  return section("Largest errors of force inside the trained range", table(rows));
}

std::string curves(const ReportInput& in) {
  std::vector<const ForceCurve*> chosen;
  for (const auto& curve : in.report.curves)
    if (curve.depth_m.size() > 2) chosen.push_back(&curve);
  // Curves are distributed evenly over the nodes and not selected by their error.
  std::vector<const ForceCurve*> shown;
  for (std::size_t i = 0; i < std::min(most_curves, chosen.size()); ++i)
    shown.push_back(chosen[i * chosen.size() / std::min(most_curves, chosen.size())]);
  std::string out =
      "<p>The component of the force along the first random ray of a node, against depth. Solid: the model; dots: "
      "finite elements; dashed: the straight line through the first dot.</p>\n<div class=\"plots\">\n";
  const ForceUnit newton = unit_of(in);
  std::vector<std::vector<std::string>> rows{
      {"node", "depth, mm", fmt::format("finite elements, {}", newton.name), fmt::format("model, {}", newton.name)}};
  for (const auto* curve : shown) {
    const auto along = [&](const Vec3& f) {
      return newton.per_N * (f[0] * curve->direction[0] + f[1] * curve->direction[1] + f[2] * curve->direction[2]);
    };
    Curve model{"model", Mark::line, 0, {}}, solves{"finite elements", Mark::points, 2, {}},
        straight{"straight line", Mark::dashes, 1, {}};
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
    out += fmt::format("<figure>{}<figcaption>Direction {}; trained to {:.3g} mm</figcaption></figure>\n",
                       plot({fmt::format("Node {}", curve->node),
                             "depth, mm",
                             fmt::format("force, {}", newton.name),
                             false,
                             {straight, model, solves}}),
                       vector(unit, 1e3, "({:.2f} {:.2f} {:.2f})"),
                       1e3 * in.model.trained_depth(curve->node, curve->direction));
  }
  out += "</div>\n<details><summary>Figures of these curves</summary>" + table(rows) + "</details>\n";
  return section("Force against depth", out);
}

std::string picture(const ReportInput& in) {
  if (in.report.of(Predictor::model).inside.displacement.n == 0) return "";
  std::vector<std::vector<std::string>> rows{
      {"node", "probes", "error of force, mean %", "max %", "of displacement, mean %"}};
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
  std::string out = "<div id=\"body\"></div>\n<p>Means over all probes inside the trained range.</p>\n";
  if (rows.size() <= 41) out += table(rows);
  return section("Distribution of the error on the body", out);
}

std::string correlation(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : "(too few probes)";
}

std::string trust(const ReportInput& in) {
  constexpr int n_paths = 200;
  const Conservation c = closed_paths(in.model, n_paths, in.seed);
  std::string out = fmt::format(
      "<p>The work along {} closed paths of displacements inside the trained range, integrated from forces, is "
      "{:.1e} of the {} in the median and {:.1e} at most. {}</p>\n",
      c.paths, c.median, c.has_energy ? "largest stored energy on the path" : "largest work |f . d| / 2 on the path",
      c.largest,
      c.has_energy ? "Forces are the gradient of a stored energy, so that no closed path gains energy."
                   : "This family has no stored energy: a closed path may gain or lose this work.");
  out += fmt::format(
      "<p>The rank correlation of the distance to the nearest trained displacement (phn_trust) with the error of "
      "the force is {} inside and {} outside the trained range.</p>\n",
      correlation(in.report.distance_correlation_inside), correlation(in.report.distance_correlation_outside));
  return section("Conservation of energy and indicator of trust", out);
}

std::string cost(const ReportInput& in) {
  const auto& speed = in.report.speed;
  std::string deformation;
  if (in.report.of(Predictor::model).inside.displacement.n > 0)
    deformation =
        fmt::format(", a deformation of {} nodes in {:.1f} us", in.model.model().output.size(), speed.deformation_us);
  std::string out = fmt::format(
      "<p>On one core of the machine that wrote this report: a force in {:.2f} us{}. An increment of the finite "
      "elements took {:.1f} ms of one core, including all other work of this validation. The model has {} in the "
      "runtime's memory and {} as text.</p>\n",
      speed.force_us, deformation, in.report.solve_ms_per_increment, bytes(in.model.memory_bytes()),
      bytes(in.model.text_bytes()));
  const std::int32_t n_levels = in.model.runtime().n_levels();
  if (n_levels > 1) {
    const auto times = measure_levels(in.model);
    std::vector<std::vector<std::string>> rows{{"level", "centers of a force", "of a deformation", "modes", "force, us",
                                                "deformation, us", "error of force, %", "of displacement, %"}};
    for (std::int32_t l = 0; l < n_levels; ++l) {
      phn_level level;
      in.model.runtime().level_info(l, level).ignore();
      const auto& time = times[static_cast<std::size_t>(l)];
      rows.push_back({std::to_string(l), std::to_string(level.force_centers), std::to_string(level.deformation_centers),
                      std::to_string(level.modes), fmt::format("{:.2f}", time.force_us),
                      fmt::format("{:.2f}", time.deformation_us), percent(level.error_force),
                      percent(level.error_displacement)});
    }
    out +=
        "<p>Times and errors of the levels. Errors are leave-one-out estimates from training, of the median "
        "node.</p>\n" +
        table(rows);
  } else {
    out +=
        "<p class=\"key\">The model has one level. <code>phynness train --levels 4</code> adds smaller levels; "
        "<code>phynness tune</code> measures families and sizes.</p>\n";
  }
  return section("Size and time", out);
}

std::string origin(const ReportInput& in) {
  return section("Origin of this report", table({{"", "value"},
                                                 {"software", escaped(in.software)},
                                                 {"scene", escaped(in.scene.source_name)},
                                                 {"physics of the scene", in.model.model().physics_hash},
                                                 {"mesh", in.model.model().mesh_hash},
                                                 {"seed of the probes", std::to_string(in.seed)},
                                                 {"time of the solves", fmt::format("{:.0f} s", in.report.seconds)}},
                                                CellKind::words));
}

}  // namespace

std::string html_report(const ReportInput& in) {
  const std::string title = in.scene.title.empty() ? "Model compared with finite elements" : in.scene.title;
  return page(title,
              "<h1>" + escaped(title) + "</h1>\n" + verdict_first(in) + modelled(in) + solved(in) + errors(in) +
                  worst(in) + curves(in) + picture(in) + trust(in) + cost(in) + origin(in),
              body_data(in));
}

}  // namespace phynness
