#include <gtest/gtest.h>

#include "core/evaluate.hpp"
#include "core/kernels.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// 400 output nodes are 38 blocks of rows: nodes become ready over several calls, and the last block is not full.
Model large_model(int n_modes = 5, int n_shared = 12) {
  Model model = small_modal_model(n_modes, 5, n_shared, 4);
  Numbers numbers;
  model.n_mesh_nodes = 1000;
  model.output.clear();
  for (int i = 0; i < 400; ++i) model.output.push_back(i + 2);
  model.output_points.resize(400, 3);
  for (Eigen::Index i = 0; i < model.output_points.size(); ++i) model.output_points.data()[i] = 0.05 * numbers.next();
  model.shared.modes = random_table(1200, n_shared, 0.5, numbers);
  return model;
}

std::vector<Model> prepared_models() {
  return {large_model(), large_model(13, 20), large_model(1, 2), large_model(12, 12), small_field_model()};
}

/// What a node says that was never touched before.
Points fresh_field(const phn_model* model, std::int32_t max_tools, const AtNode& tool) {
  std::size_t bytes = 0;
  EXPECT_EQ(phn_data_size(model, max_tools, &bytes), PHN_OK);
  std::vector<char> memory(bytes);
  phn_data* data = nullptr;
  EXPECT_EQ(phn_data_init(memory.data(), bytes, model, max_tools, &data), PHN_OK);
  Points u(info_of(model).n_output, 3);
  EXPECT_GE(phn_deform(model, data, tool, u.data()), 0);
  return u;
}

// Claim: whatever was touched before, in whatever order, prepared or not: fields are the same to the last bit.
// Scratch for one tool keeps three of four nodes.
TEST(PreparedNodes, GiveTheSameFieldInAnyOrder) {
  auto all = prepared_models();
  all.push_back(small_model());  // of family rbfn
  for (const Model& model : all)
    for (const std::int32_t max_tools : {1, 3}) {
      const LoadedModel loaded(write_model_text(model), max_tools);
      Numbers numbers;
      const auto choose = [&](int n) { return static_cast<int>((numbers.next() + 1) / 2 * n * 0.999); };
      const std::int32_t active[] = {3, 5, 8, 15};
      for (int call = 0; call < 400; ++call) {
        double d[3];
        for (double& x : d) x = 0.01 * numbers.next();
        const AtNode tool(active[choose(4)], d);
        if (call % 7 == 0) {
          ASSERT_EQ(phn_prepare(loaded.model, loaded.data, AtNode(active[choose(4)])), PHN_OK);
        }
        Points u(info_of(loaded.model).n_output, 3);
        ASSERT_GE(phn_deform(loaded.model, loaded.data, tool, u.data()), 0);
        ASSERT_EQ(u, fresh_field(loaded.model, max_tools, tool));
      }
    }
}

/// Floats are summed in another order: 20 roundings of 6e-8 of the sizes of the terms, which are at most some
/// ten times the largest displacement here.
constexpr double rounding = 2e-5;

/// A node's deformation or field at all output nodes, as these kernels have it. Terms that only fields have
/// are arbitrary numbers.
Eigen::VectorXd values_by(const runtime::ModalKernels& kernels, const LoadedModel& loaded,
                          const runtime::SharedTable& shared, const runtime::ModalTables& tables,
                          const runtime::PreparedNode* prepared) {
  const runtime::SharedModes& centers = loaded.model->shared;
  const double x[] = {0.3, -0.7, 0.2};
  const std::int32_t n_basis = centers.n_centers + (&shared == &centers ? 3 : 9);
  Eigen::VectorXd basis = Eigen::VectorXd::LinSpaced(n_basis, -1, 1), amplitude(tables.n_modes), values(shared.n_rows);
  kernels.basis(centers, x, basis.data());
  kernels.amplitudes(tables, n_basis, basis.data(), amplitude.data());
  kernels.field(shared, tables, prepared, amplitude.data(), loaded.data->scratch, values.data());
  return values;
}

void expect_same_bits(const LoadedModel& loaded, const runtime::SharedTable& shared, const runtime::ModalTables& tables,
                      const runtime::PreparedNode* prepared) {
  using namespace phynness::runtime;
  const auto expected = values_by(*modal_kernels(0), loaded, shared, tables, prepared);
  for (int set = 1; set < n_instruction_sets; ++set) {
    if (modal_kernels(set) == nullptr) continue;
    EXPECT_EQ(values_by(*modal_kernels(set), loaded, shared, tables, prepared), expected) << modal_kernels(set)->name;
  }
}

/// Of every model: check(loaded, active, its response).
template <class Check>
void for_each_response(Check check) {
  for (const Model& model : prepared_models()) {
    const LoadedModel loaded(write_model_text(model));
    for (std::int32_t active = 0; active < loaded.model->n_active; ++active)
      check(loaded, active, *loaded.model->active[active].modal);
  }
}

// Claim: summing the modes beforehand changes fields by rounding alone; near nodes, in double, not by a bit.
TEST(PreparedNodes, ChangeNothingButRounding) {
  using namespace phynness::runtime;
  for_each_response([](const LoadedModel& loaded, std::int32_t active, const ModalResponse& node) {
    const phn_model& m = *loaded.model;
    const PreparedNode* prepared = prepare(m, loaded.data->prepared, active);
    EXPECT_EQ(prepared != nullptr, node.n_modes < m.shared.n_modes);
    const auto with = values_by(best_modal_kernels(), loaded, m.shared, node, prepared),
               without = values_by(best_modal_kernels(), loaded, m.shared, node, nullptr);
    EXPECT_LE((with - without).cwiseAbs().maxCoeff(), rounding * without.cwiseAbs().maxCoeff());
    for (std::int32_t i = 0; i < node.n_near; ++i)
      EXPECT_EQ(with.segment<3>(3 * node.near[i]), without.segment<3>(3 * node.near[i]));
  });
}

// Claim: every set of instructions that this processor has gives the same bits.
TEST(PreparedNodes, EveryInstructionSetGivesTheSameBits) {
  using namespace phynness::runtime;
  for_each_response([](const LoadedModel& loaded, std::int32_t active, const ModalResponse& node) {
    const phn_model& m = *loaded.model;
    expect_same_bits(loaded, m.shared, node, prepare(m, loaded.data->prepared, active));
    expect_same_bits(loaded, m.shared, node, nullptr);
    for (std::int32_t f = 0; f < m.n_fields; ++f)
      if (node.fields[f].n_modes > 0) expect_same_bits(loaded, m.fields[f], node.fields[f], nullptr);
    const auto n = static_cast<std::size_t>(node.n_modes) * rows_per_block;
    std::vector<float> expected(n), block(n);
    modal_kernels(0)->sum_block(m.shared, node, m.shared.modes, expected.data());
    for (int set = 1; set < n_instruction_sets; ++set) {
      if (modal_kernels(set) == nullptr) continue;
      modal_kernels(set)->sum_block(m.shared, node, m.shared.modes, block.data());
      EXPECT_EQ(block, expected) << modal_kernels(set)->name;
    }
  });
}

// Claim: coupled tools deform the body alike, to the last bit, before and after their nodes are prepared.
TEST(PreparedNodes, ServeCoupledTools) {
  Model model = large_model();
  const LoadedModel loaded(write_model_text(model));
  const phn_tool tools[] = {{{3, 5, -1}, {0.25, 0.75, 0}, {0.001, -0.002, 0.001}},
                            {{8, -1, -1}, {1, 0, 0}, {0, 0.001, -0.001}}};
  double forces[6];
  ASSERT_GE(phn_couple(loaded.model, loaded.data, 2, tools, forces, nullptr), 0);
  Points cold(400, 3), warm(400, 3);
  ASSERT_GE(phn_coupled_deform(loaded.model, loaded.data, cold.data()), 0);
  for (const std::int32_t node : {3, 5, 8}) ASSERT_EQ(phn_prepare(loaded.model, loaded.data, AtNode(node)), PHN_OK);
  ASSERT_GE(phn_coupled_deform(loaded.model, loaded.data, warm.data()), 0);
  EXPECT_GT(cold.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(warm, cold);
}

// Claim: what cannot be prepared is named; where there is nothing to prepare, all is well.
TEST(PreparedNodes, MisuseIsNamed) {
  const std::string text = write_model_text(small_modal_model());
  const LoadedModel loaded(text), other(text);
  EXPECT_EQ(phn_prepare(nullptr, loaded.data, AtNode(3)), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_prepare(loaded.model, nullptr, AtNode(3)), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_prepare(loaded.model, other.data, AtNode(3)), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_prepare(loaded.model, loaded.data, AtNode(4)), PHN_ERROR_NOT_ACTIVE);
  for (const Family family : {Family::rbfn, Family::linear}) {
    const LoadedModel without(write_model_text(small_model_of(family)));
    EXPECT_EQ(phn_prepare(without.model, without.data, AtNode(3)), PHN_OK);
  }
}

}  // namespace
