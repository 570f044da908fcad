// Claims: of a scene with other active nodes, output nodes or directions only the rays that an earlier database does
// not have are solved, and the database, by any number of ranks, is the one of which all are solved. A killed growth
// keeps the earlier database and goes on. A model of some nodes of a database is the model of their own database.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class Growth : public CommandLine {
 protected:
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  /// The scene of the tests with `n` of four active nodes.
  static std::string scene(int n, int increments = 2) {
    const auto text = small_scene("P1", increments);
    std::string active = "active = [";
    for (const char* at : {"0.3, 0.4", "0.7, 0.6", "0.1, 0.9", "0.9, 0.1"})
      if (n-- > 0) active += "{ nearest = { point_fraction = [" + std::string(at) + ", 1.0] }, surface_only = true }, ";
    return changed(text, text.substr(text.find("active ="), text.find("[probe]") - text.find("active =")),
                   active + "]\n");
  }
  /// The same with the displacement of the top only.
  static std::string top_of(const std::string& text) {
    return changed(
        text, "active",
        "output = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\nactive");
  }
  void expect_fresh(const std::string& file, const std::string& scene_name) {
    std::filesystem::remove(folder / "fresh.h5");
    succeed("precompute " + scene_name + " -o fresh.h5");
    expect_same_results(folder / file, folder / "fresh.h5");
  }
};

TEST_F(Growth, SolvesOnlyWhatIsMissing) {
  write_file(folder / "two.toml", scene(2));
  write_file(folder / "four.toml", scene(4));
  succeed("precompute two.toml -o two.h5");
  const auto plan = succeed("plan four.toml --from two.h5 --rays 4 --json plan.json");
  EXPECT_EQ(json("plan.json").at("rays_taken"), 52) << plan.out;
  EXPECT_EQ(json("plan.json").at("rays_requested"), 52);
  const auto grown =
      shell("mpirun --oversubscribe -n 2 \"$PHYNNESS\" precompute four.toml -o four.h5 --from two.h5 --json four.json");
  ASSERT_EQ(grown.exit_status, 0) << grown.err;
  EXPECT_EQ(json("four.json").at("rays_taken"), 52);
  EXPECT_EQ(json("four.json").at("rays"), 104);
  expect_names(unbroken(grown.out), {"52 taken from two.h5, 52 solved"});
  expect_fresh("four.h5", "four.toml");

  // Fewer nodes, a smaller part of the body, fewer directions: nothing is solved.
  write_file(folder / "less.toml", changed(top_of(scene(1)), "directions = 26", "directions = \"hemisphere\""));
  succeed("precompute less.toml -o less.h5 --from four.h5 --json less.json");
  EXPECT_EQ(json("less.json").at("rays_taken"), 17);
  EXPECT_EQ(json("less.json").at("increments_of_run"), 0);
  expect_fresh("less.h5", "less.toml");

  const auto stiffer = changed(scene(2), "2000.0", "2500.0");
  write_file(folder / "stiffer.toml", changed(stiffer, "max_displacement_m = 0.008", "max_displacement_m = 0.01"));
  const auto refused = be_refused("precompute stiffer.toml -o stiffer.h5 --from two.h5");
  expect_names(refused.err, {"material.", "probe.max_displacement_m", "other increments"});
  EXPECT_FALSE(std::filesystem::exists(folder / "stiffer.h5"));
  write_file(folder / "more.toml", scene(1));
  expect_names(be_refused("precompute more.toml -o more.h5 --from less.h5").err, {"output nodes"});
}

TEST_F(Growth, GoesOnAfterAKill) {
  write_file(folder / "one.toml", scene(1, 6));
  write_file(folder / "four.toml", scene(4, 6));
  succeed("precompute one.toml -o organ.h5");
  const auto before = read_file(folder / "organ.h5");
  // The first log has the rays that were taken, the second those that are solved.
  const auto killed = shell(
      "\"$PHYNNESS\" precompute four.toml -o organ.h5 --resume & pid=$!; "
      "for i in $(seq 2000); do "
      "  size=$(cat organ.h5.grown.log/rank-0000-1 2>/dev/null | wc -c); [ \"$size\" -gt 40000 ] && break; "
      "  sleep 0.01; done; kill -KILL $pid; wait $pid");
  ASSERT_NE(killed.exit_status, 0) << "it finished before the signal came: the scene is too small for this test";
  EXPECT_EQ(read_file(folder / "organ.h5"), before);
  succeed("precompute four.toml -o organ.h5 --resume --json resumed.json");
  EXPECT_EQ(json("resumed.json").at("rays_taken"), 0) << "they were in the log";
  EXPECT_GT(json("resumed.json").at("rays_resumed"), 26);
  EXPECT_LT(json("resumed.json").at("rays_resumed"), 104);
  expect_fresh("organ.h5", "four.toml");
  for (const char* left : {"organ.h5.grown", "organ.h5.grown.log", "organ.h5.log"})
    EXPECT_FALSE(std::filesystem::exists(folder / left)) << left;
  // Rays of nodes that the scene does not want would be lost.
  expect_names(be_refused("precompute one.toml -o organ.h5 --resume").err, {"nodes.active", "--from"});
}

TEST_F(Growth, TrainsSomeNodesOfADatabase) {
  const auto modal = [](const std::string& text) { return changed(text, "family = \"rbfn\"", "family = \"modal\""); };
  write_file(folder / "three.toml", modal(scene(3)));
  write_file(folder / "part.toml", modal(top_of(scene(2))));
  succeed("precompute three.toml -o three.h5");
  succeed("precompute part.toml -o part.h5");
  succeed("train part.toml three.h5 -o of_three");
  succeed("train part.toml part.h5 -o of_part");
  for (const char* file : {"model.txt", "mesh.txt"})
    EXPECT_EQ(read_file(folder / "of_three" / file), read_file(folder / "of_part" / file)) << file;
  expect_names(be_refused("calibrate of_three three.h5 --rays 100").err, {"--scene"});
  succeed("calibrate of_three three.h5 --scene part.toml --rays 100");
  succeed("calibrate of_part part.h5 --rays 100");
  EXPECT_EQ(read_file(folder / "of_three/model.txt"), read_file(folder / "of_part/model.txt"));
  // The other way round rays are missing, and of another depth all are.
  expect_names(be_refused("train three.toml part.h5 -o other").err, {"--from part.h5"});
  write_file(folder / "deeper.toml", changed(scene(1), "0.008", "0.016"));
  expect_names(be_refused("train deeper.toml three.h5 -o other").err, {"probe.max_displacement_m"});
}

TEST_F(Growth, RunUsesWhatItHas) {
  const auto linear = [](int n) {
    const auto text = changed(changed(scene(n), "neo-hookean", "linear"), "family = \"rbfn\"", "family = \"linear\"");
    return changed(text, "check_probes = 0", "check_probes = 1");
  };
  const auto run = [&](int n) {
    write_file(folder / "scene.toml", linear(n));
    return succeed("run scene.toml -o out --resume --json all.json");
  };
  run(1);
  expect_names(be_refused("run scene.toml -o out").err, {"--resume"});
  run(3);
  EXPECT_EQ(json("out/precompute.json").at("rays_taken"), 26);
  expect_fresh("out/database.h5", "scene.toml");
  const auto before = read_file(folder / "out/database.h5");
  expect_names(run(2).err, {"all rays of the scene are in"});
  EXPECT_EQ(read_file(folder / "out/database.h5"), before);
  EXPECT_EQ(json("out/train.json").at("networks"), 2);
}

}  // namespace
}  // namespace phynness::test
