// Claim: the fields of a scene pass through the pipeline: they are stored, modelled by family modal, compared with both
// trivial predictors and closer to the finite elements than these, printed by eval and solve in the same columns, and
// shown. A scene without fields has the same database and model as before.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class FieldsOfAScene : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml",
               deep_scene() + "[database]\nfields = [\"energy-density\", \"von-mises-stress\"]\n");
    make_once({"precompute scene.toml -o d.h5"});
  }

  /// Two fifths of the block's height deep. In a third of that depth the body is so nearly linear that linear
  /// theory is closer to its stress than 26 directions are (docs/theory.md, "Conservative forces and modes").
  static std::string deep_scene() {
    return changed(small_scene("p1-p1", 3), "max_displacement_m = 0.008", "max_displacement_m = 0.02");
  }

  /// Rows of numbers under a header.
  std::vector<std::vector<double>> table(const std::string& name, std::string& header) const {
    std::istringstream lines(read_file(folder / name));
    std::getline(lines, header);
    std::vector<std::vector<double>> rows;
    for (std::string line; std::getline(lines, line);) {
      rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
    }
    return rows;
  }
};

TEST_F(FieldsOfAScene, AreModelledBetterThanByEitherYardstick) {
  succeed("train scene.toml d.h5 -o m --family modal --json t.json");
  succeed("validate scene.toml m --probes 80 --json v.json");
  const auto v = json("v.json");
  for (const std::string field : {"von-mises-stress", "energy-density"}) {
    EXPECT_GT(json("t.json").at("modal").at("fields").at(field).at("truncation_error").get<double>(), 0);
    for (const std::string group : {"inside", "outside"})
      for (const std::string measure : {"nodal", "l2"}) {
        const auto mean = [&](const nlohmann::json& of) {
          return of.at(group).at("fields").at(field).at(measure).at("mean").get<double>();
        };
        EXPECT_LT(mean(v), 0.6 * mean(v.at("linear"))) << field << " " << group << " " << measure;
        EXPECT_LT(mean(v), 0.25 * mean(v.at("zero"))) << field << " " << group << " " << measure;
      }
    // One over the largest: by definition of the l2 measure of nothing.
    EXPECT_DOUBLE_EQ(v.at("zero").at("inside").at("fields").at(field).at("l2").at("max").get<double>(), 1);
  }
}

TEST_F(FieldsOfAScene, AreTheSameColumnsOfEvalAndSolve) {
  succeed("train scene.toml d.h5 -o m --family modal");
  const auto tool = " --node " + std::to_string(active_of("m").at(0)) + " --displacement 0.002,0.001,-0.005";
  EXPECT_EQ(json("info.json").at("fields"), (nlohmann::json{"von-mises-stress", "energy-density"}));
  succeed("eval m" + tool + " --deformation e.csv --json e.json");
  succeed("solve d.h5" + tool + " --deformation s.csv --json s.json");
  std::string eval_header, solve_header;
  const auto eval = table("e.csv", eval_header), solve = table("s.csv", solve_header);
  EXPECT_EQ(eval_header, "node,x,y,z,ux,uy,uz,von_mises_stress_Pa,energy_density_J_per_m3");
  EXPECT_EQ(eval_header, solve_header);
  ASSERT_EQ(eval.size(), solve.size());
  for (const std::size_t column : {7u, 8u}) {
    double largest = 0, error = 0;
    for (std::size_t i = 0; i < eval.size(); ++i) {
      EXPECT_EQ(eval[i][0], solve[i][0]);
      EXPECT_GE(eval[i][column], 0);
      largest = std::max(largest, solve[i][column]);
      error += std::abs(eval[i][column] - solve[i][column]) / static_cast<double>(eval.size());
    }
    // Validation above measures it; a wrong unit or column would be wrong by the whole value.
    EXPECT_LT(error, 0.05 * largest) << column;
    const auto field = column == 7 ? "von-mises-stress" : "energy-density";
    EXPECT_DOUBLE_EQ(json("s.json").at("fields").at(field).at("max").get<double>(), largest);
  }
}

TEST_F(FieldsOfAScene, AreStoredAsSolved) {
  const auto database = Database::open(folder / "d.h5");
  const auto& header = database.header();
  ASSERT_EQ(header.fields, (std::vector<Field>{Field::von_mises_stress, Field::energy_density}));
  const auto rays = database.rays(0);
  const auto& e = header.directions[2];
  const double depth = header.magnitudes_m.back();
  std::ostringstream tool;
  tool.precision(17);
  tool << " --node " << header.sets.active[0] << " --displacement " << depth * e[0] << "," << depth * e[1] << ","
       << depth * e[2];
  succeed("solve d.h5" + tool.str() + " --deformation s.csv");
  std::string heading;
  const auto solved = table("s.csv", heading);
  const std::size_t n = solved.size(), last = header.magnitudes_m.size() - 1;
  ASSERT_EQ(n, header.sets.output.size());
  for (std::size_t f = 0; f < 2; ++f) {
    double largest = 0;
    for (const auto& row : solved) largest = std::max(largest, row[7 + f]);
    // Rounded to float32 (6e-8), and solved to 1e-8 of the reactions.
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(rays[2].fields[f][last * n + i], solved[i][7 + f], 1e-6 * largest);
  }
  const auto shown = succeed("show d.h5 --node " + std::to_string(header.sets.active[0]) + " --direction 2 -o p.pvd");
  EXPECT_NE(read_file(folder / "p-0001.vtu").find("von_mises_stress_Pa"), std::string::npos);
  EXPECT_NE(shown.err.find("stored at output nodes only"), std::string::npos) << shown.err;
}

TEST_F(FieldsOfAScene, AreLeftOutByFamiliesThatDoNotModelThem) {
  expect_names(succeed("train scene.toml d.h5 -o m --family rbfn").err,
               {"(von-mises-stress, energy-density) are not modelled"});
  succeed("validate scene.toml m --probes 8 --json v.json");
  EXPECT_FALSE(json("v.json").at("inside").contains("fields"));
}

TEST_F(FieldsOfAScene, DoNotChangeWhatTheSceneSolves) {
  write_file(folder / "plain.toml", deep_scene());
  succeed("precompute plain.toml -o p.h5");
  const auto with = Database::open(folder / "d.h5"), without = Database::open(folder / "p.h5");
  EXPECT_TRUE(without.header().fields.empty());
  EXPECT_EQ(with.header().physics_hash, without.header().physics_hash);
  for (std::int32_t a = 0; a < 2; ++a) {
    const auto these = with.rays(a), those = without.rays(a);
    for (std::size_t d = 0; d < these.size(); ++d) {
      EXPECT_EQ(these[d].force, those[d].force);
      EXPECT_EQ(these[d].displacement, those[d].displacement);
    }
  }
  expect_names(be_refused("precompute plain.toml -o d.h5 --resume").err, {"other [database] fields"});
  succeed("train plain.toml p.h5 -o p --family modal");
  EXPECT_EQ(read_file(folder / "p" / "model.txt").find("\nfield"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
