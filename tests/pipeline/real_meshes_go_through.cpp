// Claim: every mesh of tests/data/meshes passes from file to validated model, and forces have the right sign. The
// settings are coarse: two nodes, three directions, two increments.
#include "command_line.hpp"

namespace phynness::test {
namespace {

struct RealMesh {
  const char *name, *file, *mesh_keys;
  double depth_m;
};

/// How the test runner names a case.
void PrintTo(const RealMesh& mesh, std::ostream* out) { *out << mesh.file; }

class RealMeshes : public CommandLine, public ::testing::WithParamInterface<RealMesh> {};

TEST_P(RealMeshes, FromFileToForce) {
  const auto& mesh = GetParam();
  const auto path = std::filesystem::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes" / mesh.file;
  write_file(folder / "scene.toml",
             "[mesh]\nfile = \"" + std::filesystem::canonical(path).string() + "\"\n" + mesh.mesh_keys +
                 "\n[material]\nlaw = \"neo-hookean\"\nc10_Pa = 250.0\nbulk_modulus_Pa = 10e3\n"
                 "[solver]\nelement = \"P1\"\n[nodes]\nfixed = { box = { min_fraction = [0,0,0], max_fraction = "
                 "[0.3,1,1] } }\n"
                 "active = [{ nearest = { point_fraction = [0.9,0.5,1] }, surface_only = true },\n"
                 "          { nearest = { point_fraction = [0.7,0.5,0.9] }, surface_only = true }]\n"
                 "[probe]\ndirections = 3\nincrements = 2\nmax_displacement_m = " +
                 std::to_string(mesh.depth_m) +
                 "\n[training]\nfamily = \"rbfn\"\ndeformation_neurons = 20\nforce_neurons = 3\nforce_spread = "
                 "2.0\nsamples = 300\n"
                 "[validation]\nprobes = 4\ncheck_probes = 0\n");
  const auto run = succeed("run scene.toml -o out");
  const auto validate = json("out/validate.json");
  EXPECT_EQ(validate.at("failed"), 0) << run.out;
}

INSTANTIATE_TEST_SUITE_P(
    All, RealMeshes,
    ::testing::Values(
        RealMesh{"liver_coarse", "own/liver_coarse.msh", "scale_to_m = 0.025", 0.006},
        RealMesh{"liver_elements", "own/liver_elements.msh", "scale_to_m = 0.1", 0.006},
        RealMesh{"liver_surface", "own/liver_surface.obj", "scale_to_m = 0.01\ntarget_size_m = 0.02", 0.006},
        RealMesh{"gallbladder", "sofa_env/gallbladder_surface.stl", "scale_to_m = 0.001\ntarget_size_m = 0.01", 0.003},
        RealMesh{"tissue_slab", "sofa_env/tissue_slab.msh", "", 0.002},
        RealMesh{"cylinder", "own/cylinder.msh", "scale_to_m = 0.1", 0.002}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace phynness::test
