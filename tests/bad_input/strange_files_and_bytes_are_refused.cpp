// Claims: a file that is missing, a folder, a pipe, unreadable, too large or with a zero is refused by name for what it
// is; control characters of a file reach no terminal and cut no message short.

#include <phynness/formats/input_file.hpp>
#include <phynness/formats/printable.hpp>

#include "../as_nobody.hpp"
#include "../formats/database_under_test.hpp"

namespace phynness::test {
namespace {

class StrangeFile : public DatabaseTest {
 protected:
  std::string path(const char* name) const { return (folder() / name).string(); }
  std::string refused(const fs::path& file, std::uint64_t most_bytes = 100, bool is_text = true) {
    const auto message = refusal([&] { read_input_file(file, {"the thing", "look elsewhere", most_bytes, is_text}); });
    expect_names(message, {file.c_str(), "the thing"});
    return message;
  }
};

TEST_F(StrangeFile, is_called_what_it_is) {
  expect_names(refused(path("nowhere")), {"does not exist"});
  expect_names(refused(folder()), {"folder"});
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0644), 0);
  expect_names(refused(path("pipe")), {"pipe"});
  expect_names(refused("/dev/null"), {"device"});
  std::ofstream(path("large")) << std::string(101, 'a');
  expect_names(refused(path("large")), {"101"});
  std::ofstream(path("closed")) << "a";
  fs::permissions(path("closed"), fs::perms::none);
  fs::permissions(folder(), fs::perms::owner_all | fs::perms::others_exec);
  const AsNobody as_nobody;
  expect_names(refused(path("closed")), {"ermission"});
}

TEST_F(StrangeFile, with_a_zero_in_its_text_says_where) {
  std::ofstream(path("text")) << std::string("a\nb\0c", 5);
  expect_names(refused(path("text")), {"text:2", "byte 3"});
  EXPECT_EQ(read_input_file(path("text"), {"", "", 100, false}), std::string("a\nb\0c", 5));
}

TEST(ControlCharacters, in_a_message_are_escaped_and_cut_nothing_off) {
  const auto error =
      input_error("what\x1b[31m", std::string("a\0b\x07\r\x7f\xC2\x9B", 8), "remedy of \xC3\xA9\n\tnext");
  const std::string text = error.what();
  EXPECT_EQ(text, "what\\x1b[31m: a\\x00b\\x07\\x0d\\x7f\\xc2\\x9b\n  remedy: remedy of \xC3\xA9\n\tnext");
}

TEST(ControlCharacters, and_long_values_leave_room_for_the_remedy) {
  const std::string text = input_error("what", std::string(1'000'000, 'x'), "the remedy").what();
  EXPECT_LT(text.size(), 10'000u);
  expect_names(text, {"1000000 bytes", "the remedy"});
  EXPECT_EQ(shortened("\xC3\xA9\xC3\xA9", 3), "\xC3\xA9 ... (4 bytes)");
}

TEST(ControlCharacters, and_what_cannot_be_seen_is_escaped) {
  EXPECT_EQ(printable("a\u202Eb\u200B"), "a\\xe2\\x80\\xaeb\\xe2\\x80\\x8b");
}

// Cut characters, a continuation alone, longer forms than needed, a surrogate, and codes beyond the last character.
TEST(ControlCharacters, and_bytes_that_are_no_utf8_are_escaped_alone) {
  for (const std::string bytes : {"\xE2\x80", "\x80", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                                  "\xF8\x88\x80\x80\x80", "\xFF"}) {
    const std::string text = printable("<" + bytes + ">\u00e9");
    EXPECT_EQ(text.size(), 4 * bytes.size() + 4) << text;
    EXPECT_EQ(text.substr(0, 3), "<\\x");
  }
}

}  // namespace
}  // namespace phynness::test
