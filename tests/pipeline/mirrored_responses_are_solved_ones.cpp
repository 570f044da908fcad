// Claim: for a scene with a plane of symmetry half of the rays are solved, and the database agrees with that of a solve
// of all rays, for node and patch probes and for displacement and mixed elements. Both solves have a tolerance of 1e-10
// of the reactions, and the error of the force is this times the norm of the sensitivities (about 1e1): the tolerance
// is 1e-8.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class MirroredResponses : public CommandLine,
                          public ::testing::WithParamInterface<std::pair<const char*, const char*>> {
 protected:
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  static std::string symmetric_scene(const std::string& element, const std::string& probe) {
    auto text = small_scene(element);
    text = changed(text, "target_size_m = 0.025", "target_size_m = 0.025\nsymmetry = \"x\"");
    text = changed(text, "[solver]", "[solver]\nrelative_tolerance = 1e-10");
    text = changed(text, "[probe]",
                   "[database]\ndisplacement_precision = \"float64\"\n"
                   "fields = [\"von-mises-stress\", \"energy-density\"]\n[probe]\n" +
                       probe);
    // Two nodes of a pair, and one on the plane.
    const auto from = text.find("active ="), to = text.find("[database]");
    return text.replace(from, to - from,
                        "active = [{ nearest = { point_fraction = [0, 0, 1] } }, { nearest = { point_fraction = [1, 0, "
                        "1] } },\n          { nearest = { point_fraction = [0.5, 1, 1] } }]\n");
  }
};

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double error = 0, size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    error = std::max(error, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return error / size;
}

TEST_P(MirroredResponses, AreThoseOfSolvingEverything) {
  const auto scene = symmetric_scene(GetParam().first, GetParam().second);
  write_file(folder / "scene.toml", scene);
  succeed("precompute scene.toml -o mirrored.h5 --json mirrored.json");
  EXPECT_EQ(json("mirrored.json").at("rays"), 26 + 17);
  EXPECT_EQ(json("mirrored.json").at("rays_mirrored"), 26 + 9);

  succeed("mesh scene.toml -o whole.msh");
  auto solved = changed(scene, "shape = \"block\"", "file = \"whole.msh\"");
  for (const char* line : {"size_m = [0.1, 0.08, 0.05]\n", "target_size_m = 0.025\n", "symmetry = \"x\"\n"})
    solved = changed(solved, line, "");
  write_file(folder / "solved.toml", solved);
  succeed("precompute solved.toml -o solved.h5");

  const auto a = Database::open(folder / "mirrored.h5"), b = Database::open(folder / "solved.h5");
  ASSERT_EQ(a.header().mesh_hash, b.header().mesh_hash);
  for (std::int32_t active = 0; active < 3; ++active) {
    const auto these = a.rays(active), those = b.rays(active);
    for (std::size_t d = 0; d < these.size(); ++d) {
      EXPECT_EQ(these[d].status, those[d].status);
      EXPECT_LT(difference(these[d].force, those[d].force), 1e-8);
      EXPECT_LT(difference(these[d].energy, those[d].energy), 1e-8);
      EXPECT_LT(difference(these[d].displacement, those[d].displacement), 1e-8);
      ASSERT_EQ(these[d].fields.size(), 2u);
      // Stored as float32, whose rounding is 6e-8; two of them.
      for (std::size_t f = 0; f < 2; ++f) EXPECT_LT(difference(these[d].fields[f], those[d].fields[f]), 2e-7);
    }
  }
  const auto info = phynness("info mirrored.h5");
  EXPECT_NE(info.out.find("35 of 78 rays are mirror images"), std::string::npos) << info.out;
  for (const char* shard : {"0/2", "1/2"}) {
    const auto part = succeed(std::string("precompute scene.toml -o parts.h5 --json part.json --shard ") + shard);
    // So few rays are dealt one by one.
    EXPECT_NEAR(json("part.json").at("rays").get<int>(), 43 / 2.0, 0.5) << shard;
  }
  succeed("merge parts.shard-0-of-2.h5 parts.shard-1-of-2.h5 -o parts.h5");
  expect_same_results(folder / "mirrored.h5", folder / "parts.h5");
  const auto train = succeed("train scene.toml mirrored.h5 -o model --json train.json");
}

INSTANTIATE_TEST_SUITE_P(Probes, MirroredResponses,
                         ::testing::Values(std::pair{"P1", "kind = \"node\"\n"},
                                           std::pair{"taylor-hood", "kind = \"patch\"\ntool_radius_m = 0.03\n"}),
                         [](const auto& info) { return info.index == 0 ? "node_P1" : "patch_taylor_hood"; });

}  // namespace
}  // namespace phynness::test
