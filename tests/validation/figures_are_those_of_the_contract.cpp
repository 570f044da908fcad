// Claims: formats/validation.md names every key of the figures of a validation, and its tables name no other; the
// report of the same results is one page that holds them. Nothing is solved: the results are made up, one of each kind.
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <phynness/formats/scene.hpp>
#include <phynness/validation/report.hpp>
#include <regex>
#include <set>
#include <sstream>

namespace phynness {
namespace {

const std::string source = PHYNNESS_SOURCE_DIR;

ProbeResult probe(std::int32_t node, Status status) {
  ProbeResult p;
  p.node = node;
  p.displacement_m = {0, 0, -0.01};
  p.status = status;
  p.model = p.linear = {0.1, 0.2, {0.1}};
  p.error_N = 0.1;
  p.largest_N = 1;
  p.bound_N = 0.05;
  return p;
}

NamedOrgan checked_sample() {
  const NamedOrgan sample(source + "/examples/model");
  Model model = sample.model();
  model.finer.is_measured = true;
  model.finer.element = "p1-p1";
  model.finer.reference = "taylor-hood";
  model.finer.nodes = 13;
  return {std::move(model), sample.mesh(), "model"};
}

Validated results() {
  Validated v{read_scene(source + "/examples/model/scene.toml"), checked_sample()};
  const auto node = v.model.model().nodes.front().node;
  const std::vector<ProbeResult> probes{probe(node, Status::converged), probe(node, Status::diverged)};
  v.report.nodes = {node};
  v.report.fixed_distance_m = {0.02};
  for (auto& errors : v.report.errors)
    for (auto* group : {&errors.inside, &errors.outside})
      group->fields.emplace_back("a field", FieldMeasures<ErrorStatistics>{});
  v.report.to_range = errors_to_range(probes, 0.02);
  v.points.points = v.points.finished = 1;
  static_cast<ErrorsByWarning&>(v.points) = v.report.to_range;
  v.points.coupled.force = ErrorStatistics::of({0.5});  // worse than linear
  v.points.linear.force = ErrorStatistics::of({0.1});
  v.pairs.pairs = v.pairs.finished = 2;
  v.motions.places = v.motions.finished = 1;
  v.motions.motions.emplace_back("a motion", MotionErrors{});
  v.points.body.emplace();
  v.rim = v.points;
  return v;
}

/// @param names  of fields and the like, which are no keys
void collect(const Json& json, const std::set<std::string>& names, std::set<std::string>& keys) {
  if (json.is_object())
    for (const auto& [key, value] : json.items()) {
      if (names.count(key) == 0) keys.insert(key);
      collect(value, names, keys);
    }
  if (json.is_array())
    for (const auto& value : json) collect(value, names, keys);
}

std::set<std::string> words(const std::string& text, const char* pattern) {
  std::set<std::string> found;
  const std::regex word(pattern);
  for (std::sregex_iterator at(text.begin(), text.end(), word), end; at != end; ++at) found.insert((*at)[1]);
  return found;
}

TEST(ValidationFigures, HaveTheKeysOfTheContract) {
  std::ifstream file(source + "/formats/validation.md");
  std::stringstream all;
  all << file.rdbuf();
  const std::string text = all.str();
  ASSERT_FALSE(text.empty());
  std::set<std::string> keys;
  auto v = results();
  collect(validation_figures(v), {"a field", "a motion"}, keys);
  v.no_points = failure("not done", "a test", "none");
  collect(validation_figures(v), {"a field", "a motion"}, keys);
  const auto named = words(text, "[`\"]([a-zA-Z0-9_]+)[`\"]");
  for (const auto& key : keys) EXPECT_TRUE(named.count(key)) << key << " is not in formats/validation.md";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("| `", 0) == 0) {
      for (const auto& key : words(line.substr(0, line.find('|', 1)), "`([a-zA-Z0-9_]+)`"))
        EXPECT_TRUE(keys.count(key)) << key << " of formats/validation.md is no key";
    }
}

TEST(ValidationFigures, AreNullWhereNothingIsKnown) {
  const auto v = results();
  const auto json = Json::parse(validation_figures(v).dump());
  EXPECT_TRUE(json.at("inside").at("force").at("mean").is_null());
  EXPECT_EQ(json.at("inside").at("force").at("n"), 0);
  EXPECT_EQ(json.at("all").at("wrong"), 1);
  EXPECT_TRUE(json.at("flagged").at("wrong").is_null());
  EXPECT_EQ(json.at("unreached").at(0).at("reason"), "diverged");
}

}  // namespace
}  // namespace phynness
