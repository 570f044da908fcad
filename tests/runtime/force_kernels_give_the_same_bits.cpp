#include <gtest/gtest.h>

#include <array>
#include <random>

#include "core/kernels.hpp"

namespace {

using namespace phynness::runtime;

struct ForceValues {
  std::array<double, 3> force;
  double energy;
  std::array<double, 9> stiffness;
  bool operator==(const ForceValues&) const = default;
};

/// A force of random centers and coefficients.
struct RandomForce {
  explicit RandomForce(std::int32_t n_centers) : terms(6 * static_cast<std::size_t>(whole_blocks(n_centers + 1))) {
    std::mt19937 random(static_cast<unsigned>(n_centers));
    std::uniform_real_distribution<double> between(-1, 1);
    for (std::int32_t k = 0; k < 6; ++k)
      for (std::int32_t i = 0; i < n_centers; ++i)
        terms[static_cast<std::size_t>(k * whole_blocks(n_centers + 1) + i)] = between(random);
    net.n_centers = n_centers;
    net.max_displacement = 0.02;
    net.shape = 0.3;
    for (double& k : net.stiffness) k = 50 * between(random);
    net.table = terms.data();
    set_rest(net, terms.data());
  }

  ForceValues by(const ForceKernels& kernels, const double* x) const {
    ForceValues values = {};
    kernels.with_both(net, x, values.force.data(), &values.energy, values.stiffness.data());
    return values;
  }

  std::vector<double> terms;
  ModalForce net = {};
};

constexpr std::int32_t force_sizes[] = {0, 1, 15, 16, 31, 32, 60, 78, 143};
constexpr double force_depths[] = {0.0, 1e-9, 0.3, 1.0, 40.0, largest_modal};

// Claim: whatever the processor has, force, energy and stiffness of one pass are the same to the last bit, for numbers
// of centers that fill whole registers and for those that do not.
TEST(ForceKernels, GiveTheSameBitsWithEverySetOfInstructions) {
  for (const std::int32_t n_centers : force_sizes) {
    const RandomForce force(n_centers);
    for (const double depth : force_depths) {
      const double x[] = {depth, -0.4 * depth, 0.2 * depth};
      const ForceValues expected = force.by(*force_kernels(0), x);
      for (int set = 1; set < n_instruction_sets; ++set) {
        const ForceKernels* kernels = force_kernels(set);
        if (kernels == nullptr) continue;
        EXPECT_EQ(force.by(*kernels, x), expected) << kernels->name << ", " << n_centers << " centers, " << depth;
      }
    }
  }
}

// Claim: what is asked for beside the force changes no bit of it, nor of anything else: each kernel gives what all
// give.
TEST(ForceKernels, GiveTheSameBitsAloneAndTogether) {
  for (int set = 0; set < n_instruction_sets; ++set) {
    const ForceKernels* kernels = force_kernels(set);
    if (kernels == nullptr) continue;
    for (const std::int32_t n_centers : force_sizes) {
      const RandomForce force(n_centers);
      for (const double depth : force_depths) {
        const double x[] = {depth, -0.4 * depth, 0.2 * depth};
        const ForceValues together = force.by(*kernels, x);
        ForceValues alone = together, with_energy = together, with_stiffness = together;
        kernels->force(force.net, x, alone.force.data(), nullptr, nullptr);
        kernels->with_energy(force.net, x, with_energy.force.data(), &with_energy.energy, nullptr);
        kernels->with_stiffness(force.net, x, with_stiffness.force.data(), nullptr, with_stiffness.stiffness.data());
        EXPECT_EQ(alone, together) << kernels->name << ", " << n_centers << " centers, " << depth;
        EXPECT_EQ(with_energy, together) << kernels->name << ", " << n_centers << " centers, " << depth;
        EXPECT_EQ(with_stiffness, together) << kernels->name << ", " << n_centers << " centers, " << depth;
      }
    }
  }
}

}  // namespace
