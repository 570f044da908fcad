// phn_image_open. It runs once and is optimized for size.
#include "image/check.hpp"

using namespace PHN_RUNTIME;

#ifdef __GNUC__
#define PHN_ONCE __attribute__((cold))
#else
#define PHN_ONCE
#endif

namespace {

template <class Real, class Image>
PHN_ONCE int open(const void* memory, size_t bytes, const Image** image) {
  if (image == nullptr) return PHN_ERROR_ARGUMENT;
  const ImageHeader<Real>* opened = nullptr;
  const int status =
      overlap(memory, bytes, image, sizeof *image) ? PHN_ERROR_OVERLAP : open_image(memory, bytes, opened);
  *image = reinterpret_cast<const Image*>(opened);
  return status;
}

}  // namespace

extern "C" {
PHN_ONCE int phn_image_open(const void* memory, size_t bytes, const phn_image** image) {
  return open<double>(memory, bytes, image);
}
PHN_ONCE int phn_imagef_open(const void* memory, size_t bytes, const phn_imagef** image) {
  return open<float>(memory, bytes, image);
}
}
