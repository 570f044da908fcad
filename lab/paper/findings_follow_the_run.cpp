// Claim: the sentences of the page about a run follow from its measurements. Other measurements result in other
// sentences with their numbers, and without measurements there is no sentence.
#include <gtest/gtest.h>

#include "report/findings.hpp"

namespace phynness::study {
namespace {

/// Two nodes, the second beside the fixed nodes, with the same errors [fractions] at each x.
CaseResult measured(const std::vector<double>& x, const std::vector<double>& held, const std::vector<double>& fresh) {
  CaseResult result;
  result.of = {"3", "Case 3", "", false, true};
  result.measured.element = "P1";
  for (const bool beside : {false, true}) {
    auto& node = result.measured.nodes.emplace_back();
    node.beside_fixed = beside;
    for (std::size_t i = 0; i < x.size(); ++i) {
      NetworkErrors row;
      row.x = x[i];
      row.neurons = static_cast<int>(x[i]);
      row.held_mean = row.held_max = held[i];
      row.fresh_mean = fresh[i];
      node.by_neurons.push_back(row);
      node.by_spread.push_back(row);
      node.by_samples.push_back(row);
      node.force_as_paper.push_back(row);
    }
    node.linear.displacement = 0.04;
  }
  return result;
}

bool says(const std::string& sentence, const std::string& part) { return sentence.find(part) != std::string::npos; }

TEST(Findings, NameTheBestSpreadOfThisRun) {
  const auto falling = measured({0.5, 1, 2}, {0.03, 0.02, 0.01}, {0.03, 0.01, 0.02}),
             rising = measured({0.5, 1, 2}, {0.01, 0.02, 0.03}, {0.03, 0.02, 0.01});
  const auto a = best_x({&falling}, &NodeMeasurements::by_spread, "spread"),
             b = best_x({&rising}, &NodeMeasurements::by_spread, "spread");
  EXPECT_TRUE(says(a, "as the paper 2 (1.00 %), fresh 1 (1.00 %)")) << a;
  EXPECT_TRUE(says(b, "as the paper 0.5 (1.00 %), fresh 2 (1.00 %)")) << b;
}

TEST(Findings, CompareWhatWasMeasured) {
  const auto worse = measured({100, 300}, {0.05, 0.01}, {0.05, 0.03}),
             better = measured({100, 300}, {0.05, 0.04}, {0.05, 0.02});
  const auto sentence = [](const CaseResult& of) {
    return fresh_against_held({&of}, &NodeMeasurements::by_neurons, &PredictorAtNode::displacement);
  };
  EXPECT_TRUE(says(sentence(worse), "Case 3: fresh 3.00 %, as the paper 1.00 %, ratio 3, the linear predictor 4.00 %"))
      << sentence(worse);
  EXPECT_TRUE(says(sentence(better), "fresh 2.00 %, as the paper 4.00 %, ratio 0.5")) << sentence(better);
  const auto pairs = last_against_first({&worse}, &NodeMeasurements::by_samples, "training pairs");
  EXPECT_TRUE(says(pairs, "300 training pairs 1.00 %, 100 training pairs 5.00 %, ratio 0.2")) << pairs;
}

TEST(Findings, CountTheNodesWhereNothingSuffices) {
  auto result = measured({10, 20}, {0.5, 0.2}, {0, 0});
  EXPECT_TRUE(says(never_enough({&result}), "1 of 1 beside the fixed ones, 1 of 1 elsewhere"))
      << never_enough({&result});
  result.measured.nodes[0].force_as_paper[1].held_max = 0.05;
  EXPECT_TRUE(says(never_enough({&result}), "1 of 1 beside the fixed ones, 0 of 1 elsewhere"))
      << never_enough({&result});
}

TEST(Findings, AreNoneWithoutMeasurements) {
  CaseResult empty;
  EXPECT_EQ(best_x({&empty}, &NodeMeasurements::by_spread, "spread"), "");
  EXPECT_EQ(fresh_against_held({}, &NodeMeasurements::by_neurons, &PredictorAtNode::force), "");
  EXPECT_EQ(deepest_pairs(empty), "");
  EXPECT_EQ(slopes({}), "");
  EXPECT_EQ(finest_level({}), "");
  EXPECT_EQ(plain_loop_against_ours({}), "");
  EXPECT_EQ(locking(empty, empty, {}), "");
  const auto report = paper_report({});
  for (const auto& figure : report.figures) EXPECT_EQ(figure.found, "") << figure.number;
  EXPECT_EQ(report.table1_found + report.table2_found, "");
}

}  // namespace
}  // namespace phynness::study
