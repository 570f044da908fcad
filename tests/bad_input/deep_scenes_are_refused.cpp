// Claim: a scene with keys, headers or brackets that are nested too deeply is refused with its line and a remedy at any
// depth. Dots and brackets in strings and comments do not count.
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
  for (const std::size_t n : {std::size_t{80}, std::size_t{20000}, std::size_t{200000}}) {
    const std::string message = refusal(text(n));
    const std::string line = std::to_string(line_of(text(n), GetParam().part + GetParam().part));
    EXPECT_EQ(message.find("body.toml:" + line + ": "), 0u) << message;
    expect_error(message, {"nested too deeply"});
  }
}

// What is not too deep is read, and refused for what it is: a key that scenes do not have, or no TOML.
TEST_P(DeepScene, OfFewerLevelsIsReadOn) {
  const std::string message = refusal(text(20));
  EXPECT_EQ(message.find("too deeply"), std::string::npos) << message;
}

const Deep deep_scenes[] = {
    {"Key", "[x]\n", "a.", "a = 1"},
    {"KeyWithSpaces", "[x]\n", "a\t. ", "a = 1"},
    {"QuotedKey", "[x]\n", "\"a.#'\\\"\".", "a = 1"},
    {"LiteralKey", "[x]\n", "'a\\'.", "a = 1"},
    {"Header", "[", "a.", "a]"},
    {"HeaderAfterStrings", "[x]\nb = \"\"\"x\"\"\"\"\"\nc = '''\"\"\"''''\nd = \"\\\\\"\n[", "a.", "a]"},
    {"HeaderOfArray", "[[", "a.", "a]]"},
    {"QuotedHeader", "['", "a'.'", "a']"},
    {"InlineTable", "x = { ", "a.", "a = 1 }"},
    {"InlineTableAfterString", "x = { b = \"\"\"x\"\"\"\", ", "a.", "a = 1 }"},
    {"InlineTables", "x = ", "{ a = ", "1"},
    {"InlineTablesOfKeys", "x = ", "{ a.b.c = ", "1"},
    {"Arrays", "x = ", "[", "1"},
    {"ArraysOverLines", "x = [ # [\n[ # ]]\n", "[", "1"},
    {"TablesInArrays", "x = ", "[{ a = ", "1"},
    {"KeyAfterComment", "# \"\"\" '''\n[x]\n", "a.", "a = 1"},
    {"KeyAfterWindowsLine", "[x] # \"\r\nb = 'c'\r\n", "a.", "a = 1"},
};
INSTANTIATE_TEST_SUITE_P(Kinds, DeepScene, testing::ValuesIn(deep_scenes),
                         [](const auto& info) { return std::string(info.param.name); });

// Levels add up over a header, the key below it and the tables inside of that.
TEST(DeepScenes, AddUp) {
  const std::string half = repeated("a.", 30) + "a";
  const std::string message = refusal("[" + half + "]\nb = 1\n" + half + " = { " + half + " = 1 }\n");
  EXPECT_EQ(message.find("body.toml:3: "), 0u) << message;
  expect_error(message, {"nested too deeply"});
  EXPECT_EQ(refusal("[" + half + "]\nb = 1\n[" + half + "b]\nc = 1\n").find("nested"), std::string::npos);
}

// A text is read once, however many strings it opens: four million quotes take no longer than as many
// letters.
TEST(DeepScenes, AreFoundInOnePass) {
  for (const char* quote : {"\"", "'", "\"\"\"\n", "[", "a.b\n"}) refusal(good_scene + repeated(quote, 4000000));
}

// Strings and comments are text: a title of dots, a comment of brackets, quotes of the other kind.
TEST(DeepScenes, AreNotMadeByStringsAndComments) {
  const std::string dots = repeated("[{.", 5000), title = "title = \"test\"";
  for (const std::string& given :
       {"title = \"" + dots + "\"", "title = '" + dots + "'", "title = \"\"\"\n" + dots + "\n\"" + dots + "\"\"\"",
        "title = '''\n" + dots + "\n''" + dots + "'''''", "title = \"\\\"" + dots + "\\\\\" # \"" + dots,
        "title = '\\' # '" + dots, "title = \"\"\"\\\"\"\"" + dots + "\\\\\"\"\"\"\" # " + dots}) {
    const std::string text = with(good_scene, title, "# " + dots + "\"\"\"\n" + given);
    EXPECT_NO_THROW(parsed(text)) << given.substr(0, 40);
  }
  // A file with many short keys and numbers in arrays is flat.
  const std::string nodes = "fixed = { nodes = [" + repeated("1,\n", 20000) + "2] }";
  EXPECT_NO_THROW(
      parsed(with(good_scene, "fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } }", nodes)));
}

}  // namespace
}  // namespace phynness::test
