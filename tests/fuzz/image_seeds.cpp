// Images of all families in float and in double, with the prologue of image_bytes.cpp.
#include <phynness/formats/image.hpp>

#include "../embedded/round_models.hpp"
#include "fuzz_target.hpp"

namespace phynness::fuzz {

std::vector<Input> seeds() {
  using namespace phynness::test;
  std::vector<Input> all;
  for (const bool floats : {false, true})
    for (const bool force_only : {false, true})
      for (const Model& model : {small_model(3, 2), small_linear_model(), small_modal_model(2, 2, 3, 2),
                                 small_round_model(Family::rbfn), small_round_model(Family::modal)}) {
        const ModelImage made = model_image(model, {force_only, floats});
        Input& input = all.emplace_back();
        append(input, static_cast<std::uint8_t>(1 + 2 * floats), static_cast<std::uint64_t>(all.size()));
        input.resize(16);
        append_text(input, {reinterpret_cast<const char*>(made.bytes.data()), made.bytes.size()});
      }
  all.push_back(all.front());
  all.back()[0] = 0;
  return all;
}

}  // namespace phynness::fuzz
