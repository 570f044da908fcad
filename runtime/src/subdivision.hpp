// Loop's subdivision of a triangulated surface as sparse maps from one level's vertices to the next's.
#pragma once

#include <phynness/phynness_surface.h>

#include <cstddef>
#include <cstdint>

#include "arena.hpp"
#include "model.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

inline constexpr std::int32_t most_levels = 6;

/// The new vertex of an edge: 3/8 of its ends, 1/8 of the vertices opposite. An edge that has not exactly two triangles
/// is a crease: `opposite` repeats its ends, which makes 1/2 and 1/2 of the same sum.
struct SurfaceEdge {
  std::int32_t end[2], opposite[2];
};

/// The new place of an old vertex: self times its own and share times the sum of its neighbours, which are
/// neighbors[first ... first of the next rule).
struct VertexRule {
  std::int32_t first;
  float self, share;
};

/// From n_vertices to n_vertices + n_edges: old vertices keep their numbers, that of edge e is n_vertices + e.
struct SurfaceLevel {
  std::int32_t n_vertices, n_edges;
  const SurfaceEdge* edges;
  const VertexRule* rules;        ///< n_vertices + 1
  const std::int32_t* neighbors;  ///< rules[n_vertices].first
};

/// Numbers of vertices, edges and triangles of a level, at most.
struct SurfaceCounts {
  std::int64_t vertices, edges, triangles;
};

/// @param counts  filled for levels 0 ... levels; edges as if no two triangles of level 0 shared one
/// @return PHN_OK; PHN_ERROR_UNDEFINED without triangles, PHN_ERROR_GEOMETRY if a triangle has equal corners,
///     PHN_ERROR_TOO_LARGE if a count leaves 32 bits
int count_surface(const phn_model& model, std::int32_t levels, SurfaceCounts* counts);

/// One level: edges in the order in which the triangles meet them, so that neighbours in space are neighbours in
/// memory. Each triangle becomes four, in its place; orientation stays.
/// @param triangles  n_triangles x 3 at the begin, room for four times as many
/// @param edges, rules, neighbors  room for those of level: 2 n_edges neighbours at most
/// @param scratch    2 n_vertices + n_edges
SurfaceLevel subdivide(std::int32_t n_vertices, std::int32_t n_triangles, std::int32_t* triangles, SurfaceEdge* edges,
                       VertexRule* rules, std::int32_t* neighbors, std::int32_t* scratch);

/// Applies a level to vectors. Weights are >= 0 and add up to 1: nothing grows.
/// @param coarse  n_vertices x 4, the fourth any number that is finite
/// @param fine    (n_vertices + n_edges) x stride, stride 3 or 4; does not overlap coarse
void refine(const SurfaceLevel& level, const float* coarse, float* fine, int stride);

}  // namespace PHN_RUNTIME

/// Knows nothing of the model any more.
struct phn_surface {
  std::int32_t n_output, n_coarse, n_vertices, n_triangles, n_levels;
  PHN_RUNTIME::SurfaceLevel level[PHN_RUNTIME::most_levels];
  std::size_t n_scratch;          ///< floats: 4 for each vertex of each level but the last
  const std::int32_t* triangles;  ///< n_triangles x 3
  const float* points;            ///< n_vertices x 3
};
