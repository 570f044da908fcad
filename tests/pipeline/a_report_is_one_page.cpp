// Claim: a report is one self-contained page without scripts that has all of its parts.
#include <regex>
#include <set>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Report : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    const auto scene = with_training(small_scene("P1", 3), "levels = 2");
    write_file(folder / "scene.toml", changed(scene, "small block", "<b>small & odd</b>\\u202E"));
    make_once({"precompute scene.toml -o d.h5", "train scene.toml d.h5 -o m --family modal",
               "validate scene.toml m --probes 80 --report r.html --json v.json"});
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
  // Verdict, errors, worst cases, curves, pictures, times, scene and probes.
  EXPECT_EQ(count("<section>"), 7U);
  // Verdict, errors, worst cases, scene.
  EXPECT_EQ(count("<table"), 4U);
  EXPECT_EQ(count("<details>"), 1U) << "the wide one";
  // A chart for each of two nodes: the model, the straight line, and the finite elements as dots.
  EXPECT_EQ(count("<svg class=\"chart\""), 2U);
  EXPECT_EQ(count("<g class=\"c0 line\">"), 2U);
  EXPECT_GE(count("<circle cx="), 4U);
  // Two maps, and each of the three largest errors by the finite elements and by the model.
  EXPECT_EQ(count("<svg class=\"body\""), 8U);
  for (const char* number : {"0", "1", "2"})
    for (const auto& part : {"href=\"#case-", "id=\"case-"}) EXPECT_EQ(count(part + std::string(number) + '"'), 1U);
  // The table's first figure is that of the JSON file.
  const double mean = 100 * json("v.json").at("inside").at("force").at("mean").get<double>();
  char text[32];
  std::snprintf(text, sizeof text, mean < 0.005 ? "%.0e" : "%.2f", mean);
  EXPECT_NE(page.find("<td>force, eq. (17), inside</td><td>" + std::string(text)), std::string::npos) << text;
}

TEST_F(Report, PicturesHaveTheirColours) {
  // The top of the block is seen from above: its triangles are coloured, most of them between the ends of the map.
  const std::regex triangle("<path d=\"M[-0-9. ]+L[-0-9. ]+z\" fill=\"(#[0-9a-f]{6})\"");
  std::set<std::string> colours;
  for (std::sregex_iterator at(page.begin(), page.end(), triangle), end; at != end; ++at) colours.insert((*at)[1]);
  EXPECT_GT(colours.size(), 10U);
}

TEST_F(Report, IsOnePageWithoutForeignWords) {
  EXPECT_EQ(count("<h1>&lt;b>small &amp; odd&lt;/b>\\xe2\\x80\\xae"), 1U) << "a title is text";
  EXPECT_EQ(count("<b>") + count("<script"), 0U);
  EXPECT_FALSE(std::regex_search(page, std::regex("(src|href)=[\"'](?!#)|url\\("))) << "nothing from elsewhere";
  EXPECT_FALSE(std::regex_search(page, std::regex("[ >(,\"-](nan|inf)[ <),\"]")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
