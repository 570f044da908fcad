// Claim: a scene with keys, headers or brackets that are nested too deeply is refused with its line and a remedy at any
// depth. The deepest scene that is not refused for it does not overflow the stack.
#include "scene_under_test.hpp"

namespace phynness::test {
namespace {

std::string repeated(const std::string& part, std::size_t n) {
  std::string text;
  for (std::size_t i = 0; i < n; ++i) text += part;
  return text;
}

struct Deep {
  const char* name;
  std::string before, part, behind;  ///< the part is repeated
};

void PrintTo(const Deep& deep, std::ostream* stream) { *stream << deep.name; }

class DeepScene : public testing::TestWithParam<Deep> {
 protected:
  static std::string text(std::size_t n) {
    const Deep& deep = GetParam();
    return good_scene + deep.before + repeated(deep.part, n) + deep.behind + "\n";
  }
};

TEST_P(DeepScene, IsRefusedWithItsLine) {
  // 20,000 levels of tables end a program that unwinds them by calls.
  for (const std::size_t n : {std::size_t{150}, std::size_t{20000}, std::size_t{200000}}) {
    const std::string message = refusal(text(n));
    const std::string line = std::to_string(line_of(text(n), GetParam().part + GetParam().part));
    EXPECT_EQ(message.find("body.toml:" + line + ": "), 0u) << message;
    expect_error(message, {"nested too deeply"});
  }
}

const Deep deep_scenes[] = {
    {"Key", "[x]\n", "a.", "a = 1"},         {"Header", "[", "a.", "a]"},  {"InlineTable", "x = { ", "a.", "a = 1 }"},
    {"InlineTables", "x = ", "{ a = ", "1"}, {"Arrays", "x = ", "[", "1"},
};
INSTANTIATE_TEST_SUITE_P(Kinds, DeepScene, testing::ValuesIn(deep_scenes),
                         [](const auto& info) { return std::string(info.param.name); });

// 128 dots in each line, 64 arrays and inline tables within each other, and in each of these tables a key of two parts
// for each dot, because the point of a number does not count.
TEST(DeepScenes, OfTheMostLevelsAreReadOn) {
  const std::string key = repeated("0.0 . ", 128) + "0";
  const std::string message =
      refusal("[" + key + "]\nb = " + repeated("[\n{ " + key + " = ", 31) + "1" + repeated(" }\n]", 31) + "\n");
  expect_error(message, {"unknown key"});
}

// Brackets in strings and comments do not count, and a line may have 128 dots in them.
TEST(DeepScenes, AreNotMadeByStringsAndComments) {
  const std::string dots = repeated("[[{.", 60), title = "title = \"test\"";
  for (const std::string& given :
       {"title = \"" + dots + "\"", "title = '" + dots + "'", "title = \"\"\"\n" + dots + "\n\"" + dots + "\"\"\"",
        "title = '''\n" + dots + "\n''" + dots + "'''''", "title = \"\\\"" + dots + "\\\\\" # \"" + dots,
        "title = '\\' # '" + dots, "title = \"\"\"\\\"\"\"" + dots + "\\\\\"\"\"\"\" # " + dots}) {
    const std::string text = with(good_scene, title, "# " + dots + "\"\"\"\n" + given);
    EXPECT_NO_THROW(parsed(text)) << given.substr(0, 40);
  }
}

// A long line of short keys and of numbers is flat.
TEST(DeepScenes, AreNotMadeByNumbers) {
  const std::string fixed = "fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } }";
  EXPECT_NO_THROW(parsed(with(good_scene, fixed, "fixed = { nodes = [" + repeated("1,\n", 20000) + "2] }")));
  const std::string points = repeated("{ nearest = { point_m = [0.25, -0.5, +1.5e-3] } }, ", 500);
  EXPECT_NO_THROW(parsed(with(good_scene, "active = \"free-surface\"", "active = [" + points + "]")));
}

}  // namespace
}  // namespace phynness::test
