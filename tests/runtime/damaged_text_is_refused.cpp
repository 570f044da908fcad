#include <gtest/gtest.h>

#include <phynness/formats/hash.hpp>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

int size_status(const std::string& text) {
  std::size_t bytes = 0;
  return phn_model_size(text.data(), text.size(), &bytes);
}

std::string with_checksum(const std::string& body) {
  Fnv1a64 hash;
  hash.add(body);
  return body + "checksum " + hash.hex() + "\n";
}

std::string body_of(const std::string& text) { return text.substr(0, text.rfind("checksum ")); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return with_checksum(body_of(text.replace(at, from.size(), to)));
}

/// Both families, small enough to damage at every byte.
std::string small_text(Family family, int n_deformation, int n_force) {
  return write_model_text(family == Family::linear ? small_linear_model()
                                                   : small_model(n_deformation, n_force));
}
class DamagedText : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, DamagedText, testing::Values(Family::rbfn, Family::linear),
                         [](const auto& info) { return std::string(name(info.param)); });

// Claim: every beginning of a model is refused, by size and by init, without touching memory beyond it.
TEST_P(DamagedText, EveryTruncationIsRefused) {
  const std::string text = small_text(GetParam(), 3, 2);
  std::vector<char> memory(1 << 20);
  for (std::size_t n = 0; n < text.size(); ++n) {
    const std::vector<char> part(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(n));
    std::size_t bytes = 1;
    const int status = phn_model_size(part.empty() ? "" : part.data(), n, &bytes);
    ASSERT_EQ(status, n == 0 ? PHN_ERROR_NOT_A_MODEL : PHN_ERROR_TRUNCATED) << "length " << n;
    EXPECT_EQ(bytes, 0u);
    const phn_model* model = nullptr;
    ASSERT_EQ(phn_model_init(memory.data(), memory.size(), part.empty() ? "" : part.data(), n, &model),
              status);
  }
}

// Claim: every damaged byte is refused. FNV-1a misses no single-byte change: each step is a bijection of the
// state.
TEST_P(DamagedText, EveryDamagedByteIsRefused) {
  std::string text = small_text(GetParam(), 3, 2);
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char kept = text[at];
    for (const int change : {1, 0x20, 0x80}) {
      text[at] = static_cast<char>(kept ^ change);
      ASSERT_LT(size_status(text), 0) << "byte " << at;
    }
    text[at] = kept;
  }
  EXPECT_EQ(size_status(text), PHN_OK);
}

// Claim: a writer's mistakes with a correct checksum are refused by the parser, byte by byte: whatever
// replaces a byte, the result is a status, never a crash; where it is accepted (a digit for a digit), init
// and evaluation are defined.
TEST_P(DamagedText, ParserSurvivesAnythingWithAGoodChecksum) {
  const std::string text = body_of(small_text(GetParam(), 2, 1));
  for (std::size_t at = 0; at < text.size(); ++at) {
    for (const char c : {'0', '9', 'f', ',', '-', ' ', '\n', 'p', '.', '\0'}) {
      std::string damaged = text;
      damaged[at] = c;
      damaged = with_checksum(damaged);
      std::size_t bytes = 0;
      if (phn_model_size(damaged.data(), damaged.size(), &bytes) != PHN_OK) continue;
      ASSERT_LT(bytes, 1u << 20);
      std::vector<char> memory(bytes);
      const phn_model* model = nullptr;
      if (phn_model_init(memory.data(), bytes, damaged.data(), damaged.size(), &model) != PHN_OK) continue;
      ASSERT_EQ(phn_data_size(model, 1, &bytes), PHN_OK);
      std::vector<char> data_memory(bytes);
      phn_data* data = nullptr;
      ASSERT_EQ(phn_data_init(data_memory.data(), bytes, model, 1, &data), PHN_OK);
      const double d[] = {0.001, 0.002, -0.003};
      std::vector<double> u(3 * phn_n_output(model));
      for (int i = 0; i < phn_n_active(model); ++i) {
        ASSERT_GE(phn_deform(model, data, 1, phn_active_nodes(model) + i, d, u.data()), 0);
        for (const double x : u) ASSERT_TRUE(std::isfinite(x));
      }
    }
  }
}

// Claim: each kind of defect has its own status.
TEST(DefectsOfText, AreTold) {
  const std::string text = write_model_text(small_model());
  EXPECT_EQ(size_status("solid liver\n"), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(size_status("phynness-mesh 1\nhash 0\nmore text to be long enough"), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(size_status(replaced(text, "phynness-model 1\n", "phynness-model 2\n")), PHN_ERROR_VERSION);
  EXPECT_EQ(size_status(replaced(text, "family rbfn", "family modal")), PHN_ERROR_FAMILY);
  EXPECT_EQ(size_status(replaced(text, "spread 1.", "spread 1,")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "spread 1.", "spread 0x1.")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "point ", "point  ")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "force 5", "force 6")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "force 5", "force 2000000000")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(replaced(text, "output 12", "output 99999999999999")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(replaced(text, "\nnode 5\n", "\nnode 2\n")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(replaced(text, "mesh_nodes 20", "mesh_nodes 10")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(with_checksum(body_of(text) + "more\n")), PHN_ERROR_SYNTAX);
  const std::string linear = write_model_text(small_linear_model());
  EXPECT_EQ(size_status(replaced(linear, "family linear", "family linea")), PHN_ERROR_FAMILY);
  EXPECT_EQ(size_status(replaced(linear, "family linear", "family rbfn")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(linear, "stiffness ", "stiffness 0p+0 ")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(linear, "stiffness ", "stiffness 1p+400 ")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(replaced(linear, "unit_responses\n", "unit_responses\n1p+0 ")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(linear, "unit_responses\n", "")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(phn_model_size(nullptr, 10, nullptr), PHN_ERROR_ARGUMENT);
}

}  // namespace
