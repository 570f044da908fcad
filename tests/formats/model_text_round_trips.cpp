#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <locale>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>

#include "loaded_model.hpp"
#include "model_numbers.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

std::vector<double> numbers_of(Model model) {
  std::vector<double> all;
  for_each_group(model, [&](const double* first, std::size_t n) { all.insert(all.end(), first, first + n); });
  for (const ModelLevel& level : model.levels) all.insert(all.end(), {level.error_force, level.error_displacement});
  for (const ModelBound& bound : model.bounds) {
    all.push_back(bound.coverage);
    all.insert(all.end(), bound.between.begin(), bound.between.end());
  }
  return all;
}

/// All integers of tables, and of lists of positions and nodes.
std::vector<std::int64_t> integers_of(const Model& model) {
  std::vector<std::int64_t> all{model.n_mesh_nodes};
  const auto list = [&](const auto& values) {
    all.push_back(std::ssize(values));
    all.insert(all.end(), values.begin(), values.end());
  };
  const auto table = [&](const ScaledTable& t) { list(t.entries.reshaped()); };
  const auto modes = [&](const ModalDeformation& modal) {
    for (const auto* t : {&modal.weights, &modal.mixing, &modal.near_modes}) table(*t);
    list(modal.near);
  };
  list(model.fixed);
  list(model.output);
  list(model.surface.reshaped());
  list(model.shared.centers);
  table(model.shared.modes);
  for (const FieldModes& field : model.fields) table(field.modes);
  for (const ModelLevel& level : model.levels) list(level.centers);
  for (const ModelBound& bound : model.bounds) all.insert(all.end(), {bound.n_rays, bound.n_nodes});
  for (const ActiveNodeModel& node : model.nodes) {
    all.insert(all.end(), {node.node, node.n_incomplete});
    list(node.prescribed);
    list(node.conservative.centers);
    modes(node.modal);
    for (const ModalDeformation& field : node.fields) modes(field);
    for (const ScaledTable& bound : node.bounds) table(bound);
    for (const LevelResponse& level : node.levels) {
      table(level.weights);
      for (const ScaledTable& weights : level.field_weights) table(weights);
    }
  }
  return all;
}

/// Values that a decimal or sloppy writer loses: negative zero, the smallest subnormal, a large number with all digits.
template <class Matrix>
void set_odd_numbers(Matrix& of, double large) {
  of(0, 0) = -0.0;
  of(0, 1) = 0x0.0000000000001p-1022;
  of(0, 2) = large;
}

// Claim: a model of every family, with and without modes, fields, levels and bounds, comes back bit for bit, scaled
// centers included, though the file holds only their indices.
TEST(ModelText, RoundTripsBitForBit) {
  Model networks = small_model(), linear = small_linear_model(), modal = small_modal_model();
  set_odd_numbers(networks.nodes[0].force.weights, 0x1.ffffffffffffep+900);
  set_odd_numbers(linear.nodes[0].linear.unit_responses, -largest_linear_entry);
  set_odd_numbers(modal.nodes[0].conservative.coefficients, -largest_linear_entry);
  modal.nodes[0].modal.mixing.entries(0, 0) = -32767;
  ModalDeformation& bare = modal.nodes[3].modal;
  for (ScaledTable* table : {&bare.weights, &bare.mixing, &bare.near_modes})
    *table = scaled_table(Eigen::MatrixXd(table->rows(), 0));
  for (const Model& model :
       {networks, linear, modal, small_field_model(), with_levels(networks), with_levels(small_field_model(), 2),
        with_bound_between(modal), with_bound_between(with_levels(networks))}) {
    const std::string text = write_model_text(model);
    const Model again = read_model_text(text, "model.txt");
    EXPECT_EQ(write_model_text(again), text);
    EXPECT_EQ(again.family, model.family);
    EXPECT_EQ(again.title, model.title);
    const auto numbers = numbers_of(again), wanted = numbers_of(model);
    ASSERT_EQ(numbers.size(), wanted.size());
    EXPECT_EQ(std::memcmp(numbers.data(), wanted.data(), sizeof(double) * wanted.size()), 0);
    EXPECT_EQ(integers_of(again), integers_of(model));
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      EXPECT_EQ(again.nodes[i].force.centers, model.nodes[i].force.centers);
      EXPECT_EQ(again.nodes[i].deformation.centers, model.nodes[i].deformation.centers);
    }
  }
}

// Claim: so does what the finite elements solved and their distance to a finer solution; without these, fields and
// bounds the text has no trace of any.
TEST(ModelText, ProvenanceRoundTrips) {
  Model model = small_modal_model();
  const std::string plain = write_model_text(model);
  for (const char* word : {"field", "bound", "finer", "solved"}) EXPECT_EQ(plain.find(word), std::string::npos) << word;
  model.finer = {true, "p1-p1",          "taylor-hood", 12,         0.03,       0.25,       0.5,         300, 13,
                 true, {4, 0.125, 0.25}, {8, 0.5, 1},   {24, 3, 4}, {23, 5, 6}, {22, 7, 8}, {12, 9, 10}, 11};
  model.solved = {true, "p1-p1", 1e3 / 3};
  const Model again = read_model_text(write_model_text(model), "model.txt");
  const auto figures_of = [](const FinerDistance& f) {
    std::string all = f.element + f.reference;
    const auto see = [&]<class Value>(const char*, const Value& value, const auto& self) -> void {
      if constexpr (std::is_arithmetic_v<Value>) all += " " + std::to_string(value);
      if constexpr (Described<Value>)
        Value::describe(value, [&](const char* key, const auto& part) { self(key, part, self); });
    };
    see("", f, see);
    return all;
  };
  EXPECT_EQ(figures_of(again.finer), figures_of(model.finer));
  EXPECT_EQ(again.solved.element, "p1-p1");
  EXPECT_EQ(again.solved.shear_modulus_Pa, 1e3 / 3);
}

// Claim: so does a relaxation, which the runtime tells; a sum of shares that is not below 1 is refused by both readers.
TEST(ModelText, RelaxationRoundTrips) {
  Model model = small_modal_model();
  EXPECT_EQ(write_model_text(model).find("relaxation"), std::string::npos);
  model.relaxation.terms.resize(2, 2);
  model.relaxation.terms << 0.3, 2, 1.0 / 3, 20;
  model.relaxation.length_m = 0.03;
  const std::string text = write_model_text(model);
  EXPECT_EQ(read_model_text(text, "model.txt").relaxation.terms, model.relaxation.terms);
  const phn_relaxation told = info_of(LoadedModel(text).model).relaxation;
  EXPECT_EQ(told.n_terms, 2);
  EXPECT_EQ(told.g[1], 1.0 / 3);
  EXPECT_EQ(told.tau_s[0], 2);
  EXPECT_EQ(told.length_m, 0.03);
  model.relaxation.terms(0, 0) = 0.7;
  EXPECT_THROW(write_model_text(model), Error);
}

// Claim: a scaled table holds every number to 1 / 65534 of its column's largest, and zeros as zeros.
TEST(ModelText, TablesRoundToTheirColumns) {
  Numbers numbers;
  Eigen::MatrixXd values(50, 4);
  for (Eigen::Index r = 0; r < 50; ++r)
    for (Eigen::Index c = 0; c < 4; ++c) values(r, c) = std::pow(10, 3 * c - 6) * numbers.next();
  values.col(2).setZero();
  const ScaledTable table = scaled_table(values);
  for (Eigen::Index c = 0; c < 4; ++c) {
    // 1e-12 for the rounding of scale and product.
    EXPECT_LE((table.values().col(c) - values.col(c)).cwiseAbs().maxCoeff(),
              values.col(c).cwiseAbs().maxCoeff() / 65534 * (1 + 1e-12));
  }
  EXPECT_EQ(table.values().col(2).norm(), 0);
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

}  // namespace
