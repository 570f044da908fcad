// Claim: a reduced body with all modes and all cells stores the energy of the solved states. Its pressure has ln J and
// the stabilization at rest, the solved one J e^(-p/lambda) and that of the deformed body: the energies differ by a few
// tenths of a percent on real meshes (docs/decisions/reduced-body.md), and by up to 2 % on a block of a few cells.
#include <phynness/formats/database.hpp>
#include <phynness/training/reduction.hpp>

#include "../body_energy.hpp"
#include "command_line.hpp"

namespace phynness::test {
namespace {

class ReducedBodyCommand : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", scene());
    write_file(folder / "regions.toml",
               scene() +
                   "[[region]]\nname = \"half\"\nyoungs_modulus_Pa = 16e3\ncells = { half_space = { point_fraction = "
                   "[0.5, 0, 0], normal = [1, 0, 0] } }\n");
    make_once({"precompute scene.toml -o d.h5", "precompute regions.toml -o regions.h5"});
  }
  static std::string scene() {
    auto text = small_scene("es-p1-p1");
    return text.replace(text.find("active = "), 0, "output = \"free\"\n");
  }
};

void expect_the_energy_of_solved_states(const std::filesystem::path& file) {
  const auto database = Database::open(file);
  const auto& header = database.header();
  ReductionReport report;
  const auto body = reduce(database, {}, {400, 1'000'000, 300, 1}, report);
  const auto modes = body.modes.values();
  for (const std::int32_t active : {0, 1})
    for (const auto& ray : database.rays(active)) {
      for (std::size_t k = 0; k < header.magnitudes_m.size(); ++k) {
        if (ray.status[k] != Status::converged) continue;
        Eigen::VectorXd u = Eigen::VectorXd::Zero(modes.rows());
        for (std::size_t i = 0; i < body.nodes.size(); ++i) {
          const auto found = std::ranges::lower_bound(header.sets.output, body.nodes[i]);
          if (found == header.sets.output.end() || *found != body.nodes[i]) continue;
          const auto place = static_cast<std::size_t>(found - header.sets.output.begin());
          for (std::size_t j = 0; j < 3; ++j)
            u[static_cast<Eigen::Index>(3 * i + j)] = ray.displacement[3 * (k * header.sets.output.size() + place) + j];
        }
        const Eigen::VectorXd q = modes.completeOrthogonalDecomposition().solve(u);
        EXPECT_NEAR(energy(body, q) / ray.energy[k], 1, 0.016) << active << " " << ray.direction << " " << k;
      }
    }
}

TEST_F(ReducedBodyCommand, StoresTheEnergyOfSolvedStates) { expect_the_energy_of_solved_states(folder / "d.h5"); }

// Half of the body is 8 times as stiff: averages at edges and pressures are those of the solver, region by region.
TEST_F(ReducedBodyCommand, StoresTheEnergyOfSolvedStatesOfRegions) {
  expect_the_energy_of_solved_states(folder / "regions.h5");
  succeed("info regions.h5 --json i.json");
  const auto half = json("i.json").at("regions").at(1);
  EXPECT_NEAR(half.at("shear_modulus_Pa").get<double>(), 16e3 / 2.9, 1e-6);
  EXPECT_NEAR(half.at("volume_m3").get<double>(), 2e-4, 0.2e-4);  // cells of a quarter of its length
  const auto once = succeed("info regions.toml");
  const std::string said = once.out + once.err, name = "region half: ";
  EXPECT_TRUE(said.find(name) < said.size() && said.find(name) == said.rfind(name)) << said;
}

// Claim: a body of given size is compared with states of two tools, and one that misses its target says so.
TEST_F(ReducedBodyCommand, WritesABodyAndItsFigures) {
  const auto outcome =
      shell("PHYNNESS_PROGRESS=1 \"$PHYNNESS\" reduce d.h5 -o body.txt --modes 20 --cells 50 --json r.json");
  for (const char* unit : {" states of several tools", " steps", " compared states"})
    EXPECT_NE(outcome.err.find(unit), std::string::npos) << unit << outcome.err;
  EXPECT_TRUE(read_file(folder / "body.txt").starts_with("phynness-body 5\nmesh "));
  EXPECT_EQ(json("r.json").at("cells"), 50);
  EXPECT_EQ(json("r.json").at("body_bytes"), read_file(folder / "body.txt").size());
  EXPECT_NE(outcome.out.find("-> body.txt"), std::string::npos) << outcome.out;
  EXPECT_NE(unbroken(outcome.out).find("states where the body answers without a warning"), std::string::npos)
      << outcome.out;
  ASSERT_EQ(json("r.json").at("sizes").size(), 1u);
  const auto errors = json("r.json").at("sizes")[0].at("errors");
  succeed("info body.txt --json i.json");
  EXPECT_EQ(json("i.json").at("has_tables_at_rest"), true);
  EXPECT_EQ(json("r.json").at("sizes")[0].at("has_tables_at_rest"), true);
  EXPECT_GT(errors.at("pairs").at("n").get<int>() + errors.at("near").at("n").get<int>(), 50);
  EXPECT_NE(unbroken(succeed("reduce d.h5 -o b.txt --target-error 1e-9").err).find("1e-07 % were wanted"),
            std::string::npos);
  write_file(folder / "plain.toml", small_scene("es-p1-p1"));
  succeed("precompute plain.toml -o p.h5");
  EXPECT_NE(be_refused("reduce p.h5 -o other.txt").err.find("output = \"free\""), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "other.txt"));
}

}  // namespace
}  // namespace phynness::test
