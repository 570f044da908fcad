// Claim: tools/study-paper runs every case whose scene exists and writes a page and a JSON file with every table and
// figure. The numbers agree with those of eval and solve. An interrupted study is resumed. Results do not depend on the
// number of ranks, and a folder of another scene is refused. Blocks of some dozen nodes are used instead of the paper's
// bodies.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <regex>
#include <sstream>

#include "pipeline/command_line.hpp"

namespace phynness::test {
namespace {

class Study : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    std::filesystem::create_directories(folder / "scenes");
    const auto scene = small_scene();
    auto linear = changed(changed(scene, "\"neo-hookean\"", "\"linear\""), "directions = 26", "directions = 3");
    write_file(folder / "scenes/liver_case1.toml", changed(linear, "increments = 2", "increments = 1"));
    write_file(folder / "scenes/liver_case3.toml", scene);
    write_file(folder / "scenes/penrose_case4.toml", scene);
    write_file(folder / "sizes.json",
               "{\"nodes\": 2, \"probes_per_node\": 3, \"neurons\": [5, 20, 100, 200, 300], \"histogram_neurons\": "
               "[5, 10, 20], \"spreads\": [0.75, 1.5], \"samples\": [100, 300], \"force_neurons\": [5, 10, 20], "
               "\"curve_neurons\": [5, 10, 20], \"study_neurons\": 20, \"training_pairs\": 400, \"test_pairs\": "
               "200, "
               "\"curve_points\": 4, \"tool_pairs\": 2}");
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  Outcome program(const std::string& arguments) const { return shell("'" PHYNNESS_PAPER_STUDY "' " + arguments); }
  Outcome study(const std::string& more = "") const {
    return program("--scenes scenes --sizes sizes.json -o out " + more);
  }

  /// Field of a deformation CSV: node -> displacement.
  std::map<int, std::array<double, 3>> field(const std::string& file) const {
    std::map<int, std::array<double, 3>> rows;
    std::istringstream in(read_file(folder / file));
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      double node = 0, x = 0;
      std::array<double, 3> u{};
      words >> node >> x >> x >> x >> u[0] >> u[1] >> u[2];
      rows[static_cast<int>(node)] = u;
    }
    return rows;
  }

  void expect_numbers(const nlohmann::json& report) const;
  void expect_curve(const nlohmann::json& report) const;
  void expect_pair(const nlohmann::json& report) const;
  void expect_page() const;
};

/// NaN and infinity become null in JSON, so that null values show them.
void expect_no_null(const nlohmann::json& value, const std::string& where) {
  EXPECT_FALSE(value.is_null()) << where;
  if (value.is_structured())
    for (const auto& [key, entry] : value.items()) expect_no_null(entry, where + "/" + key);
}

void Study::expect_numbers(const nlohmann::json& report) const {
  EXPECT_EQ(report.at("tables").at("1").size(), 18U);
  EXPECT_EQ(report.at("tables").at("2").size(), 5U);
  EXPECT_EQ(report.at("tables").at("2").at(1).at(1), "596");
  for (int column : {2, 4})
    for (std::size_t row = 1; row < 18; ++row) {
      const std::string cell = report.at("tables").at("1").at(row).at(column);
      EXPECT_NE(cell, "not run") << row;
      EXPECT_NE(cell, "-") << row;
    }
  for (const char* number : {"6", "7", "8", "9", "10", "11", "12", "14", "15", "P1 and p1-p1"}) {
    const auto& figure = report.at("figures").at(number);
    EXPECT_FALSE(figure.at("panels").empty()) << number;
    for (const char* words : {"title", "conditions", "paper", "found"})
      EXPECT_GT(figure.at(words).get<std::string>().size(), 10U) << number << ' ' << words;
    for (const auto& panel : figure.at("panels"))
      for (const auto& series : panel.at("series")) {
        EXPECT_GE(series.at("x").size(), 2U) << number << ' ' << series.at("name");
        EXPECT_EQ(series.at("x").size(), series.at("y").size());
      }
    expect_no_null(figure, number);
  }
  EXPECT_EQ(report.at("figures").at("13").at("table").size(), 5U);
  for (const char* id : {"1", "3", "3-p1-p1", "4"}) {
    expect_no_null(report.at("cases").at(id).at("measured"), id);
    EXPECT_EQ(report.at("cases").at(id).at("measured").at("nodes").size(), 2U);
  }
  EXPECT_EQ(report.at("cases").at("2").at("not_run"), "there is no scenes/liver_case2.toml");
  EXPECT_FALSE(report.at("quick"));
}

/// The top of the block is flat, so that its inward normal is -z. The forces of the curve are those of a single solve
/// and of the model, up to the solver's tolerance of 1e-8 of the force and rounding.
void Study::expect_curve(const nlohmann::json& report) const {
  const auto& node = report.at("cases").at("3").at("measured").at("nodes").at(1);
  const auto& curves = node.at("curves");
  const double depth = curves.at("depth_m").at(2);
  EXPECT_NEAR(depth, 0.75 * 0.008 * 4 / 2.8, 1e-12);
  std::ostringstream tool;
  tool.precision(17);
  tool << " --node " << node.at("node") << " --displacement 0,0," << -depth;
  ASSERT_EQ(phynness("solve out/case-3/database.h5" + tool.str() + " --json solve.json").exit_status, 0);
  ASSERT_EQ(phynness("eval out/case-3/ours" + tool.str() + " --json eval.json").exit_status, 0);
  const double solved = -json("solve.json").at("tools").at(0).at("force").at(2).get<double>();
  const double said = -json("eval.json").at("tools").at(0).at("force").at(2).get<double>();
  EXPECT_GT(solved, 0);
  EXPECT_NEAR(curves.at("finite_elements").at(2).get<double>(), solved, 1e-6 * solved);
  EXPECT_NEAR(curves.at("ours").at(2).get<double>(), said, 1e-9 * solved);
  // The error of the linear predictor, computed independently.
  const double linear = depth * node.at("stiffness_N_per_m").get<double>();
  EXPECT_NEAR(curves.at("linear").at(2).get<double>(), linear, 1e-12 * linear);
}

/// A pair of tools by eval with the paper's weights and by a solve with both nodes prescribed. Tolerance 1e-6: the
/// solver's tolerance and a file with nine digits.
void Study::expect_pair(const nlohmann::json& report) const {
  const auto& pair = report.at("cases").at("3").at("measured").at("pairs").at(0);
  ASSERT_EQ(pair.at("depths").size(), 2U);
  std::vector<std::map<int, std::array<double, 3>>> solved, said;
  for (const auto& depth : pair.at("depths")) {
    std::ostringstream tools;
    tools.precision(17);
    for (const auto& [node, direction] : {std::pair{"a", "first"}, std::pair{"b", "second"}}) {
      tools << " --node " << pair.at(node) << " --displacement ";
      for (int k = 0; k < 3; ++k)
        tools << (k ? "," : "") << depth.at("depth_m").get<double>() * pair.at(direction).at(k).get<double>();
    }
    ASSERT_EQ(phynness("solve out/case-3/database.h5" + tools.str() + " --deformation s.csv").exit_status, 0);
    ASSERT_EQ(phynness("eval out/case-3/networks --tools paper" + tools.str() + " --deformation e.csv").exit_status, 0);
    solved.push_back(field("s.csv"));
    said.push_back(field("e.csv"));
  }
  const auto counts = [&](int node) { return node != pair.at("a") && node != pair.at("b"); };
  double largest = 0;
  for (std::size_t i = 0; i < 2; ++i)
    for (const auto& [node, u] : said[i])
      if (counts(node)) {
        const auto& truth = solved[i].at(node);
        largest = std::max(largest, std::hypot(truth[0], truth[1], truth[2]));
      }
  for (std::size_t i = 0; i < 2; ++i) {
    double sum = 0;
    int n = 0;
    for (const auto& [node, u] : said[i])
      if (counts(node)) {
        const auto& truth = solved[i].at(node);
        sum += std::hypot(u[0] - truth[0], u[1] - truth[1], u[2] - truth[2]) / largest;
        ++n;
      }
    ASSERT_GT(n, 10);
    EXPECT_NEAR(pair.at("depths").at(i).at("paper_mean").get<double>(), sum / n, 1e-6 * sum / n);
  }
}

void Study::expect_page() const {
  const auto page = read_file(folder / "out/paper.html");
  const auto count = [&](const std::string& what) {
    std::size_t n = 0;
    for (auto at = page.find(what); at != std::string::npos; at = page.find(what, at + 1)) ++n;
    return n;
  };
  for (const char* part : {"Table 1", "Table 2", "Figure 6:", "Figure 7:", "Figure 8:", "Figure 9:", "Figure 10:",
                           "Figure 11:", "Figure 12:", "Figure 13:", "Figure 14:", "Figure 15:", "P1 and p1-p1",
                           "not run: there is no scenes/liver_case2.toml", "Errata"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("Quick study"), std::string::npos);
  EXPECT_GE(count("\"curves\""), 20U);
  const auto own = page.substr(0, page.find("<script"));
  EXPECT_FALSE(std::regex_search(own, std::regex("(src|href)=[\"'](?!#)"))) << "nothing from elsewhere";
  EXPECT_FALSE(std::regex_search(own, std::regex("[ >(,-](nan|inf)[ <),]")));
  if (shell("command -v chromium").exit_status != 0) {
    std::printf("no chromium: the page was not opened in a browser\n");
    return;
  }
  const auto seen = shell(
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --enable-logging=stderr --virtual-time-budget=5000 "
      "--dump-dom file://" +
      (folder / "out/paper.html").string() + " 2> log.txt > dom.html");
  ASSERT_EQ(seen.exit_status, 0);
  EXPECT_EQ(read_file(folder / "log.txt").find("CONSOLE"), std::string::npos) << read_file(folder / "log.txt");
  EXPECT_NE(read_file(folder / "dom.html").find("<canvas"), std::string::npos);
}

TEST_F(Study, HasEveryTableAndFigureAndGoesOnWhereItWas) {
  const auto first = study("--ranks 1");
  ASSERT_EQ(first.exit_status, 0) << first.err << first.out;
  const auto report = json("out/paper.json");
  expect_numbers(report);
  expect_curve(report);
  expect_pair(report);
  expect_page();

  // After the measurements of two cases were lost, those of the selected case are repeated on two ranks and are the
  // same.
  std::filesystem::remove(folder / "out/case-3/measured.json");
  std::filesystem::remove(folder / "out/case-4/measured.json");
  const auto again = study("--ranks 2 --cases 3");
  ASSERT_EQ(again.exit_status, 0) << again.err << again.out;
  EXPECT_EQ(again.out.find("precompute"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find(": measure"), std::string::npos) << again.out;
  auto before = report.at("cases").at("3").at("measured"),
       after = json("out/paper.json").at("cases").at("3").at("measured");
  // Finished cases remain on the page even if they are not selected.
  EXPECT_EQ(json("out/paper.json").at("cases").at("1").at("measured"), report.at("cases").at("1").at("measured"));
  EXPECT_EQ(json("out/paper.json").at("cases").at("4").at("not_run"), "not asked for (--cases)");
  for (auto* measured : {&before, &after}) {
    measured->erase("seconds");
    for (auto& node : measured->at("nodes")) node.erase("training_cpu_s");
  }
  EXPECT_EQ(before, after);

  write_file(folder / "scenes/liver_case3.toml", changed(small_scene(), "2000.0", "2100.0"));
  const auto other = study("--cases 3");
  EXPECT_EQ(other.exit_status, 2);
  EXPECT_NE(other.err.find("another scene"), std::string::npos) << other.err;
}

TEST_F(Study, NamesWhatItDoesNotKnow) {
  const auto no_case = study("--cases 3,7");
  EXPECT_EQ(no_case.exit_status, 2);
  EXPECT_NE(no_case.err.find("no such case: 7"), std::string::npos) << no_case.err;
  // An empty value, such as an unset variable of a shell, does not select all cases.
  const auto nothing = study("--cases ''");
  EXPECT_EQ(nothing.exit_status, 2);
  EXPECT_NE(nothing.err.find("no case is named"), std::string::npos) << nothing.err;
  const auto nowhere = program("--quick -o /proc/nowhere");
  EXPECT_EQ(nowhere.exit_status, 2);
  EXPECT_NE(nowhere.err.find("can be written"), std::string::npos) << nowhere.err;
  const auto no_folder = program("--scenes nowhere -o out");
  EXPECT_EQ(no_folder.exit_status, 2);
  EXPECT_NE(no_folder.err.find("nowhere"), std::string::npos) << no_folder.err;
}

}  // namespace
}  // namespace phynness::test
