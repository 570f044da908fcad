// phn_image_open.
#include "image/check.hpp"

using namespace PHN_RUNTIME;

namespace {

template <class Real, class Image>
int open(const void* memory, size_t bytes, const Image** image) {
  if (image == nullptr) return PHN_ERROR_ARGUMENT;
  const ImageHeader<Real>* opened = nullptr;
  const int status =
      overlap(memory, bytes, image, sizeof *image) ? PHN_ERROR_OVERLAP : open_image(memory, bytes, opened);
  *image = reinterpret_cast<const Image*>(opened);
  return status;
}

}  // namespace

extern "C" {
int phn_image_open(const void* memory, size_t bytes, const phn_image** image) {
  return open<double>(memory, bytes, image);
}
int phn_imagef_open(const void* memory, size_t bytes, const phn_imagef** image) {
  return open<float>(memory, bytes, image);
}
}

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
