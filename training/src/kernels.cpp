#include "kernels.hpp"

// `omp simd` allows the compiler to reorder these sums only; the OpenMP runtime is not used. The clones save a fifth of
// the training time. The order of the sums depends on the vector width, so that trained weights of different machines
// agree up to rounding; for different numbers of threads they are identical.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PHYNNESS_CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define PHYNNESS_CLONES
#endif

namespace phynness::kernels {

PHYNNESS_CLONES void dot_block(const double* q, std::size_t stride, const double* h, std::size_t n, double* sums) {
  const double *q0 = q, *q1 = q + stride, *q2 = q + 2 * stride, *q3 = q + 3 * stride;
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
#pragma omp simd reduction(+ : s0, s1, s2, s3)
  for (std::size_t p = 0; p < n; ++p) {
    s0 += q0[p] * h[p];
    s1 += q1[p] * h[p];
    s2 += q2[p] * h[p];
    s3 += q3[p] * h[p];
  }
  sums[0] = s0, sums[1] = s1, sums[2] = s2, sums[3] = s3;
}

PHYNNESS_CLONES void subtract_block(const double* q, std::size_t stride, const double* c, double* h, std::size_t n) {
  const double *q0 = q, *q1 = q + stride, *q2 = q + 2 * stride, *q3 = q + 3 * stride;
  const double c0 = c[0], c1 = c[1], c2 = c[2], c3 = c[3];
#pragma omp simd
  for (std::size_t p = 0; p < n; ++p) h[p] -= (c0 * q0[p] + c1 * q1[p]) + (c2 * q2[p] + c3 * q3[p]);
}

PHYNNESS_CLONES void dot_residuals(const double* q, const double* r, std::size_t stride, std::size_t n, double* sums) {
  const double *r0 = r, *r1 = r + stride, *r2 = r + 2 * stride;
  double s0 = 0, s1 = 0, s2 = 0;
#pragma omp simd reduction(+ : s0, s1, s2)
  for (std::size_t p = 0; p < n; ++p) {
    s0 += q[p] * r0[p];
    s1 += q[p] * r1[p];
    s2 += q[p] * r2[p];
  }
  sums[0] = s0, sums[1] = s1, sums[2] = s2;
}

PHYNNESS_CLONES double update_residuals(const double* q, const double* c, double* r, std::size_t stride, double* error,
                                        std::size_t n) {
  double *r0 = r, *r1 = r + stride, *r2 = r + 2 * stride;
  const double c0 = c[0], c1 = c[1], c2 = c[2];
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t p = 0; p < n; ++p) {
    const double e0 = r0[p] - c0 * q[p], e1 = r1[p] - c1 * q[p], e2 = r2[p] - c2 * q[p];
    r0[p] = e0, r1[p] = e1, r2[p] = e2;
    const double square = e0 * e0 + e1 * e1 + e2 * e2;
    error[p] = square;
    sum += square;
  }
  return sum;
}

PHYNNESS_CLONES void product_column(const double* a, const std::int32_t* first, const double* b,
                                    const std::int32_t* second, double* h, std::size_t n) {
#pragma omp simd
  for (std::size_t p = 0; p < n; ++p) h[p] = a[first[p]] * b[second[p]];
}

}  // namespace phynness::kernels
