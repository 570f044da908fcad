// Claims: of a scene with other active nodes, output nodes or directions only the rays that an earlier database does
// not have are solved, and the database, by any number of ranks, is the one of which all are solved. A smaller depth
// has the first increments of every ray, also of a body that folds; to a larger depth only rays that go on are solved,
// and those that begin in another way are named. All moduli times a factor need no solve: the tolerance of 1e-9 is far
// above the rounding of parameters, and a thousandth of what a change of 1e-6 in one modulus would do. A killed growth
// keeps the earlier database and goes on. A model of some nodes of a database is the model of their own database.
#include <algorithm>
#include <cmath>
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
  void expect_fresh(const std::string& file, const std::string& scene_name, double rounding = 0) {
    std::filesystem::remove(folder / "fresh.h5");
    succeed("precompute " + scene_name + " -o fresh.h5");
    expect_same_results(folder / file, folder / "fresh.h5", rounding);
  }
  /// Increments of 1/128 m into a nearly incompressible block 60 mm high, which folds between 40 and 50 mm.
  static std::string deep_scene(int increments) {
    auto text = changed(changed(scene(2, increments), "\"P1\"", "\"p1-p1\""), "0.45", "0.4975");
    text = changed(changed(text, "[0.1, 0.08, 0.05]", "[0.09, 0.06, 0.06]"), "0.025", "0.02");
    text = changed(text, "0.7, 0.6", "0.1, 0.9");
    text = changed(text, "family = \"rbfn\"", "family = \"modal\"");
    text = changed(text, "[training]", "[database]\nfields = [\"von-mises-stress\"]\n[training]");
    return changed(text, "0.008", std::to_string(increments / 128.0) + "\nmin_jacobian = 0");
  }
};

TEST_F(Growth, TakesTheFirstIncrementsOfBodiesThatFold) {
  write_file(folder / "deep.toml", deep_scene(8));
  write_file(folder / "shallow.toml", deep_scene(6));
  succeed("precompute deep.toml -o deep.h5");
  int before = 0, beyond = 0;
  for (const auto& end : Database::open(folder / "deep.h5").ends())
    if (end.reason == EndReason::fold) ++(end.fold_depth_m < 6 / 128.0 ? before : beyond);
  EXPECT_GT(before, 0);
  EXPECT_GT(beyond, 0);
  succeed("precompute shallow.toml -o shallow.h5 --from deep.h5 --json shallow.json");
  EXPECT_EQ(json("shallow.json").at("rays_taken"), 52);
  EXPECT_EQ(json("shallow.json").at("increments_of_run"), 0);
  expect_fresh("shallow.h5", "shallow.toml");
  succeed("train shallow.toml deep.h5 -o of_deep");
  succeed("train shallow.toml shallow.h5 -o of_shallow");
  EXPECT_EQ(read_file(folder / "of_deep/model.txt"), read_file(folder / "of_shallow/model.txt"));

  // The other way round, the rays that end within the smaller depth are there, and the others begin in the same way.
  const auto ends = Database::open(folder / "shallow.h5").ends();
  const auto early = std::count_if(ends.begin(), ends.end(), [](const auto& end) { return end.is_early(); });
  const auto grown = shell(
      "mpirun --oversubscribe -n 2 \"$PHYNNESS\" precompute deep.toml -o again.h5 --from shallow.h5 --json deep.json");
  ASSERT_EQ(grown.exit_status, 0) << grown.err;
  EXPECT_EQ(json("deep.json").at("rays_taken"), early);
  EXPECT_EQ(json("deep.json").at("rays_compared"), 52 - early);
  EXPECT_EQ(json("deep.json").at("rays_on_another_branch"), 0) << grown.err;
  expect_same_results(folder / "again.h5", folder / "deep.h5");
  succeed("precompute deep.toml -o shallow.h5 --resume");
  expect_same_results(folder / "shallow.h5", folder / "deep.h5");
}

TEST_F(Growth, NamesRaysOnAnotherBranch) {
  write_file(folder / "one.toml", changed(scene(1, 1), "0.008", "0.004"));
  write_file(folder / "two.toml", scene(1, 2));
  succeed("precompute one.toml -o one.h5");
  const auto one = Database::open(folder / "one.h5");
  DatabaseWriter::create(folder / "other.h5", one.header(), false);
  DatabaseWriter log(folder / "other.h5", one.header(), 0);
  for (Ray ray : one.rays(0)) {
    if (ray.direction == 7) ray.force[0] += 1e-8 * std::abs(ray.force[2]) + 1e-8 * std::abs(ray.force[0]);
    log.append(ray);
  }
  log.close();
  DatabaseWriter::pack(folder / "other.h5", one.header());
  const auto grown = succeed("precompute two.toml -o two.h5 --from other.h5 --json two.json");
  EXPECT_EQ(json("two.json").at("rays_compared"), 26);
  EXPECT_EQ(json("two.json").at("rays_on_another_branch"), 1);
  const auto node = std::to_string(one.header().sets.active.front());
  expect_names(unbroken(grown.err), {"25 of 26 rays begin as in other.h5", "another branch of equilibria",
                                     "node " + node + ", direction 7, from 0.004 m on"});
  expect_fresh("two.h5", "two.toml");
}

TEST_F(Growth, ScalesWithAllModuli) {
  write_file(folder / "soft.toml", deep_scene(4));
  write_file(folder / "stiff.toml", changed(deep_scene(4), "2000.0", "2666.6666666666665"));
  succeed("precompute soft.toml -o soft.h5");
  succeed("precompute stiff.toml -o stiff.h5 --from soft.h5 --json stiff.json");
  EXPECT_EQ(json("stiff.json").at("rays_taken"), 52);
  EXPECT_EQ(json("stiff.json").at("increments_of_run"), 0);
  expect_fresh("stiff.h5", "stiff.toml", 1e-9);
  // A model of the soft body answers for the stiff one; the fits differ by the rounding of their data, 1e-16, times the
  // condition of the equations for forces and energies, which was 1e10.
  succeed("train soft.toml soft.h5 -o soft");
  succeed("train stiff.toml stiff.h5 -o stiff");
  const auto node = std::to_string(Database::open(folder / "soft.h5").header().sets.active.front());
  const auto eval = [&](const std::string& arguments) {
    succeed("eval " + arguments + " --node " + node + " --displacement 0.004,0,-0.01 --json eval.json");
    return json("eval.json");
  };
  const auto own = eval("stiff"), scaled = eval("soft --modulus-factor 1.3333333333333333"), soft = eval("soft");
  const auto near = [](const nlohmann::json& a, const nlohmann::json& b) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(), 1e-5 * std::abs(b.get<double>()));
  };
  for (int k = 0; k < 3; ++k) near(scaled["tools"][0]["force"][k], own["tools"][0]["force"][k]);
  near(scaled["energy"], own["energy"]);
  near(scaled["fields"]["von-mises-stress"]["max"], own["fields"]["von-mises-stress"]["max"]);
  EXPECT_EQ(scaled["max_displacement"], soft["max_displacement"]);

  const auto refused = be_refused("precompute stiff.toml -o soft.h5 --resume");
  expect_names(refused.err, {"material.", "--from"});
}

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

  const auto stiffer = changed(scene(2), "poisson_ratio = 0.45", "poisson_ratio = 0.4");
  write_file(folder / "stiffer.toml", changed(stiffer, "max_displacement_m = 0.008", "max_displacement_m = 0.01"));
  const auto refused = be_refused("precompute stiffer.toml -o stiffer.h5 --from two.h5");
  expect_names(refused.err,
               {"material.", "probe.max_displacement_m", "other increments", "factor that all moduli have"});
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
  // The other way round rays are missing, and with another step all are.
  expect_names(be_refused("train three.toml part.h5 -o other").err, {"--from part.h5"});
  write_file(folder / "deeper.toml", changed(scene(1), "0.008", "0.016"));
  expect_names(be_refused("train deeper.toml three.h5 -o other").err, {"probe.max_displacement_m"});
}

TEST_F(Growth, RunMakesAgainWhatDependsOnAChange) {
  auto text = changed(scene(3), "family = \"rbfn\"", "family = \"modal\"\nmodes = 4");
  text = changed(text, "probes = 8", "probes = 8\ncalibration_rays = 100");
  const std::vector<std::string> files{"database.h5", "train.json", "calibrate.json", "validate.json"};
  const auto times = [&] {
    std::vector<std::filesystem::file_time_type> all;
    for (const auto& file : files) all.push_back(std::filesystem::last_write_time(folder / "out" / file));
    return all;
  };
  const auto run = [&](const std::string& now) {
    write_file(folder / "scene.toml", now);
    return succeed("run scene.toml -o out --resume --json all.json");
  };
  /// Runs again. @return how many of the files are as before
  const auto kept = [&](const std::string& now) {
    const auto before = times();
    run(now);
    const auto after = times();
    const auto first = std::mismatch(before.begin(), before.end(), after.begin()).first - before.begin();
    for (auto i = static_cast<std::size_t>(first); i < files.size(); ++i) EXPECT_NE(before[i], after[i]) << files[i];
    EXPECT_EQ(json("all.json").at("train").at("family"), "modal");
    return first;
  };
  run(text);
  EXPECT_EQ(kept(text), 4);
  text = changed(text, "probes = 8", "probes = 12");
  EXPECT_EQ(kept(text), 3);
  EXPECT_EQ(json("all.json").at("validate").at("probes"), 12);
  text = changed(text, "calibration_rays = 100", "calibration_rays = 120");
  EXPECT_EQ(kept(text), 2);
  succeed("run scene.toml -o anew");
  EXPECT_EQ(read_file(folder / "out/model/model.txt"), read_file(folder / "anew/model/model.txt"));
  text = changed(text, "modes = 4", "modes = 5");
  EXPECT_EQ(kept(text), 1);
  // A model that the run has not made is made again.
  succeed("calibrate out/model out/database.h5 --rays 100 --seed 2");
  EXPECT_EQ(kept(text), 1);
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
  // Half of the depth with half of the increments is there, too, and the file is left as it is.
  const auto depth = [&](const char* increments, const char* depth_m) {
    const auto text = changed(linear(2), "increments = 2", increments);
    write_file(folder / "scene.toml", changed(text, "max_displacement_m = 0.008", depth_m));
    return succeed("run scene.toml -o out --resume --json all.json");
  };
  expect_names(depth("increments = 1", "max_displacement_m = 0.004").err, {"all rays of the scene are in"});
  EXPECT_EQ(read_file(folder / "out/database.h5"), before);
  write_file(folder / "scene.toml", linear(3));
  succeed("run scene.toml -o out --resume");
  EXPECT_EQ(read_file(folder / "out/database.h5"), before);
}

}  // namespace
}  // namespace phynness::test
