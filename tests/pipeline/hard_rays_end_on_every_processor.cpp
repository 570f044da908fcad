// Claim: a ray whose tangent cannot be factorized with the OpenBLAS kernels of this processor is solved in another way
// and does not slow down the others. Messages of PETSc are not printed.
//
// Node 163 of the paper's liver with p1-p1 elements (K/mu = 200, node probe to 28 mm), direction 6: with the kernels
// for SkylakeX, LDL^T without pivoting finds a zero pivot. All 156 increments have an equilibrium.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class HardRays : public CommandLine, public ::testing::WithParamInterface<const char*> {};

TEST_P(HardRays, OfThePapersLiverAreSolved) {
#if defined(__x86_64__)
  if (std::string(GetParam()) == "SkylakeX" && !__builtin_cpu_supports("avx512f"))
    GTEST_SKIP() << "this processor has no AVX-512";
#endif
  auto scene = read_file(PHYNNESS_SOURCE_DIR "/scenes/liver_case3.toml");
  const auto replace = [&](const std::string& from, const std::string& to) {
    const auto at = scene.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    scene.replace(at, scene.find('\n', at) - at, to);
  };
  replace("element =", "element = \"p1-p1\"");
  replace("active =", "active = { nodes = [163] }");
  write_file(folder / "scene.toml", scene);
  const auto outcome =
      shell(std::string("OPENBLAS_CORETYPE=") + GetParam() + " \"$PHYNNESS\" precompute scene.toml -o d.h5");
  EXPECT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_EQ((outcome.out + outcome.err).find("PETSC ERROR"), std::string::npos) << outcome.err;
  const auto states = summarize(Database::open(folder / "d.h5")).states;
  EXPECT_EQ(states.at(Status::converged), 156);
  EXPECT_EQ(states.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Kernels, HardRays, ::testing::Values("SkylakeX", "Haswell", "Prescott"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace phynness::test
