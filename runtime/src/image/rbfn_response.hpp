// Responses of family rbfn in an image: networks of Gaussians.
#pragma once

#include "core/rbfn/exponential.hpp"
#include "image/view.hpp"

namespace PHN_IMAGES {

inline void network_force(const Header& image, const image::Network<Real, 3>& net, const Real* d, Real* force) {
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

/// @param factor  working memory, one number per neuron: its factor that depends on the displacement
inline void network_field(const Header& image, const image::Network<Real, 6>& net, const Real* d, Real* factor,
                          Real* field) {
  const uint32_t n = net.displacement.n;
  const auto* row = at<uint16_t>(image, net.displacement);
  const auto* output = at<uint16_t>(image, net.output);
  const Real *rows = at<Real>(image, image.displacements), *points = at<Real>(image, image.output_points);
  for (uint32_t i = 0; i < n; ++i) {
    const Real* c = rows + 3 * static_cast<size_t>(row[i]);
    Real square = 0;
    for (int k = 0; k < 3; ++k) {
      const Real y = net.factor[k] * (d[k] - c[k]);
      square += y * y;
    }
    factor[i] = power_of_half(square);
  }
  const Real* point = points;
  for (uint32_t o = 0; o < image.output_nodes.n; ++o, point += 3, field += 3) {
    Real sum[3] = {net.constant[0], net.constant[1], net.constant[2]};
    const Real* w = at<Real>(image, net.weight);
    for (uint32_t i = 0; i < n; ++i, w += 3) {
      const Real* c = points + 3 * static_cast<size_t>(output[i]);
      Real square = 0;
      for (int k = 0; k < 3; ++k) {
        const Real y = net.factor[3 + k] * (point[k] - c[k]);
        square += y * y;
      }
      const Real h = factor[i] * power_of_half(square);
      for (int k = 0; k < 3; ++k) sum[k] += w[k] * h;
    }
    for (int k = 0; k < 3; ++k) field[k] = sum[k];
  }
}

/// @param d  clamped, also in the functions below
inline void response_force(const Header& image, const RbfnResponse& rbfn, const Real* d, Real* force) {
  network_force(image, rbfn.force, d, force);
}

/// Family rbfn has no energy.
inline Real response_energy(const Header&, const RbfnResponse&, const Real*) { return 0; }

/// Family rbfn has no stiffness.
inline void response_stiffness(const Header&, const RbfnResponse&, const Real*, Real*) {}

/// @param scratch  one number per neuron
inline bool response_field(const Header& image, const RbfnResponse& rbfn, const Real* d, Real* scratch, Real* field) {
  network_field(image, rbfn.deformation, d, scratch, field);
  return true;
}

}  // namespace PHN_IMAGES
