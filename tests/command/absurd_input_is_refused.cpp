// Claims: sizes outside of double precision, texts that are not numbers, control characters, files of other kinds and
// foreign files in the log folder of a database are refused by the command, or ignored. Outputs describe the present
// run only, and an output that cannot be written does not remain incomplete.
#include <sys/resource.h>

#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

class AbsurdInput : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
  }
  /// small_scene() with one line replaced.
  void write_scene_with(const std::string& key, const std::string& line) {
    auto text = small_scene();
    const auto from = text.find(key);
    text.replace(from, text.find('\n', from) - from, line);
    write_file(folder / "changed.toml", text);
  }
  void expect_refused(const std::string& arguments, std::initializer_list<const char*> parts) {
    const auto outcome = shell("timeout 60 \"$PHYNNESS\" " + arguments);
    EXPECT_EQ(outcome.exit_status, 2) << arguments << "\n" << outcome.err;
    for (const char* part : parts) EXPECT_NE(outcome.err.find(part), std::string::npos) << part << "\n" << outcome.err;
    const auto first = outcome.err.find("remedy: ");
    if (first != std::string::npos) {
      EXPECT_EQ(outcome.err.find("remedy: ", first + 1), std::string::npos) << outcome.err;
    }
  }
  bool is_empty_of(const std::string& suffix) const {
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.path().string().ends_with(suffix)) return false;
    return true;
  }
};

TEST_F(AbsurdInput, DisplacementsThatRoundingHidesAreRefused) {
  for (const char* depth : {"5e-324", "1e-30", "1e-14"}) {
    write_scene_with("max_displacement_m", std::string("max_displacement_m = ") + depth);
    expect_refused("precompute changed.toml -o d.h5", {"changed.toml:", "max_displacement_m"});
    expect_refused(std::string("solve scene.toml --node 0 --displacement 0,0,") + depth, {"--displacement"});
  }
  EXPECT_FALSE(fs::exists(folder / "d.h5"));
  EXPECT_FALSE(fs::exists(folder / "d.h5.log"));
}

TEST_F(AbsurdInput, SizesOfBodiesThatRoundingHidesAreRefused) {
  write_scene_with("size_m", "size_m = [1e-300, 1e-300, 1e-300]");
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:4", "size_m"});
  write_file(folder / "wall.stl",
             "solid w\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
             "endloop\nendfacet\nendsolid w\n");
  auto text = small_scene();
  const auto from = text.find("shape = "), to = text.find("[solver]");
  const std::string rest = "[material]\nlaw = \"neo-hookean\"\nyoungs_modulus_Pa = 2000.0\npoisson_ratio = 0.4\n";
  text.replace(from, to - from, "file = \"wall.stl\"\nthickness_m = 1e-20\n" + rest);
  text.replace(text.find("\"P1\""), 4, "\"shell\"");
  write_file(folder / "changed.toml", text);
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:", "thickness_m", "1e-20"});
  text.replace(text.find("thickness_m = 1e-20"), 19, "thickness_m = 1e-3\nscale_to_m = 1e-300");
  write_file(folder / "changed.toml", text);
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:", "scale_to_m"});
}

TEST_F(AbsurdInput, NumbersOfOptionsThatAreNoneAreRefused) {
  for (const char* option : {"--seed -1", "--ranks nan", "--rays 1s"})
    expect_refused(std::string("plan scene.toml ") + option,
                   {std::string(option).substr(0, std::string_view(option).find(' ')).c_str()});
  expect_refused("mesh scene.toml -o ''", {"--output"});
  expect_refused("info ''", {"give the name of a file or a folder"});  // which cannot be omitted
}

TEST_F(AbsurdInput, ABodyThatIsFixedAllOverIsSaidToBe) {
  write_scene_with("fixed", "fixed = \"surface\"");
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:", "fixed"});
}

TEST_F(AbsurdInput, PipesAreCalledPipes) {
  ASSERT_EQ(shell("mkfifo p.toml p.msh p.h5").exit_status, 0);
  expect_refused("info p.toml", {"p.toml", "pipe"});
  expect_refused("info p.msh", {"p.msh", "pipe"});
  expect_refused("info p.h5", {"p.h5", "not a file"});
  expect_refused("eval " PHYNNESS_SAMPLE_MODEL " --queries p.toml", {"p.toml", "pipe"});
  auto text = small_scene();
  const auto from = text.find("shape = "), to = text.find("[material]");
  text.replace(from, to - from, "file = \"p.msh\"\n");
  write_file(folder / "changed.toml", text);
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:3", "pipe"});
}

TEST_F(AbsurdInput, FilesWithoutPermissionAreSaidToBe) {
  succeed("precompute scene.toml -o d.h5");
  ASSERT_EQ(shell("chmod 000 d.h5 scene.toml").exit_status, 0);
  // Permissions do not bind root, who becomes nobody.
  const std::string user = geteuid() == 0 ? "setpriv --reuid=65534 --clear-groups " : "";
  if (shell(user + "test -x \"$PHYNNESS\"").exit_status != 0) GTEST_SKIP() << "nobody may run the command";
  for (const char* name : {"d.h5", "scene.toml"}) {
    const auto outcome = shell(user + "\"$PHYNNESS\" info " + name);
    EXPECT_EQ(outcome.exit_status, 2) << outcome.err;
    expect_names(outcome.err, {name, "ermission"});
  }
}

TEST_F(AbsurdInput, GigabytesOfZerosEndSoonAndCostNoMemory) {
  for (const char* name : {"large.toml", "large.msh", "large.vtk", "large.stl", "large.obj", "large.vtu", "large.ply",
                           "large.off", "large.inp"}) {
    write_file(folder / name, "");
    fs::resize_file(folder / name, std::uintmax_t{3} << 30);
    const auto outcome = shell(std::string("timeout 20 \"$PHYNNESS\" info ") + name);
    EXPECT_EQ(outcome.exit_status, 2) << name << "\n" << outcome.err;
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
    EXPECT_LT(outcome.err.size(), 1000u);
    fs::remove(folder / name);
  }
  rusage largest{};
  getrusage(RUSAGE_CHILDREN, &largest);
  EXPECT_LT(largest.ru_maxrss, 500'000) << "kilobytes, libraries included";
}

TEST_F(AbsurdInput, ControlCharactersReachNoTerminal) {
  auto text = small_scene();
  text.replace(text.find("small block"), 11, "\\u001b[31mred\\u0007\\u009b");
  write_file(folder / "scene.toml", text);
  const auto info = succeed("info scene.toml");
  EXPECT_NE(info.out.find("\\x1b[31mred\\x07\\xc2\\x9b"), std::string::npos) << info.out;
  write_scene_with("element", "element = \"a\\u0000\\u001b[2J\"");
  const auto refused = be_refused("info changed.toml");
  EXPECT_NE(refused.err.find("remedy: "), std::string::npos) << refused.err;
  const auto option = shell("\"$PHYNNESS\" info \"$(printf 'x\\033[31my')\"");
  for (const auto& outcome : {info, refused, option})
    for (const char c : outcome.out + outcome.err)
      EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') << outcome.out << outcome.err;
}

TEST_F(AbsurdInput, FilesOfOthersInAFolderOfLogsAreKept) {
  fs::create_directories(folder / "d.h5.log");
  write_file(folder / "d.h5.log/thesis.txt", "mine");
  write_file(folder / "d.h5.log/rank-00007", "mine, under the name of a log");
  be_refused("precompute scene.toml -o d.h5");
  succeed("precompute scene.toml -o d.h5 --resume");
  EXPECT_EQ(read_file(folder / "d.h5.log/thesis.txt"), "mine");
  EXPECT_EQ(read_file(folder / "d.h5.log/rank-00007"), "mine, under the name of a log");
  EXPECT_TRUE(is_empty_of("rank-0000"));
  EXPECT_FALSE(fs::exists(folder / "d.h5.log/lock"));
  fs::create_directories(folder / "e.h5.log");
  fs::create_symlink("/nowhere/lock", folder / "e.h5.log/lock");
  expect_refused("precompute scene.toml -o e.h5", {"e.h5.log/lock"});
  fs::create_directories(folder / "f.h5.log");
  write_file(folder / "f.h5.log/lock", "of somebody");
  expect_refused("precompute scene.toml -o f.h5", {"f.h5.log/lock", "is not one of this program"});
  EXPECT_EQ(read_file(folder / "f.h5.log/lock"), "of somebody");
}

TEST_F(AbsurdInput, AResumeOfOtherWorkIsRefusedBeforeItIsAnnounced) {
  succeed("precompute scene.toml -o d.h5");
  write_scene_with("youngs_modulus_Pa", "youngs_modulus_Pa = 2500.0");
  const auto outcome = be_refused("precompute changed.toml -o d.h5 --resume");
  EXPECT_EQ(outcome.err.find("resuming"), std::string::npos) << outcome.err;
}

TEST_F(AbsurdInput, ASelectionOfNothingStillLeavesTheMeshToLookAt) {
  write_file(folder / "changed.toml", small_scene());
  auto text = small_scene();
  text.insert(text.find("[probe]"), "output = { sphere = { center_m = [0, 0, 0.1], radius_m = 0.01 } }\n");
  write_file(folder / "changed.toml", text);
  expect_refused("mesh changed.toml -o m.msh",
                 {"changed.toml:16", "output nodes", "at (0, 0, 0.05) m, 0.04 m", "m.msh"});
  const auto mesh = read_file(folder / "m.msh");
  expect_names(mesh, {"\"phynness_fixed\"", "\"phynness_active\""});
  EXPECT_EQ(mesh.find("phynness_output"), std::string::npos);
  succeed("info m.msh");
}

TEST_F(AbsurdInput, TheCostOfAnIncrementIsThatOfTheIncrementsOfTheRun) {
  succeed("precompute scene.toml -o d.h5 --json first.json");
  EXPECT_EQ(json("first.json").at("increments_of_run"), json("first.json").at("increments"));
  const auto again = succeed("precompute scene.toml -o d.h5 --resume --json again.json");
  EXPECT_EQ(json("again.json").at("increments_of_run"), 0);
  EXPECT_EQ(again.out.find("core-ms"), std::string::npos) << again.out;
}

TEST_F(AbsurdInput, AFullDiskLeavesNoHalfOfAModelOrAnExport) {
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o model");
  const auto mesh = fs::file_size(folder / "model/mesh.txt"), model = fs::file_size(folder / "model/model.txt");
  ASSERT_GT(model, mesh + 1024);
  // In blocks of 512 bytes: mesh.txt fits, model.txt does not.
  const auto limit = "ulimit -f " + std::to_string(mesh / 512 + 1) + "; \"$PHYNNESS\" ";
  EXPECT_EQ(shell(limit + "train scene.toml d.h5 -o half").exit_status, 1);
  EXPECT_TRUE(fs::is_empty(folder / "half"));
  succeed("export model -o whole");
  const auto header = fs::file_size(folder / "whole/model.h");
  EXPECT_EQ(shell("ulimit -f " + std::to_string(header / 512 + 1) + "; \"$PHYNNESS\" export model -o part").exit_status,
            1);
  EXPECT_TRUE(fs::is_empty(folder / "part"));
}

TEST_F(AbsurdInput, AFullDiskIsReportedOnceWithARemedyThatExists) {
  const auto remedies = [](const std::string& text) {
    int n = 0;
    for (auto at = text.find("remedy: "); at != std::string::npos; at = text.find("remedy: ", at + 1)) ++n;
    return n;
  };
  // 120 blocks of 512 bytes: the header fits, a fraction of the rays does. Open MPI would make larger files.
  write_file(folder / "scene.toml", small_scene("P1", 6));
  const auto stopped =
      shell("export OMPI_MCA_ess_singleton_isolated=1; ulimit -f 120; \"$PHYNNESS\" precompute scene.toml -o e.h5");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  EXPECT_EQ(remedies(stopped.err), 1) << stopped.err;
  EXPECT_EQ(stopped.err.find("rank 0 stops"), std::string::npos) << stopped.err;
}

}  // namespace
}  // namespace phynness::test
