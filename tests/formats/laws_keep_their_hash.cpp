// Claim: the description of a material in a database does not change.
// With others, `--resume`, training and validation would refuse existing databases.
#include "../bad_input/scene_under_test.hpp"

namespace phynness::test {
namespace {

struct Pinned {
  std::string name, law_and_moduli, lines, hash;
};

class PhysicsHashOfALaw : public testing::TestWithParam<Pinned> {};

TEST_P(PhysicsHashOfALaw, IsThatOfItsFirstDatabases) {
  const auto& [name, law_and_moduli, lines, hash] = GetParam();
  // Every choice is written out, so that no default has a part in the hash.
  const auto scene =
      parsed("[mesh]\nshape = \"block\"\ntarget_nodes = 60\nsize_m = [0.1, 0.1, 0.1]\n[material]\n" + law_and_moduli +
             "\n[solver]\nelement = \"P1\"\nrelative_tolerance = 1e-8\nmax_iterations = 40\n"
             "max_cutbacks = 6\n[nodes]\nfixed = { group = \"base\" }\nactive = \"free-surface\"\n"
             "output = \"free-surface\"\n[probe]\nkind = \"node\"\ndirections = 26\nincrements = 4\n"
             "max_displacement_m = 0.02\n");
  const auto summary = physics_summary(scene);
  const auto from = summary.find("material."), to = summary.find("solver.");
  EXPECT_EQ(summary.substr(from, to - from), lines);
  EXPECT_EQ(physics_hash(scene), hash) << summary;
}

INSTANTIATE_TEST_SUITE_P(
    Laws, PhysicsHashOfALaw,
    testing::Values(Pinned{"linear", "law = \"linear\"\nyoungs_modulus_Pa = 1500.0\npoisson_ratio = 0.45",
                           "material.law = linear\nmaterial.shear_modulus_Pa = "
                           "517.2413793103449\nmaterial.lame_lambda_Pa = 4655.172413793105\n",
                           "0e9b4e5a39e0582b"},
                    Pinned{"st_venant_kirchhoff",
                           "law = \"st-venant-kirchhoff\"\nshear_modulus_Pa = 500.0\nlame_lambda_Pa = 1234.5",
                           "material.law = st-venant-kirchhoff\nmaterial.shear_modulus_Pa = "
                           "500\nmaterial.lame_lambda_Pa = 1234.5\n",
                           "427c5741694f3019"},
                    Pinned{"neo_hookean", "law = \"neo-hookean\"\nc10_Pa = 250.0\nd1_per_Pa = 1e-5",
                           "material.law = neo-hookean\nmaterial.shear_modulus_Pa = "
                           "500\nmaterial.lame_lambda_Pa = 99666.66666666666\n",
                           "4989c0d143d16ee7"},
                    Pinned{"neo_hookean_by_youngs_modulus",
                           "law = \"neo-hookean\"\nyoungs_modulus_Pa = 1500.0\nbulk_modulus_Pa = 5e4",
                           "material.law = neo-hookean\nmaterial.shear_modulus_Pa = "
                           "501.67224080267556\nmaterial.lame_lambda_Pa = 49665.55183946488\n",
                           "e7926360f79d589f"},
                    Pinned{"mooney_rivlin", "law = \"mooney-rivlin\"\nc10_Pa = 2.0\nc01_Pa = 0.2\nd1_per_Pa = 1e-5",
                           "material.law = mooney-rivlin\nmaterial.c10_Pa = 2\nmaterial.c01_Pa = "
                           "0.2\nmaterial.bulk_modulus_Pa = 99999.99999999999\n",
                           "e1941fc003b49de4"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace phynness::test
