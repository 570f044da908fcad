// Tables 1 and 2, Figures 13 and 14, and the summary at the beginning.
#include <array>
#include <cmath>

#include "findings.hpp"

namespace phynness::study {
namespace {

/// The case that fills a column of Table 1.
const CaseResult* column(const PaperStudy& study, bool liver) { return ran(study, liver ? "3" : "4"); }

std::string bytes(double n) {
  return n < 1e6   ? fmt::format("{:.0f} kB", n / 1e3)
         : n < 1e9 ? fmt::format("{:.1f} MB", n / 1e6)
                   : fmt::format("{:.2f} GB", n / 1e9);
}
std::string seconds(double s) {
  if (s < 100) return fmt::format("{:.2g} s", s);
  return s < 5400 ? fmt::format("{:.0f} min", s / 60) : fmt::format("{:.1f} h", s / 3600);
}
std::string microseconds(double us) {
  return us < 1000 ? fmt::format("{:.2f} us", us) : fmt::format("{:.2f} ms", us / 1e3);
}
std::string rate(double us) {
  if (!(us > 0)) return "";
  const double fps = 1e6 / us;
  if (fps < 1e4) return fmt::format("{:.3g} fps", fps);
  return fps < 1e6 ? fmt::format("{:.0f},000 fps", fps / 1e3) : fmt::format("{:.1f} million fps", fps / 1e6);
}

/// The paper's Table 2.
struct PaperLevel {
  int vertices, triangles;
  double seconds;
};
constexpr std::array<PaperLevel, 4> paper_levels{
    {{596, 1188, 0.00936}, {2378, 4752, 0.03748}, {9506, 19008, 0.15}, {38018, 76032, 0.5994}}};

/// Least squares with relative weights, because otherwise the largest values would dominate.
std::pair<double, double> straight_line(const std::vector<double>& x, const std::vector<double>& y) {
  double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double w = 1 / (y[i] * y[i]);
    s += w;
    sx += w * x[i];
    sxx += w * x[i] * x[i];
    sy += w * y[i];
    sxy += w * x[i] * y[i];
  }
  const double slope = (s * sxy - sx * sy) / (s * sxx - sx * sx);
  return {(sy - slope * sx) / s, slope};
}

/// Median over the nodes.
double errors_at(const CaseResult& result, int neurons, double NetworkErrors::*error) {
  std::vector<double> values;
  for (const auto& node : result.measured.nodes)
    for (const auto& row : node.by_neurons)
      if (row.x == neurons) values.push_back(row.*error);
  return values.empty() ? -1 : median(values);
}

std::string words_or_dash(double fraction) { return fraction < 0 ? "-" : percent(fraction) + " %"; }

}  // namespace

TextTable summary(const PaperStudy& study) {
  TextTable table{{"", "paper", "ours", "our default family", "linear predictor"}};
  const auto* liver = column(study, true);
  if (liver != nullptr) {
    const auto& nodes = liver->measured.nodes;
    const auto linear = percent(node_median(nodes, [](const auto&n) { return n.linear.displacement; })) + " %",
               ours = percent(node_median(nodes, [](const auto&n) { return n.ours.displacement; })) + " %";
    for (const int neurons : {100, 200, 300}) {
      const bool text = neurons != 200;
      table.push_back(
          {fmt::format("liver, Case 3: mean error of the displacement, {} neurons (median of nodes)", neurons),
           text ? "between 2 and 3 %" : "",
           words_or_dash(errors_at(*liver, neurons, &NetworkErrors::held_mean)) + "; fresh " +
               words_or_dash(errors_at(*liver, neurons, &NetworkErrors::fresh_mean)),
           ours, linear});
    }
  }
  for (const bool is_liver : {true, false}) {
    const auto* result = column(study, is_liver);
    if (result == nullptr) continue;
    const auto& nodes = result->measured.nodes;
    std::vector<double> ours, linear;
    for (const auto& node : nodes) {
      ours.push_back(node.ours.force_max);
      linear.push_back(node.linear.force_max);
    }
    table.push_back({is_liver ? "liver: neurons for forces within 10 %" : "drain: neurons for forces within 10 %",
                     is_liver ? "87" : "63", needed_words(result->measured, false),
                     "largest error " + percent(median(ours)) + " %, median node", percent(median(linear)) + " %"});
  }
  if (liver != nullptr && !liver->measured.pairs.empty()) {
    Histogram paper, coupled, linear;
    for (const auto& pair : liver->measured.pairs)
      for (const auto& depth : pair.depths) {
        add(paper, depth.paper);
        add(coupled, depth.coupled);
        add(linear, depth.linear);
      }
    table.push_back({"two tools: nodes off by less than 4 %", "the majority", percent(share_below(paper, 0.04)) + " %",
                     percent(share_below(coupled, 0.04)) + " % (coupled)", percent(share_below(linear, 0.04)) + " %"});
  }
  if (liver != nullptr && liver->times) {
    table.push_back({fmt::format("deformation of the free nodes, {} neurons", liver->times->neurons), "6.5 ms",
                     microseconds(liver->times->deformation_us), microseconds(liver->times->ours_deformation_us), ""});
    table.push_back(
        {"force", "1.5 us", microseconds(liver->times->force_us), microseconds(liver->times->ours_force_us), ""});
  }
  return table;
}

TextTable table_1(const PaperStudy& study) {
  TextTable table{{"parameter", "liver, paper", "liver, ours", "Penrose drain, paper", "Penrose drain, ours"}};
  const auto row = [&](const std::string& what, const std::string& liver, const std::string& drain, const auto& of) {
    std::vector<std::string> cells{what};
    for (const bool is_liver : {true, false}) {
      cells.push_back(is_liver ? liver : drain);
      const auto* result = column(study, is_liver);
      cells.push_back(result == nullptr ? "not run" : of(*result));
    }
    table.push_back(cells);
  };
  const auto number = [](auto n) { return fmt::format("{}", n); };
  row("machine", "Pentium 4, 3 GHz, 2 GB, one core", "the same", [&](const CaseResult&) { return study.machine; });
  row("number of nodes", "739", "239", [&](const CaseResult& r) { return number(r.facts.nodes); });
  row("free nodes (touched and reconstructed)", "486", "181",
      [&](const CaseResult& r) { return number(r.facts.free_nodes); });
  row("type of element", "3D tetrahedra", "triangular shell elements", [&](const CaseResult& r) {
    return fmt::format("{} ({})", r.facts.corners == 4 ? "3D tetrahedra" : "triangular shell elements",
                       r.measured.element);
  });
  row("number of elements", "2341", "436", [&](const CaseResult& r) { return number(r.facts.cells); });
  row("precomputation cases (rays)", "12636", "4706", [&](const CaseResult& r) {
    return fmt::format("{}; {} increments, {} of them without equilibrium", r.facts.rays, r.facts.increments,
                       r.facts.failed);
  });
  row("CPU time of the automated script", "15 s", "8 s", [&](const CaseResult& r) {
    return r.facts.setup_s > 0 ? seconds(r.facts.setup_s) : std::string("not recorded");
  });
  row("data points, one network", "75660", "23520",
      [&](const CaseResult& r) { return number(r.measured.data_points); });
  row("neurons", "200", "100",
      [&](const CaseResult& r) { return r.times ? number(r.times->neurons) : std::string("-"); });
  row("training samples", "5000", "5000", [&](const CaseResult& r) { return number(r.facts.samples); });
  row("CPU time to train a network, data extraction included", "280 s", "170 s", [&](const CaseResult& r) {
    return seconds(node_mean(r.measured.nodes, [](const auto& n) { return n.training_cpu_s; })) +
           " (and its force network)";
  });
  row("total pre-computation, data and training", "87 h", "18 h", [&](const CaseResult& r) {
    const double training =
        node_mean(r.measured.nodes, [](const auto& n) { return n.training_cpu_s; }) * r.facts.networks;
    return fmt::format("{} of one core: {} of solving, {} of training", seconds(r.facts.solve_cpu_s + training),
                       seconds(r.facts.solve_cpu_s), seconds(training));
  });
  row("size of the data recorded", "8 GB", "6 GB", [&](const CaseResult& r) { return bytes(r.facts.database_bytes); });
  row("size of the data extracted for training", "501 MB", "170 MB", [&](const CaseResult& r) {
    constexpr double numbers_of_a_pair = 9, size_of_number = 8;
    return bytes(r.facts.networks * static_cast<double>(r.facts.samples) * numbers_of_a_pair * size_of_number) +
           ", never written";
  });
  row("size of the networks", "5.4 MB", "2.02 MB", [&](const CaseResult& r) {
    return fmt::format("{} as text; default family {}", bytes(r.facts.model_bytes), bytes(r.facts.ours_bytes));
  });
  row("deformation of the free nodes", "6.5 ms (154 fps)", "2.9 ms (345 fps)", [&](const CaseResult& r) {
    if (!r.times) return std::string("-");
    return fmt::format("{} ({}); straight loop {}; default family {}", microseconds(r.times->deformation_us),
                       rate(r.times->deformation_us), microseconds(r.times->deformation_plain_us),
                       microseconds(r.times->ours_deformation_us));
  });
  row("force", "1.5 us", "1.5 us", [&](const CaseResult& r) {
    if (!r.times) return std::string("-");
    return fmt::format("{} ({} neurons); default family {}", microseconds(r.times->force_us), r.times->force_neurons,
                       microseconds(r.times->ours_force_us));
  });
  return table;
}

TextTable table_2(const PaperStudy& study) {
  TextTable table{{"level", "vertices, paper", "ours", "triangles, paper", "ours", "time, paper", "ours: networks",
                   "at every vertex (the paper's way)", "default family"}};
  const auto* liver = column(study, true);
  for (std::size_t l = 0; l < paper_levels.size(); ++l) {
    std::vector<std::string> row{std::to_string(l),
                                 std::to_string(paper_levels[l].vertices),
                                 "not run",
                                 std::to_string(paper_levels[l].triangles),
                                 "not run",
                                 fmt::format("{:.5f} s", paper_levels[l].seconds),
                                 "",
                                 "",
                                 ""};
    if (liver != nullptr && liver->times && l < liver->times->levels.size()) {
      const auto& ours = liver->times->levels[l];
      row[2] = std::to_string(ours.vertices);
      row[4] = std::to_string(ours.triangles);
      row[6] = microseconds(ours.network_us);
      row[7] = microseconds(ours.every_vertex_us);
      row[8] = microseconds(ours.ours_us);
    }
    table.push_back(row);
  }
  return table;
}

PaperFigure figure_13(const PaperStudy& study) {
  PaperFigure figure{"13", "The liver's surface, subdivided", "Case 3 was not run.", "", "", {}, {}};
  figure.paper = "Four meshes by Loop's scheme, 596 to 38,018 vertices.";
  if (const auto* liver = column(study, true); liver != nullptr) {
    figure.conditions = "At rest, seen from above.";
    figure.table = {{"level", "vertices", "triangles"}};
    for (std::size_t l = 0; l < liver->surfaces.size(); ++l)
      figure.table.push_back({std::to_string(l), std::to_string(liver->surfaces[l].points.rows()),
                              std::to_string(liver->surfaces[l].triangles.rows())});
  }
  return figure;
}

PaperFigure figure_14(const PaperStudy& study) {
  PaperFigure figure{"14", "Time of a deformation against vertices", "Case 3 was not run.", "", "", {}, {}};
  figure.paper = "The time grows in a straight line with vertices: 9.36, 37.5, 150 and 599 ms, 15.8 us a vertex.";
  const auto* liver = column(study, true);
  if (liver == nullptr || !liver->times) return figure;
  figure.found = slopes(*liver->times);
  figure.conditions = fmt::format("{}; networks of {} neurons; medians on one core of: {}.", conditions(*liver),
                                  liver->times->neurons, study.machine);
  Panel panel{"Time against vertices", "vertices", "time, ms", true, true, {}};
  Series paper{"paper, Pentium 4", LineStyle::points, 2, {}, {}},
      networks{"networks, then Loop's weights", LineStyle::points, 0, {}, {}},
      every{"network at every vertex", LineStyle::points, 5, {}, {}},
      ours{liver->measured.ours + ", then Loop's weights", LineStyle::points, 3, {}, {}};
  for (const auto& level : paper_levels) {
    paper.x.push_back(level.vertices);
    paper.y.push_back(1e3 * level.seconds);
  }
  for (const auto& level : liver->times->levels) {
    for (auto* series : {&networks, &every, &ours}) series->x.push_back(level.vertices);
    networks.y.push_back(1e-3 * level.network_us);
    every.y.push_back(1e-3 * level.every_vertex_us);
    ours.y.push_back(1e-3 * level.ours_us);
  }
  figure.table = {{"", "constant, us", "per vertex, us", "farthest point from the line, %"}};
  for (const auto& series : {paper, every, networks, ours}) {
    panel.series.push_back(series);
    if (series.x.size() < 2) continue;
    const auto [constant, slope] = straight_line(series.x, series.y);
    Series line{"", LineStyle::line, series.color, {}, {}};
    double farthest = 0;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      line.x.push_back(series.x[i]);
      line.y.push_back(constant + slope * series.x[i]);
      farthest = std::max(farthest, std::abs(line.y.back() / series.y[i] - 1));
    }
    panel.series.push_back(line);
    figure.table.push_back({series.name, fmt::format("{:.3g}", 1e3 * constant), fmt::format("{:.3g}", 1e3 * slope),
                            fmt::format("{:.1f}", 100 * farthest)});
  }
  figure.panels.push_back(panel);
  return figure;
}

}  // namespace phynness::study
