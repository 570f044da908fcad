// The C interface of phynness_surface.h.
#include <cmath>
#include <cstring>

#include "core/evaluate.hpp"
#include "surface/subdivision.hpp"
#include "tools/triangle.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Displacements and coordinates are clamped to this [m], so that sums over any number of neighbours are finite.
constexpr double largest_coordinate = 1e25;

float cut_to_float(double value) {
  const double above = value > -largest_coordinate ? value : -largest_coordinate;
  return static_cast<float>(above < largest_coordinate ? above : largest_coordinate);
}

/// The arrays of a surface with the sizes of `counts`.
struct SurfaceParts {
  phn_surface* surface;
  std::int32_t* triangles;
  float* points;
  SurfaceEdge* edges[most_levels];
  VertexRule* rules[most_levels];
  std::int32_t* neighbors[most_levels];
  float* scratch;
};

std::size_t scratch_floats(const phn_surface& surface) {
  std::size_t n = 0;
  for (std::int32_t k = 0; k < surface.n_levels; ++k) n += 4 * static_cast<std::size_t>(surface.level[k].n_vertices);
  return n;
}

SurfaceParts lay_out_surface(Arena& arena, const SurfaceCounts* counts, std::int32_t levels) {
  SurfaceParts parts = {};
  std::size_t n_rows = 0, n_numbers = 0;
  parts.surface = arena.take<phn_surface>(1);
  parts.triangles = arena.take<std::int32_t>(3 * static_cast<std::size_t>(counts[levels].triangles));
  parts.points = arena.take<float>(3 * static_cast<std::size_t>(counts[levels].vertices));
  for (std::int32_t k = 0; k < levels; ++k) {
    const auto n_vertices = static_cast<std::size_t>(counts[k].vertices);
    const auto n_edges = static_cast<std::size_t>(counts[k].edges);
    parts.edges[k] = arena.take<SurfaceEdge>(n_edges);
    parts.rules[k] = arena.take<VertexRule>(n_vertices + 1);
    parts.neighbors[k] = arena.take<std::int32_t>(2 * n_edges);
    n_rows += n_vertices;
    n_numbers = 2 * n_vertices + n_edges;
  }
  // Working memory of init, first for integers, then for rows of points.
  static_assert(sizeof(float) == sizeof(std::int32_t), "");
  parts.scratch = arena.take<float>(4 * n_rows > n_numbers ? 4 * n_rows : n_numbers);
  return parts;
}

/// Applies all levels to the rows of four at the start of `rows`; the result has the finest vertices.
void refine_all(const phn_surface& surface, float* rows, float* out) {
  for (std::int32_t k = 0; k < surface.n_levels; ++k) {
    const bool last = k + 1 == surface.n_levels;
    float* finer = rows + 4 * static_cast<std::size_t>(surface.level[k].n_vertices);
    refine(surface.level[k], rows, last ? out : finer, last ? 3 : 4);
    rows = finer;
  }
}

/// Copies n rows of three numbers to rows of `stride` numbers.
void put_rows(const double* from, std::int32_t n, int stride, float* to) {
  for (std::int32_t i = 0; i < n; ++i, from += 3, to += stride) {
    for (int k = 0; k < 3; ++k) to[k] = cut_to_float(from[k]);
    if (stride == 4) to[3] = 0;
  }
}

std::size_t out_bytes(const phn_surface& surface) {
  return 3 * static_cast<std::size_t>(surface.n_vertices) * sizeof(float);
}

/// Checks the arguments of a deformation, first the memory, then the numbers. @return a status of phynness.h
int check_field(const phn_surface& surface, const float* scratch, const double* field, const float* out) {
  const bool complete = (scratch != nullptr || surface.n_scratch == 0) && (field != nullptr || surface.n_output == 0);
  if (!complete) return PHN_ERROR_ARGUMENT;
  const std::size_t n = 3 * static_cast<std::size_t>(surface.n_output);
  const std::size_t field_bytes = n * sizeof *field, scratch_bytes = surface.n_scratch * sizeof *scratch;
  if (overlap(field, field_bytes, out, out_bytes(surface)) || overlap(scratch, scratch_bytes, field, field_bytes) ||
      overlap(scratch, scratch_bytes, out, out_bytes(surface)))
    return PHN_ERROR_OVERLAP;
  for (std::size_t i = 0; i < n; ++i)
    if (!std::isfinite(field[i])) return PHN_ERROR_NOT_FINITE;
  return PHN_OK;
}

}  // namespace

extern "C" {

int phn_surface_size(const phn_model* model, int32_t levels, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (model == nullptr || levels < 0 || levels > most_levels) return PHN_ERROR_ARGUMENT;
  SurfaceCounts counts[most_levels + 1];
  const int refused = count_surface(*model, levels, counts);
  if (refused != PHN_OK) return refused;
  Arena arena;
  lay_out_surface(arena, counts, levels);
  if (arena.overflow()) return PHN_ERROR_TOO_LARGE;
  *bytes = arena.needed();
  return PHN_OK;
}

int phn_surface_init(void* memory, size_t bytes, const phn_model* model, int32_t levels, const phn_surface** surface) {
  if (surface == nullptr) return PHN_ERROR_ARGUMENT;
  *surface = nullptr;
  if (memory == nullptr || model == nullptr || levels < 0 || levels > most_levels) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, model, model->bytes) || overlap(memory, bytes, surface, sizeof *surface))
    return PHN_ERROR_OVERLAP;
  SurfaceCounts counts[most_levels + 1];
  const int refused = count_surface(*model, levels, counts);
  if (refused != PHN_OK) return refused;
  Arena arena(memory, bytes);
  const SurfaceParts parts = lay_out_surface(arena, counts, levels);
  if (arena.overflow()) return PHN_ERROR_BUFFER;

  phn_surface made = {};
  made.n_output = model->n_output;
  made.n_coarse = made.n_vertices = model->n_output + model->n_fixed;
  made.n_triangles = model->n_triangles;
  made.triangles = parts.triangles;
  made.points = parts.points;
  std::memcpy(parts.triangles, model->triangles, 3 * static_cast<std::size_t>(made.n_triangles) * sizeof(std::int32_t));
  for (std::int32_t& k = made.n_levels; k < levels; ++k) {
    made.level[k] = subdivide(made.n_vertices, made.n_triangles, parts.triangles, parts.edges[k], parts.rules[k],
                              parts.neighbors[k], reinterpret_cast<std::int32_t*>(parts.scratch));
    made.n_vertices += made.level[k].n_edges;
    made.n_triangles *= 4;
  }
  made.n_scratch = scratch_floats(made);

  const int stride = levels > 0 ? 4 : 3;
  float* rows = levels > 0 ? parts.scratch : parts.points;
  put_rows(model->output_points, model->n_output, stride, rows);
  put_rows(model->fixed_points, model->n_fixed, stride, rows + stride * static_cast<std::size_t>(model->n_output));
  refine_all(made, rows, parts.points);
  *parts.surface = made;
  *surface = parts.surface;
  return PHN_OK;
}

int phn_surface_info(const phn_surface* surface, phn_surface_contents* contents) {
  if (contents == nullptr) return PHN_ERROR_ARGUMENT;
  *contents = {};
  if (surface == nullptr) return PHN_ERROR_ARGUMENT;
  *contents = {surface->n_vertices, surface->n_triangles, surface->triangles, surface->points,
               surface->n_scratch * sizeof(float)};
  return PHN_OK;
}

int phn_surface_deform(const phn_surface* surface, float* scratch, const double* field, float* out) {
  if (surface == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  const int status = check_field(*surface, scratch, field, out);
  if (status != PHN_OK) {
    std::memset(out, 0, out_bytes(*surface));
    return status;
  }
  const int stride = surface->n_levels > 0 ? 4 : 3;
  float* rows = surface->n_levels > 0 ? scratch : out;
  put_rows(field, surface->n_output, stride, rows);
  // Fixed nodes do not move.
  std::memset(rows + stride * static_cast<std::size_t>(surface->n_output), 0,
              stride * static_cast<std::size_t>(surface->n_coarse - surface->n_output) * sizeof *rows);
  refine_all(*surface, rows, out);
  return PHN_OK;
}

}  // extern "C"
