// The report as JSON and as a page.
#include <phynness/pages/report.hpp>
#include <phynness/studies/json.hpp>

#include "mesh_picture.hpp"
#include "parts.hpp"

namespace phynness {
namespace {

using json = nlohmann::ordered_json;
using namespace report;

const char* mark(LineStyle style) {
  switch (style) {
    case LineStyle::line:
      return "line";
    case LineStyle::dashes:
      return "dashes";
    case LineStyle::dots:
      return "dotted";
    case LineStyle::points:
      return "points";
    case LineStyle::joined:
      return "joined";
  }
  return "line";
}

json drawn(const Panel& panel) {
  std::vector<Curve> curves;
  for (const auto& series : panel.series) {
    Curve curve{series.name, mark(series.style), series.color, {}};
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (!panel.log_y || series.y[i] > 0) curve.at.emplace_back(series.x[i], series.y[i]);
    curves.push_back(std::move(curve));
  }
  json more{{"log_x", panel.log_x}, {"log_y", panel.log_y}};
  if (panel.high > panel.low) more["range"] = {panel.low, panel.high};
  return chart(panel.title, panel.x, panel.y, curves, more);
}

json text(const std::string& words) { return {{"text", words}}; }
json remark(const std::string& words) { return {{"remark", words}}; }

/// A section that leaves out what is empty. @param what  texts, tables and pictures
json section_of(const std::string& title, const std::vector<json>& what) {
  std::vector<json> blocks;
  for (const auto& block : what)
    if (!block.is_null()) blocks.push_back(block);
  return section(title, blocks);
}
json said(const char* who, const std::string& what) {
  return what.empty() ? json() : json{{"text", fmt::format("{} {}", who, what)}};
}
json words_table(const TextTable& rows) { return rows.size() < 2 ? json() : json{{"table", rows}, {"words", true}}; }

json figure_section(const PaperStudy& study, const PaperFigure& figure) {
  std::vector<json> blocks{said("Paper:", figure.paper)};
  json panels = json::array(), pictures = json::array();
  for (const auto& panel : figure.panels) panels.push_back(drawn(panel));
  if (!panels.empty()) blocks.push_back({{"charts", panels}});
  if (const auto* liver = study::ran(study, "3"); figure.number == "13" && liver != nullptr)
    for (std::size_t l = 0; l < liver->surfaces.size(); ++l)
      pictures.push_back(
          {{"svg", mesh_picture(liver->surfaces[l].points, liver->surfaces[l].triangles)},
           {"caption", fmt::format("Level {}: {} vertices, {} triangles", l, liver->surfaces[l].points.rows(),
                                   liver->surfaces[l].triangles.rows())}});
  if (!pictures.empty()) blocks.push_back({{"pictures", pictures}});
  blocks.push_back(words_table(figure.table));
  blocks.push_back(said("This run:", figure.found));
  if (!figure.conditions.empty()) blocks.push_back(remark("Conditions: " + figure.conditions));
  const bool numbered = figure.number.find_first_not_of("0123456789") == std::string::npos;
  return section_of((numbered ? "Figure " : "") + figure.number + ": " + figure.title, blocks);
}

/// Results of phynness validate for both models of a case.
json validations(const PaperStudy& study) {
  TextTable rows{{"case, error % (17)", "model", "force: mean", "p95", "max", "displacement: mean", "p95",
                  "beyond R: force", "displacement", "solved: inside, beyond"}};
  for (const auto& result : study.cases) {
    if (!result.missing.empty()) continue;
    const auto& probes = result.ours_errors;
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
    if (!result.networks_errors.is_null()) add("the paper's networks", result.networks_errors);
    if (result.ours_errors.is_null()) continue;
    add(result.measured.ours.c_str(), result.ours_errors);
    add("linear predictor", result.ours_errors.at("linear"));
    add("zero", result.ours_errors.at("zero"));
  }
  if (rows.size() < 2) return {};
  return section_of(
      "Whole models compared with new solves",
      {text("Every free node has its networks. Probes are in random directions, half of them outside of the "
            "trained range (phynness validate). Errors are those of the probes with an equilibrium. The two "
            "trivial predictors are listed for comparison."),
       words_table(rows)});
}

json what_ran(const PaperStudy& study) {
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
  return section_of("Cases",
                    {words_table(rows), remark(fmt::format("{}; {}. This run took {:.1f} min; stages that were "
                                                           "already finished were kept.",
                                                           study.software, study.machine, study.seconds / 60))});
}

json numbers_or_null(const std::vector<double>& values) {
  json out = json::array();
  for (const double v : values) out.push_back(v);
  return out;
}

}  // namespace

nlohmann::ordered_json to_json(const PaperStudy& study, const PaperReport& report) {
  json out{{"study", "paper"},
           {"quick", !study.less_than_full.empty()},
           {"software", study.software},
           {"machine", study.machine},
           {"seconds", study.seconds}};
  if (!study.less_than_full.empty()) out["less_than_full"] = study.less_than_full;
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
    entry["facts"] = nlohmann::json(result.facts);
    entry["validate"] = {{"networks", result.networks_errors}, {"ours", result.ours_errors}};
    entry["measured"] = nlohmann::json(result.measured);
    if (result.times) entry["runtime"] = nlohmann::json(*result.times);
  }
  return out;
}

std::string html_page(const PaperStudy& study, const PaperReport& report) {
  json quick;
  if (!study.less_than_full.empty())
    quick = {{"warning", "Quick study, a check of all parts whose numbers should not be quoted: " +
                             study.less_than_full + ". Without --quick the study has the sizes of the paper."}};
  std::vector<json> sections{section_of(
      "",
      {quick, text("D. Deo and S. De, PhyNNeSS (2011), Cases 1 to 4, computed anew. Errors are the paper's (17): the "
                   "difference over the largest finite element response of the same node and group. Two predictors "
                   "that the paper does not have are shown for comparison: the linear predictor, which uses three "
                   "unit responses at rest, and the default family of this software (modal; linear for the linear "
                   "case). Figures 1 to 5 of the paper have no measurements.")})};
  if (report.summary.size() > 1)
    sections.push_back(section_of("The paper's numbers and ours", {words_table(report.summary)}));
  sections.push_back(what_ran(study));
  sections.push_back(section_of("Table 1: model data", {said("Paper:", report.table1_paper), words_table(report.table1),
                                                        said("This run:", report.table1_found)}));
  if (auto whole = validations(study); !whole.is_null()) sections.push_back(std::move(whole));
  for (const auto& figure : report.figures) {
    if (figure.number == "13")
      sections.push_back(section_of(
          "Table 2: successive subdivision",
          {said("Paper:", report.table2_paper), words_table(report.table2), said("This run:", report.table2_found)}));
    sections.push_back(figure_section(study, figure));
  }
  sections.push_back(section_of(
      "Errata of the paper that matter here",
      {text("(9) is printed with a minus sign, with which a positive C01 would soften; its II is tr(C^2). We use the "
            "usual "
            "nearly incompressible law."),
       text("(12) sums to m but means the neurons. Algorithm 1 loops while the displacement is at most n times delta."),
       text("(17) divides by the network's largest output; we divide by the finite elements'."),
       text("Case 1's E = 20 is in kPa. D1 = 1e-5 per Pa is taken as K = 1/D1 = 100 kPa."),
       text("The paper's mesh and shell thickness are not published.")}));
  return page("The paper's tables and figures, from our runs", sections);
}

}  // namespace phynness
