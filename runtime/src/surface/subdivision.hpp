// Loop's subdivision of a triangulated surface as sparse linear maps from the vertices of one level to those of the
// next.
#pragma once

#include <phynness/phynness_surface.h>

#include <cstddef>
#include <cstdint>

#include "core/arena.hpp"
#include "core/model.hpp"

namespace PHN_RUNTIME {

inline constexpr std::int32_t most_levels = 6;

/// The new vertex of an edge: 3/8 of its ends plus 1/8 of the opposite vertices. An edge without exactly two triangles
/// is a crease, for which `opposite` repeats the ends, so that the same sum gives 1/2 of each end.
struct SurfaceEdge {
  std::int32_t end[2], opposite[2];
};

/// The new position of an old vertex: self times its old position plus share times the sum of its neighbours, which are
/// neighbors[first ... first of the next rule).
struct VertexRule {
  std::int32_t first;
  float self, share;
};

/// The map from n_vertices to n_vertices + n_edges vertices. Old vertices keep their numbers; the new vertex of edge e
/// has the number n_vertices + e.
struct SurfaceLevel {
  std::int32_t n_vertices, n_edges;
  const SurfaceEdge* edges;
  const VertexRule* rules;        ///< n_vertices + 1
  const std::int32_t* neighbors;  ///< rules[n_vertices].first
};

/// Upper bounds of the numbers of vertices, edges and triangles of a level.
struct SurfaceCounts {
  std::int64_t vertices, edges, triangles;
};

/// @param counts  filled for levels 0 ... levels; edges as if no two triangles of level 0 shared one
/// @return PHN_OK; PHN_ERROR_UNDEFINED without triangles, PHN_ERROR_GEOMETRY if a triangle has equal corners,
///     PHN_ERROR_TOO_LARGE if a count exceeds 32 bits
int count_surface(const phn_model& model, std::int32_t levels, SurfaceCounts* counts);

/// One level. Edges are numbered in the order of the triangles, so that neighbours in space are neighbours in memory.
/// Each triangle is replaced by four of the same orientation.
/// @param triangles  n_triangles x 3 at the start; capacity for four times as many
/// @param edges, rules, neighbors  memory for those of the level; at most 2 n_edges neighbours
/// @param scratch    2 n_vertices + n_edges
SurfaceLevel subdivide(std::int32_t n_vertices, std::int32_t n_triangles, std::int32_t* triangles, SurfaceEdge* edges,
                       VertexRule* rules, std::int32_t* neighbors, std::int32_t* scratch);

/// Applies a level to vectors. Weights are >= 0 and have the sum 1, so that values do not grow.
/// @param coarse  n_vertices x 4; the fourth may be any finite number
/// @param fine    (n_vertices + n_edges) x stride, stride 3 or 4; does not overlap coarse
void refine(const SurfaceLevel& level, const float* coarse, float* fine, int stride);

}  // namespace PHN_RUNTIME

/// Independent of the model from which it was made.
struct phn_surface {
  std::int32_t n_output, n_coarse, n_vertices, n_triangles, n_levels;
  PHN_RUNTIME::SurfaceLevel level[PHN_RUNTIME::most_levels];
  std::size_t n_scratch;          ///< floats: 4 for each vertex of each level but the last
  const std::int32_t* triangles;  ///< n_triangles x 3
  const float* points;            ///< n_vertices x 3
};
