// Arbitrary sequences of calls with arbitrary arguments on valid models of every family. Input: the model, calls.
#include <phynness/formats/model.hpp>

#include "../runtime/small_model.hpp"
#include "ask_model.hpp"

namespace phynness::fuzz {
namespace {

using namespace phynness::test;

const std::vector<LoadedText>& models() {
  static const auto* all = [] {
    auto* loaded = new std::vector<LoadedText>;
    for (const Model& model : {small_model(), small_linear_model(), small_modal_model(), small_field_model(),
                               small_modal_model(8, 3, 8, 4), small_model(0, 0), small_modal_model(3, 40, 6, 4),
                               with_levels(small_model(40, 40)), with_levels(small_field_model())}) {
      const std::string text = write_model_text(model);
      loaded->emplace_back(text.data(), text.size(), 3 * loaded->size());
      require(loaded->back().model != nullptr, "a good model");
    }
    return loaded;
  }();
  return *all;
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> all;
  Random random(11);
  for (int i = 0; i < 240; ++i) {
    Input& input = all.emplace_back();
    input.push_back(static_cast<std::uint8_t>(i));
    for (int k = 0; k < 200; ++k) input.push_back(static_cast<std::uint8_t>(random.next()));
  }
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script script(data, size);
  const LoadedText& loaded = models()[static_cast<std::size_t>(script.below(static_cast<int>(models().size())))];
  static const auto* before = [] {
    auto* hashes = new std::vector<std::uint64_t>;
    for (const auto& each : models()) hashes->push_back(each.hash());
    return hashes;
  }();
  ask(loaded.model, script, true);
  require(loaded.hash() == (*before)[static_cast<std::size_t>(&loaded - models().data())], "a model never changes");
  return 0;
}
