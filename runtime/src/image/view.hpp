// Access to the parts of an image (image_layout.hpp) for the evaluation of every family. Like all files that image.hpp
// includes, this file uses no header and no function of a C++ library.
#pragma once

#include <phynness/phynness_image.h>

#include <phynness/image_layout.hpp>

#include "core/lookup.hpp"

// The host links the code for both kinds of numbers.
#ifdef PHYNNESS_IMAGE_FLOAT
#define PHN_IMAGES phynness::images_of_floats
#else
#define PHN_IMAGES phynness::images_of_doubles
#endif

namespace PHN_IMAGES {

using namespace PHN_RUNTIME;
using Real = phn_real;
using Header = image::Header<Real>;
using ActiveNode = image::ActiveNode<Real>;
using RbfnResponse = image::RbfnResponse<Real>;
using LinearResponse = image::LinearResponse<Real>;
using ModalResponse = image::ModalResponse<Real>;

template <class T>
const T* at(const Header& image, uint32_t offset) {
  return reinterpret_cast<const T*>(reinterpret_cast<const unsigned char*>(&image) + offset);
}
template <class T>
const T* at(const Header& image, image::Table table) {
  return at<T>(image, table.at);
}

inline void clear(Real* out, size_t n) {
  for (size_t i = 0; i < n; ++i) out[i] = 0;
}

/// d / max_displacement. @param d  clamped
inline void scale_displacement(const Header& image, const Real* d, Real* x) {
  for (int k = 0; k < 3; ++k) x[k] = clamp(d[k] / image.max_displacement, Real(image::largest_displacement));
}

}  // namespace PHN_IMAGES
