// A model in the runtime, with memory in vectors that a C program would allocate.
#pragma once

#include <phynness/phynness_surface.h>
#include <phynness/phynness_tools.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace phynness::test {

/// Zeros for null, but for the precision.
inline phn_info info_of(const phn_model* model) {
  phn_info info;
  phn_model_info(model, &info);
  return info;
}

/// The tool at a node as an argument; null without a displacement.
struct AtNode : phn_tool {
  explicit AtNode(std::int32_t node) : phn_tool{{node, -1, -1}, {1, 0, 0}, {0, 0, 0}} {}
  AtNode(std::int32_t node, const double* d) : AtNode(node) {
    is_given = d != nullptr;
    for (int k = 0; k < 3 && is_given; ++k) displacement[k] = d[k];
  }
  operator const phn_tool*() const { return is_given ? this : nullptr; }
  bool is_given = true;
};

/// Zeros for null.
inline phn_surface_contents contents_of(const phn_surface* surface) {
  phn_surface_contents contents;
  phn_surface_info(surface, &contents);
  return contents;
}

struct Trained {
  Trained(const phn_model* model, std::int32_t node, const double* d)
      : status(phn_depth(model, AtNode(node, d), &depth)) {}
  double depth = -1;
  int status;
};

struct LoadedModel {
  explicit LoadedModel(const std::string& text, std::int32_t max_tools = 4) {
    std::size_t bytes = 0;
    check(phn_model_size(text.data(), text.size(), &bytes, nullptr));
    model_memory.resize(bytes);
    check(phn_model_init(model_memory.data(), bytes, text.data(), text.size(), &model, nullptr));
    check(phn_data_size(model, max_tools, &bytes));
    data_memory.resize(bytes);
    check(phn_data_init(data_memory.data(), bytes, model, max_tools, &data));
  }
  static void check(int status) {
    if (status != PHN_OK) throw std::runtime_error(phn_status_message(status));
  }

  std::vector<char> model_memory, data_memory;
  const phn_model* model = nullptr;
  phn_data* data = nullptr;
};

}  // namespace phynness::test
