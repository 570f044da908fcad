// Claims: Organ of phynness.hpp gives the bits and statuses of the C functions, of a model, a body and both; several
// threads share model and body; it can be moved, takes vectors of Eigen, and refuses arrays of a wrong length.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <phynness/formats/text_file.hpp>
#include <phynness/phynness_batch.hpp>
#include <random>
#include <thread>

#include "../block_body.hpp"
#include "loaded_body.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace phynness::test {
namespace {

template <class To, class From>
constexpr bool takes = std::is_convertible_v<From, To>;
static_assert(takes<In3, const double (&)[3]> && takes<In3, double (&)[3]>);
static_assert(takes<In3, const std::array<double, 3>&> && takes<Out3, std::array<double, 3>&>);
static_assert(takes<In3, const Eigen::Vector3d&> && takes<Out3, Eigen::Vector3d&>);
static_assert(takes<Out9, Eigen::Matrix3d&> && takes<Out3, Eigen::Map<Eigen::Vector3d>&>);
static_assert(!takes<In3, const double (&)[2]> && !takes<In3, const double (&)[4]>);
static_assert(!takes<In3, const std::array<double, 2>&> && !takes<In3, const std::array<float, 3>&>);
static_assert(!takes<Out3, const double (&)[3]> && !takes<Out3, const std::array<double, 3>&>);
static_assert(!takes<In3, const Eigen::VectorXd&> && !takes<Out9, Eigen::Vector3d&>);
static_assert(!takes<Out3, Eigen::Map<Eigen::Vector3d, 0, Eigen::InnerStride<2>>&>);
static_assert(!std::is_copy_constructible_v<Organ> && std::is_nothrow_move_constructible_v<Organ>);
static_assert(sizeof(Organ::Status) == sizeof(int));

phn_tool at_node(std::int32_t node, const std::array<double, 3>& d) {
  return {{node, -1, -1}, {1, 0, 0}, {d[0], d[1], d[2]}};
}

template <class T>
bool same(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

bool same(const phn_tool& a, const phn_tool& b) {
  return same(a.nodes, b.nodes) && same(a.weights, b.weights) && same(a.displacement, b.displacement);
}
bool same(const phn_contact_state& a, const phn_contact_state& b) {
  return same(a.force, b.force) && same(a.proxy, b.proxy) && same(a.normal, b.normal) && same(a.scale, b.scale) &&
         same(a.unbalanced, b.unbalanced) && same(a.held, b.held) && same(a.in_contact, b.in_contact);
}
bool same(const phn_contact_state (&a)[2], const phn_contact_state (&b)[2]) {
  return same(a[0], b[0]) && same(a[1], b[1]);
}

class OrganOfAModel : public ::testing::TestWithParam<Family> {
 protected:
  std::string text = write_model_text(GetParam() == Family::linear ? small_linear_model()
                                                                   : with_bound_between(small_model_of(GetParam())));
  LoadedModel c{text};
};
INSTANTIATE_TEST_SUITE_P(Families, OrganOfAModel, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(OrganOfAModel, HoldsAsC) {
  Organ organ(text, {}, 4);
  ASSERT_TRUE(organ && organ.status() == PHN_OK && organ.wrong_byte() == 0);
  EXPECT_EQ(organ.info().family, std::string(name(GetParam())));
  EXPECT_EQ(organ.body(), nullptr);
  EXPECT_EQ(organ.body_info().n_nodes, 0);
  ASSERT_EQ(organ.n_deform(), 36u);
  std::vector<double> field(36, 1), expected_field(36, 2);
  EXPECT_EQ(organ.deform(field), PHN_OK);
  EXPECT_EQ(field, std::vector<double>(36, 0.0)) << "before the first tool";
  const std::array<double, 3> inside{0.001, -0.002, 0.003}, outside{0.1, -0.2, 0.3}, nan{0, NAN, 0};
  for (const std::int32_t node : {3, 5, 8, 15, 4, -1})
    for (const std::array<double, 3>& d : {inside, outside, nan}) {
      const phn_tool tool = at_node(node, d);
      std::array<double, 3> force{}, expected{};
      std::array<double, 9> stiffness{}, expected_stiffness{};
      double energy = 1, expected_energy = 2;
      EXPECT_EQ(organ.hold(tool, force),
                phn_force(c.model, c.data, AtNode(node, d.data()), expected.data(), nullptr, nullptr));
      EXPECT_TRUE(same(force, expected));
      EXPECT_EQ(organ.deform(field), phn_deform(c.model, c.data, AtNode(node, d.data()), expected_field.data()));
      EXPECT_EQ(field, expected_field);
      double bound = -1, expected_bound = -2;
      EXPECT_EQ(organ.bound({&bound, 1}), phn_bound(c.model, AtNode(node, d.data()), &expected_bound));
      EXPECT_EQ(bound, expected_bound);
      EXPECT_EQ(organ.hold(tool, force, energy),
                phn_force(c.model, c.data, AtNode(node, d.data()), expected.data(), &expected_energy, nullptr));
      EXPECT_TRUE(same(force, expected) && energy == expected_energy);
      EXPECT_EQ(organ.hold(tool, force, energy, stiffness),
                phn_force(c.model, c.data, AtNode(node, d.data()), expected.data(), &expected_energy,
                          expected_stiffness.data()));
      EXPECT_TRUE(same(force, expected) && energy == expected_energy && same(stiffness, expected_stiffness));
      double depth = -2;
      const Trained trained(c.model, node, d.data());
      EXPECT_EQ(organ.depth(tool, depth), trained.status);
      EXPECT_EQ(depth, trained.depth);
    }
}

TEST(OrganOfARelaxingModel, RelaxesOneToolAndSeveralAsC) {
  Model model = small_model_of(Family::modal);
  model.relaxation.terms = Eigen::RowVector2d(0.5, 0.1);
  Organ organ(write_model_text(model), {}, 2);
  ASSERT_TRUE(organ) << organ.problem();
  const phn_tool tool = at_node(3, {0.001, -0.002, 0.003});
  phn_relaxing history{};
  for (int step = 0; step < 3; ++step) {
    double force[3], expected[3];
    ASSERT_EQ(organ.hold(tool, force), PHN_OK);
    const int status = phn_relax(&organ.relaxation(), &history, force, nullptr, 0.01, expected);
    if (step < 2)
      EXPECT_EQ(organ.relax(tool, 0.01, force), status);
    else
      EXPECT_EQ(organ.relax({&tool, 1}, 0.01, force), status) << "the same history";
    EXPECT_EQ(std::memcmp(force, expected, sizeof force), 0) << step;
  }
}

TEST_P(OrganOfAModel, HoldsPlacesAndSeveralToolsAsC) {
  Organ organ(text, {}, 4);
  phn_tool tools[2], expected_tool;
  const double above[3] = {0.3, 0.2, 0.9};
  double point[3], expected_point[3], distance = 0, expected_distance;
  EXPECT_EQ(organ.nearest(above, tools[0], point, distance),
            phn_nearest(c.model, above, &expected_tool, expected_point, &expected_distance));
  EXPECT_TRUE(same(tools[0], expected_tool) && same(point, expected_point));
  EXPECT_EQ(distance, expected_distance);
  EXPECT_EQ(organ.nearest({{0.9, 0.1, 0.2}}, tools[1]), PHN_OK);
  tools[0].displacement[1] = tools[1].displacement[2] = 0.002;

  std::vector<double> field(36), expected_field(36);
  double forces[6], expected[6];
  phn_coupled coupled;
  OrganReport report;
  EXPECT_EQ(organ.hold(tools, forces, &report), phn_couple(c.model, c.data, 2, tools, expected, &coupled));
  EXPECT_TRUE(same(forces, expected));
  EXPECT_EQ(report.energy_J, coupled.energy);
  EXPECT_EQ(report.residual_m, coupled.residual);
  EXPECT_EQ(organ.deform(field), phn_coupled_deform(c.model, c.data, expected_field.data()));
  EXPECT_EQ(field, expected_field);
  double bounds[2] = {1, 1};
  EXPECT_EQ(organ.bound(bounds), PHN_ERROR_UNDEFINED) << "a model has none of coupled tools";
  EXPECT_EQ(bounds[0], PHN_NO_BOUND);
  EXPECT_EQ(bounds[1], PHN_NO_BOUND);

  // A model of node probes couples one tool between nodes, too.
  for (const phn_tool& tool : tools) {
    double force[3], energy = -1;
    const int status = organ.info().has_energy != 0 ? organ.hold(tool, force, energy) : organ.hold(tool, force);
    EXPECT_EQ(status, phn_couple(c.model, c.data, 1, &tool, expected, &coupled));
    EXPECT_EQ(std::memcmp(force, expected, sizeof force), 0);
    if (organ.info().has_energy != 0) {
      EXPECT_EQ(energy, coupled.energy);
    }
    EXPECT_EQ(organ.deform(field), status | phn_coupled_deform(c.model, c.data, expected_field.data()));
    EXPECT_EQ(field, expected_field);
    double bound = 1, expected_bound = 2;
    EXPECT_EQ(organ.bound({&bound, 1}), phn_bound(c.model, &tool, &expected_bound));
    EXPECT_EQ(bound, expected_bound);
  }
  double one[3];
  EXPECT_EQ(organ.hold({tools, 1}, one, &report), phn_couple(c.model, c.data, 1, tools, expected, &coupled));
  EXPECT_EQ(std::memcmp(one, expected, sizeof one), 0);
  EXPECT_EQ(report.energy_J, coupled.energy);
}

class OrganOfABody : public ::testing::Test {
 protected:
  OrganOfABody() { phn_body_info(body, &info); }
  /// Of the top, on the half away from the fixed side.
  std::int32_t node_at(double y) const {
    Eigen::Index nearest = 0;
    (block.mesh.nodes.rowwise() - Eigen::RowVector3d(0.09, y, 0.03)).rowwise().norm().minCoeff(&nearest);
    return static_cast<std::int32_t>(nearest);
  }
  Block block;
  const phn_tool tools[2] = {at_node(node_at(0.03), {0.004, 0, 0.002}), at_node(node_at(0.09), {0, -0.003, 0})};
  std::string body_text = write_body_text(block.body), model_text = write_model_text(springs_on(block));
  LoadedBody loaded{body_text, 2};
  const phn_body* body = loaded.body;
  phn_body_state* state = loaded.state;
  phn_body_contents info{};
};

TEST_F(OrganOfABody, HoldsAsC) {
  Organ organ({}, body_text, 2, 5);
  ASSERT_TRUE(organ);
  EXPECT_EQ(organ.model(), nullptr);
  ASSERT_EQ(organ.n_deform(), 3 * static_cast<std::size_t>(info.n_nodes));
  std::vector<double> field(organ.n_deform()), expected_field(organ.n_deform());
  double forces[6], expected[6], bounds[2];
  phn_body_report pressed;
  OrganReport report;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(organ.hold(tools, forces, &report), phn_body_force(body, state, 2, tools, 5, expected, &pressed));
    EXPECT_TRUE(same(forces, expected));
    EXPECT_EQ(report.energy_J, pressed.energy);
    EXPECT_EQ(report.residual_m, pressed.residual_m);
    EXPECT_EQ(report.unbalanced, pressed.unbalanced);
    EXPECT_EQ(report.steps, pressed.steps);
    EXPECT_EQ(organ.deform(field), phn_body_deform(body, state, expected_field.data()));
    EXPECT_EQ(field, expected_field);
    EXPECT_EQ(organ.bound(bounds), phn_body_bound(body, state, 2, expected));
  }
  EXPECT_NE(forces[0], 0);
  EXPECT_GE(phn_body_force(organ.body(), organ.state(), 1, tools, 5, expected, nullptr), PHN_OK);  // another user
  EXPECT_EQ(organ.bound(bounds), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(bounds[0], PHN_NO_BOUND);
  EXPECT_EQ(bounds[1], PHN_NO_BOUND);
  EXPECT_GE(organ.hold(tools, forces), PHN_OK);
  EXPECT_GE(phn_body_force(body, state, 1, tools, 5, expected, nullptr), PHN_OK);
  EXPECT_GE(phn_body_force(body, state, 2, tools, 5, expected, nullptr), PHN_OK);
  double energy = 1, stiffness[9] = {1}, one[3] = {1, 1, 1};
  EXPECT_EQ(organ.hold(tools[0], one, energy), phn_body_force(body, state, 1, tools, 5, expected, &pressed));
  EXPECT_EQ(std::memcmp(one, expected, sizeof one), 0);
  EXPECT_EQ(energy, pressed.energy);
  EXPECT_EQ(organ.hold(tools[0], one, energy, stiffness), PHN_ERROR_UNDEFINED);
  EXPECT_TRUE(one[0] == 0 && energy == 0 && stiffness[0] == 0);
  double depth = 0;
  EXPECT_EQ(organ.depth(tools[0], depth), PHN_OK);
  EXPECT_EQ(depth, info.max_displacement_m);

  EXPECT_EQ(organ.reset(), PHN_OK);
  loaded.rest();
  EXPECT_EQ(organ.hold(tools, forces), phn_body_force(body, state, 2, tools, 5, expected, nullptr));
  EXPECT_TRUE(same(forces, expected)) << "from rest";
}

// One tool is answered by the model, two by the body; both deform the same nodes, so that a picture does not jump.
TEST_F(OrganOfABody, BesideAModelAnswersSeveral) {
  Organ organ(model_text, body_text, 2, 5);
  ASSERT_TRUE(organ);
  const LoadedModel c(model_text, 2);
  ASSERT_EQ(organ.n_deform(), 3 * static_cast<std::size_t>(organ.info().n_output));
  ASSERT_LT(organ.info().n_output, info.n_nodes);
  std::vector<double> field(organ.n_deform()), expected_field(3 * static_cast<std::size_t>(info.n_nodes));
  double force[3], forces[6], expected[6];
  EXPECT_EQ(organ.hold(tools[0], force),
            phn_force(c.model, c.data, AtNode(tools[0].nodes[0], tools[0].displacement), expected, nullptr, nullptr));
  EXPECT_EQ(std::memcmp(force, expected, sizeof force), 0);
  EXPECT_EQ(organ.deform(field),
            phn_deform(c.model, c.data, AtNode(tools[0].nodes[0], tools[0].displacement), expected_field.data()));
  EXPECT_EQ(std::memcmp(field.data(), expected_field.data(), 8 * field.size()), 0);

  // The body did not follow the first tool: its forces are there in the first call, and then go on by five steps.
  EXPECT_EQ(organ.hold(tools, forces), PHN_OK);
  EXPECT_EQ(phn_body_force(body, state, 2, tools, Organ::steps_to_follow, expected, nullptr), PHN_OK);
  EXPECT_TRUE(same(forces, expected));
  EXPECT_GT(std::fabs(forces[0]) + std::fabs(forces[1]) + std::fabs(forces[2]), 0);
  phn_tool moved[] = {tools[0], tools[1]};
  moved[1].displacement[2] *= 1.01;
  EXPECT_EQ(organ.hold(moved, forces), phn_body_force(body, state, 2, moved, 5, expected, nullptr));
  EXPECT_TRUE(same(forces, expected));
  EXPECT_EQ(organ.deform(field), phn_body_deform(body, state, expected_field.data()));
  double largest = 0;
  for (std::int32_t o = 0; o < organ.info().n_output; ++o)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t node = organ.info().output_nodes[o];  // the body's nodes are all of the mesh
      EXPECT_EQ(field[3 * static_cast<std::size_t>(o) + k], expected_field[3 * static_cast<std::size_t>(node) + k]);
      largest = std::max(largest, std::fabs(field[3 * static_cast<std::size_t>(o) + k]));
    }
  EXPECT_GT(largest, 0.001);
}

TEST_F(OrganOfABody, TouchesAsC) {
  Organ organ(model_text, body_text, 2, 5);
  std::size_t bytes = 0;
  phn_contact* contact = nullptr;
  ASSERT_EQ(phn_body_contact_size(body, 2, &bytes), PHN_OK);
  std::vector<char> of_contact(bytes);
  ASSERT_EQ(phn_body_contact_init(of_contact.data(), bytes, body, 2, 5, &contact), PHN_OK);
  for (const double z : {0.05, 0.04, 0.034, 0.033}) {
    const phn_contact_tool spheres[2] = {{{0.08, 0.03, z}, 0.005, 0, PHN_TOOL_PRESS},
                                         {{0.08, 0.09, z}, 0.005, 0, PHN_TOOL_PRESS}};
    phn_contact_state states[2], expected[2];
    OrganReport report;
    phn_contact_report pressed;
    EXPECT_EQ(organ.touch(spheres, states, &report), phn_contact_step(contact, 2, spheres, expected, &pressed));
    EXPECT_TRUE(same(states, expected));
    EXPECT_EQ(report.energy_J, pressed.energy);
    EXPECT_EQ(states[0].in_contact, z < 0.035 ? 1 : 0);
  }
}

TEST_F(OrganOfABody, OfAModelAloneTouchesAsC) {
  Organ organ(model_text);
  const LoadedModel c(model_text, 1);
  std::size_t bytes = 0;
  phn_contact* contact = nullptr;
  ASSERT_EQ(phn_contact_size(c.model, 1, &bytes), PHN_OK);
  std::vector<char> of_contact(bytes);
  ASSERT_EQ(phn_contact_init(of_contact.data(), bytes, c.model, 1, &contact), PHN_OK);
  std::vector<double> field(organ.n_deform()), expected_field(organ.n_deform());
  for (const double z : {0.05, 0.04, 0.034, 0.033}) {
    const phn_contact_tool sphere[1] = {{{0.08, 0.03, z}, 0.005, 0, PHN_TOOL_PRESS}};
    phn_contact_state states[1], expected;
    OrganReport report;
    phn_contact_report coupled;
    EXPECT_EQ(organ.touch(sphere, states, &report), phn_contact_step(contact, 1, sphere, &expected, &coupled));
    EXPECT_TRUE(same(states[0], expected));
    EXPECT_EQ(report.energy_J, coupled.energy);
    EXPECT_EQ(states[0].in_contact, z < 0.035 ? 1 : 0);
    EXPECT_EQ(organ.deform(field), phn_contact_deform(contact, expected_field.data()));
    EXPECT_EQ(field, expected_field);
    double bound = 1;
    EXPECT_EQ(organ.bound({&bound, 1}), PHN_ERROR_UNDEFINED);
    EXPECT_EQ(bound, PHN_NO_BOUND);
  }
  EXPECT_NE(Eigen::Map<const Eigen::VectorXd>(field.data(), std::ssize(field)).norm(), 0);
  EXPECT_EQ(organ.reset(), PHN_OK);
  EXPECT_EQ(organ.deform(field), PHN_OK);
  EXPECT_EQ(field, std::vector<double>(field.size(), 0.0));
}

TEST_F(OrganOfABody, ThreadsShareIt) {
  Organ first(model_text, body_text, 2, 5);
  double alone[6];
  EXPECT_GE(first.hold(tools, alone), 0);
  EXPECT_GE(first.reset(), 0);
  std::array<Organ, 4> organs;
  for (Organ& organ : organs) organ = first.another();
  first = Organ();  // model and body live as long as one that has them
  std::array<int, 4> wrong{};
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < organs.size(); ++i)
    threads.emplace_back([&, i] {
      for (int round = 0; round < 3; ++round) {
        double forces[6], one[3];
        wrong[i] += organs[i].reset() < 0 || organs[i].hold(tools, forces) < 0 || !same(forces, alone);
        wrong[i] += organs[i].hold(tools[i % 2], one) < 0;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

TEST_P(OrganOfAModel, ABatchAnswersEachToolAlone) {
  Organ organ(text);
  Batch batch(organ, 3);
  ASSERT_EQ(batch.status(), PHN_OK);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-0.004, 0.004);
  constexpr std::size_t n = 2000;  // more than three shares
  std::vector<double> x(3 * n), points(3 * n), forces(3 * n), distances(n);
  std::vector<phn_tool> tools(n);
  std::vector<int> statuses(n), found(n);
  for (double& k : x) k = number(random);
  x[3 * 700] = NAN;
  ASSERT_EQ(batch.nearest(x, tools, points, distances, found), PHN_OK);
  for (std::size_t i = 0; i < n; ++i) std::generate_n(tools[i].displacement, 3, [&] { return number(random); });
  tools[1500].displacement[1] = NAN;
  ASSERT_EQ(batch.hold(tools, forces, statuses), PHN_OK);
  for (std::size_t i = 0; i < n; ++i) {
    phn_tool tool;
    std::array<double, 3> from{x[3 * i], x[3 * i + 1], x[3 * i + 2]}, point{}, force{};
    double distance = 0;
    ASSERT_EQ(found[i], organ.nearest(from, tool, point, distance));
    ASSERT_TRUE(same(tool.nodes, tools[i].nodes) && same(tool.weights, tools[i].weights) && distance == distances[i] &&
                std::equal(point.begin(), point.end(), &points[3 * i]))
        << i;
    ASSERT_EQ(statuses[i], organ.hold(tools[i], force));
    ASSERT_TRUE(std::equal(force.begin(), force.end(), &forces[3 * i])) << i;
  }
  EXPECT_EQ(found[700], PHN_ERROR_NOT_FINITE);
  EXPECT_LT(statuses[1500], 0);
  EXPECT_EQ(batch.hold(tools, {forces.data(), 3 * n - 1}, statuses), PHN_ERROR_BUFFER);
  EXPECT_EQ(batch.nearest({x.data(), 5}, {tools.data(), 2}, points, distances, found), PHN_ERROR_BUFFER);
  EXPECT_EQ(batch.hold({}, {}, {}), PHN_OK);
  EXPECT_EQ(Batch(Organ()).hold(tools, forces, statuses), PHN_ERROR_ARGUMENT);
}

TEST_F(OrganOfABody, ReadsFiles) {
  const auto path =
      std::filesystem::temp_directory_path() / ("phynness_organ_" + std::to_string(std::random_device{}()));
  write_model_texts(path, {model_text, write_mesh_text(block.mesh)});
  const std::string folder = path.string(), file = (path / "body.txt").string();
  write_text_file(file, body_text);
  double force[3], expected[3];
  EXPECT_GE(Organ(model_text).hold(tools[0], expected), 0);
  for (const std::string& model : {folder, folder + "/model.txt"}) {
    Organ organ = Organ::read(model.c_str(), file.c_str(), 2);
    ASSERT_TRUE(organ && organ.body() != nullptr);
    EXPECT_GE(organ.hold(tools[0], force), 0);
    EXPECT_TRUE(same(force, expected));
  }
  EXPECT_TRUE(Organ::read(nullptr, file.c_str()));
  EXPECT_EQ(Organ::read(folder.c_str()).problem(), "");
  // Claim: a refusal names the file, and says what is wrong with it.
  const std::string mesh = folder + "/mesh.txt", none = "/no/such/folder";
  const auto refused = [](const char* model, const char* body, int status, const std::string& problem) {
    const Organ organ = Organ::read(model, body);
    EXPECT_EQ(organ.status(), status);
    EXPECT_EQ(organ.problem().substr(0, problem.size()), problem);
    EXPECT_EQ(organ.another().problem(), organ.problem());
  };
  refused(none.c_str(), nullptr, PHN_ERROR_NOT_A_MODEL, none + ": neither a model.txt nor a folder with one");
  refused(folder.c_str(), none.c_str(), PHN_ERROR_NOT_A_MODEL, none + ": no file that can be read");
  refused(folder.c_str(), folder.c_str(), PHN_ERROR_NOT_A_MODEL, folder + ": no file that can be read");
  refused(file.c_str(), nullptr, PHN_ERROR_NOT_A_MODEL, file + ": this is a body, and no model");
  refused(nullptr, (folder + "/model.txt").c_str(), PHN_ERROR_NOT_A_MODEL, folder + "/model.txt: this is a model");
  refused(folder.c_str(), mesh.c_str(), PHN_ERROR_NOT_A_MODEL, mesh + ": this is not a phynness body, at byte 1");
  refused(mesh.c_str(), nullptr, PHN_ERROR_NOT_A_MODEL,
          mesh + ": " + phn_status_message(PHN_ERROR_NOT_A_MODEL) + ", at byte 1");
  refused(nullptr, nullptr, PHN_ERROR_ARGUMENT, phn_status_message(PHN_ERROR_ARGUMENT));
  std::filesystem::remove_all(path);
}

TEST_F(OrganOfABody, MisuseHasAStatus) {
  Organ none, bad("solid liver");
  EXPECT_EQ(none.status(), PHN_ERROR_ARGUMENT);
  EXPECT_FALSE(bad);
  EXPECT_EQ(bad.status(), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(bad.wrong_byte(), 1u);
  EXPECT_STREQ(bad.status().message(), phn_status_message(PHN_ERROR_NOT_A_MODEL));
  const Organ bad_body(model_text, "solid liver");
  EXPECT_TRUE(bad_body.model() != nullptr && bad_body.status() == PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(Organ({}, {}).status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(Organ(model_text, {}, 0).status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(Organ(model_text, {}, 1, 0).status(), PHN_ERROR_ARGUMENT);
  Model other = springs_on(block);
  other.mesh_hash = "fedcba9876543210";
  const Organ of_another(write_model_text(other), body_text);
  EXPECT_EQ(of_another.status(), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(of_another.problem(), "the body: the body is of another mesh than the model");

  const phn_contact_tool sphere[1] = {{{0.08, 0.03, 0.1}, 0.005, 0, PHN_TOOL_PRESS}};
  phn_contact_state state[1];
  double force[3] = {1, 1, 1}, number = 1, stiffness[9];
  phn_tool found;
  for (Organ* organ : {&none, &bad}) {
    Organ copy = organ->another();
    for (Organ* any : {organ, &copy}) {
      EXPECT_EQ(any->hold(tools[0], force), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(force[0], 0);
      EXPECT_EQ(any->hold(tools[0], force, number, stiffness), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->hold({tools, 1}, force), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->touch(sphere, state), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->deform({force, 3}), PHN_ERROR_ARGUMENT);
      EXPECT_LT(any->bound({force, 3}), 0);
      EXPECT_EQ(force[2], PHN_NO_BOUND);
      EXPECT_EQ(any->depth(tools[0], number), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->nearest(force, found), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->reset(), PHN_ERROR_ARGUMENT);
      EXPECT_EQ(any->n_deform(), 0u);
    }
  }
  Organ organ(model_text, body_text, 2);
  std::vector<double> shorter(organ.n_deform() - 1, 7);
  EXPECT_EQ(organ.deform(shorter), PHN_ERROR_BUFFER);
  EXPECT_EQ(shorter, std::vector<double>(shorter.size(), 7.0));
  const phn_tool nine[9] = {};
  double forces[27];
  EXPECT_EQ(organ.hold(nine, {forces, 26}), PHN_ERROR_BUFFER);
  EXPECT_EQ(organ.hold(nine, forces), PHN_ERROR_TOO_MANY_TOOLS);
  EXPECT_EQ(forces[26], 0);
  EXPECT_EQ(organ.hold({nine, 3}, forces), PHN_ERROR_TOOLS);
  EXPECT_EQ(organ.bound({forces, 0}), PHN_ERROR_BUFFER);
  EXPECT_EQ(organ.touch(sphere, {state, 0}), PHN_ERROR_BUFFER);

  const Organ moved = std::move(organ);
  EXPECT_TRUE(moved);
  EXPECT_FALSE(organ);  // NOLINT(bugprone-use-after-move): what a move leaves is the claim
  EXPECT_EQ(organ.hold(tools[0], force), PHN_ERROR_ARGUMENT);
  Organ::Status status(PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE);
  EXPECT_TRUE(status.ok() && status.outside() && status.incomplete() && !status.unsettled() && !status.are_near());
  status = PHN_ERROR_ARGUMENT;
  EXPECT_FALSE(status.ok() || status.outside() || status.incomplete());
}

}  // namespace
}  // namespace phynness::test
