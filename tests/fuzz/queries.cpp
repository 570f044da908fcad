// Arbitrary sequences of calls with arbitrary arguments on valid models of every family. Input: the model, calls.
#include "../runtime/small_model.hpp"
#include "ask_model.hpp"

namespace phynness::fuzz {

std::vector<Input> seeds() { return random_inputs(11, 240, 200); }

}  // namespace phynness::fuzz

using namespace phynness::fuzz;
using namespace phynness::test;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Models models({small_model(), small_linear_model(), small_modal_model(), small_field_model(),
                              small_modal_model(8, 3, 8, 4), small_model(0, 0), small_modal_model(3, 40, 6, 4),
                              with_levels(small_model(40, 40)), with_levels(small_field_model())},
                             3);
  Script script(data, size);
  models.ask_one(script, [&](const phn_model* model) { ask(model, script, true); });
  return 0;
}
