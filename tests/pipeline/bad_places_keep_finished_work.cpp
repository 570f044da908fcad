// Claims: with a limit of file size, as on a full disk, or together with a second process, precompute ends with a
// reason and a remedy and keeps every finished ray. After the cause is removed, it continues to the same database.
#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class BadPlace : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene("P1", 6));
    make_once({"precompute scene.toml -o whole.h5"});
  }
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

// Open MPI's folder there would be shared by all processes that work alone, and removed by the first that ends.
TEST_F(BadPlace, NoFolderForTemporaryFilesIsNeeded) {
  const auto run = shell("TMPDIR=scene.toml \"$PHYNNESS\" precompute scene.toml -o database.h5");
  EXPECT_EQ(run.exit_status, 0) << run.err;
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(BadPlace, BesideASecondProcess) {
  // The first is stopped in the middle, so that it is alive however long the second takes.
  const auto both = signalled(
      "\"$PHYNNESS\" precompute scene.toml -o database.h5",
      "[ \"$(cat database.h5.log/rank-* 2>/dev/null | wc -c)\" -gt 40000 ]",
      "kill -STOP $pid; echo $pid >pid.txt; \"$PHYNNESS\" precompute scene.toml -o database.h5 --resume 2>second.txt; "
      "echo $? >second.status; kill -CONT $pid");
  EXPECT_EQ(both.exit_status, 0) << both.err;
  EXPECT_EQ(text("second.status"), "2\n");
  auto pid = text("pid.txt");
  pid.pop_back();
  expect_names(text("second.txt"), {std::string("database.h5"), "process " + pid + " on "});
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

}  // namespace
}  // namespace phynness::test
