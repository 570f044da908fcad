// Claims: of a scene of round tools the database has points of the free surface beside the active ones, at one spacing
// with them, with the response at rest. A scene without them has the same rays and hash, and grows to them without
// solving a ray; they end as they began if the scene no longer wants them. Commands name them.
#include <algorithm>
#include <iomanip>
#include <phynness/formats/database.hpp>
#include <sstream>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class Elsewhere : public CommandLine {
 protected:
  /// A block whose top is active in part, with points `spacing` apart.
  static std::string patch_scene(const std::string& keys) {
    const auto scene = with_active(
        small_scene("p1-p1", 1),
        "active = { spacing_m = 0.04, within = { sphere = { center_fraction = [0.2, 0.5, 1], radius_m = 0.04 "
        "}, surface_only = true } }\noutput = \"free\"\n");
    return changed(scene, "directions = 26", "directions = 3\nkind = \"patch\"\ntool_radius_m = 0.0375\n" + keys);
  }
  static std::string point_of(const Mesh& mesh, std::int32_t node) {
    std::ostringstream text;
    text << std::setprecision(17) << mesh.nodes(node, 0) << ',' << mesh.nodes(node, 1) << ',' << mesh.nodes(node, 2);
    return text.str();
  }
  AtRest response(const char* file, std::int32_t point) const { return Database::open(folder / file).at_rest(point); }
};

TEST_F(Elsewhere, PointsAreSpreadAndGrow) {
  write_file(folder / "scene.toml", patch_scene(""));
  write_file(folder / "without.toml", patch_scene("elsewhere = \"none\"\n"));
  const auto solved = succeed("precompute scene.toml -o database.h5 --json run.json");
  const auto header = read_database_header(folder / "database.h5");
  const auto& sets = header.sets;
  ASSERT_GT(sets.linear.size(), 6U);
  EXPECT_EQ(json("run.json").at("points_at_rest"), sets.linear.size());
  expect_names(solved.out, {std::to_string(sets.linear.size()) + " points elsewhere"});
  expect_names(succeed("info database.h5").out, {std::to_string(sets.linear.size()) + " elsewhere with the linear"});
  expect_names(succeed("plan scene.toml").out, {"elsewhere " + std::to_string(sets.linear.size()) + " points"});
  expect_error(be_refused("show database.h5 --direction 0 -o x.pvd --node " + std::to_string(sets.linear[0])).err,
               {"response at rest only"});
  // Distances along the surface are not shorter than straight ones.
  NodeList free = surface_nodes(header.mesh.surface);
  std::erase_if(free, [&](std::int32_t i) { return std::ranges::binary_search(sets.fixed, i); });
  auto all = sets.linear;
  all.insert(all.end(), sets.active.begin(), sets.active.end());
  for (const auto i : free) {
    const auto away = (header.mesh.nodes(all, Eigen::all).rowwise() - header.mesh.nodes.row(i)).rowwise().norm();
    EXPECT_LE(away.minCoeff(), 0.75 * 0.04) << i;
  }
  for (const auto i : sets.linear) {
    EXPECT_TRUE(std::ranges::binary_search(free, i)) << i;
    EXPECT_FALSE(std::ranges::binary_search(sets.active, i)) << i;
  }
  ASSERT_EQ(sets.linear_tools.size(), sets.linear.size());
  EXPECT_TRUE(sets.linear_tools[0].mean);

  succeed("precompute without.toml -o grown.h5");
  const auto before = read_database_header(folder / "grown.h5");
  EXPECT_TRUE(before.sets.linear.empty());
  EXPECT_EQ(before.physics_hash, header.physics_hash);
  succeed("precompute scene.toml -o grown.h5 --resume --json run.json");
  EXPECT_EQ(json("run.json").at("increments_of_run"), 0);
  expect_same_results(folder / "grown.h5", folder / "database.h5");
  for (std::int32_t i = 0; i < std::ssize(sets.linear); ++i) {
    EXPECT_EQ(response("grown.h5", i).stiffness_N_per_m, response("database.h5", i).stiffness_N_per_m);
    EXPECT_EQ(response("grown.h5", i).displacement, response("database.h5", i).displacement);
  }
  // The tool's mean moves with the tool, up to the float32 of the displacements.
  const auto one = response("database.h5", 0);
  for (std::size_t along = 0; along < 3; ++along)
    for (std::size_t k = 0; k < 3; ++k) {
      double mean = 0;
      for (std::size_t i = 0; i < sets.linear_tools[0].nodes.size(); ++i) {
        const auto at = std::ranges::find(sets.output, sets.linear_tools[0].nodes[i]) - sets.output.begin();
        mean += sets.linear_tools[0].weights[i] *
                one.displacement[3 * (along * sets.output.size() + static_cast<std::size_t>(at)) + k];
      }
      EXPECT_NEAR(mean, along == k, 1e-6);
    }
  succeed("precompute without.toml -o grown.h5 --resume --json run.json");
  EXPECT_EQ(json("run.json").at("increments_of_run"), 0);
  EXPECT_TRUE(read_database_header(folder / "grown.h5").sets.linear.empty());
}

// Claim: a model of such a database answers on the whole free surface, at these points with the stiffness at rest; of a
// database without them only where it was probed.
TEST_F(Elsewhere, ModelsAnswerThere) {
  for (const std::string keys : {"", "elsewhere = \"none\"\n"}) {
    write_file(folder / "scene.toml", patch_scene(keys));
    succeed("precompute scene.toml -o database.h5");
    succeed("train scene.toml database.h5 -o model --family modal");
    const auto said = succeed("info model --json info.json").out;
    const auto surface = json("info.json").at("surface");
    const auto header = read_database_header(folder / "database.h5");
    const bool anywhere = keys.empty();
    EXPECT_EQ(surface.at("linear_points"), header.sets.linear.size());
    EXPECT_EQ(said.find("answer as the body at rest") != std::string::npos, anywhere);
    const double area = surface.at("nonlinear").get<double>() + surface.at("linear").get<double>();
    if (!anywhere) {
      EXPECT_LT(area, 0.5);
    } else {
      EXPECT_LT(area, 1) << "triangles of fixed and active nodes are in neither";
      EXPECT_GT(area, 0.95) << "few triangles have both";
      const auto share = [](const std::string& text) {
        const auto line = unbroken(text);
        const auto at = line.find("a tool is between them on ");
        return at < line.size() ? line.substr(at, line.find('%', at) - at) : "not said";
      };
      EXPECT_EQ(share(succeed("info scene.toml").out), share(said));
      EXPECT_NE(share(said), "not said");
      const auto node = header.sets.linear[0];
      const auto expected = response("database.h5", 0).stiffness_N_per_m;
      const auto at = " --point " + point_of(header.mesh, node) + " --displacement 0,0,-0.001 --json eval.json";
      const auto warned = succeed("eval model" + at).err;
      EXPECT_NE(warned.find("the tool is at or beside nodes where the model is linear"), std::string::npos) << warned;
      EXPECT_EQ(warned.find("deeper than trained"), std::string::npos) << warned;
      const auto force = json("eval.json").at("tools").at(0).at("force");
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(force.at(k).get<double>(), -0.001 * expected[3 * k + 2], 1e-12);
    }
    std::filesystem::remove(folder / "database.h5");
  }
}

}  // namespace
}  // namespace phynness::test
