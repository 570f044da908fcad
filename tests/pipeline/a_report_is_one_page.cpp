// Claim: a report is one self-contained page with all of its parts, which a browser reads without an error.
#include <regex>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Report : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    auto scene = small_scene("P1", 3);
    scene.replace(scene.find("small block"), 11, "<b>small & odd</b>\\u202E");
    write_file(folder / "scene.toml", scene);
    ASSERT_EQ(phynness("precompute scene.toml -o d.h5").exit_status, 0);
    ASSERT_EQ(phynness("train scene.toml d.h5 -o m --family modal --levels 2").exit_status, 0);
    const auto run = phynness("validate scene.toml m --probes 80 --report r.html --json v.json");
    ASSERT_EQ(run.exit_status, 0) << run.err;
    page = read_file(folder / "r.html");
  }
  std::size_t count(const std::string& what) const {
    std::size_t n = 0;
    for (auto at = page.find(what); at != std::string::npos; at = page.find(what, at + 1)) ++n;
    return n;
  }
  std::string page;
};

TEST_F(Report, HoldsWhatItPromises) {
  // Scene, probes, errors, worst cases, curves, pictures, conservation, times, origin.
  EXPECT_EQ(count("<h2>"), 9U);
  // Verdict, scene, errors, errors to R, worst cases, curves, nodes, levels, origin.
  EXPECT_EQ(count("<table"), 9U);
  // Four histograms, a curve for each of some nodes.
  EXPECT_GE(count("class=\"chart\""), 6U);
  EXPECT_EQ(count("<figure>"), count("</figure>"));
  // Each of the largest errors inside can be shown on the body.
  EXPECT_EQ(count("data-case="), 10U);
  EXPECT_EQ(count("<span class=\"verdict\">"), 8U);
  EXPECT_NE(page.find("better than linear"), std::string::npos);
  // The table's first figure is that of the JSON file.
  const double mean = 100 * json("v.json").at("inside").at("force").at("mean").get<double>();
  char text[32];
  std::snprintf(text, sizeof text, mean < 0.005 ? "%.0e" : "%.2f", mean);
  EXPECT_NE(page.find("<td>force (17), inside</td><td>" + std::string(text)), std::string::npos) << text;
}

TEST_F(Report, IsOnePageWithoutForeignWords) {
  EXPECT_EQ(page.find("<b>small"), std::string::npos) << "a title is text";
  EXPECT_NE(page.find("&lt;b&gt;small &amp; odd&lt;/b&gt;\\xe2\\x80\\xae"), std::string::npos)
      << "a mark of direction is visible";
  const auto own = page.find("<script");
  EXPECT_FALSE(std::regex_search(page.substr(0, own), std::regex("(src|href)=[\"'](?!#)"))) << "nothing from elsewhere";
  EXPECT_FALSE(std::regex_search(page.substr(0, own), std::regex("[ >(,-](nan|inf)[ <),]")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
