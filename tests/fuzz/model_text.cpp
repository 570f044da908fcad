// Arbitrary bytes as model.txt are refused with a documented status, or are a model with defined results. If the
// runtime accepts a text, so does the reader of the host, and the text that it writes is the same model. Input: a byte
// (bit 0: set the right checksum, bits 1 ... 4: alignment), 8 bytes that determine the queries, the text.
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>

#include "../runtime/small_model.hpp"
#include "ask_model.hpp"
#include "texts.hpp"

namespace phynness::fuzz {
namespace {

constexpr std::size_t prologue = 9;

const std::vector<std::string_view> words = words_of(
    "0|1|2|3|4|5|7|8|9|12|13|20|1024|1025|32767|-32767|32768|65536|2147483647|2147483648|4294967296|9999999999|"
    "99999999999|0p+0|-0p+0|1p+0|-1p+0|1p-20|1p-1022|0.0000000000001p-1022|1p-1074|1.fffffffffffffp+1023|1p+1023|"
    "-1p+1023|1p+1024|1p+9999|1p-500|1p+500|1p+300|-1p+332|1p+332|1.47ae147ae147bp-7|1p|p+0|1.p+0|0x1p+0|nan|inf|"
    "rbfn|modal|linear|phynness-model|family|title|directions|displacements|fixed|output|surface|active|node|"
    "point|prescribed|incomplete|trained_depth|force|deformation|shape|stiffness|weights|mixing|near|near_modes|"
    "shared_modes|modes|amplitude_centers|fields|field|degree|scale|spread|bias|unit_responses|checksum|");

/// What the host makes of a text that the runtime accepted.
void host_agrees(const std::string& text) {
  try {
    const std::string written = write_model_text(read_model_text(text, "input"));
    std::size_t here = 0, there = 0;
    require(phn_model_size(text.data(), text.size(), &here, nullptr) == PHN_OK, "accepted before");
    require(phn_model_size(written.data(), written.size(), &there, nullptr) == PHN_OK && here == there,
            "what the host writes is the same model");
    require(write_model_text(read_model_text(written, "input")) == written, "a round trip");
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    require(false, "the host reads what the runtime reads");
  }
}

}  // namespace

std::vector<Input> seeds() {
  using namespace phynness::test;
  std::vector<Input> all;
  Model no_surface = small_linear_model(), bare = small_model(0, 0);
  no_surface.surface.resize(0, 3);
  bare.nodes.clear();
  int i = 0;
  for (const Model& model : {small_model(2, 2), small_model(0, 1), small_linear_model(), small_modal_model(2, 2, 2, 2),
                             small_modal_model(0, 1, 0, 0), small_field_model(), no_surface, bare}) {
    Input& input = all.emplace_back();
    append(input, static_cast<std::uint8_t>(1 + 2 * i), static_cast<std::uint64_t>(i));
    ++i;
    append_text(input, write_model_text(model));
  }
  all.push_back(all.front());
  all.back()[0] = 0;
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return change_text(data, size, max_size, seed, prologue, words);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script script(data, size);
  const std::uint8_t how = script.byte();
  Random random(script.raw<std::uint64_t>());
  const Input rest = script.rest();
  std::string text(rest.begin(), rest.end());
  if (how & 1) text = sealed(text);
  // A block of its own size, so that reading beyond it shows.
  const std::vector<char> exact(text.begin(), text.end());
  const LoadedText loaded(exact.empty() ? text.c_str() : exact.data(), exact.size(), (how >> 1) & 15);
  if (loaded.model == nullptr) {
    if (how & 32) {
      try {
        read_model_text(text, "input");
      } catch (const Error&) {
      }
    }
    return 0;
  }
  host_agrees(text);
  look_at(loaded.model);
  const std::uint64_t before = loaded.hash();
  Input questions(400);
  for (auto& byte : questions) byte = static_cast<std::uint8_t>(random.next());
  Script asked(questions);
  ask(loaded.model, asked, false, 12);
  require(loaded.hash() == before, "a model never changes");
  return 0;
}
