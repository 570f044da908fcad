// Claims: an output that is an input or another output, whatever the spelling, or that cannot be written where it is to
// be, is refused before the work, with both options and paths; an output that fails costs no other output.
#include "../../cli/command_files.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <phynness/formats/error.hpp>

#include "../as_nobody.hpp"
#include "../messages.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;
using cli::PathKind;

/// A fresh folder; claims are those of one process, so that each test has names of its own.
class Files : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / (std::string("phynness-files-") + info->name() + std::to_string(getpid()));
    fs::create_directories(folder / "model");
    for (const char* name : {"d.h5", "model/model.txt"}) std::ofstream(folder / name) << "text";
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path folder;
};

TEST_F(Files, of_outputs_are_no_inputs) {
  cli::declare_input("DATABASE", folder / "d.h5");
  cli::declare_input("MODEL_DIR", folder / "model");
  fs::create_symlink("d.h5", folder / "link");
  fs::create_directory_symlink(".", folder / "around");
  for (const char* same : {"d.h5", "./model/../d.h5", "link", "around/d.h5"})
    expect_names(message_of([&] { cli::declare_output("--json", folder / same); }),
                 {"would overwrite an input", "--json", same, "DATABASE"});
  message_of([&] { cli::declare_output("--json", folder / "model/model.txt"); });
  message_of([&] { cli::declare_output("--output", folder / "d.h5", PathKind::database); });
  cli::declare_output("--json", folder / "d.json");
}

TEST_F(Files, of_outputs_are_not_those_of_another_output) {
  cli::declare_output("--output", folder / "new", PathKind::model);
  for (const char* same : {"new", "new/model.txt", "model/../new/mesh.txt"})
    expect_names(message_of([&] { cli::declare_output("--json", folder / same); }), {"another output", "--output"});
  cli::declare_output("--report", "/dev/null");
  cli::declare_output("--surface", "/dev/null");
}

TEST_F(Files, that_cannot_be_written_are_refused) {
  const auto place = [&](const char* path, PathKind kind = PathKind::file) {
    return message_of([&] { cli::check_place("--json", folder / path, kind); });
  };
  expect_names(place("nowhere/x.json"), {"--json", "nowhere", "make the folder"});
  expect_names(place("model"), {"this is a folder"});
  expect_names(place("d.h5/x.json"), {"d.h5 is a file"});
  expect_names(place("d.h5/m", PathKind::model), {"d.h5 is a file"});
  expect_names(place("model", PathKind::model), {"has not written", "model.txt"});
  cli::check_place("--output", folder / "new/model", PathKind::model);
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  const AsNobody as_nobody;
  expect_names(place("x.json"), {"not writable"});
}

TEST_F(Files, that_fail_cost_no_others) {
  int written = 0;
  EXPECT_THROW(cli::write_each({[] { throw failure("a", "", ""); }, [&] { ++written; }}), Error);
  EXPECT_EQ(written, 1);
}

}  // namespace
}  // namespace phynness::test
