// Claims: sizes outside of double precision and texts that are not numbers are refused by the command, control
// characters reach no terminal, and outputs describe the present run only.
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
  void expect_refused(const std::string& arguments, const std::vector<std::string>& parts) {
    const auto outcome = shell("timeout 60 \"$PHYNNESS\" " + arguments);
    EXPECT_EQ(outcome.exit_status, 2) << arguments << "\n" << outcome.err;
    expect_names(outcome.err, parts);
    const auto first = outcome.err.find("remedy: ");
    if (first != std::string::npos) {
      EXPECT_EQ(outcome.err.find("remedy: ", first + 1), std::string::npos) << outcome.err;
    }
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

TEST_F(AbsurdInput, ABodyThatIsFixedAllOverIsSaidToBe) {
  write_scene_with("fixed", "fixed = \"surface\"");
  expect_refused("mesh changed.toml -o m.msh", {"changed.toml:", "fixed"});
}

TEST_F(AbsurdInput, ControlCharactersReachNoTerminal) {
  write_file(folder / "scene.toml", changed(small_scene(), "small block", "\\u001b[31mred\\u0007\\u009b"));
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

}  // namespace
}  // namespace phynness::test
