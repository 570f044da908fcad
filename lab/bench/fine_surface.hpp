// The surface of a model, subdivided by the runtime (phynness_surface.h), in memory of its own.
#pragma once

#include <phynness/phynness_surface.h>

#include <cstddef>
#include <span>
#include <vector>

namespace phynness {

class FineSurface {
 public:
  /// @param levels  0 ... 6
  FineSurface(const phn_model* model, int levels) {
    std::size_t bytes = 0;
    _status = phn_surface_size(model, levels, &bytes);
    if (_status < 0) return;
    _memory.resize(bytes);
    _status = phn_surface_init(_memory.data(), bytes, model, levels, &_surface);
    phn_surface_info(_surface, &_info);
    _scratch.resize(_info.scratch_bytes / sizeof(float));
    displacements.resize(points().size());
  }
  /// Of the construction: below 0 there is no surface.
  int status() const { return _status; }
  std::int32_t n_vertices() const { return _info.n_vertices; }
  std::int32_t n_triangles() const { return _info.n_triangles; }
  /// n_triangles x 3
  const std::int32_t* triangles() const { return _info.triangles; }
  /// n_vertices x 3 [m], undeformed
  std::span<const float> points() const { return {_info.points, 3 * static_cast<std::size_t>(n_vertices())}; }
  /// Sets displacements. @param field  n_output x 3 [m]. @return a status
  int deform(const double* field) { return phn_surface_deform(_surface, _scratch.data(), field, displacements.data()); }

  std::vector<float> displacements;  ///< n_vertices x 3 [m]

 private:
  std::vector<std::byte> _memory;
  std::vector<float> _scratch;
  const phn_surface* _surface = nullptr;
  phn_surface_contents _info{};
  int _status = PHN_OK;
};

}  // namespace phynness
