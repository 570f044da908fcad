// phynness for C++17: the functions of phynness_surface.h as members of a class, in the manner of phynness.hpp.
#ifndef PHYNNESS_SURFACE_HPP
#define PHYNNESS_SURFACE_HPP

#include <phynness/phynness_surface.h>
#include <phynness/phynness.hpp>

namespace phynness::rt {

/// The subdivided surface. It is constant and does not use its model after construction.
class Surface : public detail::Built<const phn_surface, detail::FieldSize> {
 public:
  Surface() = default;
  Surface(const Model& model, std::int32_t levels, Span<std::byte> own = {}) {
    more().n_field = 3 * static_cast<std::size_t>(model.n_output());
    build(model.get(), levels, own, phn_surface_size, phn_surface_init);
  }
  static std::size_t bytes_for(const Model& model, std::int32_t levels) noexcept {
    return bytes_of(phn_surface_size, model.get(), levels);
  }

  std::int32_t n_vertices() const noexcept { return contents().n_vertices; }
  Span<const std::int32_t> triangles() const noexcept {
    return {contents().triangles, 3 * static_cast<std::size_t>(contents().n_triangles)};
  }
  Span<const float> points() const noexcept { return {contents().points, n_numbers()}; }
  /// Number of floats of working memory for deform.
  std::size_t n_scratch() const noexcept { return contents().scratch_bytes / sizeof(float); }

  /// @param scratch  n_scratch() floats, one array for each thread
  /// @param field    n_output x 3 [m]
  /// @param out      n_vertices x 3 [m]
  Status deform(Span<float> scratch, Span<const double> field, Span<float> out) const noexcept {
    if (scratch.size() < n_scratch() || field.size() < more().n_field || out.size() < n_numbers())
      return PHN_ERROR_BUFFER;
    return phn_surface_deform(get(), scratch.data(), field.data(), out.data());
  }

 private:
  phn_surface_contents contents() const noexcept {
    phn_surface_contents contents;
    phn_surface_info(get(), &contents);
    return contents;
  }
  std::size_t n_numbers() const noexcept { return 3 * static_cast<std::size_t>(n_vertices()); }
};

}  // namespace phynness::rt

#endif
