// A model in the runtime, with memory in vectors that a C program would allocate.
#pragma once

#include <phynness/phynness.h>

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

struct Trained {
  Trained(const phn_model* model, std::int32_t node, const double* d)
      : status(phn_trained_depth(model, node, d, &depth)) {}
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
