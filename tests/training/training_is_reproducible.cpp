#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/training/node_training.hpp>

#include "sampling.hpp"
#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

std::string text_of(const ResponseSource& source, const TrainingSpec& spec, int threads,
                    TrainingReport* kept = nullptr) {
  TrainingReport report;
  const Model model = train(source, spec, report, {}, threads);
  if (kept) *kept = report;
  return write_model_text(model);
}

// Claim: the generator is SplitMix64; values for seed 0 as in its authors' reference implementation. Samples
// are then the same on every platform.
TEST(Sampling, GeneratorIsSplitMix64) {
  SplitMix64 random(0);
  EXPECT_EQ(random.next(), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(random.next(), 0x6e789e6aa1b965f4ULL);
  EXPECT_EQ(random.next(), 0x06c45d188009454fULL);
}

// Claim: draws are distinct, complete and uniform. 20,000 draws of 5 of 20: each number 5,000 times, standard
// deviation 61; six of them are allowed.
TEST(Sampling, DrawsAreUniformWithoutReplacement) {
  SplitMix64 random(7);
  std::vector<int> count(20, 0);
  for (int trial = 0; trial < 20000; ++trial) {
    auto drawn = draw_without_replacement(20, 5, random);
    std::sort(drawn.begin(), drawn.end());
    ASSERT_TRUE(std::adjacent_find(drawn.begin(), drawn.end()) == drawn.end());
    for (const std::int32_t i : drawn) ++count[i];
  }
  for (const int c : count) EXPECT_NEAR(c, 5000, 366);
  EXPECT_EQ(draw_without_replacement(4, 9, random).size(), 4u);
}

// Claim: the seed alone decides the samples: equal seeds give equal models on any number of threads, bit for bit,
// different ones different models.
TEST(Training, SeedDecides) {
  const DatabaseHeader header = small_header();
  TrainingSpec spec = small_spec();
  const std::string one = text_of(source_of(header), spec, 1);
  EXPECT_EQ(one, text_of(source_of(header), spec, 2));
  EXPECT_EQ(one, text_of(source_of(header), spec, 5));
  spec.seed = 2;
  EXPECT_NE(one, text_of(source_of(header), spec, 1));
}

// Claim: what failed never enters. Two sources differ only in what stands in failed increments: zeros here, NaN and
// huge numbers there; the models are equal to the last bit, and the counts and depths tell of the failures.
TEST(Training, FailedIncrementsNeverEnter) {
  const DatabaseHeader header = small_header();
  const auto with = [&](double force, double displacement) {
    ResponseSource source = source_of(header);
    source.rays = [&header, force, displacement](std::int32_t active) {
      std::vector<Ray> rays = small_rays(header, active);
      for (Ray& ray : rays) {
        const int first_failed = (ray.direction + active) % 9;
        for (int i = first_failed; i < n_increments; ++i) {
          ray.status[i] = i == first_failed ? Status::inverted : Status::after_failure;
          std::fill_n(ray.force.begin() + 3 * i, 3, force);
          std::fill_n(ray.displacement.begin() + 3 * n_nodes * i, 3 * n_nodes, displacement);
        }
      }
      return rays;
    };
    return source;
  };
  TrainingReport report;
  const std::string clean = text_of(with(0, 0), small_spec(), 1, &report);
  EXPECT_EQ(clean, text_of(with(std::numeric_limits<double>::quiet_NaN(), 1e300), small_spec(), 1));
  EXPECT_GT(report.n_increments_failed, 0);
  EXPECT_EQ(report.n_increments_used + report.n_increments_failed,
            static_cast<std::int64_t>(header.sets.active.size()) * 26 * n_increments);
  const Model model = read_model_text(clean, "clean");
  EXPECT_EQ(model.nodes[0].trained_depth_m[0], 0);
  EXPECT_EQ(model.nodes[0].trained_depth_m[1], header.magnitudes_m[0]);
  EXPECT_EQ(model.nodes[0].trained_depth_m[4], header.magnitudes_m[3]);
  EXPECT_EQ(model.nodes[0].n_incomplete, 12);
}

// Claim: a value that is not finite in an increment marked converged is a damaged database, refused and not trained on.
TEST(Training, RefusesValuesThatAreNotFinite) {
  const DatabaseHeader header = small_header();
  ResponseSource source = source_of(header);
  source.rays = [&](std::int32_t active) {
    std::vector<Ray> rays = small_rays(header, active);
    rays[3].force[2] = std::numeric_limits<double>::quiet_NaN();
    return rays;
  };
  TrainingReport report;
  EXPECT_THROW(train(source, small_spec(), report), Error);
}

// Claim: a node without any converged increment is left out and counted; directions never asked for are no failures.
TEST(Training, NodesWithoutResponsesAreSkippedAndCounted) {
  const DatabaseHeader header = small_header();
  ResponseSource source = source_of(header);
  source.rays = [&](std::int32_t active) {
    std::vector<Ray> rays = small_rays(header, active);
    for (Ray& ray : rays) {
      if (active == 2) ray.status.assign(n_increments, Status::diverged);
      if (active == 3 && ray.direction < 13) ray.status.assign(n_increments, Status::not_requested);
    }
    return rays;
  };
  TrainingReport report;
  const Model model = train(source, small_spec(), report, {}, 2);
  EXPECT_EQ(report.n_skipped, 1);
  EXPECT_EQ(report.skipped_nodes, std::vector<std::int32_t>{header.sets.active[2]});
  EXPECT_EQ(model.nodes.size(), header.sets.active.size() - 1);
  EXPECT_EQ(model.nodes[2].node, header.sets.active[3]);
  EXPECT_EQ(model.nodes[2].n_incomplete, 0);
  EXPECT_EQ(report.n_increments_failed, 26 * n_increments);
}

// Claim: few data never make a network that over-fits: neurons stay below the stated share of the points.
TEST(Training, FewPointsCapTheNeurons) {
  const DatabaseHeader header = small_header();
  TrainingSpec spec = small_spec();
  spec.force_neurons = 1000;
  spec.deformation_neurons = 1000;
  spec.samples = 100;
  TrainingReport report;
  const Model model = train(source_of(header), spec, report);
  for (const ActiveNodeModel& node : model.nodes) {
    EXPECT_LE(static_cast<double>(node.force.weights.rows()), largest_neuron_share * 26 * n_increments);
    EXPECT_LE(static_cast<double>(node.deformation.weights.rows()), largest_neuron_share * 100);
  }
}

// Claim: nodes that the probe moves itself, and only these, are kept out of the deformation data.
TEST(Training, PrescribedNodesAreNotTrainedOn) {
  const DatabaseHeader header = small_header();
  const NetworkPoints points =
      deformation_points(training_tables(header), small_rays(header, 3), {{9, 11}, {1.0, 0.5}}, 9, 1000000, 1);
  EXPECT_EQ(points.size(), static_cast<std::size_t>(26 * n_increments * (n_nodes - 2)));
  for (const std::int32_t place : points.place) EXPECT_TRUE(place != 9 && place != 11);
}

// Claim: what the progress callback throws ends training, on any number of threads.
TEST(Training, CanBeInterrupted) {
  const DatabaseHeader header = small_header();
  for (const int threads : {1, 2}) {
    std::atomic<int> calls{0};
    TrainingReport report;
    const auto stop = [&](auto, auto) {
      if (++calls >= 3) throw 1;
    };
    EXPECT_THROW(train(source_of(header), small_spec(), report, stop, threads), int);
    EXPECT_LT(calls, static_cast<int>(header.sets.active.size()));
  }
}

// Claim: the searched spread is a candidate, the same every time, and no candidate beats it by more than the
// difference between the search's held-out points and these (a third).
TEST(Training, SearchFindsASpreadThatServesUnseenPoints) {
  const DatabaseHeader header = small_header();
  TrainingSpec spec = small_spec();
  spec.force_spread = 0;
  spec.deformation_spread = 0;
  TrainingReport report;
  const std::string text = text_of(source_of(header), spec, 2, &report);
  EXPECT_EQ(text, text_of(source_of(header), spec, 1));
  const auto error = [&](double spread) {
    NetworkPoints held_out;
    const NetworkPoints train = deformation_points(training_tables(header), small_rays(header, 5), {{15}, {1.0}}, 15,
                                                   spec.samples, 99, &held_out, 1000);
    return mean_relative_error(fit_network(train, {spec.deformation_neurons, spread, 0}).network, held_out);
  };
  double best = 1;
  for (const double spread : deformation_spread_candidates()) best = std::min(best, error(spread));
  EXPECT_LT(error(report.deformation_spread), best * 4 / 3);
}

}  // namespace
