// phn_image_open.
#include "image/check.hpp"

using namespace PHN_RUNTIME;

extern "C" int phn_image_open(const void* memory, size_t bytes, const phn_image** image) {
  if (image == nullptr) return PHN_ERROR_ARGUMENT;
  const ImageHeader<phn_real>* opened = nullptr;
  const int status =
      overlap(memory, bytes, image, sizeof *image) ? PHN_ERROR_OVERLAP : open_image(memory, bytes, opened);
  *image = reinterpret_cast<const phn_image*>(opened);
  return status;
}

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
