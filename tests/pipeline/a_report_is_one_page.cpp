// Claim: a report is one self-contained page with all of its parts, which a browser reads without an error.
#include <regex>
#include <set>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Report : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    if (shell("command -v gnuplot").exit_status != 0) GTEST_SKIP() << "no gnuplot";
    auto scene = small_scene("P1", 3);
    scene.replace(scene.find("small block"), 11, "<b>small & odd</b>");
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
  // Scene, errors, worst cases, nodes, levels, origin.
  EXPECT_EQ(count("<table"), 6U);
  // Four histograms, a curve for each of some nodes, two views and their scale.
  EXPECT_GE(count("<svg"), 8U);
  EXPECT_EQ(count("<svg"), count("</svg>"));
  EXPECT_EQ(count("<figure>"), count("</figure>"));
  EXPECT_GT(count("<polygon"), 20U);
  // The table's first figure is that of the JSON file.
  const double mean = 100 * json("v.json").at("inside").at("force").at("mean").get<double>();
  char text[32];
  std::snprintf(text, sizeof text, mean < 0.005 ? "%.0e" : "%.2f", mean);
  EXPECT_NE(page.find("<td>force (17), inside</td><td>" + std::string(text)), std::string::npos) << text;
}

TEST_F(Report, IsOnePageWithoutForeignWords) {
  EXPECT_EQ(page.find("<b>small"), std::string::npos) << "a title is text";
  EXPECT_NE(page.find("&lt;b&gt;small &amp; odd"), std::string::npos);
  EXPECT_EQ(count("<script"), 0U);
  EXPECT_FALSE(std::regex_search(page, std::regex("(src|href)=[\"'](?!#)"))) << "nothing from elsewhere";
  EXPECT_FALSE(std::regex_search(page, std::regex("[ >(,-](nan|inf)[ <),]")));
  // Every id once, every reference to one that is there.
  std::set<std::string> ids;
  const std::regex id(" id=[\"']([^\"']*)"), use("xlink:href=[\"']#([^\"']*)");
  for (std::sregex_iterator it(page.begin(), page.end(), id), end; it != end; ++it)
    EXPECT_TRUE(ids.insert((*it)[1]).second) << (*it)[1];
  for (std::sregex_iterator it(page.begin(), page.end(), use), end; it != end; ++it)
    EXPECT_TRUE(ids.count((*it)[1])) << (*it)[1];
}

TEST_F(Report, IsReadByABrowserWithoutAnError) {
  if (shell("command -v chromium").exit_status != 0) GTEST_SKIP() << "no chromium";
  const auto seen = shell(
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --enable-logging=stderr "
      "--dump-dom file://" +
      (folder / "r.html").string() + " 2> log.txt > dom.html");
  ASSERT_EQ(seen.exit_status, 0);
  EXPECT_EQ(read_file(folder / "log.txt").find("CONSOLE"), std::string::npos) << read_file(folder / "log.txt");
  EXPECT_NE(read_file(folder / "dom.html").find("<polygon"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
