// The tables and figures of the study with the numbers of the paper: as data, as JSON, and as a page.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/studies/measurements.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

namespace phynness {

/// A case of lab/paper/study.py.
struct PaperCase {
  std::string id, title, scene;
  bool linear = false;  ///< three unit responses instead of networks
  bool liver = true;    ///< column of Table 1
};

/// Results of the stages of a case.
struct CaseFacts {
  std::int64_t nodes = 0, free_nodes = 0, surface_nodes = 0, cells = 0, corners = 0;
  std::int64_t rays = 0, increments = 0, failed = 0;
  double setup_s = 0, solve_cpu_s = 0;            ///< CPU time of the finite elements on one core
  double networks_train_s = 0, ours_train_s = 0;  ///< wall time of all nodes, all threads
  double database_bytes = 0, model_bytes = 0, ours_bytes = 0;
  int samples = 0, networks = 0;
};

struct SurfaceShape {
  Points points;
  Triangles triangles;
};

struct CaseResult {
  PaperCase of;
  std::string missing;  ///< reason why it was not run; empty if it was run
  CaseFacts facts;
  nlohmann::json networks_errors, ours_errors;  ///< of phynness validate; null if there is no such model
  CaseMeasurements measured;
  std::optional<RuntimeTimes> times;
  std::vector<SurfaceShape> surfaces;  ///< by level of subdivision
};

struct PaperStudy {
  std::string less_than_full;  ///< what a quick study reduces; empty: nothing
  std::string software, machine;
  double seconds = 0;  ///< of this run
  std::vector<CaseResult> cases;
};

enum class LineStyle { line, dashes, dots, points, joined };
struct Series {
  std::string name;
  LineStyle style = LineStyle::line;
  int color = 0;
  std::vector<double> x, y;
};
struct Panel {
  std::string title, x, y;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  double low = 0, high = 0;  ///< of the vertical axis; equal: chosen from the series
};
/// Rows of texts; the first row is the head.
using TextTable = std::vector<std::vector<std::string>>;
struct PaperFigure {
  std::string number, title;
  std::string conditions, paper, found;  ///< conditions of the run, statement of the paper, measurements of this run
  std::vector<Panel> panels;
  TextTable table;
};
struct PaperReport {
  TextTable summary, table1, table2;
  std::string table1_paper, table1_found, table2_paper, table2_found;  ///< as in PaperFigure
  std::vector<PaperFigure> figures;  ///< in the paper's order; the last is force with and without locking
};

/// Every table and figure for which a case was run.
PaperReport paper_report(const PaperStudy& study);
nlohmann::ordered_json to_json(const PaperStudy& study, const PaperReport& report);
/// Self-contained HTML.
std::string html_page(const PaperStudy& study, const PaperReport& report);

}  // namespace phynness
