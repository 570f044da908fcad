// Claims: for a patch that its mesh does not resolve mesh, info, plan and train print a warning with file and line. The
// recommended change removes the warning. Other scenes have no such warning. The same holds for patches that lose a
// part to fixed nodes, and the shift that the warning states is that of the centroid of half a disk. Commands that do
// not choose places do not repeat the warning that each node is probed.
#include <regex>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Patches : public CommandLine {
 protected:
  /// A block with edges of about 25 mm.
  static std::string scene(const std::string& radius, const std::string& depth,
                           const std::string& size = "target_size_m = 0.025") {
    const auto text =
        changed(small_scene(), "[probe]\n", "[probe]\nkind = \"patch\"\ntool_radius_m = " + radius + "\n");
    return changed(changed(text, "max_displacement_m = 0.008", "max_displacement_m = " + depth),
                   "target_size_m = 0.025", size);
  }
  std::string warnings(const std::string& text) {
    write_file(folder / "scene.toml", text);
    const auto meshed = succeed("mesh scene.toml -o mesh.msh");
    return unbroken(meshed.err);
  }
  static std::string recommended(const std::string& key, const std::string& words) {
    std::smatch found;
    EXPECT_TRUE(std::regex_search(words, found, std::regex("; .*(" + key + " = [0-9.e+-]+[0-9])"))) << key << "\n"
                                                                                                    << words;
    return found[1];
  }
};

const std::string unresolved = "not resolved";
bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(Patches, OfFewEdgesAreNamedByEveryCommandThatReadsThem) {
  write_file(folder / "scene.toml", scene("0.03", "0.008"));
  succeed("precompute scene.toml -o d.h5");
  for (const char* line : {"mesh scene.toml -o mesh.msh", "info scene.toml", "info d.h5", "plan scene.toml --rays 2"}) {
    const auto outcome = succeed(line);
    EXPECT_TRUE(holds(outcome.err, "warning: ") && holds(outcome.err, unresolved)) << line << "\n" << outcome.err;
    EXPECT_TRUE(holds(outcome.err, "scene.toml:")) << line << "\n" << outcome.err;
  }
}

TEST_F(Patches, OfEveryNodeAreNamedOnlyWherePlacesAreChosen) {
  const auto dense = with_active(scene("0.06", "0.008"),
                                 "active = { spacing_m = 0.001, within = { sphere = { center_fraction = [0.5, 0.5, 1], "
                                 "radius_m = 0.03 }, surface_only = true } }\n");
  write_file(folder / "scene.toml", changed(dense, "directions = 26", "directions = 3"));
  for (const char* line :
       {"precompute scene.toml -o d.h5", "mesh scene.toml -o mesh.msh", "info scene.toml", "plan scene.toml --rays 2"})
    EXPECT_TRUE(holds(unbroken(succeed(line).err), "nodes of the part are probed")) << line;
  for (const char* line : {"check scene.toml --probes 1", "info d.h5", "precompute scene.toml --mesh mesh.msh -o e.h5",
                           "solve scene.toml --point 0.05,0.04,0.05 --displacement 0,0,-0.001"})
    EXPECT_FALSE(holds(unbroken(succeed(line).err), "nodes of the part are probed")) << line;
}

TEST_F(Patches, AreResolvedAsRecommended) {
  const auto words = warnings(scene("0.03", "0.008"));
  const auto radius = recommended("tool_radius_m", words);
  EXPECT_FALSE(holds(warnings(scene(radius.substr(radius.find("= ") + 2), "0.008")), unresolved)) << words;
  EXPECT_FALSE(holds(warnings(small_scene()), unresolved)) << "a node probe";
  EXPECT_TRUE(holds(warnings(scene("0.06", "0.008")), "is wider than the body is long, 0.1 m"));
  EXPECT_FALSE(holds(warnings(scene("0.049", "0.008")), "is wider"));
  // A liver, as a block has a whole number of cells along each edge.
  const auto liver = [](const std::string& size) {
    const auto text =
        changed(scene("0.03", "0.008", size), "shape = \"block\"\nsize_m = [0.1, 0.08, 0.05]\n", "shape = \"liver\"\n");
    return changed(text, "plane = { point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = 1e-6 }",
                   "box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] }");
  };
  const auto of_liver = warnings(liver("target_size_m = 0.02"));
  EXPECT_TRUE(holds(of_liver, unresolved));
  EXPECT_FALSE(holds(of_liver, "remesh")) << of_liver;
  // Its tetrahedra in a file need another key, too. A size that has no effect is not what the new one is scaled from.
  std::filesystem::rename(folder / "mesh.msh", folder / "liver.msh");
  const auto file = [&](const std::string& size) {
    return changed(liver(size), "shape = \"liver\"", "file = \"liver.msh\"");
  };
  const auto of_file = warnings(file("target_size_m = 0.1"));
  EXPECT_TRUE(holds(of_file, "have no effect without remesh = true")) << of_file;
  EXPECT_TRUE(holds(of_file, "(of a file of tetrahedra: and remesh = true)")) << of_file;
  const auto remeshed = warnings(file(recommended("target_size_m", of_file) + "\nremesh = true"));
  EXPECT_FALSE(holds(remeshed, unresolved)) << of_file << remeshed;
  EXPECT_FALSE(holds(warnings(liver(recommended("target_size_m", of_liver))), unresolved)) << of_liver;
}

TEST_F(Patches, ThatLoseAPartToFixedNodesAreNamedWithTheirShift) {
  // One half of the top is fixed, up to a line through the node at its middle. Half a disk has its centroid at
  // 4 R / (3 pi) = 0.42 R; edges of R / 3 leave a strip of up to an edge that belongs to fixed and free nodes.
  auto text = scene("0.03", "0.008", "target_size_m = 0.01");
  const auto set = [&](const std::string& key, const std::string& value) {
    const auto at = text.find("\n" + key + " = ") + 1;
    const auto next = text.find(key == "active" ? "\n[" : "\n", at);
    text.replace(at, next - at, key + " = " + value);
  };
  set("fixed", "{ half_space = { point_fraction = [0.49, 0, 0], normal = [1, 0, 0] } }");
  const std::string selection =
      "[{ nearest = { point_fraction = [0.55, 0.5, 1] } }, { nearest = { point_fraction = [0.9, 0.5, 1] } }]";
  set("active", selection);
  const auto words = warnings(text);
  std::smatch found;
  ASSERT_TRUE(std::regex_search(words, found, std::regex("part of the patch at 1 of 2 .*\\(([0-9.]+) of the radius")))
      << words;
  EXPECT_NEAR(std::stod(found[1]), 0.42, 0.25) << words;
  EXPECT_TRUE(std::regex_search(words, found, std::regex("active = (.*\\] \\})"))) << words;
  set("active", changed(found[1], "SELECTION", selection));
  EXPECT_FALSE(holds(warnings(text), "part of the patch"));
}

}  // namespace
}  // namespace phynness::test
