// Claim: a report is one self-contained page whose data have all of its parts. That a browser draws them without an
// error is the claim of web/browser_tests/report.test.ts.
#include <regex>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Report : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    auto scene = with_training(small_scene("P1", 3), "levels = 2");
    scene.replace(scene.find("small block"), 11, "<b>small & odd</b>\\u202E");
    write_file(folder / "scene.toml", scene);
    succeed("precompute scene.toml -o d.h5");
    succeed("train scene.toml d.h5 -o m --family modal");
    succeed("validate scene.toml m --probes 80 --report r.html --json v.json");
    page = read_file(folder / "r.html");
    const std::string start = R"(id="phynness-data">)";
    const auto at = page.find(start) + start.size();
    data = page.substr(at, page.find("</script>", at) - at);
    const auto parsed = nlohmann::json::parse(data);
    for (const auto& section : parsed.at("sections"))
      for (const auto& block : section.at("blocks")) blocks.push_back(block);
  }
  std::size_t count(const std::string& what) const {
    std::size_t n = 0;
    for (auto at = data.find(what); at != std::string::npos; at = data.find(what, at + 1)) ++n;
    return n;
  }
  std::size_t blocks_with(const char* key) const {
    return static_cast<std::size_t>(
        std::count_if(blocks.begin(), blocks.end(), [&](const auto& block) { return block.contains(key); }));
  }
  std::string page, data;
  std::vector<nlohmann::json> blocks;
};

TEST_F(Report, HoldsWhatItPromises) {
  // Verdict, errors, worst cases, curves, pictures, times, scene and probes.
  EXPECT_EQ(count("\"blocks\":"), 7U);
  // Verdict, errors, worst cases, scene.
  EXPECT_EQ(blocks_with("table"), 4U);
  EXPECT_EQ(blocks_with("folded"), 1U) << "the wide one";
  EXPECT_EQ(blocks_with("body"), 1U);
  // A chart for each of two nodes.
  EXPECT_EQ(count("\"curves\":"), 2U);
  // Each of the largest errors inside can be shown on the body.
  EXPECT_EQ(count("\"case\":"), 10U);
  // The table's first figure is that of the JSON file.
  const double mean = 100 * json("v.json").at("inside").at("force").at("mean").get<double>();
  char text[32];
  std::snprintf(text, sizeof text, mean < 0.005 ? "%.0e" : "%.2f", mean);
  EXPECT_NE(data.find("[\"force, eq. (17), inside\",\"" + std::string(text)), std::string::npos) << text;
}

TEST_F(Report, IsOnePageWithoutForeignWords) {
  EXPECT_EQ(data.find('<'), std::string::npos) << "a title is text";
  EXPECT_NE(data.find("\\u003cb>small & odd\\u003c/b>"), std::string::npos);
  const auto own = page.find("<script");
  EXPECT_FALSE(std::regex_search(page.substr(0, own), std::regex("(src|href)=[\"'](?!#)"))) << "nothing from elsewhere";
  EXPECT_FALSE(std::regex_search(data, std::regex("[ >(,-](nan|inf)[ <),]")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
