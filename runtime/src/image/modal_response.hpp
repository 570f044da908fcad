// Responses of family modal in an image.
#pragma once

#include "image/view.hpp"

namespace PHN_IMAGES {

/// Force, energy and stiffness are derivatives of one potential (ModalForce in core/model.hpp): sums over the same
/// centers. Calls add(x - c, b) for every center, including the one at 0.
template <class Add>
void for_each_center(const Header& image, const ModalResponse& node, const Real* x, Add add) {
  const Real* rows = at<Real>(image, image.displacements);
  const auto* row = at<uint16_t>(image, node.center);
  const Real* b = at<Real>(image, node.coefficient);
  for (const auto* end = row + node.center.n; row != end; ++row, b += 3) {
    const Real* c = rows + 3 * static_cast<size_t>(*row);
    const Real y[3] = {x[0] - c[0], x[1] - c[1], x[2] - c[2]};
    add(y, b);
  }
  const Real weight[3] = {-node.total[0], -node.total[1], -node.total[2]};
  add(x, weight);
}

/// K R x
inline void linear_force(const Header& image, const ModalResponse& node, const Real* x, Real* d, Real* force) {
  for (int k = 0; k < 3; ++k) d[k] = image.max_displacement * x[k];
  multiply_symmetric(node.stiffness, d, force);
}

/// @param d  clamped, also in the functions below
inline void response_force(const Header& image, const ModalResponse& node, const Real* d, Real* force) {
  Real x[3], scaled[3], sum[3] = {0, 0, 0};
  scale_displacement(image, d, x);
  const Real s2 = node.shape * node.shape;
  for_each_center(image, node, x, [&](const Real* y, const Real* b) {
    const Real q = square_root(dot(y, y) + s2), along = dot(y, b) / q;
    for (int k = 0; k < 3; ++k) sum[k] += q * b[k] + along * y[k];
  });
  linear_force(image, node, x, scaled, force);
  for (int k = 0; k < 3; ++k) force[k] += sum[k] + node.force_at_rest[k];
}

inline Real response_energy(const Header& image, const ModalResponse& node, const Real* d) {
  Real x[3], scaled[3], force[3], sum = 0;
  scale_displacement(image, d, x);
  const Real s2 = node.shape * node.shape;
  for_each_center(image, node, x,
                  [&](const Real* y, const Real* b) { sum += square_root(dot(y, y) + s2) * dot(y, b); });
  linear_force(image, node, x, scaled, force);
  const Real* rest = node.force_at_rest;
  return dot(scaled, force) / 2 + image.max_displacement * ((sum + node.energy_at_rest) + dot(rest, x));
}

inline void response_stiffness(const Header& image, const ModalResponse& node, const Real* d, Real* stiffness) {
  Real x[3], sum[6] = {};
  scale_displacement(image, d, x);
  const Real s2 = node.shape * node.shape;
  for_each_center(image, node, x, [&](const Real* y, const Real* b) {
    const Real q = square_root(dot(y, y) + s2), n[3] = {y[0] / q, y[1] / q, y[2] / q}, along = dot(n, b);
    Real* at = sum;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) *at++ += b[i] * n[j] + n[i] * b[j] + along * (Real(i == j) - n[i] * n[j]);
  });
  for (int i = 0; i < 6; ++i) sum[i] = node.stiffness[i] + sum[i] / image.max_displacement;
  fill_symmetric(sum, stiffness);
}

/// out = table times vector. @param scaled  the vector times the columns' factors
inline void multiply_rows(const int16_t* entry, uint32_t n_rows, uint32_t n_columns, const Real* scaled, Real* out) {
  for (uint32_t r = 0; r < n_rows; ++r, entry += n_columns) {
    Real sum = 0;
    for (uint32_t j = 0; j < n_columns; ++j) sum += Real(entry[j]) * scaled[j];
    out[r] = sum;
  }
}

inline void scale_columns(const Header& image, const image::ScaledTable& table, const Real* value, Real* scaled) {
  const Real* scale = at<Real>(image, table.scale);
  for (uint32_t j = 0; j < table.scale.n; ++j) scaled[j] = scale[j] * value[j];
}

/// @param scratch  n_amplitude_centers + 3, then n_shared, then twice n_modes
inline bool response_field(const Header& image, const ModalResponse& node, const Real* d, Real* scratch, Real* field) {
  const uint32_t n_centers = image.amplitude_center.n, n_shared = image.modes.scale.n, m = node.weights.scale.n;
  if (m == 0) return false;  // forces only
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
  for (uint32_t r = 0; r < n_centers + 3; ++r, weight += m)
    for (uint32_t j = 0; j < m; ++j) amplitude[j] += basis[r] * Real(weight[j]);
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
  return true;
}

}  // namespace PHN_IMAGES
