// Claim: the interfaces other programs rely on: exit statuses, JSON keys, the CSV's header, node numbers.
#include <cmath>

#include "command_line.hpp"

namespace phynness::test {
namespace {

using Contract = CommandLine;

TEST_F(Contract, PipelineFromSceneToForce) {
  write_file(folder / "scene.toml", small_scene());
  const auto run = succeed("run scene.toml -o out");
  for (const char* name :
       {"out/mesh.msh", "out/database.h5", "out/model/model.txt", "out/model/mesh.txt", "out/validate.json"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "out/model"), {}), 2)
      << "MODEL_DIR holds exactly model.txt and mesh.txt";

  const auto v = json("out/validate.json");
  EXPECT_EQ(v.at("probes"), 8);
  EXPECT_EQ(v.at("failed"), 0);
  for (const auto& block : {v, v.at("linear"), v.at("zero")})
    for (const char* group : {"inside", "outside"})
      for (const char* what : {"force", "displacement"})
        for (const char* figure : {"mean", "p95", "max"})
          EXPECT_TRUE(std::isfinite(block.at(group).at(what).at(figure).get<double>()));
  // What zero predicts is wrong by the whole of the largest response.
  EXPECT_NEAR(v.at("zero").at("inside").at("force").at("max").get<double>(), 1.0, 1e-12);
  // The yardstick that must hold at depths of a third of an element: far better than zero, worse than nothing.
  EXPECT_LT(v.at("linear").at("inside").at("force").at("mean").get<double>(), 0.2);
  EXPECT_GT(v.at("linear").at("inside").at("force").at("mean").get<double>(), 0.0);

  // The same question to the model and to the finite elements, the same shape of answer.
  const auto active = active_of("out/database.h5");
  const auto node = active.at(0);
  const auto tool = " --node " + std::to_string(node) + " --displacement 0,0,-0.006";
  const auto eval = succeed("eval out/model" + tool + " --json eval.json --deformation eval.csv");
  for (const char* source : {"scene.toml", "out/database.h5"}) {
    const auto solve = succeed("solve " + std::string(source) + tool + " --json solve.json --deformation solve.csv");
    const auto e = json("eval.json"), s = json("solve.json");
    for (const auto& answer : {e, s}) {
      EXPECT_EQ(answer.at("tools").at(0).at("node"), node);
      EXPECT_EQ(answer.at("tools").at(0).at("displacement").size(), 3u);
      EXPECT_EQ(answer.at("tools").at(0).at("force").size(), 3u);
      EXPECT_GT(answer.at("energy").get<double>(), 0);
      // The touched node is an output node and moves by exactly what was asked.
      EXPECT_GE(answer.at("max_displacement").get<double>(), 0.006 * (1 - 1e-12));
      EXPECT_LT(answer.at("tools").at(0).at("force").at(2).get<double>(), 0) << "a push needs a push";
    }
    const double fe = s.at("tools").at(0).at("force").at(2), model = e.at("tools").at(0).at("force").at(2);
    // 20 neurons on 52 points of a smooth curve; a defect in sign, scale or node order is off by far more.
    EXPECT_NEAR(model, fe, 0.1 * std::abs(fe));
    const auto header = std::string("node,x,y,z,ux,uy,uz\n");
    EXPECT_EQ(read_file(folder / "eval.csv").substr(0, header.size()), header);
    const auto csv_e = read_file(folder / "eval.csv"), csv_s = read_file(folder / "solve.csv");
    EXPECT_EQ(std::count(csv_e.begin(), csv_e.end(), '\n'), std::count(csv_s.begin(), csv_s.end(), '\n'));
  }

  // Two tools: the paper's weights define no force.
  const auto other = active.at(1);
  const auto two = succeed("eval out/model" + tool + " --node " + std::to_string(other) +
                           " --displacement 0.003,0,0 --tools paper --json two.json");
  EXPECT_TRUE(json("two.json").at("tools").at(0).at("force").is_null());
  EXPECT_TRUE(json("two.json").at("energy").is_null());
  const auto solve_two = succeed("solve scene.toml" + tool + " --node " + std::to_string(other) +
                                 " --displacement 0.003,0,0 --json solve_two.json");
  EXPECT_EQ(json("solve_two.json").at("tools").at(1).at("force").size(), 3u);

  // One probe lies inside the range: of errors beyond it there are none, which is not an error of zero.
  succeed("validate scene.toml out/model --probes 1 --json one.json");
  EXPECT_TRUE(json("one.json").at("outside").at("force").at("mean").is_null());
  EXPECT_FALSE(json("one.json").at("inside").at("force").at("mean").is_null());
  // The same probes on any number of ranks.
  on_two_ranks("validate scene.toml out/model --json two_ranks.json");
  for (const char* group : {"inside", "outside"}) EXPECT_EQ(json("two_ranks.json").at(group), v.at(group));

  // A model of another scene is refused, by all ranks together.
  write_file(folder / "other.toml", changed(small_scene(), "2000.0", "2500.0"));
  be_refused("validate other.toml out/model --probes 2");
  be_refused("train other.toml out/database.h5 -o m2");
  const auto refused = shell("timeout 60 mpirun --oversubscribe -n 2 \"$PHYNNESS\" validate other.toml out/model");
  EXPECT_EQ(refused.exit_status, 2) << refused.err;
  EXPECT_NE(refused.err.find("another scene"), std::string::npos) << refused.err;
}

// Of a mesh for ParaView the numbers are those of the mesh to the last bit, so that it has the same hash.
TEST_F(Contract, AMeshForParaViewIsTheMesh) {
  write_file(folder / "scene.toml", small_scene());
  const auto printed = succeed("mesh scene.toml -o mesh.msh --json mesh.json");
  expect_names(printed.out, {"thickness ", " mean cell edges below active nodes in the median"});
  succeed("mesh scene.toml -o mesh.vtu");
  expect_names(be_refused("mesh scene.toml -o mesh.xyz").err, {"mesh.xyz", "ends in .vtu (ParaView) or .msh (gmsh)"});
  expect_names(succeed("info mesh.vtu --json info.json").out, {json("mesh.json").at("mesh_hash").get<std::string>(),
                                                               "size      volume 0.0004, area 0.034; edges of "});
  // A block of 0.1 x 0.08 x 0.05 m with cells of a quarter of its length.
  EXPECT_NEAR(json("info.json").at("volume").get<double>(), 4e-4, 1e-12);
  for (const char* field : {"\"fixed\"", "\"active\"", "\"output\""})
    EXPECT_NE(read_file(folder / "mesh.vtu").find(field), std::string::npos) << field;
}

TEST_F(Contract, AFileOfSeveralBodiesIsDescribedByItsLargest) {
  write_file(folder / "two.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 5.1 0 0\nv 5 0.1 0\nv 5 0 0.1\n"
             "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n");
  const auto said = succeed("info two.obj");
  expect_names(unbroken(said.err), {"several closed surfaces: 2 components of 4 and 4", "repair = true"});
  expect_names(said.out, {"box       0 0 0 to 1 1 1 (file units)"});
}

TEST_F(Contract, WrongUsageExitsWith2AndSaysWhy) {
  write_file(folder / "scene.toml", small_scene());
  struct Case {
    const char *arguments, *says;
  };
  for (const auto& [arguments, says] : {
           Case{"mesh missing.toml -o m.msh", "missing.toml"},
           Case{"mesh scene.toml -o no/such/folder/m.msh", "no/such/folder"},
           Case{"solve scene.toml --node 3", "--displacement"},
           Case{"solve scene.toml --node 3 --displacement 0,0,nan", "'0,0,nan'"},
           Case{"solve scene.toml --node 999999 --displacement 0,0,-0.001", "999999"},
           Case{"eval nowhere --node 1 --displacement 0,0,0", "nowhere"},
           Case{"info nowhere.h5", "nowhere.h5"},
           Case{"train scene.toml scene.toml -o m", "scene.toml"},
           Case{"validate scene.toml . --probes 0", "--probes"},
           Case{"validate scene.toml . --seed -1", "--seed"},
           Case{"solve scene.toml --node 3 --displacement 0,0,-1e9", "'0,0,-1e9'"},
           Case{"train scene.toml d.h5 -o m --set deformation_spread=nan", "spread"},
       }) {
    const auto outcome = be_refused(arguments);
    SCOPED_TRACE(arguments);
    expect_names(outcome.err + outcome.out, {says});
  }
}

}  // namespace
}  // namespace phynness::test
