// Claim: a scene of 1 mm or 1 m with moduli of 1 Pa or 1 GPa, those of a region with them, gives the same results from
// its text on: mesh, selections, steps, forces, displacements. The program contains no length or modulus of its own.
//
// The solver works with dimensionless values, so that iterates differ only by the rounding of the change of units. The
// tolerance of 1e-8 is that of the scenes, which limits the precision of all results.
#include <gtest/gtest.h>

#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <sstream>

#include "solver_cases.hpp"

namespace phynness::test {
namespace {

constexpr double same = 1e-8;

std::string scene_text(const Case& c, double edge_m, double modulus_Pa) {
  std::ostringstream text;
  text.precision(17);
  const std::string region = scene_lines(times(8 * modulus_Pa, unit_material(c.law, 30)));
  text << "[mesh]\nshape = \"block\"\nsize_m = [" << edge_m << ", " << 0.8 * edge_m << ", " << 0.6 * edge_m
       << "]\ntarget_size_m = " << 0.35 * edge_m << "\n"
       << scene_lines(times(modulus_Pa, unit_material(c.law, 50)))
       << "[[region]]\nname = \"part\"\ncells = { box = { min_fraction = [0.5, 0, 0], max_fraction = [1, 1, 1] } }"
       << region.substr(region.find('\n', region.find("law"))) << "[solver]\nelement = \"" << name(c.element)
       << "\"\n[nodes]\nfixed = { box = { min_fraction = [0, 0, 0], max_fraction = [1, 1, 0.01] } }\n"
       << "active = { nearest = { point_fraction = [0.4, 0.6, 1] }, surface_only = true }\n"
       << "[probe]\nkind = \"patch\"\ntool_radius_m = " << 0.4 * edge_m << "\nmax_displacement_m = " << 0.06 * edge_m
       << "\n";
  return text.str();
}

/// Without dimension.
struct Answer {
  Mesh mesh;
  NodeSets sets;
  std::vector<Eigen::Vector3d> forces;
  std::vector<Points> displacements;
  std::vector<int> iterations;
};

Answer answer(const Case& c, double edge_m, double modulus_Pa) {
  const Scene scene = parse_scene(scene_text(c, edge_m, modulus_Pa), "units.toml", ".");
  Answer a;
  a.mesh = make_mesh(scene).mesh;
  a.sets = resolve_selections(scene, a.mesh);
  ProbeSolver solver(scene, a.mesh, a.sets);
  solver.touch(a.sets.active);
  const double d = scene.probe.max_displacement_m;
  for (const Vec3& e : {Vec3{0.6, 0, -0.8}, Vec3{0, 0.8, 0.6}}) {
    const auto r = solver.solve({{d * e[0], d * e[1], d * e[2]}}, 2);
    EXPECT_EQ(r.status, Status::converged) << edge_m << " m, " << modulus_Pa << " Pa";
    a.forces.push_back(Eigen::Vector3d::Map(r.force_N[0].data()) / (modulus_Pa * edge_m * edge_m));
    a.displacements.push_back(r.displacement_m / edge_m);
    a.iterations.push_back(r.iterations);
  }
  a.mesh.nodes /= edge_m;
  return a;
}

class Units : public ::testing::TestWithParam<Case> {};

TEST_P(Units, DoNotMatter) {
  if (!PHYNNESS_TEST_GMSH) GTEST_SKIP() << "built without gmsh";
  const auto reference = answer(GetParam(), 0.1, 500);
  ASSERT_GT(reference.forces[0].norm(), 0.01);
  for (const double edge_m : {1e-3, 1.0})
    for (const double modulus_Pa : {1.0, 1e9}) {
      const auto other = answer(GetParam(), edge_m, modulus_Pa);
      ASSERT_EQ(other.mesh.cells, reference.mesh.cells);
      EXPECT_LT((other.mesh.nodes - reference.mesh.nodes).norm(),
                1e-12);  // gmsh works in units of the edge length
      EXPECT_EQ(other.sets.fixed, reference.sets.fixed);
      EXPECT_EQ(other.sets.active, reference.sets.active);
      EXPECT_EQ(other.iterations, reference.iterations);
      for (std::size_t i = 0; i < other.forces.size(); ++i) {
        EXPECT_LT((other.forces[i] - reference.forces[i]).norm(), same * reference.forces[i].norm());
        EXPECT_LT((other.displacements[i] - reference.displacements[i]).norm(),
                  same * reference.displacements[i].norm());
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Laws, Units,
                         ::testing::ValuesIn(cases({{"neo-hookean", {"P1", "p1-p1", "es-p1-p1"}},
                                                    {"mooney-rivlin", {"taylor-hood"}},
                                                    {"st-venant-kirchhoff", {"P2"}},
                                                    {"linear", {"P1"}}})),
                         case_name);

}  // namespace
}  // namespace phynness::test
