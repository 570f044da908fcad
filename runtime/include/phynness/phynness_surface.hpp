// phynness for C++17: the functions of phynness_surface.h as members of a class, in the manner of phynness.hpp.
#ifndef PHYNNESS_SURFACE_HPP
#define PHYNNESS_SURFACE_HPP

#include <phynness/phynness_surface.h>
#include <phynness/phynness.hpp>

namespace phynness::rt {
#ifdef PHYNNESS_FLOAT
inline namespace in_float {
#else
inline namespace in_double {
#endif

/// The subdivided surface. It is constant and does not use its model after construction.
class Surface {
 public:
  Surface() = default;
  Surface(const Model& model, std::int32_t levels, Span<std::byte> own = {})
      : _n_field(3 * static_cast<std::size_t>(model.n_output())) {
    std::size_t bytes = 0;
    _status = phn_surface_size(model.get(), levels, &bytes);
    if (!_status.ok()) return;
    void* place = _memory.place(own, bytes);
    _status = phn_surface_init(place, own.data() ? own.size() : bytes, model.get(), levels, &_surface);
  }
  Surface(Surface&& other) noexcept { swap(other); }
  Surface& operator=(Surface&& other) noexcept {
    Surface(std::move(other)).swap(*this);
    return *this;
  }
  static std::size_t bytes_for(const Model& model, std::int32_t levels) noexcept {
    std::size_t bytes = 0;
    return phn_surface_size(model.get(), levels, &bytes) == PHN_OK ? bytes : 0;
  }

  explicit operator bool() const noexcept { return _surface != nullptr; }
  Status status() const noexcept { return _status; }
  const phn_surface* get() const noexcept { return _surface; }
  std::int32_t n_vertices() const noexcept { return phn_surface_n_vertices(_surface); }
  Span<const std::int32_t> triangles() const noexcept {
    return {phn_surface_triangles(_surface), 3 * static_cast<std::size_t>(phn_surface_n_triangles(_surface))};
  }
  Span<const float> points() const noexcept { return {phn_surface_points(_surface), n_numbers()}; }
  /// Number of floats of working memory for deform.
  std::size_t n_scratch() const noexcept { return phn_surface_scratch_size(_surface) / sizeof(float); }

  /// @param scratch  n_scratch() floats, one array for each thread
  /// @param field    n_output x 3 [m]
  /// @param out      n_vertices x 3 [m]
  Status deform(Span<float> scratch, Span<const double> field, Span<float> out) const noexcept {
    if (scratch.size() < n_scratch() || field.size() < _n_field || out.size() < n_numbers()) return PHN_ERROR_BUFFER;
    return phn_surface_deform(_surface, scratch.data(), field.data(), out.data());
  }

 private:
  std::size_t n_numbers() const noexcept { return 3 * static_cast<std::size_t>(n_vertices()); }
  void swap(Surface& other) noexcept {
    std::swap(_memory, other._memory);
    std::swap(_surface, other._surface);
    std::swap(_n_field, other._n_field);
    std::swap(_status, other._status);
  }

  detail::Memory _memory;
  const phn_surface* _surface = nullptr;
  std::size_t _n_field = 0;
  Status _status = PHN_ERROR_ARGUMENT;
};

}  // inline namespace
}  // namespace phynness::rt

#endif
