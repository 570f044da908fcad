// Claims: in a homogeneous state the von Mises stress and the energy density at every node are those of independently
// written laws, for every law and element. The energy of the cells adds up to the stored energy in any state. A node
// has the mean of its cells, weighted by volume. The predictor of linear theory has the fields of the finite elements.
//
// The homogeneous state is represented exactly (p1-p1: the stabilization vanishes for a constant pressure), and a cell
// is integrated exactly. The tolerance of 1e-12 is the rounding of a stress that is a difference of terms up to 10
// times larger.
#include "body_states.hpp"
#include "probe_block.hpp"
#include "solve/nodal_fields.hpp"

namespace phynness::test {
namespace {

constexpr double rounding = 1e-12;
const std::vector<Field> both{Field::von_mises_stress, Field::energy_density};

double von_mises(const Eigen::Matrix3d& stress) {
  const Eigen::Matrix3d s = stress - stress.trace() / 3 * Eigen::Matrix3d::Identity();
  return std::sqrt(1.5) * s.norm();
}

/// sigma = P F^T / J; the theory of small strains knows no other stress than P.
Eigen::Matrix3d cauchy(const Material& m, const Eigen::Matrix3d& F) {
  const Eigen::Matrix3d P = first_piola(m, F);
  return m.law->linear ? P : Eigen::Matrix3d(P * F.transpose() / F.determinant());
}

Mesh irregular_block(std::uint64_t seed) {
  Random random(seed);
  return irregular(block_mesh({2, 2, 2}, {1, 1.2, 0.9}), 0.08, random);
}

class Fields : public ::testing::TestWithParam<Case> {};

TEST_P(Fields, OfAHomogeneousStateAreTheClosedForms) {
  const auto material = unit_material(GetParam().law, 10);
  const auto mesh = irregular_block(11);
  const Discretization body(mesh, form_set(material, GetParam().element, 1));
  const NodalFields fields(body, both);
  Eigen::Matrix3d sheared, stretched = Eigen::Vector3d(1.5, 0.85, 0.8).asDiagonal();
  sheared << 1.1, 0.3, -0.1, 0.05, 0.9, 0.2, -0.15, 0.1, 1.05;
  for (const auto& F : {sheared, stretched}) {
    const auto values = fields.at_nodes(body, homogeneous_state(body, material, F));
    const double stress = von_mises(cauchy(material, F)), energy = energy_density(material, F);
    ASSERT_GT(stress, 0.3);  // sizeable, or the tolerance means little
    ASSERT_GT(energy, 0.05);
    ASSERT_EQ(values.rows(), mesh.n_nodes());
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      EXPECT_NEAR(values(i, 0), stress, rounding * 10 * stress);
      EXPECT_NEAR(values(i, 1), energy, rounding * 10 * energy);
    }
  }
}

TEST_P(Fields, AreZeroAtRest) {
  const auto material = unit_material(GetParam().law, 10);
  const auto mesh = irregular_block(12);
  const Discretization body(mesh, form_set(material, GetParam().element, 1));
  const auto values = NodalFields(body, both).at_nodes(body, std::vector<double>(body.n_dofs(), 0.0));
  // F = I holds in the arithmetic of most cells; its error, 1e-16 of strain, is all there is, times moduli up to 10.
  EXPECT_LT(values.cwiseAbs().maxCoeff(), 1e-13);
}

// Of mixed elements the two integrands differ everywhere; what their integrals differ by is the pressure
// equations, times p: a residual of 1e-11 of the reactions, which are of the size of the energy here.
TEST_P(Fields, EnergyOfTheCellsAddsUpToTheStoredEnergyAtEquilibrium) {
  const auto material = unit_material(GetParam().law, 10);
  const auto mesh = irregular_block(13);
  Discretization body(mesh, form_set(material, GetParam().element, 1));
  SolverSpec spec;
  spec.element = GetParam().element;
  spec.relative_tolerance = 1e-11;
  std::vector<std::int32_t> held;
  for (int p = 0; p < body.n_points(); ++p)
    if (body.points()(p, 0) == 0) held.insert(held.end(), body.dofs(p).begin(), body.dofs(p).end());
  Equilibrium equilibrium(body, held, spec);
  const auto load = dead_traction(body, mesh, {0.02, 0.03, -0.06}, [](const Vector3& X) { return X[0] == 1; });
  std::vector<double> state(body.n_dofs(), 0.0);
  solve_in_steps(body, equilibrium, load, 4, state);
  const auto means = NodalFields(body, {Field::energy_density}).in_cells(body, state);
  double sum = 0, total_volume = 0;
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    sum += means(cell, 0) * body.cell_volume(cell);
    total_volume += body.cell_volume(cell);
  }
  EXPECT_GT(sum, 1e-4);
  EXPECT_NEAR(sum, body.energy(state), 1e-9 * sum);
  EXPECT_NEAR(total_volume, volume(mesh), rounding * total_volume);
  EXPECT_GE(means.minCoeff(), 0);
}

/// Any displacement, any pressure; J > 0 everywhere.
std::vector<double> rough_state(const Discretization& body, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> state(body.n_dofs());
  for (auto& value : state) value = 0.02 * random();
  return state;
}

TEST_P(Fields, OfANodeAreTheMeanOfItsCellsByVolume) {
  const auto material = unit_material(GetParam().law, 10);
  const auto mesh = irregular_block(15);
  const Discretization body(mesh, form_set(material, GetParam().element, 1));
  const auto state = rough_state(body, 16);
  const NodalFields fields(body, both);
  const auto cells = fields.in_cells(body, state), nodes = fields.at_nodes(body, state);
  // The cells of a node are looked up in the mesh that went in, by their four corners.
  std::map<std::array<std::int32_t, 4>, int> number;
  const auto sorted = [](std::array<std::int32_t, 4> corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  for (int cell = 0; cell < body.n_cells(); ++cell) number[sorted(body.cell_nodes(cell))] = cell;
  for (std::int32_t node = 0; node < mesh.n_nodes(); ++node) {
    Eigen::RowVector2d sum(0, 0);
    double weights = 0;
    for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c) {
      const auto row = mesh.cells.row(c);
      if ((row.array() != node).all()) continue;
      Eigen::Matrix3d edges;
      for (int i = 0; i < 3; ++i) edges.row(i) = mesh.nodes.row(row[i + 1]) - mesh.nodes.row(row[0]);
      const double cell_volume = edges.determinant() / 6;
      sum += cell_volume * cells.row(number.at(sorted({row[0], row[1], row[2], row[3]})));
      weights += cell_volume;
    }
    EXPECT_LT((nodes.row(node) - sum / weights).norm(), rounding * nodes.row(node).norm());
  }
  // A rough state, or any way of averaging would do.
  EXPECT_GT((nodes.col(0).array() - nodes.col(0).mean()).abs().maxCoeff(), 0.1 * nodes.col(0).mean());
}

INSTANTIATE_TEST_SUITE_P(Laws, Fields, ::testing::ValuesIn(every_case()), case_name);

class FieldsOfElement : public ::testing::TestWithParam<Element> {};

// Closed forms that share nothing with first_piola(): St. Venant-Kirchhoff at stretch 2 with lateral stretch
// sqrt(0.1) carries P = 3 (E = 1, nu = 0.3), so sigma = P / 0.1 = 30 alone along the bar; a Hookean bar at
// strain 0.2 carries E 0.2 and stores E 0.2^2 / 2.
TEST_P(FieldsOfElement, InABarTheVonMisesStressIsTheAxialOne) {
  const auto mesh = irregular_block(17);
  const auto stress_and_energy = [&](const Material& material, const Eigen::Matrix3d& F) {
    const Discretization body(mesh, form_set(material, GetParam(), 1));
    const auto values = NodalFields(body, both).at_nodes(body, homogeneous_state(body, material, F));
    return Eigen::Vector2d(values.row(0).transpose());
  };
  const Eigen::Matrix3d doubled = Eigen::Vector3d(2, std::sqrt(0.1), std::sqrt(0.1)).asDiagonal();
  EXPECT_NEAR(stress_and_energy(hookean(law_named("st-venant-kirchhoff"), 1, 0.3), doubled)[0], 30, 30 * rounding * 10);
  const Eigen::Matrix3d strained = Eigen::Vector3d(1.2, 0.94, 0.94).asDiagonal();
  const auto bar = stress_and_energy(hookean(law_named("linear"), 1, 0.3), strained);
  EXPECT_NEAR(bar[0], 0.2, 0.2 * rounding * 10);
  EXPECT_NEAR(bar[1], 0.02, 0.02 * rounding * 10);
}

INSTANTIATE_TEST_SUITE_P(Elements, FieldsOfElement, ::testing::ValuesIn(every_element), element_name);

ProbeBlock with_fields(const Case& c) {
  auto block = probe_block(c, 10, {2, 2, 2});
  block.scene.database.fields = both;
  return block;
}

/// Largest difference of a field of the predictor from the finite elements', over the largest value.
Eigen::Vector2d difference(ProbeSolver& solver, const Vec3& d) {
  const auto response = solver.solve({d}, 1);
  EXPECT_EQ(response.status, Status::converged);
  const auto linear = solver.linear_fields({d});
  Eigen::Vector2d largest;
  for (int f = 0; f < 2; ++f) {
    EXPECT_GT(response.fields.col(f).minCoeff(), -1e-12 * response.fields.col(f).maxCoeff());
    largest[f] = (linear.col(f) - response.fields.col(f)).cwiseAbs().maxCoeff() / response.fields.col(f).maxCoeff();
  }
  return largest;
}

class LinearFields : public ::testing::TestWithParam<Element> {};

TEST_P(LinearFields, AreExactWhereTheLawIsLinear) {
  const auto block = with_fields({law_named("linear"), GetParam()});
  auto solver = block.touched();
  // The solver's tolerance, 1e-8 of forces, is what remains.
  for (const Vec3& d : {Vec3{0.004, 0.002, -0.008}, Vec3{0, 0.03, 0.02}})
    EXPECT_LT(difference(solver, d).maxCoeff(), 1e-6);
}

TEST_P(LinearFields, AreTheLimitOfSmallDisplacements) {
  const auto block = with_fields({law_named("neo-hookean"), GetParam()});
  auto solver = block.touched();
  const auto far = difference(solver, {0.002, 0, -0.004}), near = difference(solver, {0.0002, 0, -0.0004});
  for (int f = 0; f < 2; ++f) {
    // A tenth of the displacement, a tenth of the error: 8 to 12 leaves room for the next order.
    EXPECT_GT(far[f] / near[f], 8) << name(every_field[static_cast<std::size_t>(f)]);
    EXPECT_LT(far[f] / near[f], 12) << name(every_field[static_cast<std::size_t>(f)]);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, LinearFields, ::testing::ValuesIn(every_element), element_name);

}  // namespace
}  // namespace phynness::test
