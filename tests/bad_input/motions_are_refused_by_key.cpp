// Claims: a good motion is read as it is written; every defect of one is refused with the file, the key, the step and
// tool, and a remedy. No text ends the program: lists without end are refused where they become too deep.
#include <phynness/formats/error.hpp>
#include <phynness/formats/motion.hpp>

#include "../messages.hpp"

namespace phynness::test {
namespace {

const char* const good =
    R"({"format":"phynness motion 1","mesh_hash":"ab","other":[1],"tools":[{"node":5},{"nodes":[1,2,3],"weights":[0.25,0.5,0.25]}],)"
    R"("time_s":[0,0.5],"displacement_m":[[[0,0,-1e-3],null],[[1,2,3],[4,5,6]]],"force_N":[[[1,0,0],null],[null,[0,0,7]]]})";

std::string with(std::string from, const std::string& to) {
  std::string text = good;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& text) {
  try {
    read_motion_text(text, "m.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  ADD_FAILURE() << "not refused: " << text.substr(0, 300);
  return "";
}

void expect_refused(const std::string& text, const std::vector<std::string>& parts) {
  SCOPED_TRACE(text.substr(0, 300));
  const auto message = refusal(text);
  expect_error(message, {"m.json"});
  expect_names(message, parts);
}

TEST(Motion, is_read_as_written) {
  const auto motion = read_motion_text(good, "m.json");
  EXPECT_EQ(motion.mesh_hash, "ab");
  ASSERT_EQ(motion.tools.size(), 2u);
  EXPECT_EQ(motion.tools[0].nodes, (std::array<std::int32_t, 3>{5, -1, -1}));
  EXPECT_EQ(motion.tools[0].weights, (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ(motion.tools[1].nodes, (std::array<std::int32_t, 3>{1, 2, 3}));
  EXPECT_EQ(motion.tools[1].weights, (std::array<double, 3>{0.25, 0.5, 0.25}));
  EXPECT_EQ(motion.time_s, (std::vector<double>{0, 0.5}));
  EXPECT_EQ(motion.displacement_m[0][0], (Motion::Vector{0, 0, -1e-3}));
  EXPECT_FALSE(motion.displacement_m[0][1]);
  EXPECT_EQ(motion.displacement_m[1][1], (Motion::Vector{4, 5, 6}));
  EXPECT_EQ(motion.force_N[1][1], (Motion::Vector{0, 0, 7}));
  EXPECT_FALSE(motion.force_N[1][0]);
}

TEST(Motion, with_a_wrong_value_is_refused_by_its_key) {
  expect_refused(with("motion 1", "motion 2"), {"format", "phynness motion 2"});
  expect_refused(with("\"format\"", "\"Format\""), {"a key is missing", "format"});
  expect_refused(with("\"time_s\"", "\"time\""), {"a key is missing", "time_s"});
  expect_refused(with("\"node\":5", "\"nod\":5"), {"a key is missing", "tools[0].node"});
  for (const char* node : {"-1", "1.5", "\"5\"", "null", "2147483648", "99999999999999999999"})
    expect_refused(with("\"node\":5", std::string("\"node\":") + node), {"tools[0].node", "number of a node"});
  expect_refused(with("[1,2,3]", "[1,2,2]"), {"tools[1].nodes", "different"});
  expect_refused(with("[1,2,3]", "[1,2]"), {"tools[1].weights", "2 entries, not 3"});
  expect_refused(with("[0.25,0.5,0.25]", "[0.5,0.75,-0.25]"), {"tools[1].weights[2]", "negative"});
  expect_refused(with("[0.25,0.5,0.25]", "[0.25,0.5,0.2]"), {"tools[1].weights", "sum 1"});
  expect_refused(with("{\"nodes\"", "{\"node\":5,\"nodes\""), {"tools[1].node", "together with nodes", "either"});
  // Differences of such numbers would be infinite.
  expect_refused(with("[0,0,7]", "[0,0,1e308]"), {"force_N[1][1][2]", "1e300", "1e+308"});
  expect_refused(with("[0,0.5]", "[-1e308,0.5]"), {"time_s[0]", "1e300"});
  expect_refused(with("[0,0.5]", "[]"), {"time_s", "entries, not 0"});
  expect_refused(with("[0,0.5]", "[0.6,0.5]"), {"time_s[1]", "earlier"});
  expect_refused(with("[0,0.5]", "[0,0.5,1]"), {"displacement_m", "3 entries, not 2"});
  expect_refused(with("[4,5,6]", "[4,5]"), {"displacement_m[1][1]", "3 entries, not 2"});
  expect_refused(with("[4,5,6]", "[4,\"5\",6]"), {"displacement_m[1][1][1]", "number", "\"5\""});
  expect_refused(with("[4,5,6]", "[4,1e7,6]"), {"displacement_m[1][1]", "1e6 m"});
  expect_refused(with(",null]", "]"), {"displacement_m[0]", "2 entries, not 1"});
  expect_refused(with("[null,[0,0,7]]", "7"), {"force_N[1]", "list"});
}

TEST(Motion, of_strange_bytes_is_refused) {
  for (const char* text : {"", "null", "7", "[]", "\"phynness motion 1\"", "{", "{}", "\xff\xfe", "phynness 1"})
    expect_refused(text, {});
  expect_refused(with("0.5]", "0.5"), {"m.json:1", "not valid JSON", "byte"});
  expect_refused(with("[4,5,6]", "[4,1e999,6]"), {"too large"});
  expect_refused(with("[4,5,6]", "[4,NaN,6]"), {"not valid JSON"});
  std::string deep;
  deep.resize(10'000'000, '[');
  expect_refused(deep, {"nested"});
  std::string tools = "{\"node\":1}";
  for (int i = 0; i < 8; ++i) tools += ",{\"node\":1}";
  expect_refused(with("{\"node\":5}", tools), {"tools", "1 to 8 entries, not 10"});
  // No prefix of a motion is one.
  const std::string text = good;
  for (std::size_t n = 0; n < text.size(); ++n) EXPECT_NE(refusal(text.substr(0, n)), "") << n;
}

TEST(Motion, messages_hold_no_control_characters) {
  const auto message = refusal(with("\"ab\"", "[\"\\u001b[2J\"]"));
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
