// Access to the parts of an image (image_layout.hpp) for the evaluation of every family. Like all files that image.hpp
// includes, this file uses no header and no function of a C++ library.
#pragma once

#include <phynness/phynness_image.h>

#include <phynness/image_layout.hpp>

#include "core/lookup.hpp"

namespace PHN_RUNTIME {

template <class Real>
using ImageHeader = image::Header<Real>;

template <class T, class Real>
const T* at(const ImageHeader<Real>& image, uint32_t offset) {
  return reinterpret_cast<const T*>(reinterpret_cast<const unsigned char*>(&image) + offset);
}
template <class T, class Real>
const T* at(const ImageHeader<Real>& image, image::Table table) {
  return at<T>(image, table.at);
}

template <class Real>
void clear(Real* out, size_t n) {
  for (size_t i = 0; i < n; ++i) out[i] = 0;
}

/// Clamps d. @return whether d was not changed
template <class Real>
bool cut_displacement(const ImageHeader<Real>& image, const Real* d, Real* at) {
  const Real largest = static_cast<Real>(image::largest_displacement) * image.max_displacement;
  bool whole = true;
  for (int k = 0; k < 3; ++k) {
    at[k] = cut(d[k], largest);
    whole = whole && at[k] == d[k];
  }
  return whole;
}

template <class Real>
const image::ActiveNode<Real>* find_active(const ImageHeader<Real>& image, int32_t node) {
  const int32_t found =
      find_sorted(at<int32_t>(image, image.active_nodes), static_cast<int32_t>(image.active_nodes.n), node);
  return found < 0 ? nullptr : at<image::ActiveNode<Real>>(image, image.active) + found;
}

/// @param d  clamped
template <class Real>
Real trained_depth(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, const Real* d) {
  return depth_along(at<Real>(image, image.directions), at<Real>(image, node.trained_depth),
                     static_cast<int32_t>(node.trained_depth.n), d, square_root(dot(d, d)), image.max_displacement);
}

/// d / max_displacement. @param d  clamped
template <class Real>
void scale_displacement(const ImageHeader<Real>& image, const Real* d, Real* x) {
  for (int k = 0; k < 3; ++k) x[k] = cut(d[k] / image.max_displacement, static_cast<Real>(image::largest_displacement));
}

}  // namespace PHN_RUNTIME
