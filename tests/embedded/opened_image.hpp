// An image in aligned memory.
#pragma once

#include <cstdint>
#include <cstring>
#include <phynness/formats/image.hpp>
#include <stdexcept>
#include <vector>

#include "../../formats/src/image/image_functions.hpp"

namespace phynness::test {

template <class Real>
struct OpenedImage {
  explicit OpenedImage(const ModelImage& from) : words(from.bytes.size() / 8) {
    std::memcpy(words.data(), from.bytes.data(), from.bytes.size());
    if (Image<Real>::open(words.data(), from.bytes.size(), &image) != PHN_OK)
      throw std::runtime_error("the image is refused");
  }
  std::int32_t n_active() const { return Image<Real>::n_active(image); }
  std::int32_t n_output() const { return Image<Real>::n_output(image); }

  std::vector<std::uint64_t> words;
  const typename Image<Real>::Type* image = nullptr;
};

}  // namespace phynness::test
