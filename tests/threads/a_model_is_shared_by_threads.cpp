// Claims: threads that share a model, a surface and an image, each with its own scratch, get exactly the results of a
// single thread. The test also runs with the sanitizer of threads, which detects races that results do not show.
#include <gtest/gtest.h>
#include <phynness/phynness_surface.h>

#include <atomic>
#include <thread>

#include "../embedded/opened_image.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace phynness::test {
namespace {

constexpr int n_threads = 8, n_rounds = 60;

/// Every function of phynness.h that takes scratch, at all active nodes, in an order that differs between threads.
std::vector<double> answers(const phn_model* model, const phn_surface* surface, int first) {
  std::size_t bytes = 0;
  LoadedModel::check(phn_data_size(model, 2, &bytes));
  std::vector<char> memory(bytes);
  phn_data* data = nullptr;
  LoadedModel::check(phn_data_init(memory.data(), bytes, model, 2, &data));
  const int n_active = info_of(model).n_active, n_output = info_of(model).n_output;
  std::vector<double> all, out(3 * static_cast<std::size_t>(n_output) + 9);
  std::vector<float> scratch(contents_of(surface).scratch_bytes / sizeof(float)),
      fine(3 * static_cast<std::size_t>(contents_of(surface).n_vertices));
  std::vector<std::vector<double>> of_node(static_cast<std::size_t>(n_active));
  for (int i = 0; i < n_active; ++i) {
    const auto at = static_cast<std::size_t>((i + first) % n_active);
    const std::int32_t node = info_of(model).active_nodes[at], other = info_of(model).active_nodes[(at + 1) % n_active];
    const double d[] = {0.002, -0.001, 0.003};
    auto& kept = of_node[at];
    const auto keep = [&](int status, std::size_t n) {
      kept.push_back(status);
      kept.insert(kept.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(n));
    };
    keep(phn_force(model, data, AtNode(node, d), out.data(), nullptr, nullptr), 3);
    keep(phn_force(model, data, AtNode(node, d), nullptr, out.data(), nullptr), 1);
    keep(phn_force(model, data, AtNode(node, d), nullptr, nullptr, out.data()), 9);
    keep(phn_deform(model, data, AtNode(other, d), out.data()), 3 * static_cast<std::size_t>(n_output));
    keep(phn_surface_deform(surface, scratch.data(), out.data(), fine.data()), 0);
    kept.insert(kept.end(), fine.begin(), fine.end());
    phn_tool tool;
    const double x[] = {0.01, 0.02, 0.01};
    keep(phn_nearest(model, x, &tool, nullptr, nullptr), 0);
    std::copy_n(d, 3, tool.displacement);
    keep(phn_couple(model, data, 1, &tool, out.data(), nullptr), 3);
    keep(phn_coupled_deform(model, data, out.data()), 3 * static_cast<std::size_t>(n_output));
  }
  for (const auto& part : of_node) all.insert(all.end(), part.begin(), part.end());
  return all;
}

class Shared : public ::testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Shared, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Shared, ModelsAnswerAsToOneThread) {
  const LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  std::size_t bytes = 0;
  LoadedModel::check(phn_surface_size(loaded.model, 2, &bytes));
  std::vector<char> memory(bytes);
  const phn_surface* surface = nullptr;
  LoadedModel::check(phn_surface_init(memory.data(), bytes, loaded.model, 2, &surface));
  // Nothing has been asked before: what is chosen at the first question is chosen by all threads at once.
  std::atomic<int> ready{0};
  std::vector<std::vector<double>> first(n_threads);
  std::vector<int> differing(n_threads);
  std::vector<std::thread> threads;
  for (int t = 0; t < n_threads; ++t)
    threads.emplace_back([&, t] {
      ++ready;
      while (ready < n_threads) std::this_thread::yield();
      const auto at = static_cast<std::size_t>(t);
      first[at] = answers(loaded.model, surface, t);
      for (int i = 1; i < n_rounds; ++i) differing[at] += answers(loaded.model, surface, t + i) != first[at];
    });
  for (auto& thread : threads) thread.join();
  const std::vector<double> alone = answers(loaded.model, surface, 0);
  for (int t = 0; t < n_threads; ++t) {
    EXPECT_EQ(differing[static_cast<std::size_t>(t)], 0);
    EXPECT_EQ(first[static_cast<std::size_t>(t)], alone);
  }
}

TEST_P(Shared, ImagesAnswerAsToOneThread) {
  const OpenedImage<float> opened(model_image(small_model_of(GetParam()), {false, true}));
  const auto ask = [&] {
    std::vector<float> scratch(opened.n_scratch()), out(opened.n_field() + 3);
    const float d[] = {0.002F, -0.001F, 0.003F};
    const auto tool = Image<float>::tool_at(3, d);
    Image<float>::force(opened.image, &tool, out.data());
    Image<float>::deform(opened.image, scratch.data(), &tool, out.data() + 3);
    return out;
  };
  const auto alone = ask();
  std::atomic<int> differing{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < n_threads; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < n_rounds; ++i) differing += ask() != alone;
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(differing, 0);
}

}  // namespace
}  // namespace phynness::test
