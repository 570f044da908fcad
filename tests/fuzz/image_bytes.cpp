// Arbitrary bytes as an image are refused with a documented status, or every result is defined. Input: a byte (bit 0:
// set the right checksum and size, bit 1: floats), 8 bytes that determine the queries, 7 unused bytes, the image.
#include <algorithm>
#include <phynness/image_layout.hpp>

#include "../../formats/src/image/image_functions.hpp"
#include "fuzz_target.hpp"

namespace phynness::fuzz {
namespace {

constexpr std::size_t prologue = 16;
/// Of magic, version, kind of number, bytes and checksum in an image.
constexpr std::size_t bytes_at = 12, checksum_at = 16;
constexpr std::size_t n_header_words = sizeof(image::Header<float>) / 4;

void seal(std::vector<std::uint64_t>& words, std::size_t bytes) {
  if (bytes < sizeof(image::Header<float>)) return;
  auto* at = reinterpret_cast<unsigned char*>(words.data());
  const auto length = static_cast<std::uint32_t>(bytes / 4 * 4);
  std::memcpy(at + bytes_at, &length, 4);
  const auto* word = reinterpret_cast<const std::uint32_t*>(words.data());
  const std::uint32_t sum = image::checksum(word + image::n_unchecked_words, length / 4 - image::n_unchecked_words);
  std::memcpy(at + checksum_at, &sum, 4);
}

template <class Real>
Real number(Script& script) {
  const double value = script.number();
  if (sizeof(Real) == 8) return static_cast<Real>(value);
  return std::isfinite(value) && std::fabs(value) > 3e38 ? std::numeric_limits<Real>::max() : static_cast<Real>(value);
}

template <class Real>
void open_and_ask(const std::vector<std::uint64_t>& words, std::size_t bytes, Script& script) {
  using namespace phynness;
  const typename Image<Real>::Type* image = nullptr;
  const int status = Image<Real>::open(words.data(), bytes, &image);
  require((image != nullptr) == (status == PHN_OK), "an image or none");
  if (status != PHN_OK) {
    require((status <= PHN_ERROR_NOT_A_MODEL && status >= PHN_ERROR_FAMILY) || status == PHN_ERROR_IMAGE_OF_FLOATS ||
                status == PHN_ERROR_IMAGE_OF_DOUBLES,
            "a documented refusal");
    return;
  }
  typename Image<Real>::Contents contents;
  require(Image<Real>::info(image, &contents) == PHN_OK, "contents");
  const std::size_t n_scratch = contents.scratch_bytes / sizeof(Real);
  require(n_scratch <= bytes, "no more working memory than the image describes");
  std::vector<Real> scratch(n_scratch), out;
  using Tool = typename Image<Real>::Tool;
  const auto check = [&](int told, std::size_t n, Real refused = 0) {
    require(told <= 3 && (told >= 0 || (told <= PHN_ERROR_ARGUMENT && told >= PHN_ERROR_UNDEFINED)),
            "a documented status");
    for (std::size_t k = 0; k < n; ++k)
      require(told >= 0 ? std::isfinite(out[k]) : out[k] == refused, "finite, or zeros");
  };
  const auto ask = [&](auto function, const Tool& tool, std::size_t n, Real refused = 0) {
    out.assign(n, 1);
    check(function(image, &tool, out.data()), n, refused);
  };
  for (int i = 0; i < 12; ++i) {
    const bool any = contents.n_active == 0 || script.below(8) == 0;
    const std::int32_t node =
        any ? script.raw<std::int32_t>() : contents.active_nodes[script.raw<std::uint16_t>() % contents.n_active];
    const Real d[3] = {number<Real>(script), number<Real>(script), number<Real>(script)};
    Tool tools[2] = {Image<Real>::tool_at(node, d)};
    out.assign(4, 1);
    const int found = Image<Real>::nearest(image, script.below(2) == 0 ? -1 : script.below(100), d, &tools[1],
                                           out.data(), out.data() + 3);
    require(found <= PHN_WARNING_UNSETTLED, "a documented status");
    check(found < 0 ? found : PHN_OK, 4);
    std::copy_n(d, 3, tools[1].displacement);
    if (script.below(2) == 0) {
      tools[1].triangle = script.below(100);
      for (Real& weight : tools[1].weights) weight = Real(0.25) * Real(script.below(4));
    }
    for (const Tool& tool : tools) {
      ask(Image<Real>::force, tool, 3);
      ask(Image<Real>::energy, tool, 1);
      ask(Image<Real>::stiffness, tool, 9);
      require(out[1] == out[3] && out[2] == out[6] && out[5] == out[7], "a symmetric stiffness");
      ask(Image<Real>::depth, tool, 1);
      ask(Image<Real>::bound, tool, 1, PHN_IMAGE_NO_BOUND);
      out.assign(3 * static_cast<std::size_t>(contents.n_output), 1);
      std::fill(scratch.begin(), scratch.end(), std::numeric_limits<Real>::quiet_NaN());
      check(Image<Real>::deform(image, scratch.data(), &tool, out.data()), out.size());
    }
  }
}

}  // namespace

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

/// Words of 32 bits are what an image consists of; every second change is in the header. The last two constants are 8
/// and 4 bytes as a size in bytes of 32 bits.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  Random random(seed);
  if (size < prologue + 8 || random.below(4) == 0) return LLVMFuzzerMutate(data, size, max_size);
  constexpr std::uint32_t words[] = {0,          1,          2,          3,          0x7fffffff, 0x80000000,
                                     0xffffffff, 0x7f800000, 0xff800000, 0x7fc00000, 0x7f7fffff, 0x7ff00000,
                                     0x7ff80000, 0x7fefffff, 0x3f800000, 0x3ff00000, 0x00800000, 0x5368d4a5,
                                     0x54b249ad, 0x00010000, 0x7fff7fff, 0x80018001, 0x20000001, 0x40000001};
  const std::size_t n_words = (size - prologue) / 4;
  for (std::size_t n = random.below(3) + 1; n > 0; --n) {
    const std::size_t n_near = random.below(2) == 0 ? std::min(n_words, n_header_words) : n_words;
    std::uint8_t* at = data + prologue + 4 * random.below(n_near);
    std::uint32_t word;
    std::memcpy(&word, at, 4);
    switch (random.below(4)) {
      case 0:
        word = words[random.below(std::size(words))];
        break;
      case 1:
        std::memcpy(&word, data + prologue + 4 * random.below(n_words), 4);
        break;
      case 2:
        word += static_cast<std::uint32_t>(random.below(17)) - 8;
        break;
      default:
        word ^= 1U << random.below(32);
    }
    std::memcpy(at, &word, 4);
  }
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < prologue) return 0;
  Script script(data, size);
  const std::uint8_t how = script.byte();
  Random random(script.raw<std::uint64_t>());
  const std::size_t bytes = size - prologue;
  std::vector<std::uint64_t> words(bytes / 8 + 1);
  if (bytes > 0) std::memcpy(words.data(), data + prologue, bytes);
  if (how & 1) seal(words, bytes);
  Input questions(1200);
  for (auto& byte : questions) byte = static_cast<std::uint8_t>(random.next());
  Script asked(questions);
  if (how & 2) {
    open_and_ask<float>(words, bytes, asked);
  } else {
    open_and_ask<double>(words, bytes, asked);
  }
  return 0;
}
