#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/kernels.hpp"
#include "core/rbfn/exponential.hpp"

namespace {

using namespace phynness::runtime;

struct Values {
  std::vector<double> force = std::vector<double>(3), of_displacement, of_point, field;
  std::vector<double> table;
  bool operator==(const Values&) const = default;
};

/// A network of random numbers. Points are inputs 3 to 5 of n_output nodes.
struct RandomNetwork {
  explicit RandomNetwork(std::int32_t n_neurons, std::int32_t n_output = 37) : points(3 * n_output) {
    std::uniform_real_distribution<double> between(-1, 1);
    for (auto& p : points) p = between(random);
    net.n_neurons = n_neurons;
    net.n_inputs = 6;
    net.inverse_square_spread = 1.7;
    for (int k = 0; k < 6; ++k) {
      net.input_center[k] = 0.1 * between(random);
      net.input_half_range[k] = 0.5;
      for (std::int32_t i = 0; i < n_neurons; ++i) center[k].push_back(between(random));
      center[k].resize(static_cast<std::size_t>(whole_blocks(n_neurons)));
      net.center[k] = center[k].data();
    }
    for (int k = 0; k < 3; ++k) {
      net.output_center[k] = 0.01 * k;
      net.output_half_range[k] = 0.3;
      net.bias[k] = 0.2;
      for (std::int32_t i = 0; i < n_neurons; ++i) weight[k].push_back(between(random));
      weight[k].resize(static_cast<std::size_t>(whole_blocks(n_neurons)));
      net.weight[k] = weight[k].data();
    }
  }

  Values by(const NetworkKernels& kernels, const double* d) const {
    const auto n = static_cast<std::size_t>(net.n_neurons), n_output = points.size() / 3;
    Values values;
    kernels.force(net, d, values.force.data());
    values.of_displacement.resize(n);
    kernels.of_inputs(net, 0, d, values.of_displacement.data());
    values.of_point.resize(n);
    kernels.of_inputs(net, 3, points.data(), values.of_point.data());
    values.table.resize((n_output + nodes_per_block - 1) / nodes_per_block * nodes_per_block * n);
    kernels.of_coordinates(net, static_cast<std::int32_t>(n_output), points.data(), values.table.data());
    values.field.resize(3 * n_output);
    std::vector<double> scratch(3 * n);
    kernels.field(net, static_cast<std::int32_t>(n_output), values.table.data(), values.of_displacement.data(), 0.7,
                  scratch.data(), values.field.data());
    return values;
  }

  std::mt19937 random{1};
  std::vector<double> points;
  std::vector<double> center[6], weight[3];
  Network net{};
};

// Claim: whatever the processor has, force and field are the same to the last bit, for sizes that fill whole
// registers and for those that do not.
TEST(NetworkKernels, GiveTheSameBitsWithEverySetOfInstructions) {
  for (const std::int32_t n_neurons : {1, 15, 16, 17, 60}) {
    const RandomNetwork network(n_neurons);
    for (const double size : {0.0, 0.3, 40.0, 1e300}) {
      const double d[] = {size, -0.4 * size, 0.2 * size};
      const auto expected = network.by(*network_kernels(0), d);
      for (int set = 1; set < n_instruction_sets; ++set)
        if (const auto* kernels = network_kernels(set)) {
          EXPECT_EQ(network.by(*kernels, d), expected) << kernels->name << ", " << n_neurons << " neurons";
        }
    }
  }
}

// Claim: within 6e-16 of the library's exp, itself exact to 2e-16, down to exp(-300); below that never more than it,
// nor so little that a product of two and a weight leaves the normal numbers; exactly 1 at 0; never negative or NaN.
TEST(Exponential, OfNegativeNumbersIsThatOfTheLibrary) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> between(0, 1);
  for (int i = 0; i < 200'000; ++i) {
    const double x = -300 * std::pow(between(random), 1 + i % 4);
    const double expected = std::exp(x);
    ASSERT_LE(std::abs(exp_of_negative(x) - expected), 8e-16 * expected) << x;
  }
  EXPECT_EQ(exp_of_negative(0), 1);
  EXPECT_EQ(exp_of_negative(-0.0), 1);
  EXPECT_EQ(exp_of_negative(-1e-300), 1);
  for (const double x : {-301.0, -709.0, -745.2, -1e300, -std::numeric_limits<double>::infinity()}) {
    EXPECT_LE(exp_of_negative(x), exp_of_negative(-300)) << x;
    EXPECT_TRUE(std::isnormal(1e-40 * exp_of_negative(x) * exp_of_negative(x))) << x;
  }
}

// Claim: within 6e-16 of the library's exp2 (as above), down to 2^-430; below that as above; exactly 1 at 0.
TEST(Exponential, OfBaseTwoIsThatOfTheLibrary) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> between(0, 1);
  for (int i = 0; i < 200'000; ++i) {
    const double t = 430 * std::pow(between(random), 1 + i % 4), expected = std::exp2(-t);
    ASSERT_LE(std::abs(power_of_half(t) - expected), 6e-16 * expected) << t;
  }
  EXPECT_EQ(power_of_half(0.0), 1.0);
  EXPECT_EQ(power_of_half(1e-300), 1.0);
  for (const double t : {430.5, 1100.0, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_LE(power_of_half(t), power_of_half(430.0)) << t;
    EXPECT_TRUE(std::isnormal(1e-40 * power_of_half(t) * power_of_half(t))) << t;
  }
}

// Claim: within 2e-7 of the library's exp2 (three roundings of 6e-8, and 2e-8 of the polynomial),
// down to 2^-46; below that never more, nor so little that a product of two and a weight leaves the normal
// numbers of float; exactly 1 at 0; never negative or NaN.
TEST(Exponential, OfBaseTwoIsThatOfTheLibraryInFloat) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> between(0, 1);
  for (int i = 0; i < 200'000; ++i) {
    const auto t = static_cast<float>(46 * std::pow(between(random), 1 + i % 4));
    const double expected = std::exp2(-static_cast<double>(t));
    ASSERT_LE(std::abs(static_cast<double>(power_of_half(t)) - expected), 2e-7 * expected) << t;
  }
  EXPECT_EQ(power_of_half(0.0f), 1.0f);
  EXPECT_EQ(power_of_half(1e-30f), 1.0f);
  for (const float t : {46.5f, 127.0f, 1e30f, std::numeric_limits<float>::infinity()}) {
    EXPECT_LE(power_of_half(t), power_of_half(46.0f)) << t;
    EXPECT_TRUE(std::isnormal(1e-9f * power_of_half(t) * power_of_half(t))) << t;
  }
}

}  // namespace
