// Claims: an image with any one damaged byte, truncated at any word, with the other type of numbers, of another version
// or at an unaligned address is refused with a separate status. An image with inconsistent tables is refused even if
// its checksum is right.
#include <gtest/gtest.h>
#include <phynness/phynness_image.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <phynness/image_layout.hpp>

#include "opened_image.hpp"
#include "round_models.hpp"

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
    header().checksum = image::checksum(word + image::n_unchecked_words, size() / 4 - image::n_unchecked_words);
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
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const unsigned flip : {0x01U, 0x80U}) {
      bytes.data()[i] ^= static_cast<unsigned char>(flip);
      ASSERT_LT(bytes.open(), 0) << "byte " << i;
      bytes.data()[i] ^= static_cast<unsigned char>(flip);
    }
  EXPECT_EQ(bytes.open(), PHN_OK);
}

TEST_P(Damaged, EndsAreNoticed) {
  for (std::size_t n = 4; n < bytes.size(); n += 4) ASSERT_EQ(bytes.open(n), PHN_ERROR_TRUNCATED) << n;
  EXPECT_EQ(bytes.open(3), PHN_ERROR_NOT_A_MODEL);
}

TEST_P(Damaged, KindsAreTold) {
  const Image<double>::Type* other = nullptr;
  EXPECT_EQ(Image<double>::open(bytes.data(), bytes.size(), &other), PHN_ERROR_IMAGE_OF_FLOATS);
  Bytes of_doubles(model_image(small_model_of(GetParam()), {}));
  EXPECT_EQ(of_doubles.open(), PHN_ERROR_IMAGE_OF_DOUBLES);
  bytes.header().real_bytes ^= 1U;  // of no kind
  EXPECT_EQ(bytes.open(), PHN_ERROR_CHECKSUM);
  bytes.header().real_bytes ^= 1U;
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
  // The last two are 4 and 8 bytes where size_t has 32 bits.
  for (const std::uint32_t more : {1U, 0xffffffffU, 0x40000001U, 0x20000001U})
    refused([=](auto& h) { h.n_scratch = more == 1 ? h.n_scratch + 1 : more; }, PHN_ERROR_RANGE);
  if (GetParam() == Family::modal) refused([](auto& h) { --h.modes.scale.n; }, PHN_ERROR_RANGE);
  for (const std::uint32_t at : {end, end - 4, 0xfffffffcU, bytes.header().provenance + 1})
    refused([=](auto& h) { h.provenance = at; }, PHN_ERROR_RANGE);
}

/// A family that is exact has no bounds, of which linear points would need a row.
TEST(DamagedSurface, BoundsOfAnExactFamilyAreRefused) {
  Bytes bytes{model_image(small_model_touched_anywhere(Family::linear), {false, true})};
  ASSERT_EQ(bytes.open(), PHN_OK);
  const auto at = reinterpret_cast<image::Provenance*>(bytes.data() + bytes.header().provenance)->surface;
  auto& surface = *reinterpret_cast<image::Surface*>(bytes.data() + at);
  const image::Table somewhere = bytes.header().active_points;
  surface.bound = {somewhere.at, bytes.header().displacements.n / 3 * bytes.header().active_nodes.n};
  surface.bound_scale = {somewhere.at, bytes.header().active_nodes.n};
  surface.between = {somewhere.at, schema::n_coupled_terms};
  EXPECT_EQ(bytes.open_sealed(), PHN_ERROR_RANGE);
}

/// Every word, replaced by numbers of all kinds under a right checksum: refused, or every answer is finite.
template <class Real>
void words_never_harm(const Model& model) {
  const ModelImage made = model_image(model, {false, sizeof(Real) == 4});
  const OpenedImage<Real> good(made);
  const Real largest = image::Bounds<Real>::value;
  for (std::size_t w = image::n_unchecked_words; w < made.bytes.size() / 4; ++w)
    for (const std::uint32_t value : {0U, 1U, 0x7fffffffU, 0xffffffffU, 0x7f800000U, 0x7ff00000U, 0x7f7fffffU,
                                      0xffefffffU, 0x00000100U, 0x5368d4a5U, 0x54b249acU}) {
      std::vector<std::uint64_t> words = good.words;
      auto* word = reinterpret_cast<std::uint32_t*>(words.data());
      word[w] = value;
      word[4] = image::checksum(word + image::n_unchecked_words, made.bytes.size() / 4 - image::n_unchecked_words);
      const typename Image<Real>::Type* image = nullptr;
      if (Image<Real>::open(words.data(), made.bytes.size(), &image) != PHN_OK) continue;
      typename Image<Real>::Contents contents;
      ASSERT_EQ(Image<Real>::info(image, &contents), PHN_OK);
      const phn_provenance& said = contents.provenance;
      for (const double x : {said.shear_modulus_Pa, said.finer_mean, said.finer_p95, said.finer_tool_radius_m})
        ASSERT_TRUE(std::isfinite(x) && x >= 0) << "word " << w << " = " << value;
      for (const char* text : {said.mesh_hash, said.physics_hash, said.element, said.reference})
        ASSERT_LT(std::strlen(text), 20U) << "word " << w << " = " << value;
      std::vector<Real> scratch(contents.scratch_bytes / sizeof(Real));
      std::vector<Real> field(3 * static_cast<std::size_t>(contents.n_output));
      for (const Real size : {Real(0), Real(0.003), largest}) {
        const Real d[3] = {size, -size / 2, -size};
        Real out[16] = {}, *point = out + 3, *apart = out + 6;
        typename Image<Real>::Tool places[3] = {Image<Real>::tool_at(3, d)};
        Image<Real>::nearest(image, -1, d, &places[1], point, apart);
        Image<Real>::nearest(image, 0, d, &places[2], point, apart);
        for (auto& tool : places) {
          std::copy_n(d, 3, tool.displacement);
          Image<Real>::force(image, &tool, out);
          Image<Real>::stiffness(image, &tool, out + 7);
          for (const Real x : out) ASSERT_TRUE(std::isfinite(x)) << "word " << w << " = " << value;
          Image<Real>::energy(image, &tool, out);
          Image<Real>::depth(image, &tool, out + 1);
          Image<Real>::bound(image, &tool, out + 2);
          for (const Real x : out) ASSERT_TRUE(std::isfinite(x)) << "word " << w << " = " << value;
          Image<Real>::deform(image, scratch.data(), &tool, field.data());
          for (const Real x : field) ASSERT_TRUE(std::isfinite(x)) << "word " << w << " = " << value;
          for (const Real x : tool.weights) ASSERT_TRUE(x >= 0 && x <= 1) << "word " << w << " = " << value;
        }
      }
    }
}
TEST_P(Damaged, WordsNeverHarm) {
  words_never_harm<float>(small_model_of(GetParam()));
  words_never_harm<double>(small_model_of(GetParam()));
  words_never_harm<float>(small_model_touched_anywhere(GetParam()));
  words_never_harm<double>(small_model_touched_anywhere(GetParam()));
}

/// NaN, infinity and what is beyond the bounds of formats/image.md are refused in every table of numbers.
TEST_P(Damaged, NumbersOutOfBoundsAreRefused) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto refused = [&](image::Table table, float bound) {
    for (std::uint32_t i = 0; i < table.n; ++i) {
      for (const float value : {nan, -nan, inf, -inf, bound * 1.0001F, bound * -1.0001F}) {
        Bytes copy = bytes;
        std::memcpy(copy.data() + table.at + 4 * i, &value, 4);
        ASSERT_EQ(copy.open_sealed(), PHN_ERROR_RANGE) << value;
      }
      Bytes copy = bytes;
      std::memcpy(copy.data() + table.at + 4 * i, &bound, 4);
      ASSERT_EQ(copy.open_sealed(), PHN_OK);
    }
  };
  const auto& header = bytes.header();
  const bool modal = GetParam() == Family::modal;
  for (const auto table : {header.active_points, header.output_points, header.directions}) refused(table, 1e12F);
  refused(header.displacements, modal ? 1e6F : 1e12F);
  refused(header.modes.scale, 31);
  refused(header.amplitude_at_rest, 1e7F);
  const auto& node = *reinterpret_cast<const image::ActiveNode<float>*>(bytes.data() + header.active.at);
  refused(node.trained_depth, 1e12F);
  for (const float depth : {-1e-30F, -0.01F, -0.0F}) {
    Bytes copy = bytes;
    std::memcpy(copy.data() + node.trained_depth.at, &depth, 4);
    EXPECT_EQ(copy.open_sealed(), depth < 0 ? PHN_ERROR_RANGE : PHN_OK) << depth;
  }
  for (const float R : {nan, inf, 0.0F, -1.0F, 0.9e-6F, 1.1e6F}) {
    Bytes copy = bytes;
    copy.header().max_displacement = R;
    EXPECT_EQ(copy.open_sealed(), PHN_ERROR_RANGE) << R;
  }
  for (const float s : {nan, inf, 0.0F, -1.0F, 0.9e-6F, 1.1e6F}) {
    Bytes copy = bytes;
    copy.header().amplitude_shape = s;
    EXPECT_EQ(copy.open_sealed(), modal ? PHN_ERROR_RANGE : PHN_OK) << s;
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Damaged, ::testing::Values(Family::rbfn, Family::linear, Family::modal));

}  // namespace
}  // namespace phynness::test
