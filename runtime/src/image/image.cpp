// The C interface of phynness_image.h, without phn_image_open.
#include "image/place.hpp"

using namespace PHN_IMAGES;

namespace {

namespace image = phynness::image;

/// phn_image is an incomplete type that stands for a Header, so that C compilers distinguish images.
const Header* header(const phn_image* image) { return reinterpret_cast<const Header*>(image); }

/// Sets the outputs of a refused call to zeros. They are written last because they may overlap the tool.
int refuse(int status, Real* out, size_t n) {
  if (out != nullptr) clear(out, n);
  return status;
}

/// The corners of a tool's place and its clamped displacement.
struct ToolQuery {
  Corners corners;
  Real d[3];
};

/// Checks a call and finds the corners. @return a status of phynness.h, with the warnings
[[gnu::noinline]] int check_query(const phn_image* opened, const phn_image_tool* tool, const Real* out,
                                  ToolQuery& query) {
  if (opened == nullptr || tool == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  if (tool->reserved[0] != 0 || tool->reserved[1] != 0) return PHN_ERROR_VERSION;
  const Header& image = *header(opened);
  int status = find_corners(image, *tool, query.corners);
  if (status == PHN_ERROR_NOT_ACTIVE && !finite(tool->displacement)) return PHN_ERROR_NOT_FINITE;
  if (status != PHN_OK) return status;
  const Real largest = Real(image::largest_displacement) * image.max_displacement;
  bool is_unclamped = true;
  for (int k = 0; k < 3; ++k) {
    query.d[k] = tool->displacement[k];
    is_unclamped = is_unclamped && query.d[k] <= largest && -query.d[k] <= largest;
  }
  if (!is_unclamped && !finite(query.d)) return PHN_ERROR_NOT_FINITE;
  for (int k = 0; k < 3 && !is_unclamped; ++k) query.d[k] = clamp(query.d[k], largest);
  if (query.corners.fixed_weight > Real(least_share)) status = PHN_WARNING_OUTSIDE;
  for (uint32_t i = 0; i < query.corners.n; ++i)
    if (query.corners.counts(i)) status |= warnings(image, query.corners.position[i], is_unclamped, query.d);
  return status;
}

/// Adds the responses between nodes. This is a function of its own, because a node needs no memory for neighbours.
template <int n>
[[gnu::noinline]] void respond_between(const Header& image, const ToolQuery& query, Real* sum) {
  Neighbourhood around;
  find_neighbours(image, query.corners, around);
  Real result[n];
  for (uint32_t i = 0; i < around.n; ++i) {
    respond<n>(image, around.position[i], query.d, result);
    for (int k = 0; k < n; ++k) sum[k] += around.weight[i] * result[k];
  }
}

template <int n>
int evaluate(const phn_image* opened, const phn_image_tool* tool, Real* out) {
  ToolQuery query;
  int status = check_query(opened, tool, out, query);
  if (status >= 0 && n != Force && !traits(*header(opened)).has_energy) status = PHN_ERROR_UNDEFINED;
  if (status < 0) return refuse(status, out, n);
  const Header& image = *header(opened);
  Real result[n] = {};
  if (query.corners.n == 1) {
    respond<n>(image, query.corners.position[0], query.d, result);
  } else {
    respond_between<n>(image, query, result);
  }
  bool all_finite = true;
  for (int k = 0; k < n; ++k) all_finite = all_finite && result[k] - result[k] == 0;
  for (int k = 0; k < n; ++k) out[k] = all_finite ? 0 + result[k] : 0;  // no -0
  return status;
}

void copy_number(const uint32_t (&from)[2], double& to) { __builtin_memcpy(&to, from, sizeof to); }

void copy_provenance(const image::Provenance& from, phn_provenance& out) {
  out.mesh_hash = from.mesh_hash;
  out.physics_hash = from.physics_hash;
  out.element = from.element;
  out.reference = from.reference;
  copy_number(from.shear_modulus_Pa, out.shear_modulus_Pa);
  copy_number(from.finer_mean, out.finer_mean);
  copy_number(from.finer_p95, out.finer_p95);
  copy_number(from.finer_tool_radius_m, out.finer_tool_radius_m);
  out.finer_probes = from.finer_probes;
  out.finer_nodes = from.finer_nodes;
  out.bound_reference = from.bound_reference;
}

phn_relaxation relaxation_of(const Header& image, image::Table table) {
  phn_relaxation out = {};
  const auto* halves = at<uint32_t>(image, table);
  const auto number = [&](uint32_t i) {
    double value;
    __builtin_memcpy(&value, halves + 2 * i, sizeof value);
    return value;
  };
  out.n_terms = static_cast<int32_t>(table.n / 4);
  if (out.n_terms > 0) out.length_m = number(0);
  for (int32_t i = 0; i < out.n_terms; ++i) {
    out.g[i] = number(1 + 2 * i);
    out.tau_s[i] = number(2 + 2 * i);
  }
  return out;
}

}  // namespace

extern "C" {

int phn_image_info(const phn_image* opened, phn_image_contents* out) {
  if (out == nullptr) return PHN_ERROR_ARGUMENT;
  *out = {};
  phn_provenance& origin = out->provenance;
  origin.mesh_hash = origin.physics_hash = origin.element = origin.reference = "";
  if (opened == nullptr) return PHN_ERROR_ARGUMENT;
  const Header& image = *header(opened);
  const image::Surface* surface = surface_of(image);
  out->max_displacement_m = image.max_displacement;
  out->active_nodes = at<int32_t>(image, image.active_nodes);
  out->output_nodes = at<int32_t>(image, image.output_nodes);
  out->active_points = at<Real>(image, image.active_points);
  out->output_points = at<Real>(image, image.output_points);
  out->scratch_bytes = image.n_scratch * sizeof(Real);
  out->n_active = static_cast<int32_t>(image.active_nodes.n);
  out->n_output = static_cast<int32_t>(image.output_nodes.n);
  out->n_triangles = surface == nullptr ? 0 : static_cast<int32_t>(surface->triangle.n / 6);
  out->has_energy = traits(image).has_energy;
  out->has_bounds = surface != nullptr && surface->bound.n > 0;
  const auto& recorded = *at<image::Provenance>(image, image.provenance);
  copy_provenance(recorded, origin);
  out->relaxation = relaxation_of(image, recorded.relaxation);
  return PHN_OK;
}

int phn_image_nearest(const phn_image* opened, int32_t from, const Real* x, phn_image_tool* tool, Real* point,
                      Real* distance) {
  Nearest found = {image::none, {0, 0, 0}, {0, 0, 0}, 0};
  Real signed_distance = 0;
  const Header* image = header(opened);
  const auto* surface = image != nullptr ? surface_of(*image) : nullptr;
  const uint32_t n_triangles = surface == nullptr ? 0 : surface->triangle.n / 6;
  constexpr size_t vector_bytes = 3 * sizeof(Real);
  int status = PHN_OK;
  if (image == nullptr || x == nullptr || tool == nullptr) {
    status = PHN_ERROR_ARGUMENT;
  } else if (surface == nullptr) {
    status = PHN_ERROR_UNDEFINED;
  } else if (from >= static_cast<int32_t>(n_triangles)) {
    status = PHN_ERROR_ARGUMENT;
  } else if (overlap(tool, sizeof *tool, point, vector_bytes) ||
             overlap(tool, sizeof *tool, distance, sizeof *distance) ||
             overlap(point, vector_bytes, distance, sizeof *distance)) {
    status = PHN_ERROR_OVERLAP;
  } else if (!finite(x)) {
    status = PHN_ERROR_NOT_FINITE;
  } else {
    Real query[3];
    for (int k = 0; k < 3; ++k) query[k] = clamp(x[k], Real(image::Bounds<Real>::value));
    const Search search(*image, *surface, query);
    if (from < 0) {
      found = search.everywhere(n_triangles);
    } else {
      found = search.on(static_cast<uint32_t>(from));
      if (!search.walk(found)) status = PHN_WARNING_UNSETTLED;
    }
    search.leave_fixed_edge(at<image::VertexCorners>(*image, surface->vertex), found);
    if (distance != nullptr) {
      signed_distance = square_root(found.square);
      if (search.is_inside(n_triangles, found)) signed_distance = -signed_distance;
    }
  }
  const Real* w = found.weight;
  const int32_t triangle = status < 0 ? -1 : static_cast<int32_t>(found.triangle);
  if (tool != nullptr) *tool = {-1, triangle, {w[0], w[1], w[2]}, {0, 0, 0}, {0, 0}};
  for (int k = 0; k < 3 && point != nullptr; ++k) point[k] = found.point[k];
  if (distance != nullptr) *distance = signed_distance;
  return status;
}

int phn_image_force(const phn_image* image, const phn_image_tool* tool, Real* force_N) {
  return evaluate<Force>(image, tool, force_N);
}
int phn_image_energy(const phn_image* image, const phn_image_tool* tool, Real* energy_J) {
  return evaluate<Energy>(image, tool, energy_J);
}
int phn_image_stiffness(const phn_image* image, const phn_image_tool* tool, Real* stiffness_N_per_m) {
  return evaluate<Stiffness>(image, tool, stiffness_N_per_m);
}

int phn_image_depth(const phn_image* opened, const phn_image_tool* tool, Real* out) {
  ToolQuery query;
  const int status = check_query(opened, tool, out, query);
  if (status < 0) return refuse(status, out, 1);
  const Corners& corners = query.corners;
  Real depth = PHN_IMAGE_NO_BOUND;
  for (uint32_t i = 0; i < corners.n; ++i) {
    const Real of_corner = corners.counts(i) ? trained_depth(*header(opened), corners.position[i], query.d) : depth;
    depth = of_corner < depth ? of_corner : depth;
  }
  *out = corners.fixed_weight > Real(least_share) ? 0 : depth;
  return status & PHN_WARNING_OUTSIDE;
}

/// This is bound_between of tools/one_tool.cpp.
[[gnu::cold]] int phn_image_bound(const phn_image* opened, const phn_image_tool* tool, Real* out) {
  ToolQuery query;
  int status = check_query(opened, tool, out, query);
  const image::Surface* surface = status < 0 ? nullptr : surface_of(*header(opened));
  if (status >= 0 && (surface == nullptr || surface->bound.n == 0)) status = PHN_ERROR_UNDEFINED;
  if (out != nullptr) *out = PHN_IMAGE_NO_BOUND;
  if (status < 0 || (status & PHN_WARNING_OUTSIDE) != 0) return status;
  const Header& image = *header(opened);
  const Corners& corners = query.corners;
  Real force[image::most_corners][3] = {}, mean[3] = {0, 0, 0}, largest = 0, least = 0, spread = 0;
  for (uint32_t i = 0; i < corners.n; ++i) {
    const uint32_t position = corners.position[i];
    const Real bound = corners.counts(i) ? bound_at_node(image, *surface, position, query.d) : 0;
    largest = bound > largest ? bound : largest;
    least += corners.weight[i] * bound;
    if (corners.n > 1) respond<Force>(image, position, query.d, force[i]);
    for (int k = 0; k < 3; ++k) mean[k] += corners.weight[i] * force[i][k];
  }
  for (uint32_t i = 0; i < corners.n; ++i) {
    const Real away[3] = {force[i][0] - mean[0], force[i][1] - mean[1], force[i][2] - mean[2]};
    spread += corners.weight[i] * square_root(dot(away, away));
  }
  Real bound = 0;
  if (corners.n > 1) {
    const Real x[] = {largest + spread, spread, square_root(dot(mean, mean))};
    bound = coupled_bound(at<Real>(image, surface->between), x, Real(PHN_IMAGE_NO_BOUND));
  }
  *out = bound > least ? bound : least;
  return status;
}

int phn_image_deform(const phn_image* opened, Real* scratch, const phn_image_tool* tool, Real* out) {
  if (opened == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  const Header& image = *header(opened);
  const size_t n = 3 * static_cast<size_t>(image.output_nodes.n);
  ToolQuery query;
  int status = check_query(opened, tool, out, query);
  if (scratch == nullptr && image.n_scratch > 0) status = PHN_ERROR_ARGUMENT;
  if (overlap(scratch, image.n_scratch * sizeof(Real), out, n * sizeof(Real))) status = PHN_ERROR_OVERLAP;
  if (status < 0) return refuse(status, out, n);
  const Corners& corners = query.corners;
  const ActiveNode* node = corners.n == 1 && n > 0 ? active_node(image, corners.position[0]) : nullptr;
  const bool deforms = node != nullptr && with_response(image, corners.position[0], [&](const auto& response) {
                         return response_field(image, response, query.d, scratch, out);
                       });
  if (!deforms) return refuse(PHN_ERROR_UNDEFINED, out, n);
  const auto* prescribed = at<uint16_t>(image, node->prescribed);
  const Real* weight = at<Real>(image, node->prescribed_weight);
  for (uint32_t p = 0; p < node->prescribed.n; ++p)
    for (uint32_t k = 0; k < 3; ++k) out[3 * prescribed[p] + k] = weight[p] * query.d[k];
  return status;
}

}  // extern "C"
