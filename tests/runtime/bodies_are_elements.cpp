// A reduced body whose modes are all displacements of the nodes of a block and whose cells are all tetrahedra, each
// with its pressure, is the body of linear elements itself: energies, forces and tools are known without the runtime.
#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>

#include <Eigen/Dense>
#include <cctype>
#include <limits>
#include <phynness/formats/body.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/schema/body_grammar.hpp>

#include "../block_body.hpp"
#include "body/body.hpp"
#include "changed_text.hpp"
#include "core/kernels.hpp"
#include "loaded_body.hpp"

namespace phynness::test {
namespace {

constexpr double radius = block_radius, depth = block_depth;
/// Tables of 16 bits round a value by up to 1/65534 of the largest of its column.
constexpr double rounding = 2e-4;

/// On the top, around (0.06, 0.06, 0.03) and 1.2 radii from it.
std::vector<phn_tool> two_tools(const Mesh& mesh, double scale) {
  return {tool_at(nearest_on_surface(mesh.nodes, mesh.surface, {0.055, 0.06, 0.03}),
                  scale * depth * Eigen::Vector3d(0.2, 0.1, -0.6)),
          tool_at(nearest_on_surface(mesh.nodes, mesh.surface, {0.09, 0.08, 0.03}),
                  scale * depth * Eigen::Vector3d(-0.3, 0.2, 0.4))};
}

/// That forces are those of the energy, at the tools that are pressed.
void expect_derivatives(LoadedBody& loaded, const std::vector<phn_tool>& tools) {
  const auto forces = loaded.force;
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      constexpr double h = 1e-3 * depth;  // the error is of its square, and rounding far below
      double energy[2];
      for (const int side : {0, 1}) {
        auto moved = tools;
        moved[t].displacement[k] += side == 0 ? -h : h;
        ASSERT_EQ(loaded.press(moved), PHN_OK);
        energy[side] = loaded.pressed.energy;
      }
      EXPECT_NEAR((energy[1] - energy[0]) / (2 * h), forces[t][static_cast<Eigen::Index>(k)], 1e-4 * forces[0].norm());
    }
}

/// Second derivatives at rest of the sum of the shape's energy over the cells.
Eigen::MatrixXd stiffness_of_shape(const Block& block) {
  const Eigen::MatrixXd gradients = block.body.gradients.values();
  const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double value, first[9];
  Eigen::Matrix<double, 9, 9> second;
  EXPECT_TRUE(
      runtime::find_body_law("mooney-rivlin")->shape(F, block.material.parameters.data(), value, first, second.data()));
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(gradients.cols(), gradients.cols());
  for (Eigen::Index c = 0; c < block.mesh.n_cells(); ++c) {
    const auto rows = gradients.middleRows(9 * c, 9);
    sum += block.body.shear_m3[static_cast<std::size_t>(c)] * rows.transpose() * second * rows;
  }
  return sum;
}

// Claim: the energy is that of the law file in all tetrahedra, and forces are its derivatives by the displacements of
// the tools; of linear elements with isochoric laws.
TEST(Bodies, HaveTheEnergyOfTheirElements) {
  for (const char* law : {"mooney-rivlin", "gent"}) {
    const Block block(law);
    LoadedBody loaded(write_body_text(block.body));
    ASSERT_EQ(loaded.status, PHN_OK) << phn_status_message(loaded.status);
    const auto tools = two_tools(block.mesh, 1);
    ASSERT_EQ(loaded.press(tools), PHN_OK);
    EXPECT_NEAR(block.energy(loaded.deformation()), loaded.pressed.energy, rounding * loaded.pressed.energy);
    expect_derivatives(loaded, tools);
  }
}

// Claim: cells of a region have its parameters; a region with those of the body changes no bit.
TEST(Bodies, HaveTheParametersOfTheirRegions) {
  Block block;
  const auto tools = two_tools(block.mesh, 1);
  LoadedBody plain(write_body_text(block.body));
  ASSERT_EQ(plain.press(tools), PHN_OK);
  Material stiff = material_of(block.material.law, {{"c10_Pa", 1600}, {"c01_Pa", 20}, {"bulk_modulus_Pa", 8e3}});
  const auto with_region = [&](const Material& material) {
    ReducedBody body = block.body;
    body.regions.resize(1, std::ssize(material.parameters) + 1);
    body.regions << Eigen::Map<const Eigen::RowVectorXd>(material.parameters.data(), std::ssize(material.parameters)),
        0;
    for (std::int32_t c = 0; c < block.mesh.n_cells(); ++c) {
      body.region_of_cell.push_back(c % 2);
      if (c % 2 == 1)
        body.bulk_rJ[static_cast<std::size_t>(c)] = std::sqrt(material.bulk_modulus_Pa * block.volume_of(c));
    }
    return write_body_text(body);
  };
  LoadedBody same(with_region(block.material)), loaded(with_region(stiff));
  ASSERT_EQ(same.press(tools), PHN_OK);
  EXPECT_EQ(same.pressed.energy, plain.pressed.energy);
  EXPECT_EQ(same.force[1], plain.force[1]);
  ASSERT_EQ(loaded.press(tools), PHN_OK);
  EXPECT_GT(loaded.pressed.energy, 1.2 * plain.pressed.energy);
  const Eigen::VectorXd u = loaded.deformation();
  double energy = 0;
  for (Eigen::Index c = 0; c < block.mesh.n_cells(); ++c)
    energy += block.volume_of(c) *
              energy_density(c % 2 == 1 ? stiff : block.material, Eigen::Matrix3d::Identity() + block.gradient(c, u));
  EXPECT_NEAR(energy, loaded.pressed.energy, rounding * energy);
  expect_derivatives(loaded, tools);
  const std::string text = with_region(stiff);
  EXPECT_EQ(write_body_text(read_body_text(text, "body.txt")), text);
}

// Claim: bounds are those of formats/body.md, and without them, or without tools, there are none.
TEST(Bodies, HaveTheBoundsOfThePage) {
  Block block;
  block.body.bounds = (Eigen::MatrixXd(3, 4) << -1, 0.2, 0.3, 0.4, -2, 0.1, 0.5, 0.3, -3, 0.3, 0.2, 0.1).finished();
  block.body.coverage = 0.95;
  block.body.n_rays = 20;
  LoadedBody loaded(write_body_text(block.body));
  ASSERT_EQ(loaded.status, PHN_OK);
  double bounds[] = {-1, -1, -1};
  EXPECT_EQ(phn_body_bound(loaded.body, loaded.state, 0, bounds), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(phn_body_bound(loaded.body, nullptr, 2, bounds), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(bounds[0], PHN_NO_BOUND);
  EXPECT_EQ(bounds[1], PHN_NO_BOUND);
  const Eigen::MatrixXd stiffness = stiffness_of_shape(block), modes = block.body.modes.values();
  const auto at_corner = [&](double scale) {
    return tool_at(nearest_on_surface(block.mesh.nodes, block.mesh.surface, {0.03, 0.02, 0.03}),
                   scale * depth * Eigen::Vector3d(0.1, 0.3, -0.2));
  };
  for (const std::size_t n : {1, 2, 3}) {
    auto tools = two_tools(block.mesh, 1), small = two_tools(block.mesh, 1e-4);
    tools.push_back(at_corner(1));
    tools.resize(n);
    small.resize(1);
    ASSERT_EQ(loaded.press(small), PHN_OK);
    const Eigen::Vector3d linear = n == 1 ? Eigen::Vector3d(1e4 * loaded.force[0]) : Eigen::Vector3d::Zero();
    ASSERT_EQ(loaded.press(tools), PHN_OK);
    const auto n_tools = static_cast<std::int32_t>(n);
    bounds[0] = 0;
    EXPECT_EQ(phn_body_bound(loaded.body, loaded.state, n_tools % 3 + 1, bounds), PHN_ERROR_ARGUMENT);
    EXPECT_EQ(bounds[0], PHN_NO_BOUND);
    ASSERT_EQ(phn_body_bound(loaded.body, loaded.state, n_tools, bounds), PHN_OK);
    const Eigen::VectorXd q = modes.colPivHouseholderQr().solve(loaded.deformation());
    const Eigen::Index half = q.size() - q.size() / 2;
    double square = 0;
    for (const auto& tool : tools) square += Eigen::Map<const Eigen::Vector3d>(tool.displacement).squaredNorm();
    const double last = q.tail(half).dot(stiffness.bottomRightCorner(half, half) * q.tail(half)) / 2;
    double terms[9];
    ASSERT_EQ(phn_body_bound_terms(loaded.body, loaded.state, n_tools, terms), PHN_OK);
    for (std::size_t t = 0; t < n; ++t) {
      const double expected[] = {last / std::sqrt(square), (loaded.force[t] - linear).norm(),
                                 loaded.pressed.energy / std::sqrt(square)};
      const auto c = block.body.bounds.row(static_cast<Eigen::Index>(n) - 1);
      double sum = c[0];
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(terms[3 * t + k], expected[k], 1e-3 * expected[k]);  // the small tools bend the body a little
        sum += c[static_cast<Eigen::Index>(k) + 1] * std::log(terms[3 * t + k]);
      }
      EXPECT_NEAR(bounds[t], std::exp(sum), 1e-9 * bounds[t]);
    }
  }
  // A spring joins the first two, although they move alike.
  auto tools = two_tools(block.mesh, 1);
  tools[1] = tools[0];
  tools.push_back(at_corner(1));
  ASSERT_EQ(loaded.press(tools), PHN_WARNING_NEAR);
  ASSERT_EQ(phn_body_bound(loaded.body, loaded.state, 3, bounds), PHN_WARNING_NEAR);
  for (const double bound : bounds) EXPECT_EQ(bound, PHN_NO_BOUND);
  LoadedBody without(write_body_text(Block().body));
  ASSERT_EQ(without.press(two_tools(block.mesh, 1)), PHN_OK);
  bounds[1] = 0;
  EXPECT_EQ(phn_body_bound(without.body, without.state, 2, bounds), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(bounds[1], PHN_NO_BOUND);
}

// Claim: tables of the energy at rest make a body whose cells have wrong weights the one with right ones where it is
// hardly deformed, and elsewhere forces are derivatives of the energy.
TEST(Bodies, AreExactNearRest) {
  Block block;
  LoadedBody right(write_body_text(block.body));
  Random random(5);
  const Eigen::MatrixXd of_all = stiffness_of_shape(block);
  for (double& weight : block.body.shear_m3) weight *= 1 + 0.5 * random();
  const Eigen::MatrixXd of_cells = stiffness_of_shape(block);
  LoadedBody wrong(write_body_text(block.body));
  block.body.cells_at_rest = scaled_table(of_cells);
  block.body.lack_at_rest = scaled_table(of_all - of_cells);
  LoadedBody scaled(write_body_text(block.body));
  ASSERT_EQ(scaled.status, PHN_OK);
  const auto tools = two_tools(block.mesh, 1e-3);
  for (LoadedBody* loaded : {&right, &wrong, &scaled}) ASSERT_EQ(loaded->press(tools), PHN_OK);
  // What is curved is some thousandths of what is not, and half of it is wrong.
  EXPECT_LT((scaled.force[0] - right.force[0]).norm(), 2e-3 * right.force[0].norm());
  EXPECT_GT((wrong.force[0] - right.force[0]).norm(), 1e-2 * right.force[0].norm());
  const auto far = two_tools(block.mesh, 1);
  ASSERT_EQ(scaled.press(far), PHN_OK);
  expect_derivatives(scaled, far);
}

// Claim: a tool holds the mean of the surface under it with the weights of the host, which halves triangles at the rim
// down to 0.4 % of the radius; also beside fixed nodes and over an edge of the block.
TEST(Bodies, HoldTheMeanUnderATool) {
  const Block block;
  LoadedBody loaded(write_body_text(block.body));
  Random random(1);
  for (int draw = 0; draw < 30; ++draw) {
    const auto at = nearest_on_surface(block.mesh.nodes, block.mesh.surface,
                                       {0.06 + 0.06 * random(), 0.06 + 0.06 * random(), 0.015 + 0.03 * random()});
    Eigen::Vector3d d(random(), random(), random());
    d *= 0.2 * depth;
    if (!(at.point[0] > 1e-6)) continue;
    ASSERT_GE(loaded.press({tool_at(at, d)}), 0);
    const auto touched = touched_nodes(block.mesh.nodes, block.mesh.surface, block.fixed, at, radius);
    const Eigen::VectorXd u = loaded.deformation();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < touched.nodes.size(); ++i)
      mean += touched.weights[i] * u.segment<3>(3 * touched.nodes[i]);
    EXPECT_LT((mean - d).norm(), 1e-5 * u.lpNorm<Eigen::Infinity>()) << draw;  // sums of floats
  }
}

// Claim: whatever tools do, with two steps a call nothing is infinite; held at last, they have the forces of a body
// that was not moved before. A release ends at rest.
TEST(Bodies, FindTheirWayBack) {
  const Block block;
  const std::string text = write_body_text(block.body);
  LoadedBody loaded(text), fresh(text);
  Random random(2);
  for (int moment = 0; moment < 200; ++moment) {
    auto tools = two_tools(block.mesh, 1 + random());
    for (auto& tool : tools)
      for (double& d : tool.displacement) d += 0.4 * depth * random();
    if (random() < 0) tools.pop_back();
    ASSERT_GE(loaded.press(tools, 2), 0);
    ASSERT_TRUE(loaded.force[0].allFinite() && loaded.force[1].allFinite() && loaded.deformation().allFinite());
    EXPECT_LE(loaded.pressed.steps, 2);
  }
  const auto tools = two_tools(block.mesh, 0.5);
  ASSERT_EQ(loaded.press(tools), PHN_OK);
  ASSERT_EQ(fresh.press(tools), PHN_OK);
  for (std::size_t t = 0; t < 2; ++t)
    EXPECT_LT((loaded.force[t] - fresh.force[t]).norm(), 1e-5 * fresh.force[0].norm());
  ASSERT_EQ(loaded.press({}), PHN_OK);
  EXPECT_LT(loaded.deformation().norm(), 1e-6 * depth);
}

// Claim: a tool that jumps beyond the trained range, however far, and is held there for 20 calls with two steps, is
// followed again when it returns: within 80 calls it has the force of a body that did not jump.
TEST(Bodies, ReturnFromJumps) {
  const Block block;
  const std::string text = write_body_text(block.body);
  LoadedBody loaded(text), fresh(text);
  for (const Vec3& x : {Vec3{0.06, 0.06, 0.03}, {0.12, 0.12, 0.03}, {0.12, 0.06, 0.0}}) {
    const auto at = nearest_on_surface(block.mesh.nodes, block.mesh.surface, x);
    const std::vector<phn_tool> back = {tool_at(at, {0, 0, -0.2 * depth})};
    fresh.rest();
    ASSERT_EQ(fresh.press(back), PHN_OK);
    for (const double jump : {2.0, 5.0, 50.0, 1e5}) {
      for (int call = 0; call < 20; ++call) {
        const int status = loaded.press({tool_at(at, jump * depth * Eigen::Vector3d(0.5, 0.6, -0.6))}, 2);
        ASSERT_GE(status, 0);
        ASSERT_TRUE(loaded.force[0].allFinite());
        EXPECT_NE(status & PHN_WARNING_OUTSIDE, 0);
      }
      int calls = 0;
      while (loaded.press(back, 2) != PHN_OK && calls < 80) ++calls;
      EXPECT_LT(calls, 80) << x[0] << " by " << jump;
      ASSERT_EQ(loaded.press(back), PHN_OK);
      EXPECT_LT((loaded.force[0] - fresh.force[0]).norm(), 1e-5 * fresh.force[0].norm()) << x[0] << " by " << jump;
    }
  }
}

// Claim: a tool that is held keeps its force when others come, go or take its place in the list, also after a call that
// is refused, and a tool that comes has none, however near it is.
TEST(Bodies, KeepForcesWhereToolsComeAndGo) {
  const Block block;
  LoadedBody loaded(write_body_text(block.body));
  const auto tools = two_tools(block.mesh, 0.5);
  const auto far = [](phn_tool tool) {  // from what two steps can follow
    for (double& d : tool.displacement) d *= 40;
    return tool;
  };
  const auto is_far = [&](const std::vector<phn_tool>& next) {
    return (loaded.press(next, 2) & PHN_WARNING_UNSETTLED) != 0 &&
           loaded.pressed.unbalanced > runtime::far_from_balance;
  };
  ASSERT_EQ(loaded.press({tools[0]}), PHN_OK);
  const Eigen::Vector3d alone = loaded.force[0];
  ASSERT_TRUE(is_far({far(tools[1]), tools[0]}));
  EXPECT_EQ(loaded.force[0].norm(), 0);
  EXPECT_EQ(loaded.force[1], alone);

  loaded.rest();
  ASSERT_EQ(loaded.press(tools), PHN_OK);
  const auto both = loaded.force;
  auto refused = tools;
  refused[0].displacement[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(loaded.press(refused), PHN_ERROR_NOT_FINITE);
  ASSERT_TRUE(is_far({far(tools[1]), tools[0]}));
  EXPECT_EQ(loaded.force[0], both[1]);
  EXPECT_EQ(loaded.force[1], both[0]);
  // The first goes, and another one comes a quarter of a radius beside the second.
  const auto near = nearest_on_surface(block.mesh.nodes, block.mesh.surface, {0.09 + radius / 4, 0.08, 0.03});
  ASSERT_TRUE(is_far({tools[1], far(tool_at(near, {0, 0, -depth}))}));
  EXPECT_EQ(loaded.force[0], both[1]);
  EXPECT_EQ(loaded.force[1].norm(), 0);
}

// Claim: two tools that slide over the block by 5 cm/s and turn are followed by one step in each millisecond. Forces
// are then within 0.1 % of those of many steps.
TEST(Bodies, FollowToolsThatMove) {
  const Block block;
  const std::string text = write_body_text(block.body);
  LoadedBody loaded(text), slow(text);
  int unsettled = 0;
  double largest = 0, off = 0;
  for (int moment = 0; moment < 600; ++moment) {
    const double t = moment / 1000.0, way = 0.05 * std::abs(0.3 - t);
    std::vector<phn_tool> tools;
    for (const int i : {0, 1}) {
      const auto at = nearest_on_surface(block.mesh.nodes, block.mesh.surface, {0.05 + 0.04 * i + way, 0.06, 0.03});
      const Eigen::Array3d phase(0, 2.1, 4.2);
      tools.push_back(
          tool_at(at, 0.15 * depth * std::min(1.0, 5 * t) * sin(6.28 * (1 + 0.7 * i) * t + phase + i).matrix()));
    }
    unsettled += loaded.press(tools, 1) == PHN_WARNING_UNSETTLED;
    EXPECT_LE(loaded.pressed.steps, 1);
    if (moment % 10 != 9) continue;
    ASSERT_EQ(slow.press(tools), PHN_OK) << moment;
    for (std::size_t i = 0; i < 2; ++i) {
      largest = std::max(largest, slow.force[i].norm());
      off = std::max(off, (loaded.force[i] - slow.force[i]).norm());
    }
  }
  EXPECT_LE(unsettled, 6);
  EXPECT_LT(off, 1e-3 * largest);
}

// Claim: tools farther than trained, or at places that no probe was near to, are outside; with too few steps they are
// unsettled.
TEST(Bodies, WarnOfWhatTheyDoNotKnow) {
  Block block;
  LoadedBody loaded(write_body_text(block.body));
  EXPECT_EQ(loaded.press(two_tools(block.mesh, 1.3)), PHN_OK);
  auto far = two_tools(block.mesh, 1);
  far[0].displacement[2] = -1.01 * depth;
  EXPECT_EQ(loaded.press(far), PHN_WARNING_OUTSIDE);
  LoadedBody other(write_body_text(block.body));
  EXPECT_EQ(other.press(two_tools(block.mesh, 1), 1), PHN_WARNING_UNSETTLED);
  block.body.kinds.assign(block.body.kinds.size(), schema::body_node_moves);
  LoadedBody unknown(write_body_text(block.body));
  EXPECT_EQ(unknown.press(two_tools(block.mesh, 0.5)), PHN_WARNING_OUTSIDE);
}

// Claim: a state is unsettled, however small the next step, where the stiffness is not positive definite. The elements
// at rest have 0.3 times the stiffness of the cells here, so that cells that soften by more than that are enough.
TEST(Bodies, AreUnsettledWhereTheStiffnessIsIndefinite) {
  Block block;
  const Eigen::MatrixXd K = stiffness_of_shape(block);
  block.body.cells_at_rest = scaled_table(K);
  block.body.lack_at_rest = scaled_table(-0.7 * K);
  LoadedBody loaded(write_body_text(block.body));
  EXPECT_EQ(loaded.press(two_tools(block.mesh, 0.1)), PHN_OK);
  loaded.rest();
  EXPECT_EQ(loaded.press(two_tools(block.mesh, 0.5)), PHN_WARNING_UNSETTLED);
  EXPECT_LT(loaded.pressed.unbalanced, 0.01);
  EXPECT_LT(loaded.pressed.residual_m, 0.01 * depth);
}

// Claim: wrong calls are refused, with forces of zero.
TEST(Bodies, RefuseWrongCalls) {
  const Block block;
  LoadedBody loaded(write_body_text(block.body), 2);
  const auto tools = two_tools(block.mesh, 1);
  const auto refused = [&](const std::vector<phn_tool>& those) {
    loaded.force.fill(Eigen::Vector3d::Ones());
    const int status = loaded.press(those);
    if (status < 0 && status != PHN_ERROR_TOOLS) {
      EXPECT_EQ(loaded.force[0].norm(), 0);
    }
    return status;
  };
  const auto with = [&](const auto& change) {
    auto changed = tools;
    change(changed[1]);
    return refused(changed);
  };
  EXPECT_EQ(with([](phn_tool& t) { t.displacement[1] = std::nan(""); }), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(with([](phn_tool& t) { t.weights[0] = std::nan(""); }), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(with([](phn_tool& t) { t.weights[0] += 0.5; }), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(with([](phn_tool& t) { t.nodes[0] = t.nodes[1] = t.nodes[2] = 99; }), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(refused({tools[0], tools[1], tools[0]}), PHN_ERROR_TOOLS);
  for (const int n_modes : {17, 18}) {
    Block few;
    for (ScaledTable* table : {&few.body.modes, &few.body.gradients})
      *table = scaled_table(table->values().leftCols(n_modes));
    EXPECT_EQ(LoadedBody(write_body_text(few.body)).press(tools) == PHN_ERROR_TOO_MANY_TOOLS, n_modes < 18);
  }
  Block held;
  held.body.tool_radius_m = 0;
  LoadedBody nodes(write_body_text(held.body));
  EXPECT_EQ(nodes.press({{{0, -1, -1}, {1, 0, 0}, {0, 0, 0}}}), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(phn_body_force(loaded.body, nodes.state, 0, nullptr, 1, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_body_force(loaded.body, loaded.state, 1, tools.data(), 0, loaded.force[0].data(), nullptr),
            PHN_ERROR_ARGUMENT);
  std::size_t bytes = 0;
  EXPECT_EQ(phn_body_state_size(loaded.body, 9, &bytes), PHN_ERROR_TOO_MANY_TOOLS);
  EXPECT_EQ(phn_body_contact_size(loaded.body, 9, &bytes), PHN_ERROR_TOO_MANY_TOOLS);
  ASSERT_EQ(phn_body_state_size(loaded.body, 2, &bytes), PHN_OK);
  phn_body_state* state = nullptr;
  std::vector<char> memory(bytes);
  EXPECT_EQ(phn_body_state_init(memory.data(), bytes - 1, loaded.body, 2, &state), PHN_ERROR_BUFFER);
  EXPECT_EQ(state, nullptr);
}

/// Spheres on a body.
struct Touched {
  explicit Touched(const std::string& text, int steps) : loaded(text) {
    constexpr int max_tools = 2;
    std::size_t bytes = 0;
    EXPECT_EQ(phn_body_contact_size(loaded.body, max_tools, &bytes), PHN_OK);
    memory.resize(bytes);
    EXPECT_EQ(phn_body_contact_init(memory.data(), bytes, loaded.body, max_tools, steps, &contact), PHN_OK);
  }
  int step(const std::vector<phn_contact_tool>& tools, phn_contact_state* states) {
    return phn_contact_step(contact, static_cast<std::int32_t>(tools.size()), tools.data(), states, &report);
  }

  LoadedBody loaded;
  std::vector<char> memory;
  phn_contact* contact = nullptr;
  phn_contact_report report = {};
};

// Claim: a sphere that presses the block and goes sideways slides: the body's force remains in the friction cone, is
// nearly normal without friction, and settles on that of the body held at the touched point. One that jumps in is felt
// at once, to 1 % of its force.
TEST(Bodies, AreTouched) {
  const Block block;
  LoadedBody beside(write_body_text(block.body));
  Touched touched(write_body_text(block.body), 2);
  phn_contact_state state{};
  for (int moment = 0; moment < 300; ++moment) {
    const double way = std::min(moment, 200) / 200.0;
    const phn_contact_tool tool{{0.05 + 0.03 * way, 0.06, 0.03 + 0.005 + 0.002 - 0.5 * depth * std::min(1.0, 3 * way)},
                                0.005,
                                0,
                                PHN_TOOL_PRESS};
    ASSERT_GE(touched.step({tool}, &state), 0) << moment;
    ASSERT_LE(touched.report.steps, 2);
    const Eigen::Map<const Eigen::Vector3d> force(state.force), normal(state.normal);
    if (!state.in_contact) continue;
    EXPECT_LE(force.dot(normal), 0) << moment;
    EXPECT_LE((force - force.dot(normal) * normal).norm(), 1e-9 * force.norm() + 1e-15) << moment;
  }
  ASSERT_EQ(state.in_contact, 1);
  const Eigen::Map<const Eigen::Vector3d> force(state.force);
  EXPECT_LT(state.unbalanced, 1e-3 * force.norm());
  ASSERT_EQ(beside.press({state.held}), PHN_OK);
  EXPECT_LT((state.scale * beside.force[0] - force).norm(), 1e-3 * force.norm());
  for (const double friction : {0.0, 0.5}) {
    Touched jumps(write_body_text(block.body), 1);
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (int moment = 0; moment < 30; ++moment) {
      const phn_contact_tool tool{
          {0.05 + (moment > 0 ? 0.01 : 0), 0.06, 0.0351 - (moment > 0 ? depth : 0)}, 0.005, friction, PHN_TOOL_PRESS};
      ASSERT_GE(jumps.step({tool}, &state), 0);
      if (moment == 1) first = force;
    }
    EXPECT_GT(first.norm(), 0);
    EXPECT_LT((first - force).norm(), 0.01 * force.norm()) << friction;
  }
}

// Claim: a tool that grasps a body holds it while it pulls, with few steps and with many.
TEST(Bodies, AreGrasped) {
  const Block block;
  for (const int steps : {1, 60}) {
    Touched touched(write_body_text(block.body), steps);
    for (int moment = 0; moment < 200; ++moment) {
      const phn_contact_tool tool{{0.05, 0.06, 0.031 + 0.002 * moment / 200}, 0.005, 0, PHN_TOOL_GRASP};
      phn_contact_state state;
      ASSERT_GE(touched.step({tool}, &state), 0);
      ASSERT_EQ(state.in_contact, 1) << steps << " " << moment;
      if (moment > 0) {
        ASSERT_GT(state.force[2], 0) << steps << " " << moment;
      }
    }
  }
}

// Claim: two spheres that slide near each other, press in turn and leave are followed by one step in each millisecond:
// forces are those of the same motion with steps until all is settled, to 2 % of the largest.
TEST(Bodies, FollowTwoSpheresWithOneStepEach) {
  const Block block;
  const std::string body_text = write_body_text(block.body);
  for (const double friction : {0.0, 0.2}) {
    std::array<std::vector<Eigen::Vector3d>, 2> forces;
    int unsettled = 0;
    for (const std::size_t is_slow : {0u, 1u}) {
      Touched touched(body_text, is_slow ? 400 : 1);
      for (int k = 0; k < 1000; ++k) {
        phn_contact_tool tools[2];
        for (int t = 0; t < 2; ++t) {
          const double press = std::pow(std::sin(3.1415926 * (t == 0 ? 1.0 : 1.7) * k / 1000.0), 2);
          tools[t] = {{0.04 + 0.02 * t + 0.01 * std::sin(k / 200.0), 0.06, 0.03 + 0.0051 - 0.5 * depth * press},
                      0.005,
                      friction,
                      PHN_TOOL_PRESS};
        }
        phn_contact_state states[2];
        const int status = touched.step({tools[0], tools[1]}, states);
        ASSERT_GE(status, 0) << k;
        unsettled += (status & PHN_WARNING_UNSETTLED) != 0;
        for (const auto& state : states) forces[is_slow].emplace_back(state.force);
      }
    }
    double largest = 0;
    for (const auto& f : forces[1]) largest = std::max(largest, f.norm());
    ASSERT_GT(largest, 0);
    int wrong = 0;
    for (std::size_t i = 0; i < forces[0].size(); ++i) wrong += (forces[0][i] - forces[1][i]).norm() > 0.02 * largest;
    EXPECT_LE(wrong, 0) << friction;
    EXPECT_LE(unsettled, 5) << friction;
  }
}

// Claim: a body is touched where it was probed; wrong calls of contact are refused.
TEST(Bodies, RefuseWrongCallsOfContact) {
  Block block;
  Touched touched(write_body_text(block.body), 2);
  const phn_contact_tool tool{{0.06, 0.06, 0.034}, 0.005, 0, PHN_TOOL_PRESS};
  phn_contact_state states[3];
  phn_contact* contact = touched.contact;
  EXPECT_EQ(touched.step({tool, tool, tool}, states), PHN_ERROR_TOOLS);
  EXPECT_EQ(phn_contact_step(contact, 1, &tool, states, reinterpret_cast<phn_contact_report*>(states)),
            PHN_ERROR_OVERLAP);
  std::size_t bytes = 0;
  EXPECT_EQ(phn_body_contact_size(touched.loaded.body, 9, &bytes), PHN_ERROR_TOO_MANY_TOOLS);
  EXPECT_EQ(phn_body_contact_size(nullptr, 1, &bytes), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_body_contact_init(touched.memory.data(), 64, touched.loaded.body, 1, 1, &contact), PHN_ERROR_BUFFER);
  EXPECT_EQ(phn_body_contact_init(touched.memory.data(), touched.memory.size(), touched.loaded.body, 1, 0, &contact),
            PHN_ERROR_ARGUMENT);
  block.body.kinds.assign(block.body.kinds.size(), schema::body_node_moves);
  const LoadedBody unknown(write_body_text(block.body));
  ASSERT_EQ(phn_body_contact_size(unknown.body, 1, &bytes), PHN_OK);
  std::vector<char> memory(bytes);
  EXPECT_EQ(phn_body_contact_init(memory.data(), bytes, unknown.body, 1, 1, &contact), PHN_ERROR_UNDEFINED);
}

// Claim: the loops of each instruction set give the same bits; sizes that are no whole blocks, too.
TEST(Bodies, HaveKernelsWithTheSameBits) {
  using namespace runtime;
  constexpr std::int32_t n = 41, stride = whole_blocks(n), rows = 72;
  Random random(4);
  std::vector<float> a(static_cast<std::size_t>(rows * stride));
  for (std::int32_t i = 0; i < rows * stride; ++i)
    a[static_cast<std::size_t>(i)] = i % stride < n ? static_cast<float>(random()) : 0;
  const RowMatrix matrix = {a.data(), rows, stride};
  std::vector<std::vector<double>> results;
  for (int set = 0; set < n_instruction_sets; ++set) {
    const BodyKernels* kernels = body_kernels(set);
    if (!kernels) continue;
    std::vector<double> x(stride), out(rows);
    for (std::size_t i = 0; i < n; ++i) x[i] = 1 / (1.5 + static_cast<double>(i));
    kernels->multiply_vector(matrix, x.data(), out.data());
    kernels->add_transposed_product({a.data(), rows - 1, stride}, out.data(), x.data());
    std::vector<float> square(static_cast<std::size_t>(stride * stride));
    kernels->add_symmetric_product(matrix, matrix, square.data());
    ASSERT_TRUE(kernels->factorize(square.data(), n, stride)) << kernels->name;
    kernels->solve(square.data(), n, stride, x.data());
    out.insert(out.end(), x.begin(), x.begin() + n);
    std::vector<float> product(static_cast<std::size_t>(stride * stride)), mixed(stride);
    kernels->add_product(matrix, matrix, product.data());
    kernels->combine_rows(a.data(), stride, a.data() + stride, mixed.data());
    out.insert(out.end(), product.begin(), product.end());
    out.insert(out.end(), mixed.begin(), mixed.end());
    results.push_back(out);
    EXPECT_EQ(out, results[0]) << kernels->name;
  }
}

// Claim: every truncation is refused; a text with other digits and a right checksum is refused, or its forces are
// finite.
TEST(Bodies, SurviveDamagedTexts) {
  const Block block;
  const std::string text = write_body_text(block.body);
  for (std::size_t n = 0; n < text.size(); n += 997) EXPECT_LT(LoadedBody(text.substr(0, n)).status, 0) << n;
  Random random(3);
  const std::size_t end = text.rfind("checksum ");
  int accepted = 0;
  for (int draw = 0; draw < 150; ++draw) {
    std::string changed = text.substr(0, end);
    // Half of the changes are in the first lines, where all but the tables is.
    const std::size_t within = draw % 2 == 0 ? 6000 : changed.size();
    for (int k = 0; k < 3; ++k)
      if (char& c = changed[random.below(within)]; std::isxdigit(static_cast<unsigned char>(c)) || draw % 5 == 0)
        c = "0189-. p"[random.below(draw % 5 == 0 ? 8 : 4)];
    LoadedBody loaded(changed + "checksum " + hash_of(changed) + "\n");
    if (loaded.status != PHN_OK) continue;
    ++accepted;
    loaded.press(two_tools(block.mesh, 1), 3);
    EXPECT_TRUE(loaded.force[0].allFinite() && loaded.force[1].allFinite() && std::isfinite(loaded.pressed.energy));
  }
  EXPECT_GT(accepted, 10);
  const std::string strange = replaced(text, "mooney-rivlin", "nobodys-law");
  EXPECT_EQ(LoadedBody(strange).status, PHN_ERROR_FAMILY);
  const std::string far = replaced(text, "depth 1.47ae147ae147bp-6\n", "depth 1.8p+1000\n");
  EXPECT_EQ(LoadedBody(far).status, PHN_ERROR_RANGE);
  std::size_t bytes = 0;
  EXPECT_EQ(phn_body_size(strange.data(), strange.size(), &bytes, nullptr), PHN_ERROR_FAMILY);
}

}  // namespace
}  // namespace phynness::test
