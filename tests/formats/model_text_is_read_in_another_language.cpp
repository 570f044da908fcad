#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <phynness/formats/model.hpp>
#include <random>
#include <sstream>

#include "loaded_model.hpp"
#include "model_text_of.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: formats/model.md suffices for another language. A reader written from that page in Python's standard
// library agrees with the runtime to 1e-12 of the largest force and displacement: both round in double, in different
// orders; but modal displacements, which the runtime sums as floats, to 1e-5. 1e-16 is what the reader's terms leave at
// rest, where the runtime's cancel exactly. Other numbers are compared with plain loops in tests/runtime.
TEST_P(ModelTextOf, AReaderInAnotherLanguageAgrees) {
  const Model model = small_model_of(GetParam());
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
                              (folder / "model.txt").string() + " < " + (folder / "queries").string() + " > " +
                              (folder / "answers").string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream answers(folder / "answers");
  for (const ActiveNodeModel& node : model.nodes) {
    for (const Eigen::Vector3d& d : probes) {
      std::vector<double> force(3), u(3 * model.output.size());
      ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force.data(), nullptr, nullptr), 0);
      ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d.data()), u.data()), 0);
      std::string line, word;
      ASSERT_TRUE(std::getline(answers, line));
      std::istringstream words(line);
      for (const auto* values : {&force, &u}) {
        const double tolerance = values == &u && model.family == Family::modal ? 1e-5 : 1e-12;
        double largest = 0;
        for (const double x : *values) largest = std::max(largest, std::abs(x));
        for (const double x : *values) {
          ASSERT_TRUE(words >> word);
          EXPECT_NEAR(std::strtod(word.c_str(), nullptr), x, tolerance * largest + 1e-16);
        }
      }
      EXPECT_FALSE(words >> word);
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
