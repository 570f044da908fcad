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
    Image<Real>::info(image, &contents);
  }
  /// Numbers of a deformation and of its working memory.
  std::size_t n_field() const { return 3 * static_cast<std::size_t>(contents.n_output); }
  std::size_t n_scratch() const { return contents.scratch_bytes / sizeof(Real); }

  std::vector<std::uint64_t> words;
  const typename Image<Real>::Type* image = nullptr;
  typename Image<Real>::Contents contents;
};

}  // namespace phynness::test
