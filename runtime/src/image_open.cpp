// phn_image_open. It runs once, and is in a file of its own so that it can be optimized for size.
#include "image_check.hpp"
#include "overlap.hpp"

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
