#include <gtest/gtest.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <locale>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model.hpp>
#include <random>
#include <sstream>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

std::string with_checksum(const std::string& body) {
  Fnv1a64 hash;
  hash.add(body);
  return body + "checksum " + hash.hex() + "\n";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  return with_checksum(text.substr(0, text.rfind("checksum ")));
}

/// Linear, one active node: short enough to replace every byte by several.
Model one_linear_node() {
  Model model = small_linear_model();
  model.nodes.resize(1);
  return model;
}

/// Modal, one active node with near nodes.
Model one_modal_node() {
  Model model = small_modal_model(2, 2, 2, 2);
  model.nodes.resize(1);
  return model;
}

/// The same with a field.
Model one_field_node() {
  Numbers numbers;
  Model model = one_modal_node();
  model.fields = {
      {"f", "Pa", 1, 2.5, random_table(static_cast<Eigen::Index>(model.output.size()), 1, 1, numbers)}};
  ModalDeformation& of_node = model.nodes[0].fields.emplace_back();
  of_node.near = {3};
  of_node.weights = random_table(2 + 9, 1, 1, numbers);
  of_node.mixing = of_node.near_modes = random_table(1, 1, 1, numbers);
  return model;
}

class ModelTextOf : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, ModelTextOf, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

std::string refusal(const std::string& text) {
  try {
    read_model_text(text, "model.txt");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "accepted";
}

// Claim: a model comes back bit for bit, scaled centers included, though the file holds only their indices.
TEST(ModelText, RoundTripsBitForBit) {
  Model model = small_model();
  // Values that a decimal or sloppy writer loses: negative zero, the smallest subnormal, the largest double's
  // neighbour.
  model.nodes[0].force.weights(0, 0) = -0.0;
  model.nodes[0].force.weights(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].force.weights(0, 2) = 0x1.ffffffffffffep+900;
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].force.centers, model.nodes[i].force.centers);
    EXPECT_EQ(again.nodes[i].deformation.centers, model.nodes[i].deformation.centers);
    EXPECT_EQ(again.nodes[i].deformation.weights, model.nodes[i].deformation.weights);
    EXPECT_EQ(again.nodes[i].prescribed_weight, model.nodes[i].prescribed_weight);
    EXPECT_EQ(again.nodes[i].n_incomplete, model.nodes[i].n_incomplete);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].force.weights(0, 0)));
  EXPECT_EQ(again.title, model.title);
  EXPECT_EQ(again.fixed, model.fixed);
  EXPECT_EQ(again.fixed_points, model.fixed_points);
  EXPECT_EQ(again.surface, model.surface);
}

// Claim: a linear model comes back bit for bit.
TEST(ModelText, LinearResponsesRoundTripBitForBit) {
  Model model = small_linear_model();
  model.nodes[0].linear.unit_responses(0, 0) = -0.0;
  model.nodes[0].linear.unit_responses(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].linear.unit_responses(0, 2) = -largest_linear_entry;
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  EXPECT_EQ(again.family, Family::linear);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].linear.stiffness, model.nodes[i].linear.stiffness);
    EXPECT_EQ(again.nodes[i].linear.unit_responses, model.nodes[i].linear.unit_responses);
    EXPECT_EQ(again.nodes[i].prescribed_weight, model.nodes[i].prescribed_weight);
    EXPECT_EQ(again.nodes[i].trained_depth_m, model.nodes[i].trained_depth_m);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].linear.unit_responses(0, 0)));
}

// Claim: a modal model comes back bit for bit, integers and scales of tables included, with and without
// modes.
TEST(ModelText, ModalModelsRoundTripBitForBit) {
  Model model = small_modal_model();
  model.nodes[0].conservative.coefficients(0, 0) = -0.0;
  model.nodes[0].conservative.coefficients(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].conservative.coefficients(0, 2) = -largest_linear_entry;
  model.nodes[0].modal.mixing.entries(0, 0) = -32767;
  ModalDeformation& bare = model.nodes[3].modal;
  for (ScaledTable* table : {&bare.weights, &bare.mixing, &bare.near_modes})
    *table = scaled_table(Eigen::MatrixXd(table->rows(), 0));
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  EXPECT_EQ(again.family, Family::modal);
  const auto equal = [](const ScaledTable& a, const ScaledTable& b) {
    return a.scale == b.scale && a.entries == b.entries;
  };
  EXPECT_TRUE(equal(again.shared.modes, model.shared.modes));
  EXPECT_EQ(again.shared.centers, model.shared.centers);
  EXPECT_EQ(again.shared.shape, model.shared.shape);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const ConservativeNetwork &force = again.nodes[i].conservative, &wanted = model.nodes[i].conservative;
    EXPECT_EQ(force.shape, wanted.shape);
    EXPECT_EQ(force.stiffness, wanted.stiffness);
    EXPECT_EQ(force.centers, wanted.centers);
    EXPECT_EQ(force.coefficients, wanted.coefficients);
    EXPECT_TRUE(equal(again.nodes[i].modal.weights, model.nodes[i].modal.weights));
    EXPECT_TRUE(equal(again.nodes[i].modal.mixing, model.nodes[i].modal.mixing));
    EXPECT_TRUE(equal(again.nodes[i].modal.near_modes, model.nodes[i].modal.near_modes));
    EXPECT_EQ(again.nodes[i].modal.near, model.nodes[i].modal.near);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].conservative.coefficients(0, 0)));
}

// Claim: so does one with fields; without them the text has no trace of any.
TEST(ModelText, FieldsRoundTripBitForBit) {
  const Model model = small_field_model();
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  const auto equal = [](const ScaledTable& a, const ScaledTable& b) {
    return a.scale == b.scale && a.entries == b.entries;
  };
  ASSERT_EQ(again.fields.size(), 2u);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_EQ(again.fields[f].name, model.fields[f].name);
    EXPECT_EQ(again.fields[f].unit, model.fields[f].unit);
    EXPECT_EQ(again.fields[f].degree, model.fields[f].degree);
    EXPECT_EQ(again.fields[f].scale, model.fields[f].scale);
    EXPECT_TRUE(equal(again.fields[f].modes, model.fields[f].modes));
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      EXPECT_TRUE(equal(again.nodes[i].fields[f].weights, model.nodes[i].fields[f].weights));
      EXPECT_TRUE(equal(again.nodes[i].fields[f].mixing, model.nodes[i].fields[f].mixing));
      EXPECT_TRUE(equal(again.nodes[i].fields[f].near_modes, model.nodes[i].fields[f].near_modes));
      EXPECT_EQ(again.nodes[i].fields[f].near, model.nodes[i].fields[f].near);
    }
  }
  EXPECT_EQ(write_model_text(small_modal_model()).find("field"), std::string::npos);
}

// Claim: a scaled table holds every number to 1 / 65534 of its column's largest, and zeros as zeros.
TEST(ModelText, TablesRoundToTheirColumns) {
  Numbers numbers;
  Eigen::MatrixXd values(50, 4);
  for (Eigen::Index r = 0; r < 50; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c) values(r, c) = std::pow(10, 3 * c - 6) * numbers.next();
  }
  values.col(2).setZero();
  const ScaledTable table = scaled_table(values);
  for (Eigen::Index c = 0; c < 4; ++c) {
    // 1e-12 for the rounding of scale and product.
    EXPECT_LE((table.values().col(c) - values.col(c)).cwiseAbs().maxCoeff(),
              values.col(c).cwiseAbs().maxCoeff() / 65534 * (1 + 1e-12));
  }
  EXPECT_EQ(table.values().col(2).norm(), 0);
}

// Claim: networks are laid out as formats/model.md has it, so models that exist stay readable. The first
// word of every line from the family on; # for a line that begins with a number.
TEST(ModelText, NetworksAreLaidOutAsDescribed) {
  Model model = small_model(1, 1);
  model.nodes.resize(1);
  const std::string text = write_model_text(model);
  std::istringstream lines(text.substr(text.find("\nfamily") + 1));
  std::string line, layout;
  while (std::getline(lines, line)) {
    const std::string word = line.substr(0, line.find(' '));
    layout += word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos ? word + ' ' : "#";
  }
  const std::string transforms =
      "input_center input_half_range output_center output_half_range spread bias #";
  EXPECT_EQ(layout,
            "family title software mesh_hash physics_hash max_displacement_m mesh_nodes directions ####"
            "displacements ########fixed ##output ############surface ####active node point prescribed #incomplete "
            "trained_depth ####force " +
                transforms + "deformation " + transforms + "checksum ");
}

struct CommaNumbers : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// Claim: the locale of the process changes neither what is written nor what is read. The C++ locale is made
// here; the C locale takes part where the system has one with a comma.
TEST(ModelText, IgnoresTheLocale) {
  const std::string text = write_model_text(small_model());
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaNumbers));
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(write_model_text(small_model()), text);
  EXPECT_EQ(write_model_text(read_model_text(text, "model.txt")), text);
  std::locale::global(before);
  std::setlocale(LC_ALL, "C");
}

// Claim: each defect has its own message.
TEST(ModelText, RefusalsSayWhatIsWrong) {
  const std::string text = write_model_text(small_model());
  std::string corrupted = text;
  corrupted[text.size() / 2] ^= 1;
  const std::pair<std::string, const char*> cases[] = {
      {"solid liver\nendsolid\n", "not a phynness model"},
      {"", "not a phynness model"},
      {text.substr(0, text.size() - 1), "truncated"},
      {text.substr(0, text.size() / 2), "truncated"},
      {text.substr(0, 5), "truncated"},
      {corrupted, "corrupted"},
      {replaced(text, "phynness-model 2\n", "phynness-model 3\n"), "another version"},
      {replaced(text, "phynness-model 2\n", "phynness-model 2\r\n"), "line endings"},
      {replaced(text, "family rbfn", "family tree"), "family"},
      {replaced(text, "spread 1.", "spread 1,"), "comma"},
      {replaced(text, "spread 1.", "spread 1x"), "malformed number"},
      {replaced(text, "spread ", "spread nan "), "not finite"},
      {replaced(text, "spread ", "spread -inf "), "not finite"},
      {replaced(text, "spread ", "spread -"), "must be positive"},
      {replaced(text, "output 12", "output 2000000000"), "larger than the rest"},
      {replaced(text, "output 12", "output -1"), "out of range"},
      {replaced(text, "output 12", "output 99999999999999999999"), "out of range"},
      {replaced(text, "force 5", "force 4"), "expected 'deformation'"},
      {replaced(text, "mesh_nodes 20", "mesh_nodes 9"), "node number is out of range"},
      {replaced(text, "\nnode 5\n", "\nnode 3\n"), "must ascend"},
      {replaced(text, "checksum", "surplus\nchecksum"), "after the last"},
  };
  const std::string linear = write_model_text(small_linear_model());
  const std::pair<std::string, const char*> linear_cases[] = {
      {linear.substr(0, linear.size() / 2), "truncated"},
      {replaced(linear, "family linear", "family rbfn"), "expected 'force'"},
      {replaced(text, "family rbfn", "family linear"), "expected 'stiffness'"},
      {replaced(linear, "stiffness ", "stiffness 1p+400 "), "stiffness is beyond 1e100"},
      {replaced(linear, "stiffness ", "stiffness nan "), "not finite"},
      {replaced(linear, "stiffness ", "stiffness 0p+0 "), "more than it should"},
      {replaced(linear, "unit_responses\n", ""), "expected 'unit_responses'"},
      {replaced(linear, "unit_responses\n", "unit_responses\n-1p+400 "), "unit response is beyond 1e100"},
      {replaced(linear, "output 12", "output 11"), ""},
      {replaced(linear, "checksum", "0p+0\nchecksum"), "after the last"},
  };
  const std::string modal = write_model_text(small_modal_model());
  const std::pair<std::string, const char*> modal_cases[] = {
      {replaced(modal, "family modal", "family linear"), "expected 'active'"},
      {replaced(modal, "shared_modes 6", "shared_modes 1025"), "out of range 0 ... 1024"},
      {replaced(modal, "\ndeformation 3", "\ndeformation 1025"), "out of range 0 ... 1024"},
      {replaced(modal, "\nmodes ", "\nmodes -"), "scale is negative"},
      {replaced(modal, "\nweights ", "\nweights 1p+5 "), "scale is negative or too large"},
      {replaced(modal, "\nshape 1", "\nshape -1"), "must be positive"},
      {replaced(modal, "\nshape ", "\nshape 1p+20 "), "holds more"},
      {replaced(modal, "stiffness ", "stiffness 1p+400 "), "stiffness is beyond 1e100"},
      {replaced(modal, "near 4\n0\n1\n2\n4\n", "near 4\n0\n1\n1\n4\n"), "must ascend"},
      {replaced(modal, "near 4\n0\n1\n2\n4\n", "near 4\n0\n1\n2\n12\n"), "near node is out of range"},
      {replaced(modal, "near 4", "near 2000000000"), "larger than the rest"},
      {replaced(modal, "amplitude_centers 4", "amplitude_centers 30000"), ""},
      {replaced(modal, "checksum", "0\nchecksum"), "after the last"},
  };
  for (const auto& [damaged, message] : modal_cases) {
    EXPECT_NE(refusal(damaged), "accepted");
    EXPECT_NE(refusal(damaged).find(message), std::string::npos)
        << refusal(damaged) << "\nshould say: " << message;
  }
  for (const auto& [damaged, message] : linear_cases) {
    EXPECT_NE(refusal(damaged), "accepted");
    EXPECT_NE(refusal(damaged).find(message), std::string::npos)
        << refusal(damaged) << "\nshould say: " << message;
  }
  for (const auto& [damaged, message] : cases) {
    EXPECT_NE(refusal(damaged).find(message), std::string::npos)
        << refusal(damaged) << "\nshould say: " << message;
  }
}

// Claim: host reader and runtime agree on what is a model, whatever single byte is replaced under a good
// checksum.
TEST_P(ModelTextOf, HostAndRuntimeRefuseTheSame) {
  const std::string text = write_model_text(GetParam() == Family::linear  ? one_linear_node()
                                            : GetParam() == Family::modal ? one_field_node()
                                                                          : small_model(1, 1));
  const std::string body = text.substr(0, text.rfind("checksum "));
  for (std::size_t at = body.find("family"); at < body.size(); at += 1) {
    for (const char c : {'2', ',', '-', 'p'}) {
      std::string damaged = body;
      damaged[at] = c;
      damaged = with_checksum(damaged);
      bool host = true;
      try {
        read_model_text(damaged, "model.txt");
      } catch (const Error&) {
        host = false;
      }
      std::vector<char> memory(1 << 18);
      const phn_model* model = nullptr;
      const int status = phn_model_init(memory.data(), memory.size(), damaged.data(), damaged.size(), &model);
      ASSERT_EQ(host, status == PHN_OK) << "byte " << at << " -> " << c << "\n" << damaged.substr(at - 5, 20);
    }
  }
}

// Claim: what cannot be stored is not written.
TEST(ModelText, WriterRefusesWhatTheFormatCannotHold) {
  Model model = small_model();
  model.nodes[0].force.weights(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_model_text(model), Error);
  model = small_model();
  model.nodes[0].deformation.centers(0, 0) += 1e-12;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_model();
  model.family = Family::modal;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.stiffness(0, 1) += 1e-12;
  EXPECT_THROW(write_model_text(model), Error) << "not symmetric";
  model = small_linear_model();
  model.nodes[0].linear.stiffness(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.unit_responses(2, 3) = 1.01e100;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.unit_responses.conservativeResize(11, 9);
  EXPECT_THROW(write_model_text(model), Error);
  const auto refused = [](auto change) {
    Model modal = small_modal_model();
    change(modal);
    EXPECT_THROW(write_model_text(modal), Error);
  };
  refused([](Model& m) { m.nodes[0].conservative.stiffness(0, 1) += 1e-12; });
  refused([](Model& m) { m.nodes[0].conservative.coefficients(0, 0) = 1.01e100; });
  refused([](Model& m) { m.nodes[0].conservative.centers[0] = 8; });
  refused([](Model& m) { m.nodes[0].conservative.centers.pop_back(); });
  refused([](Model& m) { m.nodes[0].conservative.shape = 0.9e-6; });
  refused([](Model& m) { m.shared.shape = 1.1e6; });
  refused([](Model& m) { m.shared.modes.scale[0] = -1; });
  refused([](Model& m) { m.shared.modes.entries(0, 0) = -32768; });
  refused([](Model& m) { m.nodes[0].modal.mixing.scale[0] = 31; });
  refused([](Model& m) { m.nodes[0].modal.weights.scale[0] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](Model& m) { m.nodes[0].modal.near.pop_back(); });
  refused([](Model& m) { m.shared.centers.pop_back(); });
}

struct ModelFolder {
  ModelFolder()
      : path(std::filesystem::temp_directory_path() /
             ("phynness_model_" + std::to_string(std::random_device{}()))) {
    mesh.nodes = Points::Random(20, 3);
    mesh.cells.resize(1, 4);
    mesh.cells << 0, 1, 2, 3;
    // Positive orientation, which mesh.txt demands.
    mesh.nodes.topRows(4) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    mesh.surface = boundary_triangles(mesh.cells);
    model = small_model();
    model.mesh_hash = mesh_hash(mesh);
  }
  ~ModelFolder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
  Mesh mesh;
  Model model;
};

// Claim: a model directory holds exactly its two files, also when it replaces an older one, and reads back
// equal.
TEST(ModelDirectory, HoldsExactlyTwoFiles) {
  ModelFolder folder;
  write_model_dir(folder.path, folder.model, folder.mesh);
  write_model_dir(folder.path, folder.model, folder.mesh);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"mesh.txt", "model.txt"}));
  const ModelDir found = read_model_dir(folder.path);
  EXPECT_EQ(found.model_text, write_model_text(folder.model));
  EXPECT_EQ(mesh_hash(found.mesh), folder.model.mesh_hash);
}

// Claim: a model never meets another mesh, neither on writing nor on reading; a missing file is named.
TEST(ModelDirectory, RefusesAnotherMesh) {
  ModelFolder folder, other;
  other.mesh.nodes(0, 0) -= 0.5;
  EXPECT_THROW(write_model_dir(folder.path, folder.model, other.mesh), Error);
  write_model_dir(folder.path, folder.model, folder.mesh);
  std::ofstream(folder.path / "mesh.txt", std::ios::binary) << write_mesh_text(other.mesh);
  try {
    read_model_dir(folder.path);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("not the mesh"), std::string::npos) << error.what();
  }
  std::filesystem::remove(folder.path / "mesh.txt");
  EXPECT_THROW(read_model_dir(folder.path), Error);
}

// Claim: formats/model.md suffices for another language. A reader written from that page in Python's standard
// library agrees with the runtime to 1e-12 of the largest number of each kind (force, displacement, energy,
// stiffness): both round in double, in different orders; but modal displacements, which the runtime sums as
// floats, to 1e-5. 1e-16 is what the reader's terms leave at rest, where the runtime's cancel exactly.
TEST_P(ModelTextOf, AReaderInAnotherLanguageAgrees) {
  const Model model = GetParam() == Family::modal ? small_field_model() : small_model_of(GetParam());
  const std::string text = write_model_text(model);
  const LoadedModel loaded(text);
  const auto folder =
      std::filesystem::temp_directory_path() / ("phynness_reader_" + std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "model.txt", std::ios::binary) << text;
  const Eigen::Vector3d probes[] = {{0, 0, 0}, {0.004, -0.002, 0.001}, {-0.012, 0.003, 0.01}};
  {
    std::ofstream queries(folder / "queries");
    for (const ActiveNodeModel& node : model.nodes) {
      for (const Eigen::Vector3d& d : probes) {
        char line[200];
        std::snprintf(line, sizeof line, "%d %a %a %a\n", node.node, d[0], d[1], d[2]);
        queries << line;
      }
    }
  }
  const std::string command = std::string(PHYNNESS_PYTHON " " PHYNNESS_MODEL_READER " ") +
                              (folder / "model.txt").string() + " < " + (folder / "queries").string() +
                              " > " + (folder / "answers").string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream answers(folder / "answers");
  for (const ActiveNodeModel& node : model.nodes) {
    for (const Eigen::Vector3d& d : probes) {
      std::vector<double> force(3), u(3 * model.output.size()), energy(1), stiffness(9);
      ASSERT_GE(phn_force(loaded.model, loaded.data, node.node, d.data(), force.data()), 0);
      ASSERT_GE(phn_deform(loaded.model, loaded.data, 1, &node.node, d.data(), u.data()), 0);
      struct Kind {
        const std::vector<double>* values;
        double tolerance, unit = 1;
      };
      std::vector<Kind> mine = {{&force, 1e-12}, {&u, GetParam() == Family::modal ? 1e-5 : 1e-12}};
      if (GetParam() != Family::rbfn) {
        ASSERT_GE(phn_energy(loaded.model, loaded.data, node.node, d.data(), energy.data()), 0);
        ASSERT_GE(phn_stiffness(loaded.model, loaded.data, node.node, d.data(), stiffness.data()), 0);
        mine.insert(mine.end(), {Kind{&energy, 1e-12}, Kind{&stiffness, 1e-12}});
      }
      std::vector<std::vector<double>> fields(model.fields.size(), std::vector<double>(model.output.size()));
      for (std::size_t f = 0; f < fields.size(); ++f) {
        if (node.fields[f].weights.cols() == 0) continue;
        ASSERT_GE(phn_field(loaded.model, loaded.data, node.node, d.data(), static_cast<std::int32_t>(f),
                            fields[f].data()),
                  0);
        mine.push_back({&fields[f], 1e-5, model.fields[f].scale});  // summed as floats, too
      }
      std::string line, word;
      ASSERT_TRUE(std::getline(answers, line));
      std::istringstream words(line);
      for (const auto& [values, tolerance, unit] : mine) {
        double largest = 0;
        for (const double x : *values) largest = std::max(largest, std::abs(x));
        for (const double x : *values) {
          ASSERT_TRUE(words >> word);
          EXPECT_NEAR(std::strtod(word.c_str(), nullptr), x, tolerance * largest + 1e-16 * unit);
        }
      }
      EXPECT_FALSE(words >> word);
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
