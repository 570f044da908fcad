// Claim: the scene of a shell passes through the whole pipeline: mesh, precompute, train, validate. The model is closer
// to new finite element solves than linear theory, and all texts refer to a shell.
#include <cmath>
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Shells : public CommandLine {
 protected:
  /// A drain of some 60 nodes, thickness over edge 1/10, K/mu = 200, two nodes beside the slit.
  static std::string small_drain(int directions = 26, int increments = 3) {
    return "title = \"small drain\"\n"
           "[mesh]\nshape = \"drain\"\ntarget_size_m = 0.006\nlength_m = 0.03\n"
           "[material]\nlaw = \"mooney-rivlin\"\nc10_Pa = 2.0\nc01_Pa = 0.2\nbulk_modulus_Pa = 880.0\n"
           "[nodes]\nfixed = [{ box = { min_fraction = [0, 0, 0], max_fraction = [1, 1, 0.01] } },\n"
           "         { box = { min_fraction = [0, 0, 0.99], max_fraction = [1, 1, 1] } }]\n"
           "active = [{ nearest = { point_fraction = [0.9, 0.8, 0.35] } },\n"
           "          { nearest = { point_fraction = [0.9, 0.8, 0.65] } }]\n"
           "[probe]\ndirections = " +
           std::to_string(directions) + "\nincrements = " + std::to_string(increments) +
           "\nmax_displacement_m = 0.0015\n"
           "[training]\nfamily = \"rbfn\"\ndeformation_neurons = 200\ndeformation_spread = 1.0\nforce_neurons = "
           "40\nforce_spread = 2.0\nsamples = 3000\n"
           "[validation]\nprobes = 12\ncheck_probes = 0\n";
  }

  void write_scene(const std::string& text) const { write_file(folder / "scene.toml", text); }
};

double mean(const nlohmann::json& errors, const char* what) {
  return errors.at("inside").at(what).at("mean").get<double>();
}

TEST_F(Shells, GoThroughThePipeline) {
  write_scene(small_drain());
  const auto mesh = succeed("mesh scene.toml -o drain.msh --json mesh.json");
  EXPECT_NE(mesh.out.find("triangles of a shell 0.5 mm thick"), std::string::npos) << mesh.out;
  EXPECT_EQ(json("mesh.json").at("tetrahedra"), 0);
  EXPECT_GT(json("mesh.json").at("shell_triangles"), 60);
  // A file of an open surface can be that of a shell only.
  const auto file = succeed("info drain.msh --json file.json");
  EXPECT_NE(file.out.find("triangles of an open surface"), std::string::npos) << file.out;
  expect_names(unbroken(file.err), {"the surface is open", " open edges (nodes ", "remedy: close the holes"});
  EXPECT_EQ(json("file.json").at("mesh_hash"), json("mesh.json").at("mesh_hash"));

  const auto precompute = succeed("precompute scene.toml -o d.h5");
  const auto info = phynness("info d.h5 --json info.json");
  EXPECT_NE(info.out.find("triangles of a shell"), std::string::npos) << info.out;
  EXPECT_EQ(info.out.find("tetra"), std::string::npos) << info.out;
  EXPECT_EQ(json("info.json").at("states").at("converged"), 2 * 26 * 3);
  const auto node = json("info.json").at("active").at(0).dump();

  for (const std::string family : {"rbfn", "modal"}) {
    const auto model = "m_" + family;
    const auto train = succeed("train scene.toml d.h5 -o " + model + " --family " + family);
    EXPECT_NE(phynness("info " + model).out.find("triangles of a shell"), std::string::npos);
    const auto validate = succeed("validate scene.toml " + model + " --json v.json --report r.html");
    EXPECT_NE(validate.out.find("uN"), std::string::npos) << "forces of micronewtons: " << validate.out;
    EXPECT_EQ(read_file(folder / "r.html").find("etrahedra"), std::string::npos);
    const auto v = json("v.json");
    EXPECT_EQ(v.at("failed"), 0);
    // A thin wall bends in directions of its own: linear theory is 3.3 % off, the models 0.1 and 0.3 %.
    EXPECT_GT(mean(v.at("linear"), "force"), 0.02) << "a body this linear tells nothing";
    EXPECT_LT(mean(v, "force"), 0.3 * mean(v.at("linear"), "force")) << family;
    EXPECT_LT(mean(v, "displacement"), 0.6 * mean(v.at("zero"), "displacement")) << family;
    // The paper's networks have 78 responses of a node to go by, and meet its displacement worse than linear theory.
    if (family == "modal") {
      EXPECT_LT(mean(v, "displacement"), 0.3 * mean(v.at("linear"), "displacement"));
    }
  }

  // A fresh solve in no direction that was trained: 2 % is several times what validation finds at worst.
  const auto tool = " --node " + node + " --displacement 0.0005,-0.0009,0.0002";
  succeed("eval m_modal" + tool + " --json e.json");
  succeed("solve d.h5" + tool + " --json s.json");
  const auto modelled = json("e.json").at("tools").at(0).at("force").get<std::vector<double>>(),
             solved = json("s.json").at("tools").at(0).at("force").get<std::vector<double>>();
  const double size = std::hypot(solved[0], solved[1], solved[2]);
  EXPECT_GT(size, 0);
  EXPECT_LT(std::hypot(modelled[0] - solved[0], modelled[1] - solved[1], modelled[2] - solved[2]), 0.02 * size);
  // Energy is the work of the way: at most the final force along it where the wall stiffens, more where it softens.
  EXPECT_GT(json("s.json").at("energy").get<double>(), 0);

  const auto shown = succeed("show d.h5 --node " + node + " --direction 0 -o shown.pvd");
  EXPECT_NE((shown.out + shown.err).find("triangles"), std::string::npos) << shown.out << shown.err;
}

TEST_F(Shells, OfTheLinearLawAreExact) {
  auto scene = changed(small_drain(3, 1), "\"mooney-rivlin\"\nc10_Pa = 2.0\nc01_Pa = 0.2\nbulk_modulus_Pa = 880.0",
                       "\"linear\"\nyoungs_modulus_Pa = 13.0\npoisson_ratio = 0.49");
  scene = changed(scene, "\"rbfn\"", "\"linear\"");
  write_scene(scene);
  const auto run = succeed("run scene.toml -o out");
  for (const char* group : {"inside", "outside"}) {
    // The solver's tolerance; float32 in the database, twice.
    EXPECT_LT(json("out/validate.json").at(group).at("force").at("max"), 1e-7);
    EXPECT_LT(json("out/validate.json").at(group).at("displacement").at("max"), 1e-6);
  }
}

TEST_F(Shells, PatchesAndPairsOfToolsAreSolved) {
  write_scene(changed(small_drain(3, 1), "[probe]", "[probe]\nkind = \"patch\"\ntool_radius_m = 0.006"));
  succeed("precompute scene.toml -o d.h5");
  const auto database = Database::open(folder / "d.h5");
  const auto& active = database.header().sets.active;
  const auto node = std::to_string(active[0]);
  succeed("solve d.h5 --node " + node + " --displacement 0,0.0015,0 --json s.json");
  const auto once = database.rays(0)[1].force;
  const auto again = json("s.json").at("tools").at(0).at("force").get<std::vector<double>>();
  const double size = std::hypot(once[0], once[1], once[2]);
  EXPECT_GT(size, 0);
  // Both solves stop at 1e-8 of the reactions; the force follows with the norm of the sensitivities.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(again[k], once[k], 1e-6 * size);
  // Two tools at once: the energy is the work of both forces, half of it where the body is nearly linear.
  const auto tools = " --node " + node + " --displacement 0,-0.00001,0 --node " + std::to_string(active[1]) +
                     " --displacement 0.00001,0,0";
  const auto solve = succeed("solve d.h5" + tools + " --json p.json");
  const auto force = [&](std::size_t tool, std::size_t k) {
    return json("p.json").at("tools").at(tool).at("force").at(k).get<double>();
  };
  const double work = (1e-5 * force(1, 0) - 1e-5 * force(0, 1)) / 2;
  EXPECT_GT(work, 0);
  // A hundredth of a millimetre: what is not linear is of the order of the displacement over the thickness, 2 %.
  EXPECT_NEAR(json("p.json").at("energy").get<double>(), work, 0.02 * work);
}

}  // namespace
}  // namespace phynness::test
