// Deformation from an image: straight loops over tables where they lie.
#pragma once

#include "image.hpp"

namespace PHN_RUNTIME {

// Whether a response has a deformation: models without modes have forces only.
template <class Real>
bool has_deformation(const image::RbfnResponse<Real>&) {
  return true;
}
template <class Real>
bool has_deformation(const image::LinearResponse<Real>&) {
  return true;
}
template <class Real>
bool has_deformation(const image::ModalResponse<Real>& modal) {
  return modal.weights.scale.n > 0;
}
template <class Real>
bool image_has_deformation(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node) {
  return image.output_nodes.n > 0 &&
         with_response(image, node, [](const auto& response) { return has_deformation(response); });
}

/// @param factor  scratch, one per neuron: what the displacement makes of it
template <class Real>
void network_field(const ImageHeader<Real>& image, const image::Network<Real, 6>& net, const Real* d, Real* factor,
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

/// out = table times vector, row by row. @param scaled  the vector times the columns' factors
template <class Real>
void multiply_rows(const int16_t* entry, uint32_t n_rows, uint32_t n_columns, const Real* scaled, Real* out) {
  for (uint32_t r = 0; r < n_rows; ++r, entry += n_columns) {
    Real sum = 0;
    for (uint32_t j = 0; j < n_columns; ++j) sum += static_cast<Real>(entry[j]) * scaled[j];
    out[r] = sum;
  }
}

template <class Real>
void scale_columns(const ImageHeader<Real>& image, const image::ScaledTable& table, const Real* value, Real* scaled) {
  const Real* scale = at<Real>(image, table.scale);
  for (uint32_t j = 0; j < table.scale.n; ++j) scaled[j] = scale[j] * value[j];
}

/// @param scratch  n_amplitude_centers + 3, then n_shared, then twice n_modes
template <class Real>
void response_field(const ImageHeader<Real>& image, const image::ModalResponse<Real>& node, const Real* d, Real* scratch,
                    Real* field) {
  const uint32_t n_centers = image.amplitude_center.n, n_shared = image.modes.scale.n, m = node.weights.scale.n;
  Real *basis = scratch, *amount = basis + n_centers + 3, *amplitude = amount + n_shared, *scaled = amplitude + m;
  Real x[3];
  scale_displacement(image, d, x);
  const Real s2 = image.amplitude_shape * image.amplitude_shape, q = square_root(dot(x, x) + s2);
  const auto* row = at<uint16_t>(image, image.amplitude_center);
  const Real *rows = at<Real>(image, image.displacements), *at_rest = at<Real>(image, image.amplitude_at_rest);
  for (uint32_t i = 0; i < n_centers; ++i) {
    const Real* c = rows + 3 * static_cast<size_t>(row[i]);
    const Real y[3] = {x[0] - c[0], x[1] - c[1], x[2] - c[2]};
    basis[i] = (square_root(dot(y, y) + s2) - q) - at_rest[i];
  }
  for (int k = 0; k < 3; ++k) basis[n_centers + static_cast<uint32_t>(k)] = x[k];
  clear(amplitude, m);
  const auto* weight = at<int16_t>(image, node.weights.entry);
  for (uint32_t r = 0; r < n_centers + 3; ++r, weight += m) {
    for (uint32_t j = 0; j < m; ++j) amplitude[j] += basis[r] * static_cast<Real>(weight[j]);
  }
  scale_columns(image, node.weights, amplitude, amplitude);
  scale_columns(image, node.mixing, amplitude, scaled);
  multiply_rows(at<int16_t>(image, node.mixing.entry), n_shared, m, scaled, amount);
  scale_columns(image, image.modes, amount, amount);
  multiply_rows(at<int16_t>(image, image.modes.entry), 3 * image.output_nodes.n, n_shared, amount, field);
  scale_columns(image, node.near_modes, amplitude, scaled);
  const auto* near = at<uint16_t>(image, node.near);
  const auto* mode = at<int16_t>(image, node.near_modes.entry);
  for (uint32_t i = 0; i < node.near.n; ++i, mode += 3 * static_cast<size_t>(m))
    multiply_rows(mode, 3, m, scaled, field + 3 * static_cast<size_t>(near[i]));
}

template <class Real>
void response_field(const ImageHeader<Real>& image, const image::LinearResponse<Real>& linear, const Real* d, Real*,
                    Real* field) {
  const Real* unit = at<Real>(image, linear.unit_responses);
  for (uint32_t o = 0; o < image.output_nodes.n; ++o, unit += 9, field += 3) {
    for (int k = 0; k < 3; ++k) field[k] = d[0] * unit[k] + d[1] * unit[3 + k] + d[2] * unit[6 + k];
  }
}

template <class Real>
void response_field(const ImageHeader<Real>& image, const image::RbfnResponse<Real>& rbfn, const Real* d, Real* scratch,
                    Real* field) {
  network_field(image, rbfn.deformation, d, scratch, field);
}

/// @param d  cut. @pre image_has_deformation(image, node)
template <class Real>
void image_field_at(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, const Real* d, Real* scratch,
                    Real* field) {
  with_response(image, node,
                [&](const auto& response) { response_field(image, response, d, scratch, field); });
  const auto* moved = at<uint16_t>(image, node.prescribed);
  const Real* weight = at<Real>(image, node.prescribed_weight);
  for (uint32_t p = 0; p < node.prescribed.n; ++p) {
    for (uint32_t k = 0; k < 3; ++k) field[3 * moved[p] + k] = weight[p] * d[k];
  }
}

}  // namespace PHN_RUNTIME
