// Claims about one round tool between nodes: its energy is a mean of energies of the nodes around it, and everything
// else follows from this energy.
#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <phynness/meshes/probe_points.hpp>
#include <utility>
#include <vector>

#include "linear_body.hpp"
#include "loaded_model.hpp"
#include "round_models.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

class RoundTools : public testing::TestWithParam<Family> {
 protected:
  const LoadedModel loaded{write_model_text(round_model_of(GetParam()))};
  const LoadedModel covered{write_model_text(covered_model_of(GetParam()))};
  const bool has_energy = GetParam() != Family::rbfn;

  struct Answer {
    int status = 0;
    Eigen::Vector3d force;
    double energy = 0;
    Eigen::Matrix3d stiffness;
  };
  Answer at(const phn_tool& tool) const { return at(loaded, tool); }
  Answer at(const LoadedModel& in, const phn_tool& tool) const {
    Answer a;
    a.status = phn_force(in.model, in.data, &tool, a.force.data(), has_energy ? &a.energy : nullptr,
                         has_energy ? a.stiffness.data() : nullptr);
    return a;
  }
  Answer at_node(std::int32_t node, const double* d) const {
    Answer a;
    a.status = phn_force(loaded.model, loaded.data, AtNode(node, d), a.force.data(), has_energy ? &a.energy : nullptr,
                         has_energy ? a.stiffness.data() : nullptr);
    return a;
  }
};
INSTANTIATE_TEST_SUITE_P(Families, RoundTools, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

const double d[3] = {0.003, -0.002, 0.004};
phn_tool moved(phn_tool tool, const Eigen::Vector3d& by) {
  for (int k = 0; k < 3; ++k) tool.displacement[k] += by[k];
  return tool;
}

// Claim: at a node, also beside fixed nodes, which do not count, the answer is that of the node; phn_couple says the
// same as phn_force to the bit; the field is the mean with the weights of the point. Fields are sums in float (6e-8
// of amplitudes of up to 1).
TEST_P(RoundTools, AreTheirNodesAndMeansBetween) {
  struct Case {
    phn_tool tool;
    double weight[3];
  };
  const Case cases[] = {{tool(3, 5, 8, 0.5, 0.3, d[0], d[1], d[2]), {0.5, 0.3, 0.2}},
                        {tool(5, 3, 0, 0.25, 0.5, d[0], d[1], d[2]), {2 / 3.0, 1 / 3.0, 0}},
                        {tool(8, 5, 3, 1, 0, d[0], d[1], d[2]), {0, 0, 1}},
                        {tool(3, 0, 1, 0.5, 0.3, d[0], d[1], d[2]), {1, 0, 0}}};
  for (const auto& [held, weight] : cases) {
    Points field = Points::Zero(12, 3), one(12, 3), coupled(12, 3);
    const std::int32_t nodes[3] = {3, 5, 8};
    const Answer said = at(held);
    const bool beside_fixed = held.nodes[1] == 0 || held.nodes[2] == 0;  // with a quarter or half of the weight
    int status = beside_fixed ? PHN_WARNING_OUTSIDE : 0;
    for (int i = 0; i < 3; ++i) {
      const Answer node = at_node(nodes[i], d);
      if (weight[i] > 0) status |= node.status;
      phn_deform(loaded.model, loaded.data, AtNode(nodes[i], d), one.data());
      field += weight[i] * one;
      if (weight[i] < 1) continue;
      EXPECT_EQ(said.force, node.force);
      EXPECT_EQ(said.energy, node.energy);
    }
    Eigen::Vector3d force;
    phn_coupled result = {1, 1};
    EXPECT_EQ(said.status, status);
    EXPECT_EQ(phn_couple(loaded.model, loaded.data, 1, &held, force.data(), &result), said.status);
    EXPECT_EQ(force, said.force);
    EXPECT_EQ(result.energy, said.energy);
    EXPECT_EQ(result.residual, 0);
    EXPECT_EQ(phn_coupled_deform(loaded.model, loaded.data, coupled.data()), said.status);
    EXPECT_LT((coupled - field).cwiseAbs().maxCoeff(), 1e-6 * field.cwiseAbs().maxCoeff());
    EXPECT_EQ(phn_deform(loaded.model, loaded.data, &held, one.data()), said.status);
    EXPECT_TRUE(weight[2] == 1 || one == coupled);  // at a node phn_deform has another order of sums
    EXPECT_LT((one - field).cwiseAbs().maxCoeff(), 1e-6 * field.cwiseAbs().maxCoeff());
  }
}

// Claim: a covered node is the point that its coordinates say, and in a triangle with it the weights of all corners add
// up; force, energy, field, trained depth and bound follow. The weights differ by rounding: 1e-12.
TEST_P(RoundTools, AreAnsweredAtCoveredNodes) {
  const double first = 20000 / 65535.0, w[2] = {first, (1 - first) * (30000 / 65535.0)};
  const phn_tool places[][2] = {
      {tool(12, -1, -1, 1, 0, d[0], d[1], d[2]), tool(3, 5, 8, w[0], w[1], d[0], d[1], d[2])},
      {tool(8, 5, 12, 0.2, 0.5, d[0], d[1], d[2]), tool(3, 5, 8, 0.3 * w[0], 0.5 + 0.3 * w[1], d[0], d[1], d[2])}};
  for (const auto& [by_coordinates, by_corners] : places) {
    EXPECT_EQ(at(by_coordinates).status, PHN_ERROR_NOT_ACTIVE);  // without coordinates
    const Answer said = at(covered, by_coordinates), wanted = at(covered, by_corners);
    EXPECT_EQ(said.status, wanted.status);
    EXPECT_LT((said.force - wanted.force).norm(), 1e-12 * wanted.force.norm());
    EXPECT_NEAR(said.energy, wanted.energy, 1e-12 * std::abs(wanted.energy));
    double depth[2];
    EXPECT_EQ(phn_depth(covered.model, &by_coordinates, &depth[0]), phn_depth(covered.model, &by_corners, &depth[1]));
    EXPECT_EQ(depth[0], depth[1]);
    Points field[2] = {Points(12, 3), Points(12, 3)};
    for (int i = 0; i < 2; ++i) {
      double force[3];
      EXPECT_GE(phn_couple(covered.model, covered.data, 1, i == 0 ? &by_coordinates : &by_corners, force, nullptr), 0);
      EXPECT_GE(phn_coupled_deform(covered.model, covered.data, field[i].data()), 0);
    }
    EXPECT_LT((field[0] - field[1]).cwiseAbs().maxCoeff(), 1e-6 * field[1].cwiseAbs().maxCoeff());
  }
}

// Claim: a model of round tools answers one of them; a second one is refused by every function that takes several, and
// nothing is held afterwards. The contact keeps the state from before.
TEST_P(RoundTools, AreAnsweredOneAtATime) {
  const phn_tool two[2] = {tool(3, 5, 8, 0.5, 0.3, d[0], d[1], d[2]), tool(5, -1, -1, 1, 0, 0.001, 0, 0)};
  Eigen::Matrix<double, 3, 2> forces;
  Points field = Points::Zero(12, 3);
  ASSERT_GE(phn_couple(loaded.model, loaded.data, 1, two, forces.data(), nullptr), 0);
  forces.setOnes();
  EXPECT_EQ(phn_couple(loaded.model, loaded.data, 2, two, forces.data(), nullptr), PHN_ERROR_ROUND_TOOLS);
  EXPECT_EQ(forces.norm(), 0);
  EXPECT_EQ(phn_coupled_deform(loaded.model, loaded.data, field.data()), PHN_OK);
  EXPECT_EQ(field.norm(), 0);
  EXPECT_NE(std::string(phn_status_message(PHN_ERROR_ROUND_TOOLS)).find("[probe]"), std::string::npos);

  std::size_t bytes = 0;
  ASSERT_EQ(phn_contact_size(loaded.model, 2, &bytes), PHN_OK);
  std::vector<char> memory(bytes);
  phn_contact* contact = nullptr;
  ASSERT_EQ(phn_contact_init(memory.data(), bytes, loaded.model, 2, &contact), PHN_OK);
  const phn_contact_tool spheres[2] = {{{0.2, 0, 0}, 0.001, 0, PHN_TOOL_PRESS},
                                       {{0, 0.2, 0}, 0.001, 0, PHN_TOOL_PRESS}};
  phn_contact_state states[2];
  EXPECT_EQ(phn_contact_step(contact, 1, spheres, states, nullptr), PHN_OK);
  EXPECT_EQ(phn_contact_step(contact, 2, spheres, states, nullptr), PHN_ERROR_ROUND_TOOLS);
}

/// Round tools at the nodes of a flat hexagon of equilateral triangles; a stiffness at each place.
Model grid_model(double (*stiffness_at)(double x, double y), int reach = 2) {
  Model model = small_linear_model();
  const auto place = [](int a, int b) { return Eigen::Vector2d(a + b / 2.0, b * std::sqrt(0.75)); };
  std::map<std::pair<int, int>, std::int32_t> number;
  for (int a = -reach; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b)
      if (std::abs(a + b) <= reach) number.emplace(std::pair(a, b), static_cast<std::int32_t>(number.size()));
  const auto n_nodes = static_cast<std::int32_t>(number.size());
  model.n_mesh_nodes = n_nodes + 2;
  model.fixed = {n_nodes, n_nodes + 1};
  model.output.clear();
  model.output_points = Points::Zero(n_nodes, 3);
  model.nodes.resize(1);
  model.nodes.resize(number.size(), model.nodes[0]);
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& [at, n] : number) {
    const auto [a, b] = at;
    const auto x = place(a, b);
    model.output.push_back(n);
    model.output_points.row(n) << x[0], x[1], 0;
    for (const auto& [p, q] :
         {std::pair(std::pair(a + 1, b), std::pair(a, b + 1)), std::pair(std::pair(a + 1, b - 1), std::pair(a + 1, b))})
      if (number.count(p) && number.count(q)) triangles.push_back({n, number.at(p), number.at(q)});
    ActiveNodeModel& node = model.nodes[static_cast<std::size_t>(n)];
    node.node = n;
    node.point = {x[0], x[1], 0};
    node.moves_mean = true;
    node.prescribed = {n};
    node.prescribed_weight = {1};
    node.linear.stiffness = stiffness_at(x[0], x[1]) * Eigen::Matrix3d::Identity();
    node.linear.unit_responses = Eigen::MatrixXd::Zero(n_nodes, 9);
  }
  model.surface.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      model.surface(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = triangles[t][k];
  return model;
}

// Claim: a stiffness that is a quadratic function of the place is met between nodes whose neighbours are all active: of
// the error of a linear interpolation less than a tenth remains, because the functions are not quadratic (6 %).
TEST(RoundToolsBetween, MeetQuadraticStiffness) {
  const auto stiffness = [](double x, double y) { return 50 + 3 * x - y + 2 * x * x - x * y + 3 * y * y; };
  const LoadedModel loaded(write_model_text(grid_model(stiffness)));
  const auto* points = info_of(loaded.model).output_points;
  for (const auto& [wa, wb] : {std::pair(0.5, 0.5), std::pair(0.4, 0.3), std::pair(0.1, 0.2)}) {
    const phn_tool held = tool(9, 10, 14, wa, wb, 0, 0, 1);  // the middle and two of its neighbours
    double x = 0, y = 0, linear = 0, force[3];
    for (int k = 0; k < 3; ++k) {
      const double* at = points + 3 * held.nodes[k];
      x += held.weights[k] * at[0];
      y += held.weights[k] * at[1];
      linear += held.weights[k] * stiffness(at[0], at[1]);
    }
    EXPECT_EQ(phn_force(loaded.model, loaded.data, &held, force, nullptr, nullptr), PHN_OK);
    EXPECT_LT(std::abs(force[2] - stiffness(x, y)), 0.1 * std::abs(linear - stiffness(x, y)));
  }
}

/// The hexagon of reach 6, bent to a paraboloid, with round tools at nodes of a given spacing only.
Model spread_model(double (*stiffness_at)(double x, double y), double spacing, double curvature = 0) {
  Model model = grid_model(stiffness_at, 6);
  const auto height = [&](double x, double y) { return -curvature / 2 * (x * x + y * y); };
  for (auto x : model.output_points.rowwise()) x[2] = height(x[0], x[1]);
  for (auto& node : model.nodes) node.point[2] = height(node.point[0], node.point[1]);
  Mesh mesh;
  mesh.nodes = model.output_points;
  mesh.surface = model.surface;
  const auto kept = spread_nodes(mesh.nodes, mesh.surface, model.output, spacing, 0);
  std::vector<ActiveNodeModel> nodes;
  for (const auto node : kept) nodes.push_back(model.nodes[static_cast<std::size_t>(node)]);
  model.nodes = nodes;
  cover_surface(model, mesh, 3 * spacing);
  return model;
}

// Claim: between spread points, which have neighbours on one side only at the border, the largest error of a smooth
// stiffness is less than half of that of a linear interpolation (found: 0.33 to 0.37; gradients of least squares leave
// 0.7 to 0.9), also where the surface is not in the triangles of the points.
TEST(RoundToolsBetween, MeetSmoothStiffness) {
  const auto stiffness = [](double x, double y) { return 50 + 10 * std::sin(x / 2) * std::cos(y / 3); };
  for (const double curvature : {0.0, 0.1})
    for (const double spacing : {2.0, 3.0}) {
      const Model model = spread_model(stiffness, spacing, curvature);
      const LoadedModel loaded(write_model_text(model));
      double largest = 0, largest_linear = 0;
      for (const auto& row : model.covered.rowwise()) {
        const auto x = model.output_points.row(row[0]);
        // Beside its corners, which need not be probed, the hexagon reaches beyond the triangles of probed nodes.
        if (std::hypot(x[0], x[1]) > 4.5) continue;
        const double first = row[2] / 65535.0, second = row[3] / 65535.0;
        const double weight[3] = {first, (1 - first) * second, (1 - first) * (1 - second)};
        double linear = 0, force[3];
        for (int k = 0; k < 3; ++k) {
          const Vec3& at = model.nodes[static_cast<std::size_t>(model.probe_triangles(row[1], k))].point;
          linear += weight[k] * stiffness(at[0], at[1]);
        }
        const phn_tool held = tool(row[0], -1, -1, 1, 0, 0, 0, 1);
        EXPECT_EQ(phn_force(loaded.model, loaded.data, &held, force, nullptr, nullptr), PHN_OK);
        const double wanted = stiffness(x[0], x[1]);
        largest = std::max(largest, std::abs(force[2] - wanted));
        largest_linear = std::max(largest_linear, std::abs(linear - wanted));
      }
      EXPECT_LT(largest, 0.5 * largest_linear);
    }
}

// Claim: everywhere between the spread points a constant stiffness is met to rounding (the weights add up to 1, in
// float to its seven digits) and a linear one up to what the width of the functions takes from the gradients: 3 % of
// the change over a spacing. The answer changes little where a tool slides a little over an edge.
TEST(RoundToolsBetween, SpreadPointsMeetLinearStiffness) {
  const auto constant = [](double, double) { return 50.0; };
  const auto linear = [](double x, double y) { return 50 + 2 * x - y; };
  for (const double spacing : {2.0, 3.0}) {
    const Model same = spread_model(constant, spacing), sloped = spread_model(linear, spacing);
    EXPECT_LT(same.nodes.size() * 2, same.output.size());
    EXPECT_EQ(same.covered.rows(), std::ssize(same.output));
    const LoadedModel flat(write_model_text(same)), slope(write_model_text(sloped));
    const auto force_of = [](const LoadedModel& in, const phn_tool& held) {
      double force[3] = {};
      EXPECT_EQ(phn_force(in.model, in.data, &held, force, nullptr, nullptr), PHN_OK);
      return force[2];
    };
    for (Eigen::Index t = 0; t < same.surface.rows(); ++t) {
      const auto corner = [&](int k) { return same.surface(t, k % 3); };
      phn_tool held = tool(corner(0), corner(1), corner(2), 0.2, 0.5, 0, 0, 1);
      Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 3; ++k) x += held.weights[k] * same.output_points.row(held.nodes[k]);
      EXPECT_NEAR(force_of(flat, held), 50, 1e-11);
      // Beside its corners, which need not be probed, the hexagon reaches beyond the triangles of probed nodes.
      const double tolerance = x.norm() < 4.5 ? 0.03 * std::sqrt(5.0) * spacing : spacing;
      EXPECT_NEAR(force_of(slope, held), linear(x[0], x[1]), tolerance);
      for (int k = 0; k < 3; ++k) {
        const double beside = 1e-9;
        const phn_tool inside = tool(corner(k), corner(k + 1), corner(k + 2), 0.4, 0.6 - beside, 0, 0, 1),
                       on_edge = tool(corner(k), corner(k + 1), -1, 0.4, 0.6, 0, 0, 1);
        EXPECT_NEAR(force_of(slope, inside), force_of(slope, on_edge), 1e-6);
      }
    }
  }
}

// Claim: contact feels the interpolated force, in both modes. The stiffness is the same in all directions, so that a
// press without friction has no tangential force, up to the tolerance of contact, 1e-4.
TEST(RoundToolsBetween, AreFeltInContact) {
  const auto stiffness = [](double x, double y) { return 50 + x + y * y; };
  const LoadedModel dense(write_model_text(grid_model(stiffness))),
      spread(write_model_text(spread_model(stiffness, 3)));
  for (const auto& [which, mode] : {std::pair(&dense, PHN_TOOL_PRESS), std::pair(&dense, PHN_TOOL_GRASP),
                                    std::pair(&spread, PHN_TOOL_PRESS), std::pair(&spread, PHN_TOOL_GRASP)}) {
    const LoadedModel& loaded = *which;
    std::size_t bytes = 0;
    ASSERT_EQ(phn_contact_size(loaded.model, 1, &bytes), PHN_OK);
    std::vector<char> memory(bytes);
    phn_contact* contact = nullptr;
    ASSERT_EQ(phn_contact_init(memory.data(), bytes, loaded.model, 1, &contact), PHN_OK);
    phn_contact_tool sphere = {{0.35, 0.2, 0.11}, 0.1, mode == PHN_TOOL_PRESS ? 0.0 : 1.0, mode};
    phn_contact_state state;
    for (const double height : {0.11, 0.09, 0.05, 0.02}) {
      sphere.center[2] = height;
      ASSERT_GE(phn_contact_step(contact, 1, &sphere, &state, nullptr), 0);
    }
    ASSERT_EQ(state.in_contact, 1);
    double said[3];
    ASSERT_GE(phn_force(loaded.model, loaded.data, &state.held, said, nullptr, nullptr), 0);
    EXPECT_LT(said[2], -1);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(state.force[k], state.scale * said[k], 1e-4 * std::abs(said[2]));
  }
}

// Claim: at rest nothing is held; the force is the gradient of the energy, the stiffness that of the force. Central
// differences over 1e-6 m of energies with 16 digits leave 3e-8, those of forces 1e-7.
TEST_P(RoundTools, HaveForcesThatAreGradients) {
  if (!has_energy) return;
  for (const auto& held : {tool(3, 5, 8, 0.5, 0.3, d[0], d[1], d[2]), tool(8, 5, 12, 0.2, 0.5, d[0], d[1], d[2])}) {
    const Answer rest = at(covered, moved(held, -Eigen::Map<const Eigen::Vector3d>(d))), here = at(covered, held);
    EXPECT_EQ(rest.force.norm(), 0);
    EXPECT_EQ(rest.energy, 0);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Answer more = at(covered, moved(held, h * Eigen::Vector3d::Unit(k))),
                   less = at(covered, moved(held, -h * Eigen::Vector3d::Unit(k)));
      EXPECT_NEAR((more.energy - less.energy) / (2 * h), here.force[k], 1e-7 * here.force.norm());
      EXPECT_LT(((more.force - less.force) / (2 * h) - here.stiffness.col(k)).norm(), 1e-6 * here.stiffness.norm());
    }
  }
}

// Claim: force and field change little where a tool slides a little over an edge, also to a triangle with a fixed node.
TEST_P(RoundTools, SlideOverEdges) {
  const double beside = 1e-9;
  const phn_tool sides[2] = {tool(3, 5, 8, 0.4, 0.6 - beside, d[0], d[1], d[2]),
                             tool(5, 3, 0, 0.6 - beside, 0.4, d[0], d[1], d[2])};
  const Answer a = at(sides[0]), b = at(sides[1]);
  // The weights differ by 1e-9; the factor 100 leaves room for the gradients.
  EXPECT_LT((a.force - b.force).norm(), 100 * beside * a.force.norm());
}

// Claim: the trained depth is the least of the nodes, and a warning of one is one of the tool, which then has no bound.
TEST_P(RoundTools, HaveTheLeastDepthOfTheirNodes) {
  const double far[3] = {0, 0.007, 0};  // node 5 was trained to 5 mm
  const phn_tool held = tool(3, 5, 8, 0.5, 0.3, far[0], far[1], far[2]),
                 without = tool(3, 8, -1, 0.5, 0.5, far[0], far[1], far[2]);
  double said = 0;
  EXPECT_TRUE(phn_depth(loaded.model, &held, &said) & PHN_WARNING_OUTSIDE || GetParam() == Family::linear);
  double depth = 1, bound = 0;
  for (const std::int32_t node : {3, 5, 8}) depth = std::min(depth, Trained(loaded.model, node, far).depth);
  EXPECT_EQ(said, depth);
  const int bounded = phn_bound(loaded.model, &without, &bound);
  EXPECT_EQ(bounded < 0, GetParam() == Family::linear);
  EXPECT_EQ(bound == PHN_NO_BOUND, GetParam() == Family::linear);
  if (GetParam() == Family::linear) return;
  EXPECT_GT(phn_bound(loaded.model, &held, &bound), 0);
  EXPECT_EQ(bound, PHN_NO_BOUND);
}

// Claim: beside fixed nodes, where more than 1e-5 of the weight is theirs, nothing counts as trained: the status of
// every function says so at any displacement. At a node nothing is said.
TEST_P(RoundTools, AreOutsideBesideFixedNodes) {
  const double small[3] = {1e-4, 0, 0};
  for (const double fixed : {9e-6, 1.1e-5}) {
    const phn_tool held = tool(3, 0, 8, 0.6 - fixed / 2, fixed, small[0], small[1], small[2]);
    const bool flagged = fixed > 1e-5;
    double said = 0, bound = 0;
    EXPECT_EQ((phn_depth(loaded.model, &held, &said) & PHN_WARNING_OUTSIDE) != 0, flagged);
    EXPECT_EQ(said == 0, flagged);
    EXPECT_EQ((at(held).status & PHN_WARNING_OUTSIDE) != 0, flagged);
    const bool bounded = phn_bound(loaded.model, &held, &bound) >= 0;
    EXPECT_EQ(bound == PHN_NO_BOUND, flagged || !bounded);
  }
}

// Claim: node probes between nodes have the force, energy and field of phn_couple of one tool, but neither stiffness
// nor trained depth; wrong arguments are refused with zeros.
TEST_P(RoundTools, AreCoupledWhereTheyAreNodeProbes) {
  const LoadedModel nodes(write_model_text(small_model_of(GetParam())));
  const phn_tool held = tool(3, 5, 8, 0.5, 0.3, d[0], d[1], d[2]);
  Eigen::Vector3d force(1, 1, 1);
  Eigen::Vector3d expected;
  Eigen::Matrix3d stiffness;
  Points field(12, 3), expected_field(12, 3);
  phn_coupled coupled;
  double energy = 0, depth = 1;
  const int status = phn_couple(nodes.model, nodes.data, 1, &held, expected.data(), &coupled);
  ASSERT_GE(status, 0);
  ASSERT_GE(phn_coupled_deform(nodes.model, nodes.data, expected_field.data()), 0);
  EXPECT_EQ(phn_force(nodes.model, nodes.data, &held, force.data(), has_energy ? &energy : nullptr, nullptr), status);
  EXPECT_EQ(force, expected);
  EXPECT_EQ(energy, coupled.energy);
  EXPECT_GE(phn_deform(nodes.model, nodes.data, &held, field.data()), 0);
  EXPECT_EQ(field, expected_field);
  EXPECT_EQ(phn_force(nodes.model, nodes.data, &held, force.data(), nullptr, stiffness.data()), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(force.norm() + stiffness.norm(), 0);
  EXPECT_EQ(phn_depth(nodes.model, &held, &depth), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(depth, 0);
  phn_tool other = held;
  other.reserved[1] = 1;
  force = {1, 1, 1};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, &other, force.data(), nullptr, nullptr), PHN_ERROR_VERSION);
  EXPECT_EQ(force.norm(), 0);
  EXPECT_EQ(phn_force(loaded.model, nodes.data, &held, force.data(), nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, nullptr, force.data(), nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, &held, nullptr, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  const phn_tool nowhere = moved(held, {NAN, 0, 0});
  depth = 1;
  EXPECT_EQ(phn_depth(loaded.model, &nowhere, &depth), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(depth, 0);
}

}  // namespace
