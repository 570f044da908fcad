#include <gtest/gtest.h>

#include "changed_text.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

int size_status(const std::string& text) {
  std::size_t bytes = 0;
  return phn_model_size(text.data(), text.size(), &bytes, nullptr);
}

/// A family, with smaller networks or without.
struct Kind {
  Family family;
  bool levels;
};
void PrintTo(const Kind& kind, std::ostream* out) { *out << name(kind.family); }

/// Every kind, small enough to damage at every byte.
std::string small_text(const Kind& kind) {
  Model model = small_model(3, 2);
  if (kind.family == Family::modal) model = small_modal_model(3, 2, 2, 2);
  if (kind.family == Family::linear) model = small_linear_model();
  return write_model_text(kind.levels ? with_levels(model, 2) : model);
}
class DamagedText : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Families, DamagedText,
                         testing::Values(Kind{Family::rbfn, false}, Kind{Family::linear, false},
                                         Kind{Family::modal, false}, Kind{Family::rbfn, true},
                                         Kind{Family::modal, true}),
                         [](const auto& info) {
                           return std::string(name(info.param.family)) + (info.param.levels ? "_levels" : "");
                         });

// Claim: every beginning of a model is refused, by size and by init, without touching memory beyond it.
TEST_P(DamagedText, EveryTruncationIsRefused) {
  const std::string text = small_text(GetParam());
  std::vector<char> memory(1 << 20);
  for (std::size_t n = 0; n < text.size(); ++n) {
    const std::vector<char> part(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(n));
    std::size_t bytes = 1;
    const int status = phn_model_size(part.empty() ? "" : part.data(), n, &bytes, nullptr);
    ASSERT_EQ(status, n == 0 ? PHN_ERROR_NOT_A_MODEL : PHN_ERROR_TRUNCATED) << "length " << n;
    EXPECT_EQ(bytes, 0u);
    const phn_model* model = nullptr;
    ASSERT_EQ(phn_model_init(memory.data(), memory.size(), part.empty() ? "" : part.data(), n, &model, nullptr),
              status);
  }
}

// Claim: every damaged byte is refused. FNV-1a misses no single-byte change: each step is a bijection of the state.
TEST_P(DamagedText, EveryDamagedByteIsRefused) {
  std::string text = small_text(GetParam());
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

// Claim: a refused text tells where the wrong word begins, counted from 1, a damaged one where its checksum is; a good
// one tells 0.
TEST(DefectsOfText, TellTheByteWhereTheyAre) {
  const std::string text = write_model_text(small_model());
  const auto wrong_byte = [](const std::string& of) {
    std::size_t bytes = 0, of_size = 99, of_init = 99;
    const phn_model* model = nullptr;
    std::vector<char> memory(1 << 18);
    const int status = phn_model_size(of.data(), of.size(), &bytes, &of_size);
    EXPECT_EQ(phn_model_init(memory.data(), memory.size(), of.data(), of.size(), &model, &of_init), status);
    EXPECT_EQ(of_init, of_size);
    return of_size;
  };
  EXPECT_EQ(wrong_byte(text), 0u);
  const struct {
    const char *from, *to, *wrong;
  } cases[] = {{"family rbfn", "family spline", "spline"},
               {"spread 1.", "spread 1,", "1,"},
               {"mesh_nodes 20", "mesh_nodes 2x", "2x"},
               {"force 5", "force 2000000000", "2000000000"},
               {"\nsurface ", "\nsurfaces ", "surfaces "}};
  for (const auto& c : cases) {
    const std::string damaged = replaced(text, c.from, c.to);
    EXPECT_EQ(wrong_byte(damaged), damaged.find(c.wrong, damaged.find(c.to)) + 1) << c.to;
  }
  std::string changed = text;
  changed[text.find("mesh_nodes")] = 'n';
  EXPECT_EQ(wrong_byte(changed), text.rfind("checksum ") + 10);
  EXPECT_EQ(wrong_byte(text.substr(0, 5)), 6u);
  EXPECT_EQ(wrong_byte("solid liver and more\n"), 1u);
}

// Claim: each kind of defect has its own status. The bounds of every section are those of formats/model.md
// (tests/formats/grammar_of_model_text.py).
TEST(DefectsOfText, AreTold) {
  const std::string text = write_model_text(small_model());
  EXPECT_EQ(size_status("solid liver\n"), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(size_status("phynness-mesh 1\nhash 0\nmore text to be long enough"), PHN_ERROR_NOT_A_MODEL);
  EXPECT_EQ(size_status(replaced(text, "phynness-model 4\n", "phynness-model 2\n")), PHN_ERROR_VERSION);
  EXPECT_EQ(size_status(replaced(text, "family rbfn", "family spline")), PHN_ERROR_FAMILY);
  EXPECT_EQ(size_status(replaced(text, "spread 1.", "spread 1,")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "point ", "point  ")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(text, "force 5", "force 2000000000")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(replaced(text, "\nnode 5\n", "\nnode 2\n")), PHN_ERROR_RANGE);
  EXPECT_EQ(size_status(with_checksum(body_of(text) + "more\n")), PHN_ERROR_SYNTAX);
  const std::string linear = write_model_text(small_linear_model());
  EXPECT_EQ(size_status(replaced(linear, "family linear", "family linea")), PHN_ERROR_FAMILY);
  EXPECT_EQ(size_status(replaced(linear, "family linear", "family rbfn")), PHN_ERROR_SYNTAX);
  EXPECT_EQ(size_status(replaced(linear, "stiffness ", "stiffness 1p+400 ")), PHN_ERROR_RANGE);
  EXPECT_EQ(phn_model_size(nullptr, 10, nullptr, nullptr), PHN_ERROR_ARGUMENT);
}

/// Another first number in the first line that begins with the word.
std::string first_number(const std::string& text, const std::string& word, const std::string& number) {
  const std::size_t at = text.find("\n" + word + " ") + word.size() + 2;
  const std::size_t end = text.find_first_of(" \n", at);
  return with_checksum(body_of(text.substr(0, at) + number + text.substr(end)));
}

// Claim: levels are bounded by the full model, for which scratch is laid out.
TEST(DefectsOfText, OfLevelsAreTold) {
  // What a level has more of than the model that it belongs to.
  const auto refused = [](Model model, Model other) {
    const std::string text = write_model_text(with_levels(model)), large = write_model_text(with_levels(other));
    const auto part = [](const std::string& of, const char* from, const char* to) {
      const std::size_t begin = of.find(from), end = of.find(to, begin + 1);
      return of.substr(begin, end - begin);
    };
    EXPECT_EQ(size_status(replaced(text, part(text, "\nlevels ", "\nactive "), part(large, "\nlevels ", "\nactive "))),
              PHN_ERROR_RANGE);
  };
  refused(small_modal_model(3, 5, 6, 2), small_modal_model(3, 5, 6, 8));
}

// Claim: coordinates beyond 1e30 m are refused wherever they stand; with those at the bound, whatever their signs, and
// a place from anywhere, everything stays finite. Found by fuzzing: two tools at +-1.8e308 m, a triangle of 1e200 m.
TEST(DefectsOfText, CoordinatesAreBounded) {
  const auto limit = std::string("1.93e5939a08ceap+99"),
             beyond = std::string("1.93e5939a08cebp+99");  // about 1e30
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    const std::string text = write_model_text(small_model_of(family));
    EXPECT_EQ(size_status(first_number(text, "point", limit)), PHN_OK);
    EXPECT_EQ(size_status(first_number(text, "point", beyond)), PHN_ERROR_RANGE);
    for (const char* section : {"\nfixed 2\n0 ", "\noutput 12\n2 "}) {
      const std::size_t at = text.find(section) + std::string(section).size();
      const std::size_t end = text.find(' ', at);
      EXPECT_EQ(size_status(with_checksum(body_of(text.substr(0, at) + limit + text.substr(end)))), PHN_OK);
      EXPECT_EQ(size_status(with_checksum(body_of(text.substr(0, at) + "-" + beyond + text.substr(end)))),
                PHN_ERROR_RANGE);
    }
    Model model = small_model_of(family);
    for (Eigen::Index o = 0; o < 12; ++o) model.output_points.row(o).setConstant(o % 2 == 0 ? 1e30 : -1e30);
    model.nodes[0].point = {1e30, -1e30, 1e30};
    model.nodes[1].point = {-1e30, 1e30, -1e30};
    for (auto& node : model.nodes)
      if (family == Family::rbfn) fill_centers(model, node.deformation);
    const LoadedModel loaded(write_model_text(model));
    const double d[] = {0.001, 0, 0};
    Points u(12, 3);
    ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(3, d), u.data()), 0);
    EXPECT_TRUE(u.allFinite());
    for (const double far : {0.0, 1e30, 1e200, -1.7e308}) {
      const double x[] = {far, 0.01, -far};
      phn_tool tool;
      double point[3];
      ASSERT_EQ(phn_nearest(loaded.model, x, &tool, point, nullptr), PHN_OK);
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(std::isfinite(point[k]));
        EXPECT_GE(tool.weights[k], 0);
        sum += tool.weights[k];
      }
      EXPECT_NEAR(sum, 1, 1e-12);
    }
  }
}

// Claim: what could overflow is refused when the model is built: a largest displacement beyond 1e90 or below
// 1e-90, and a center farther than 1e3 of it.
TEST(DefectsOfText, ModalModelsThatCouldOverflowAreRefused) {
  Model model = small_modal_model();
  const auto init_status = [](const Model& m) {
    const std::string text = write_model_text(m);
    std::vector<char> memory(1 << 18);
    const phn_model* built = nullptr;
    return phn_model_init(memory.data(), memory.size(), text.data(), text.size(), &built, nullptr);
  };
  model.displacements *= 900;
  EXPECT_EQ(init_status(model), PHN_OK);
  model.displacements *= 2;
  EXPECT_EQ(init_status(model), PHN_ERROR_RANGE);
  model.displacements *= 0;
  model.max_displacement_m = 1e91;
  EXPECT_EQ(init_status(model), PHN_ERROR_RANGE);
  model.max_displacement_m = 1e-91;
  EXPECT_EQ(init_status(model), PHN_ERROR_RANGE);
  model.max_displacement_m = 1e-89;
  EXPECT_EQ(init_status(model), PHN_OK);
}

}  // namespace
