// Claims: an image with any one byte damaged, cut short at any word, of the other kind of number, of another
// version or at an odd address is refused with its own status; one whose tables do not fit is refused though
// its checksum is right.
#include <gtest/gtest.h>
#include <phynness/image.h>

#include <phynness/image_layout.hpp>

#include "../runtime/small_model.hpp"
#include "opened_image.hpp"

namespace phynness::test {
namespace {

struct Bytes {
  explicit Bytes(const ModelImage& image) : words(image.bytes.size() / 8) {
    std::memcpy(words.data(), image.bytes.data(), image.bytes.size());
  }
  unsigned char* data() { return reinterpret_cast<unsigned char*>(words.data()); }
  image::Header<float>& header() { return *reinterpret_cast<image::Header<float>*>(words.data()); }
  std::size_t size() const { return 8 * words.size(); }
  int open(std::size_t bytes) {
    const phn_imagef* image = reinterpret_cast<const phn_imagef*>(this);
    const int status = phn_imagef_open(data(), bytes, &image);
    EXPECT_EQ(image == nullptr, status != PHN_OK);
    return status;
  }
  int open() { return open(size()); }
  int open_sealed() {
    const auto* word = reinterpret_cast<const std::uint32_t*>(data());
    header().checksum =
        image::checksum(word + image::n_unchecked_words, size() / 4 - image::n_unchecked_words);
    return open();
  }

  std::vector<std::uint64_t> words;
};

class Damaged : public ::testing::TestWithParam<Family> {
 protected:
  Bytes bytes{model_image(small_model_of(GetParam()), {false, true})};
};

TEST_P(Damaged, BytesAreNoticed) {
  ASSERT_EQ(bytes.open(), PHN_OK);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const unsigned flip : {0x01U, 0x80U}) {
      bytes.data()[i] ^= static_cast<unsigned char>(flip);
      ASSERT_LT(bytes.open(), 0) << "byte " << i;
      bytes.data()[i] ^= static_cast<unsigned char>(flip);
    }
  }
  EXPECT_EQ(bytes.open(), PHN_OK);
}

TEST_P(Damaged, EndsAreNoticed) {
  for (std::size_t n = 4; n < bytes.size(); n += 4) ASSERT_EQ(bytes.open(n), PHN_ERROR_TRUNCATED) << n;
  EXPECT_EQ(bytes.open(3), PHN_ERROR_NOT_A_MODEL);
}

TEST_P(Damaged, KindsAreTold) {
  const phn_image* other = nullptr;
  EXPECT_EQ(phn_image_open(bytes.data(), bytes.size(), &other), PHN_ERROR_VERSION);
  const phn_imagef* image = nullptr;
  EXPECT_EQ(phn_imagef_open(bytes.data() + 2, bytes.size() - 2, &image), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_imagef_open(nullptr, 0, &image), PHN_ERROR_ARGUMENT);
  bytes.header().magic = 0x50484e49;  // the other order of bytes
  EXPECT_EQ(bytes.open(), PHN_ERROR_NOT_A_MODEL);
}

TEST_P(Damaged, TablesThatDoNotFitAreRefused) {
  const auto refused = [&](auto change, int status) {
    Bytes copy = bytes;
    change(copy.header());
    EXPECT_EQ(copy.open_sealed(), status);
  };
  const auto end = static_cast<std::uint32_t>(bytes.size());
  refused([](auto& h) { h.family = static_cast<image::Family>(3); }, PHN_ERROR_FAMILY);
  refused([](auto& h) { ++h.active_nodes.n; }, PHN_ERROR_RANGE);
  refused([](auto& h) { ++h.active.at; }, PHN_ERROR_RANGE);
  refused([&](auto& h) { h.active.at = end; }, PHN_ERROR_RANGE);
  refused([](auto& h) { h.output_nodes.n = 0xffffffff; }, PHN_ERROR_RANGE);
  refused([](auto& h) { h.output_points.at = 0xfffffffc; }, PHN_ERROR_RANGE);
  refused([](auto& h) { h.displacements.n = 3; }, GetParam() == Family::linear ? PHN_OK : PHN_ERROR_RANGE);
  refused([](auto& h) { h.directions.n -= 3; }, PHN_ERROR_RANGE);
  if (GetParam() != Family::linear) refused([](auto& h) { h.n_scratch -= 1; }, PHN_ERROR_RANGE);
  if (GetParam() == Family::modal) refused([](auto& h) { --h.modes.scale.n; }, PHN_ERROR_RANGE);
}

/// Every word of the tables, replaced by large and small numbers under a right checksum: never a crash.
TEST_P(Damaged, WordsNeverCrash) {
  const float d[3] = {0.001F, 0, -0.003F};
  for (std::size_t w = image::n_unchecked_words; w < bytes.size() / 4; ++w) {
    for (const std::uint32_t value : {0U, 1U, 0x7fffffffU, 0xffffffffU}) {
      Bytes copy = bytes;
      std::memcpy(copy.data() + 4 * w, &value, 4);
      const auto* word = reinterpret_cast<const std::uint32_t*>(copy.data());
      copy.header().checksum =
          image::checksum(word + image::n_unchecked_words, copy.size() / 4 - image::n_unchecked_words);
      const phn_imagef* image = nullptr;
      if (phn_imagef_open(copy.data(), copy.size(), &image) != PHN_OK) continue;
      std::vector<float> scratch(phn_imagef_scratch(image) < 100000 ? phn_imagef_scratch(image) : 0);
      std::vector<float> out(3 * static_cast<std::size_t>(phn_imagef_n_output(image)) + 3);
      phn_imagef_force(image, 3, d, out.data());
      if (scratch.size() == phn_imagef_scratch(image))
        phn_imagef_deform(image, scratch.data(), 3, d, out.data());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Damaged, ::testing::Values(Family::rbfn, Family::linear, Family::modal));

}  // namespace
}  // namespace phynness::test
