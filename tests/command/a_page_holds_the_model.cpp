// Claims: the page of `phynness view` contains the text of the model, every converged increment of the database and the
// errors of the nodes, whatever the texts in them are. It refers to nothing
// outside. With --body it contains the body. Files of other models are refused with their reason, and a refused page is
// not written. Without pages in the build the command says how to get them.
#include <regex>

#include "../block_body.hpp"
#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

using Json = nlohmann::json;

class Page : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    const auto text = with_training(small_scene(), "levels = 2");
    const std::string title = R"(</script><script>alert(\"x\")</script> <!-- 'q' \u202E \u2028 ä)";
    write_file(folder / "scene.toml", changed(text, "small block", title));
    make_once({"precompute scene.toml -o d.h5", "train scene.toml d.h5 --family modal -o model"});
    node = active_of("d.h5").at(0);
  }
  /// Errors with the hashes of the model, by which `view` knows whose they are, of its finer level.
  void write_errors(const Json& by_node, const char* changed = "", int level = 1) const {
    phynness("info model --json info.json");
    Json all{{"by_node", by_node}, {"conditions", {{"level", level}, {"nodes", json("info.json").at("active")}}}};
    for (const char* key : {"model_hash", "mesh_hash"})
      all[key] = std::string(changed) == key ? Json("0123456789abcdef") : json("info.json").at(key);
    write_file(folder / "e.json", all.dump());
  }
  void expect_refused(const std::string& options, const std::vector<std::string>& parts) const {
    const auto refused = be_refused("view model " + options + " -o none.html");
    EXPECT_FALSE(std::filesystem::exists(folder / "none.html"));
    expect_error(refused.err, parts);
  }
  int node = -1;
};

#if PHYNNESS_HAS_PAGES

TEST_F(Page, HoldsModelIncrementsAndErrors) {
  write_errors({{"nodes", {node}}, {"force_error", {0.25}}, {"displacement_error", {0.5}}});
  succeed("view model --database d.h5 --errors e.json -o organ.html");
  const auto data = page_data("organ.html");
  EXPECT_EQ(data.at("format"), "phynness view 1");
  EXPECT_EQ(data.at("model").get<std::string>(), read_file(folder / "model/model.txt"));
  EXPECT_EQ(data.at("validation").at("force_error"), Json({0.25}));
  const auto& rays = data.at("rays");
  EXPECT_EQ(rays.size(), 2u * 26u);
  for (const auto& ray : rays) {
    EXPECT_EQ(ray.at("depth_m"), Json({0.004, 0.008}));
    EXPECT_EQ(ray.at("force_N").size(), 2u);
  }
  // The stored force of one ray, from the command that reads the database itself.
  const auto& ray = rays.at(0);
  succeed("solve d.h5 --node " + ray.at("node").dump() + " --displacement " +
          std::to_string(0.008 * ray.at("direction")[0].get<double>()) + "," +
          std::to_string(0.008 * ray.at("direction")[1].get<double>()) + "," +
          std::to_string(0.008 * ray.at("direction")[2].get<double>()) + " --json s.json");
  const auto answer = json("s.json");
  const auto& force = answer.at("tools").at(0).at("force");
  for (std::size_t k = 0; k < 3; ++k)  // the displacement above has 1e-6 m of rounding in 8 mm, the page 6 digits
    EXPECT_NEAR(ray.at("force_N")[1][k].get<double>(), force[k].get<double>(),
                1e-3 * std::abs(force[2].get<double>()) + 1e-6);
}

TEST_F(Page, RefersToNothingOutside) {
  succeed("view model -o organ.html");
  const auto page = read_file(folder / "organ.html");
  const std::regex outside(R"re(<(script|link|img|iframe)[^>]*(src|href)=|@import|url\((?!data:))re");
  std::smatch found;
  const auto head = page.substr(0, page.find("<script"));
  EXPECT_FALSE(std::regex_search(head, found, outside)) << found.str();
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_LT(page.size(), 450000 + std::filesystem::file_size(folder / "model/model.txt") * 2 / 3)
      << "the page takes at most 0.45 MB beside the model; hexadecimal digits are compressed to about a half";
}

TEST_F(Page, HoldsABodyOfTheModel) {
  Block block;
  block.body.mesh_hash = mesh_hash(block.mesh);
  write_model_dir(folder / "block", springs_on(block), block.mesh);
  const auto body = write_body_text(block.body);
  write_file(folder / "body.txt", body);
  succeed("view block --body body.txt -o organ.html");
  EXPECT_EQ(page_data("organ.html").at("body").get<std::string>(), body);
  expect_refused("--body body.txt", {"another mesh", "body.txt", "phynness reduce"});
  write_file(folder / "body.txt", body.substr(0, body.size() / 2));
  expect_refused("--body body.txt", {"body.txt", "truncated"});
  expect_refused("--body none.txt", {"none.txt"});
}

TEST_F(Page, FilesOfOtherModelsAreRefused) {
  write_file(folder / "other.toml", changed(small_scene(), "0.025", "0.030"));
  succeed("precompute other.toml -o other.h5");
  expect_refused("--database other.h5", {"another mesh", "other.h5"});
  for (const auto& [by_node, part] :
       std::vector<std::pair<Json, std::string>>{{Json(3), "by_node"},
                                                 {{{"nodes", {node}}, {"force_error", {0.1}}}, "displacement_error"},
                                                 {{{"nodes", {"x"}}, {"force_error", {0.1}}}, "e.json"}}) {
    write_errors(by_node);
    expect_refused("--errors e.json", {"e.json", part});
  }
  const Json good{{"nodes", {node}}, {"force_error", {0.1}}, {"displacement_error", {0.1}}};
  for (const char* key : {"model_hash", "mesh_hash"}) {
    write_errors(good, key);
    expect_refused("--errors e.json", {key, "0123456789abcdef", "validate"});
  }
  write_file(folder / "e.json", Json{{"by_node", good}}.dump());
  expect_refused("--errors e.json", {"hash = none", "validate"});
  write_errors(good, "", 0);
  expect_refused("--errors e.json", {"level 0", "validate"});
  for (const char* text : {"", "no JSON", "[1, 2]", "{\"by_node\": ", "\xFF\xFE"}) {
    write_file(folder / "e.json", text);
    expect_refused("--errors e.json", {"e.json"});
  }
  expect_refused("--errors none.json", {"none.json"});
}

#else

TEST_F(Page, IsMissingWithARemedy) { expect_refused("", {"this build has no page", "Node"}); }

#endif

}  // namespace
}  // namespace phynness::test
