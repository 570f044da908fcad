// Time-critical loops of training, compiled for several instruction sets and selected at load time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace phynness::kernels {

/// Columns per sweep: enough to hide the latency of the sums and to reduce the number of reads of h.
inline constexpr int block = 4;

/// sums[j] = q_j . h for `block` columns q_j = q + j * stride of length n.
void dot_block(const double* q, std::size_t stride, const double* h, std::size_t n, double* sums);
/// h -= sum_j c[j] q_j.
void subtract_block(const double* q, std::size_t stride, const double* c, double* h, std::size_t n);
/// sums[k] = q . r_k for the three residual columns r_k = r + k * stride.
void dot_residuals(const double* q, const double* r, std::size_t stride, std::size_t n, double* sums);
/// r_k -= c[k] q, error[p] = sum_k r_k[p]^2; returns the sum of error.
double update_residuals(const double* q, const double* c, double* r, std::size_t stride, double* error, std::size_t n);
/// h[p] = a[first[p]] * b[second[p]].
void product_column(const double* a, const std::int32_t* first, const double* b, const std::int32_t* second, double* h,
                    std::size_t n);

}  // namespace phynness::kernels
