#include <cstring>

#include "body/body.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {
namespace {

PHN_INLINE void sum_lanes(double (&sum)[block_size], double& total) {
  double many[1][block_size];
  for (std::int32_t i = 0; i < block_size; ++i) many[0][i] = sum[i];
  add_up_many(many, &total);
}

/// The product a . x of a row.
template <class X>
PHN_INLINE double row_times(const float* a, const X* x, std::int32_t n_whole) {
  double sum[block_size] = {}, total;
  for (std::int32_t m = 0; m < n_whole; m += block_size)
    for (std::int32_t i = 0; i < block_size; ++i)
      sum[i] += static_cast<double>(a[m + i]) * static_cast<double>(x[m + i]);
  sum_lanes(sum, total);
  return total;
}

PHN_INLINE void multiply_rows(const float* rows, std::int64_t n, std::int32_t stride, const double* x, double* out) {
  for (std::int64_t r = 0; r < n; ++r) out[r] = row_times(rows + r * stride, x, stride);
}

PHN_INLINE void add_rows(const float* rows, std::int64_t n, std::int32_t stride, const double* factor, double* out) {
  constexpr int several = 4;  // `out` is read and written less often with several rows at a time.
  std::int64_t r = 0;
  for (; r + several <= n; r += several) {
    const float *a = rows + r * stride, *b = a + stride, *c = b + stride, *d = c + stride;
    const double fa = factor[r], fb = factor[r + 1], fc = factor[r + 2], fd = factor[r + 3];
    for (std::int32_t m = 0; m < stride; ++m) out[m] += (fa * a[m] + fb * b[m]) + (fc * c[m] + fd * d[m]);
  }
  for (; r < n; ++r)
    for (std::int32_t m = 0; m < stride; ++m) out[m] += factor[r] * rows[r * stride + m];
}

/// A few floats; GCC 12 keeps arrays of them in registers, but not arrays of floats.
#ifdef __GNUC__
template <int bytes>
struct LanesOf {
  typedef float type __attribute__((vector_size(bytes)));
};
#else
template <int bytes>
struct LanesOf {
  struct type {
    float at[bytes / sizeof(float)];
    type& operator+=(const type& b) {
      for (std::size_t i = 0; i < bytes / sizeof(float); ++i) at[i] += b.at[i];
      return *this;
    }
    friend type operator*(float a, type b) {
      for (float& x : b.at) x *= a;
      return b;
    }
  };
};
#endif

/// out += sign A^T B: the rows from `first` to `end`. A tile of 4 x 2 registers stays in registers.
/// @tparam upper  only the columns from the diagonal on, in blocks
template <int bytes, int sign, bool upper>
PHN_INLINE void add_products_of(const float* a, std::int32_t a_stride, const float* b, std::int64_t n,
                                std::int32_t first, std::int32_t end, std::int32_t stride, float* out) {
  using Lanes = typename LanesOf<bytes>::type;
  constexpr std::int32_t height = 4, width = sizeof(Lanes) / sizeof(float), wide = block_size / width > 1 ? 2 : 1;
  for (std::int32_t i = first; i < end; i += height)
    for (std::int32_t j = upper ? i / (wide * width) * (wide * width) : 0; j < stride; j += wide * width) {
      Lanes tile[height][wide] = {}, right;
      for (std::int64_t r = 0; r < n; ++r) {
        const float* left = a + r * a_stride + i;
        for (std::int32_t l = 0; l < wide; ++l) {
          memcpy(&right, b + r * stride + j + l * width, sizeof right);
          for (std::int32_t k = 0; k < height; ++k) tile[k][l] += left[k] * right;
        }
      }
      for (std::int32_t k = 0; k < height; ++k)
        for (std::int32_t l = 0; l < wide; ++l) {
          float* to = out + (i + k) * stride + j + l * width;
          memcpy(&right, to, sizeof right);
          right += static_cast<float>(sign) * tile[k][l];
          memcpy(to, &right, sizeof right);
        }
    }
}

/// out = sum_k factor[k] rows[k], of the nine rows of a cell
template <int bytes>
PHN_INLINE void combine_nine_rows(const float* rows, std::int32_t stride, const float* factor, float* out) {
  using Lanes = typename LanesOf<bytes>::type;
  constexpr std::int32_t width = sizeof(Lanes) / sizeof(float);
  for (std::int32_t m = 0; m < stride; m += width) {
    Lanes sum = {}, row;
    for (std::int32_t k = 0; k < 9; ++k) {
      memcpy(&row, rows + k * stride + m, sizeof row);
      sum += factor[k] * row;
    }
    memcpy(out + m, &sum, sizeof sum);
  }
}

/// Smaller pivots, over the diagonal, are mostly rounding errors, which would spoil the softest direction.
constexpr float least_pivot = 1e-4f;

/// Computes a block of rows of the factor, then subtracts its products from the rows below.
template <int bytes>
PHN_INLINE bool factorize_rows(float* a, std::int32_t n, std::int32_t stride) {
  float diagonal[schema::most_body_modes];
  for (std::int32_t i = 0; i < n; ++i) diagonal[i] = a[static_cast<std::int64_t>(i) * (stride + 1)];
  for (std::int32_t first = 0; first < n; first += block_size) {
    float* block = a + static_cast<std::int64_t>(first) * stride;
    const std::int32_t height = n - first < block_size ? n - first : block_size;
    for (std::int32_t i = 0; i < height; ++i) {
      float* row = block + i * stride;
      for (std::int32_t k = 0; k < i; ++k) {
        const float *above = block + k * stride, factor = above[first + i];
        for (std::int32_t m = first; m < stride; ++m) row[m] -= factor * above[m];
      }
      const float pivot = row[first + i];
      if (!(pivot > least_pivot * diagonal[first + i])) return false;
      const float inverse = 1 / square_root(pivot);
      for (std::int32_t m = first; m < stride; ++m) row[m] *= inverse;
      row[first + i] = inverse;
    }
    add_products_of<bytes, -1, true>(block, stride, block, height, first + block_size, stride, stride, a);
  }
  return true;
}

PHN_INLINE void solve_rows(const float* factor, std::int32_t n, std::int32_t stride, double* x) {
  for (std::int32_t i = 0; i < n; ++i) {
    const float* row = factor + static_cast<std::int64_t>(i) * stride;
    const double value = x[i] *= row[i];
    for (std::int32_t m = i + 1; m < n; ++m) x[m] -= value * row[m];
  }
  for (std::int32_t i = n - 1; i >= 0; --i) {
    const float* row = factor + static_cast<std::int64_t>(i) * stride;
    const std::int32_t whole = whole_blocks(i + 1);
    double sum = row_times(row + whole, x + whole, stride - whole);
    for (std::int32_t m = i + 1; m < n && m < whole; ++m) sum += row[m] * x[m];
    x[i] = (x[i] - sum) * row[i];
  }
}

#define PHN_BODY_KERNELS(name, bytes, attributes)                                                                  \
  namespace name {                                                                                                 \
  attributes void multiply_vector(const RowMatrix& a, const double* x, double* out) {                              \
    multiply_rows(a.data, a.n_rows, a.stride, x, out);                                                             \
  }                                                                                                                \
  attributes void add_transposed_product(const RowMatrix& a, const double* x, double* out) {                       \
    add_rows(a.data, a.n_rows, a.stride, x, out);                                                                  \
  }                                                                                                                \
  attributes void add_symmetric_product(const RowMatrix& a, const RowMatrix& b, float* out) {                      \
    add_products_of<bytes ? bytes : 16, 1, true>(a.data, a.stride, b.data, a.n_rows, 0, a.stride, b.stride, out);  \
  }                                                                                                                \
  attributes void add_product(const RowMatrix& a, const RowMatrix& b, float* out) {                                \
    add_products_of<bytes ? bytes : 16, 1, false>(a.data, a.stride, b.data, a.n_rows, 0, a.stride, b.stride, out); \
  }                                                                                                                \
  attributes void combine_rows(const float* rows, std::int32_t stride, const float* factor, float* out) {          \
    combine_nine_rows<bytes ? bytes : 16>(rows, stride, factor, out);                                              \
  }                                                                                                                \
  attributes bool factorize(float* a, std::int32_t n, std::int32_t stride) {                                       \
    return factorize_rows < bytes ? bytes : 16 > (a, n, stride);                                                   \
  }                                                                                                                \
  attributes void solve(const float* factor, std::int32_t n, std::int32_t stride, double* x) {                     \
    solve_rows(factor, n, stride, x);                                                                              \
  }                                                                                                                \
  constexpr BodyKernels kernels = {                                                                                \
      #name, multiply_vector, add_transposed_product, add_symmetric_product, add_product, combine_rows, factorize, \
      solve};                                                                                                      \
  }

PHN_FOR_EACH_SET(PHN_BODY_KERNELS, BodyKernels)

}  // namespace

const BodyKernels* body_kernels(int set) { return kernels_for(kernels_of_sets, set); }
const BodyKernels& best_body_kernels() { return best_of(kernels_of_sets); }

}  // namespace PHN_RUNTIME
