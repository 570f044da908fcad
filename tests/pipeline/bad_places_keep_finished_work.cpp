// Claims: on a full disk, with a limit of file size, in a read-only folder or together with a second process,
// precompute ends with a reason and a remedy and keeps every finished ray. After the cause is removed, it continues to
// the same database.
#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class BadPlace : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene("P1", 6));
    succeed("precompute scene.toml -o whole.h5");
  }
  /// Runs a script as root of a mount namespace of its own, or skips where that is not allowed.
  bool may_mount() const { return shell("unshare -rm sh -c 'mount -t tmpfs tmpfs /mnt'").exit_status == 0; }
  std::string text(const char* name) const { return read_file(folder / name); }
};

TEST_F(BadPlace, LimitOfFileSize) {
  // 120 blocks of 512 bytes: the header fits, a fraction of the rays does. Open MPI would make larger files.
  const auto full = shell(
      "export OMPI_MCA_ess_singleton_isolated=1; ulimit -f 120; "
      "\"$PHYNNESS\" precompute scene.toml -o database.h5");
  EXPECT_EQ(full.exit_status, 1);
  expect_names(full.err, {"cannot write", "rank-0000", "File too large", "--resume"});
  const auto kept = database_progress(folder / "database.h5");
  EXPECT_GT(kept.rays_logged, 0);
  EXPECT_LT(kept.rays_logged, kept.rays_total);
  EXPECT_TRUE(kept.damage.empty());
  succeed("precompute scene.toml -o database.h5 --resume");
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(BadPlace, DiskThatFillsUp) {
  if (!may_mount()) GTEST_SKIP() << "no mount namespaces here";
  write_file(folder / "script.sh",
             "set -u; mkdir disk; mount -t tmpfs -o size=128k tmpfs disk\n"
             "\"$PHYNNESS\" precompute scene.toml -o disk/database.h5 2>full.txt; echo $? >full.status\n"
             "\"$PHYNNESS\" info disk/database.h5 >info.txt\n"
             "mount -o remount,size=16m disk\n"
             "\"$PHYNNESS\" precompute scene.toml -o disk/database.h5 --resume 2>resumed.txt || exit\n"
             "cp disk/database.h5 database.h5\n");
  const auto script = shell("export PHYNNESS; unshare -rm sh script.sh");
  EXPECT_EQ(script.exit_status, 0) << script.err << text("resumed.txt");
  EXPECT_EQ(text("full.status"), "1\n");
  expect_names(text("full.txt"), {"No space left on device", "free space", "--resume"});
  EXPECT_NE(text("info.txt").find("unfinished database: "), std::string::npos) << text("info.txt");
  EXPECT_EQ(text("info.txt").find("unfinished database: 0 "), std::string::npos) << text("info.txt");
  EXPECT_NE(text("resumed.txt").find("note: resuming"), std::string::npos) << text("resumed.txt");
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(BadPlace, ReadOnlyFolder) {
  if (!may_mount()) GTEST_SKIP() << "no mount namespaces here";
  write_file(folder / "script.sh",
             "set -u; mkdir disk; mount -t tmpfs tmpfs disk\n"
             "(export OMPI_MCA_ess_singleton_isolated=1; ulimit -f 120;\n"
             " \"$PHYNNESS\" precompute scene.toml -o disk/database.h5 2>/dev/null)\n"
             "test -s disk/database.h5.log/rank-0000 || exit\n"
             "mount -o remount,ro disk\n"
             "\"$PHYNNESS\" precompute scene.toml -o disk/new.h5 2>new.txt; echo $? >new.status\n"
             "\"$PHYNNESS\" precompute scene.toml -o disk/database.h5 --resume 2>old.txt; echo $? >old.status\n"
             "mount -o remount,rw disk\n"
             "\"$PHYNNESS\" precompute scene.toml -o disk/database.h5 --resume || exit\n"
             "cp disk/database.h5 database.h5\n");
  const auto script = shell("export PHYNNESS; unshare -rm sh script.sh");
  EXPECT_EQ(script.exit_status, 0) << script.err;
  for (const char* run : {"new", "old"}) {
    EXPECT_EQ(text((std::string(run) + ".status").c_str()), "2\n");
    const auto message = text((std::string(run) + ".txt").c_str());
    EXPECT_NE(message.find("not writable"), std::string::npos) << message;
  }
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

// Open MPI's folder there would be shared by all processes that work alone, and removed by the first that ends.
TEST_F(BadPlace, NoFolderForTemporaryFilesIsNeeded) {
  const auto run = shell("TMPDIR=scene.toml \"$PHYNNESS\" precompute scene.toml -o database.h5");
  EXPECT_EQ(run.exit_status, 0) << run.err;
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(BadPlace, BesideASecondProcess) {
  // The first is stopped in the middle, so that it is alive however long the second takes.
  const auto both = shell(
      "\"$PHYNNESS\" precompute scene.toml -o database.h5 & pid=$!; "
      "for i in $(seq 4000); do size=$(cat database.h5.log/rank-* 2>/dev/null | wc -c); "
      "  [ \"$size\" -gt 40000 ] && break; sleep 0.01; done; kill -STOP $pid; echo $pid >pid.txt; "
      "\"$PHYNNESS\" precompute scene.toml -o database.h5 --resume 2>second.txt; echo $? >second.status; "
      "kill -CONT $pid; wait $pid");
  EXPECT_EQ(both.exit_status, 0) << both.err;
  EXPECT_EQ(text("second.status"), "2\n");
  auto pid = text("pid.txt");
  pid.pop_back();
  expect_names(text("second.txt"), {std::string("database.h5"), "process " + pid + " on "});
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

}  // namespace
}  // namespace phynness::test
