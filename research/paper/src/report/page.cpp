// The report as JSON and as a page.
#include <phynness/drawing/html.hpp>
#include <phynness/drawing/plots.hpp>
#include <phynness/studies/json.hpp>

#include "mesh_picture.hpp"
#include "parts.hpp"

namespace phynness {
namespace {

using json = nlohmann::ordered_json;
using namespace report;

report::Mark mark(LineStyle style) {
  switch (style) {
    case LineStyle::line:
      return Mark::line;
    case LineStyle::dashes:
      return Mark::dashes;
    case LineStyle::dots:
      return Mark::dotted;
    case LineStyle::points:
      return Mark::points;
    case LineStyle::joined:
      return Mark::joined_points;
  }
  return Mark::line;
}

std::string drawn(const Panel& panel) {
  PlotSpec spec{panel.title, panel.x, panel.y, panel.log_x, {}, panel.log_y, panel.low, panel.high};
  for (const auto& series : panel.series) {
    Curve curve{series.name, mark(series.style), series.color, {}};
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (!panel.log_y || series.y[i] > 0) curve.at.emplace_back(series.x[i], series.y[i]);
    spec.curves.push_back(std::move(curve));
  }
  return "<figure>" + plot(spec) + "</figure>\n";
}

std::string said(const char* who, const std::string& what) {
  return what.empty() ? "" : fmt::format("<p><b>{}</b> {}</p>\n", who, escaped(what));
}

std::string escaped_table(const TextTable& rows) {
  if (rows.size() < 2) return "";
  TextTable cells = rows;
  for (auto& row : cells)
    for (auto& cell : row) cell = escaped(cell);
  return table(cells, CellKind::words);
}

std::string figure_section(const PaperStudy& study, const PaperFigure& figure) {
  std::string body = said("Paper:", figure.paper);
  if (!figure.panels.empty()) {
    body += "<div class=\"plots\">\n";
    for (const auto& panel : figure.panels) body += drawn(panel);
    body += "</div>\n";
  }
  if (figure.number == "13")
    if (const auto* liver = study::ran(study, "3"); liver != nullptr) {
      body += "<div class=\"plots\">\n";
      for (std::size_t l = 0; l < liver->surfaces.size(); ++l)
        body += mesh_picture(liver->surfaces[l].points, liver->surfaces[l].triangles,
                             fmt::format("Level {}: {} vertices, {} triangles", l, liver->surfaces[l].points.rows(),
                                         liver->surfaces[l].triangles.rows()));
      body += "</div>\n";
    }
  body += escaped_table(figure.table) + said("This run:", figure.found);
  if (!figure.conditions.empty()) body += "<p class=\"key\">Conditions: " + escaped(figure.conditions) + "</p>\n";
  const bool numbered = figure.number.find_first_not_of("0123456789") == std::string::npos;
  return section((numbered ? "Figure " : "") + figure.number + ": " + figure.title, body);
}

/// Results of phynness validate for both models of a case.
std::string validations(const PaperStudy& study) {
  TextTable rows{{"case, error % (17)", "model", "force: mean", "p95", "max", "displacement: mean", "p95",
                  "beyond R: force", "displacement", "solved: inside, beyond"}};
  for (const auto& result : study.cases) {
    if (!result.missing.empty()) continue;
    const auto& probes = result.facts.ours_errors;
    const std::string solved =
        probes.is_object() && probes.contains("solved_inside")
            ? fmt::format("{}, {} of {}", probes.at("solved_inside").get<std::int64_t>(),
                          probes.at("solved_outside").get<std::int64_t>(), probes.at("probes").get<std::int64_t>())
            : "-";
    const auto add = [&](const char* name, const nlohmann::json& of) {
      const auto cell = [&](const char* group, const char* what, const char* statistic) {
        const auto& value = of.at(group).at(what).at(statistic);
        return value.is_null() ? std::string("-") : study::percent(value.get<double>());
      };
      rows.push_back({result.of.title, name, cell("inside", "force", "mean"), cell("inside", "force", "p95"),
                      cell("inside", "force", "max"), cell("inside", "displacement", "mean"),
                      cell("inside", "displacement", "p95"), cell("outside", "force", "mean"),
                      cell("outside", "displacement", "mean"), solved});
    };
    if (!result.facts.networks_errors.is_null()) add("the paper's networks", result.facts.networks_errors);
    if (result.facts.ours_errors.is_null()) continue;
    add(result.measured.ours.c_str(), result.facts.ours_errors);
    add("linear predictor", result.facts.ours_errors.at("linear"));
    add("zero", result.facts.ours_errors.at("zero"));
  }
  return rows.size() < 2 ? ""
                         : section("Whole models compared with new solves",
                                   "<p>Every free node has its networks. Probes are in random directions, half of "
                                   "them outside of the trained range (phynness validate). Errors are those of "
                                   "the probes with an equilibrium. The two trivial predictors are listed for "
                                   "comparison.</p>\n" +
                                       escaped_table(rows));
}

std::string what_ran(const PaperStudy& study) {
  TextTable rows{{"case", "scene", "rays", "increments", "no equilibrium", "solving, CPU min"}};
  for (const auto& result : study.cases) {
    if (!result.missing.empty()) {
      rows.push_back({result.of.title, result.of.scene, "not run: " + result.missing, "", "", ""});
      continue;
    }
    rows.push_back({result.of.title, result.of.scene, std::to_string(result.facts.rays),
                    std::to_string(result.facts.increments), std::to_string(result.facts.failed),
                    fmt::format("{:.1f}", result.facts.solve_cpu_s / 60)});
  }
  return section("Cases",
                 escaped_table(rows) +
                     fmt::format("<p class=\"key\">{}; {}. This run took {:.1f} min; stages that were already finished "
                                 "were kept.</p>\n",
                                 escaped(study.software), escaped(study.machine), study.seconds / 60));
}

json numbers_or_null(const std::vector<double>& values) {
  json out = json::array();
  for (const double v : values) out.push_back(v);
  return out;
}

}  // namespace

nlohmann::ordered_json to_json(const PaperStudy& study, const PaperReport& report) {
  json out{{"study", "paper"},
           {"quick", study.quick},
           {"software", study.software},
           {"machine", study.machine},
           {"seconds", study.seconds}};
  if (study.quick) out["less_than_full"] = quick_words();
  out["summary"] = report.summary;
  out["tables"] = {{"1", report.table1}, {"2", report.table2}};
  for (const auto& figure : report.figures) {
    json panels = json::array();
    for (const auto& panel : figure.panels) {
      json series = json::array();
      for (const auto& s : panel.series)
        series.push_back({{"name", s.name}, {"x", numbers_or_null(s.x)}, {"y", numbers_or_null(s.y)}});
      panels.push_back({{"title", panel.title}, {"x", panel.x}, {"y", panel.y}, {"series", series}});
    }
    out["figures"][figure.number] = {{"title", figure.title}, {"conditions", figure.conditions},
                                     {"paper", figure.paper}, {"found", figure.found},
                                     {"panels", panels},      {"table", figure.table}};
  }
  for (const auto& result : study.cases) {
    json& entry = out["cases"][result.of.id];
    entry["title"] = result.of.title;
    if (!result.missing.empty()) {
      entry["not_run"] = result.missing;
      continue;
    }
    const auto& f = result.facts;
    entry["facts"] = {{"nodes", f.nodes},
                      {"free_nodes", f.free_nodes},
                      {"surface_nodes", f.surface_nodes},
                      {"cells", f.cells},
                      {"rays", f.rays},
                      {"increments", f.increments},
                      {"failed", f.failed},
                      {"setup_s", f.setup_s},
                      {"solve_cpu_s", f.solve_cpu_s},
                      {"networks_train_s", f.networks_train_s},
                      {"ours_train_s", f.ours_train_s},
                      {"database_bytes", f.database_bytes},
                      {"model_bytes", f.model_bytes},
                      {"ours_bytes", f.ours_bytes},
                      {"samples", f.samples},
                      {"networks", f.networks}};
    entry["validate"] = {{"networks", f.networks_errors}, {"ours", f.ours_errors}};
    entry["measured"] = nlohmann::json(result.measured);
    if (result.times) entry["runtime"] = nlohmann::json(*result.times);
  }
  return out;
}

std::string html_page(const PaperStudy& study, const PaperReport& report) {
  std::string body = "<h1>The paper's tables and figures, from our runs</h1>\n";
  if (study.quick)
    body += "<p class=\"warning\"><b>Quick study</b>, a check of all parts whose numbers should not be quoted: " +
            escaped(quick_words()) + ". Without --quick the study has the sizes of the paper.</p>\n";
  body +=
      "<p>D. Deo and S. De, PhyNNeSS (2011), Cases 1 to 4, computed anew. Errors are the paper's (17): the "
      "difference over the largest finite element response of the same node and group. Two predictors that the "
      "paper does not have are shown for comparison: the linear predictor, which uses three unit responses at "
      "rest, and the default family of this software (modal; linear for the linear case). Figures 1 to 5 of the "
      "paper have no measurements.</p>\n";
  if (report.summary.size() > 1) body += section("The paper's numbers and ours", escaped_table(report.summary));
  body += what_ran(study);
  body += section("Table 1: model data", said("Paper:", report.table1_paper) + escaped_table(report.table1) +
                                             said("This run:", report.table1_found));
  body += validations(study);
  for (const auto& figure : report.figures) {
    if (figure.number == "13")
      body += section(
          "Table 2: successive subdivision",
          said("Paper:", report.table2_paper) + escaped_table(report.table2) + said("This run:", report.table2_found));
    body += figure_section(study, figure);
  }
  body += section("Errata of the paper that matter here",
                  "<ul><li>(9) is printed with a minus sign, with which a positive C01 would soften; its II "
                  "is tr(C<sup>2</sup>). We use the "
                  "usual nearly incompressible law.</li><li>(12) sums to m but means the neurons. Algorithm "
                  "1 loops while the displacement is "
                  "at most n times delta.</li><li>(17) divides by the network's largest output; we divide by "
                  "the finite elements'.</li>"
                  "<li>Case 1's E = 20 is in kPa. D1 = 1e-5 per Pa is taken as K = 1/D1 = 100 "
                  "kPa.</li><li>The paper's mesh and shell thickness "
                  "are not published.</li></ul>\n");
  return page("The paper's tables and figures", body);
}

}  // namespace phynness
