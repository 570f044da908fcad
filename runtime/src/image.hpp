// Evaluation of images (image_layout.hpp): no header of a C++ library, no function of anybody else's.
#pragma once

#include <phynness/phynness_image.h>

#include <phynness/image_layout.hpp>

#include "conservative.hpp"
#include "lookup.hpp"

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

/// What depends on the number: 2^-t for 0 <= t.
template <class Real>
struct Arithmetic;
template <>
struct Arithmetic<float> {
  using Bits = uint32_t;
  static constexpr int n_terms = 8, mantissa_bits = 23, bias = 127;
  static constexpr float largest_exponent = 126;
};
template <>
struct Arithmetic<double> {
  using Bits = uint64_t;
  static constexpr int n_terms = 14, mantissa_bits = 52, bias = 1023;
  static constexpr double largest_exponent = 1022;
};

/// 2^-t, relative error some 1e-7 (float) or 3e-16 (double): t is cut where the result would leave normal numbers.
template <class Real>
Real power_of_half(Real t) {
  using A = Arithmetic<Real>;
  t = t < A::largest_exponent ? t : A::largest_exponent;
  const auto whole = static_cast<int32_t>(t + Real(0.5));
  const Real z = (static_cast<Real>(whole) - t) * Real(0.693147180559945309417);  // 2^-t = 2^-whole e^z, |z| < 0.35
  constexpr double factorial[14] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800, 479001600,
                                    6227020800.};
  Real sum = static_cast<Real>(1 / factorial[A::n_terms - 1]);
#ifdef __GNUC__
#pragma GCC unroll 16
#endif
  for (int k = A::n_terms - 2; k >= 0; --k) sum = sum * z + static_cast<Real>(1 / factorial[k]);
  const auto bits = static_cast<typename A::Bits>(A::bias - whole) << A::mantissa_bits;
  Real scale;
  __builtin_memcpy(&scale, &bits, sizeof scale);
  return sum * scale;
}

template <class Real>
void clear(Real* out, size_t n) {
  for (size_t i = 0; i < n; ++i) out[i] = 0;
}

/// d cut. @return whether nothing was cut
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

/// @param d  cut
template <class Real>
Real trained_depth(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, const Real* d) {
  return depth_along(at<Real>(image, image.directions), at<Real>(image, node.trained_depth),
                     static_cast<int32_t>(node.trained_depth.n), d);
}

// Traits of a family (phynness/schema/family.hpp) without a table: position-independent code finds one by way of an offset
// table in memory, which a device without an operating system does not set up.
constexpr bool is_proportional(Family family) { return family == Family::linear; }
constexpr bool has_energy(Family family) { return family != Family::rbfn; }
constexpr bool has_modes(Family family) { return family == Family::modal; }
constexpr bool agrees_with_schema(Family family) {
  return is_proportional(family) == schema::traits(family).proportional &&
         has_energy(family) == schema::traits(family).has_energy &&
         has_modes(family) == schema::traits(family).has_modes;
}
static_assert(agrees_with_schema(Family::rbfn) && agrees_with_schema(Family::linear) &&
              agrees_with_schema(Family::modal));

/// @param d  cut, unless `whole` is false
template <class Real>
int image_warnings(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, bool whole, const Real* d) {
  const bool outside =
      !whole || (!is_proportional(image.family) &&
                 square_root(dot(d, d)) > depth_slack<Real> * trained_depth(image, node, d));
  return (outside ? PHN_WARNING_OUTSIDE : 0) | (node.incomplete ? PHN_WARNING_INCOMPLETE : 0);
}

template <class Real>
void network_force(const ImageHeader<Real>& image, const image::Network<Real, 3>& net, const Real* d, Real* force) {
  const Real d0 = d[0], d1 = d[1], d2 = d[2], f0 = net.factor[0], f1 = net.factor[1], f2 = net.factor[2];
  const Real* rows = at<Real>(image, image.displacements);
  const auto* row = at<uint16_t>(image, net.displacement);
  const Real* w = at<Real>(image, net.weight);
  Real s0 = net.constant[0], s1 = net.constant[1], s2 = net.constant[2];
  for (const auto* end = row + net.displacement.n; row != end; ++row, w += 3) {
    const Real* c = rows + 3 * static_cast<size_t>(*row);
    const Real y0 = f0 * (d0 - c[0]), y1 = f1 * (d1 - c[1]), y2 = f2 * (d2 - c[2]);
    const Real h = power_of_half(y0 * y0 + y1 * y1 + y2 * y2);
    s0 += w[0] * h;
    s1 += w[1] * h;
    s2 += w[2] * h;
  }
  force[0] = s0;
  force[1] = s1;
  force[2] = s2;
}

/// Family modal: a response with its header, as the functions of conservative.hpp want it.
template <class Real>
struct ImageForce {
  const ImageHeader<Real>& image;
  const image::ModalResponse<Real>& node;
  Real max_displacement, shape;
  const Real *stiffness, *force_at_rest;
  Real energy_at_rest;
};

template <class Real, class Add>
void for_each_center(const ImageForce<Real>& net, const Real* x, Add add) {
  const Real* rows = at<Real>(net.image, net.image.displacements);
  const auto* row = at<uint16_t>(net.image, net.node.center);
  const Real* b = at<Real>(net.image, net.node.coefficient);
  for (const auto* end = row + net.node.center.n; row != end; ++row, b += 3) {
    const Real* c = rows + 3 * static_cast<size_t>(*row);
    const Real y[3] = {x[0] - c[0], x[1] - c[1], x[2] - c[2]};
    add(y, b);
  }
  const Real weight[3] = {-net.node.total[0], -net.node.total[1], -net.node.total[2]};
  add(x, weight);
}

template <class Real>
ImageForce<Real> image_force(const ImageHeader<Real>& image, const image::ModalResponse<Real>& node) {
  return {image, node, image.max_displacement, node.shape, node.stiffness, node.force_at_rest, node.energy_at_rest};
}

/// d over max_displacement. @param d  cut
template <class Real>
void scale_displacement(const ImageHeader<Real>& image, const Real* d, Real* x) {
  for (int k = 0; k < 3; ++k)
    x[k] = cut(d[k] / image.max_displacement, static_cast<Real>(image::largest_displacement));
}

// Answers of a response, by family. @param d  cut
template <class Real>
void response_force(const ImageHeader<Real>& image, const image::RbfnResponse<Real>& rbfn, const Real* d, Real* force) {
  network_force(image, rbfn.force, d, force);
}
template <class Real>
void response_force(const ImageHeader<Real>&, const image::LinearResponse<Real>& linear, const Real* d, Real* force) {
  multiply_symmetric(linear.stiffness, d, force);
}
template <class Real>
void response_force(const ImageHeader<Real>& image, const image::ModalResponse<Real>& modal, const Real* d,
                    Real* force) {
  Real x[3];
  scale_displacement(image, d, x);
  conservative_force(image_force(image, modal), x, force);
}

/// The family has none.
template <class Real>
Real response_energy(const ImageHeader<Real>&, const image::RbfnResponse<Real>&, const Real*) {
  return 0;
}
template <class Real>
Real response_energy(const ImageHeader<Real>&, const image::LinearResponse<Real>& linear, const Real* d) {
  Real force[3];
  multiply_symmetric(linear.stiffness, d, force);
  return dot(d, force) / 2;
}
template <class Real>
Real response_energy(const ImageHeader<Real>& image, const image::ModalResponse<Real>& modal, const Real* d) {
  Real x[3];
  scale_displacement(image, d, x);
  return conservative_energy(image_force(image, modal), x);
}

/// The family has none.
template <class Real>
void response_stiffness(const ImageHeader<Real>&, const image::RbfnResponse<Real>&, const Real*, Real*) {}
template <class Real>
void response_stiffness(const ImageHeader<Real>&, const image::LinearResponse<Real>& linear, const Real*,
                        Real* stiffness) {
  const Real* k = linear.stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) stiffness[3 * i + j] = stiffness[3 * j + i] = *k++;
  }
}
template <class Real>
void response_stiffness(const ImageHeader<Real>& image, const image::ModalResponse<Real>& modal, const Real* d,
                        Real* stiffness) {
  Real x[3];
  scale_displacement(image, d, x);
  conservative_stiffness(image_force(image, modal), x, stiffness);
}

/// f(null pointer to the type of a response); the one place that tells the families of images apart.
template <class Real, class Function>
auto with_response_type(Family family, Function&& f) {
  switch (family) {
    case Family::rbfn:
      return f(static_cast<const image::RbfnResponse<Real>*>(nullptr));
    case Family::linear:
      return f(static_cast<const image::LinearResponse<Real>*>(nullptr));
    case Family::modal:
      break;
  }
  return f(static_cast<const image::ModalResponse<Real>*>(nullptr));
}

template <class Real, class Response>
const Response& response_at(const ImageHeader<Real>& image, uint32_t offset, const Response*) {
  return *at<Response>(image, offset);
}

/// f(response of the node). @pre the image was checked
template <class Real, class Function>
auto with_response(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, Function&& f) {
  return with_response_type<Real>(image.family,
                                  [&](const auto* type) { return f(response_at(image, node.response, type)); });
}

}  // namespace PHN_RUNTIME
