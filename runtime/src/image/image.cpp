// The C interface of phynness_image.h: argument checks and statuses.
#include "image/place.hpp"

using namespace PHN_RUNTIME;

namespace {

namespace image = phynness::image;
using Real = phn_real;
using Header = ImageHeader<Real>;
using ActiveNode = image::ActiveNode<Real>;

/// phn_image is an incomplete type that stands for a Header, so that C compilers distinguish images.
const Header* header(const phn_image* image) { return reinterpret_cast<const Header*>(image); }

/// Sets the outputs of a refused call to zeros. They are written last because they may overlap the displacement.
int refuse(int status, Real* out, size_t n) {
  if (out != nullptr) clear(out, n);
  return status;
}

/// A tool at a node: its clamped displacement and the warnings.
struct NodeQuery {
  const ActiveNode* found = nullptr;
  Real d[3] = {0, 0, 0};
  int status = PHN_OK;

  /// @return a status of phynness.h; warnings are in `status`
  int ask(const Header& image, int32_t node, const Real* by) {
    found = find_active(image, node);
    if (found == nullptr) return PHN_ERROR_NOT_ACTIVE;
    if (!finite(by)) return PHN_ERROR_NOT_FINITE;
    const bool whole = cut_displacement(image, by, d);
    status = image_warnings(image, *found, whole, d);
    return PHN_OK;
  }
  void add_others(const Header&) {}
  uint32_t n() const { return 1; }
  Real weight(uint32_t) const { return 1; }
  template <class Function>
  void respond(const Header& image, uint32_t, Function&& f) const {
    with_response(image, *found, f);
  }
};

/// A round tool at a place: the same, with the nodes around it.
struct PlaceQuery {
  Around<Real> around;
  Real d[3] = {0, 0, 0};
  int status = PHN_OK;

  int ask(const Header& image, const phn_image_place* place, const Real* by) {
    if (place == nullptr) return PHN_ERROR_ARGUMENT;
    const auto* surface = surface_of(image);
    if (surface == nullptr) return PHN_ERROR_UNDEFINED;
    const int refused = find_corners(image, *surface, static_cast<uint32_t>(place->triangle), place->weights, around);
    if (refused != PHN_OK) return refused;
    if (!finite(by)) return PHN_ERROR_NOT_FINITE;
    const bool whole = cut_displacement(image, by, d);
    status = around.fixed_weight > largest_fixed_weight<Real> ? PHN_WARNING_OUTSIDE : PHN_OK;
    for (uint32_t i = 0; i < around.n; ++i) {
      if (around.counts(i)) status |= warned(image, around.active[i], whole);
    }
    return PHN_OK;
  }
  void add_others(const Header& image) { add_neighbours(image, *surface_of(image), around); }
  uint32_t n() const { return around.n; }
  Real weight(uint32_t i) const { return around.weight[i]; }
  template <class Function>
  void respond(const Header& image, uint32_t i, Function&& f) const {
    with_response_at(image, around.active[i], f);
  }

 private:
  int warned(const Header& image, uint32_t own, bool whole) const {
    if (own < image.active_nodes.n) return image_warnings(image, at<ActiveNode>(image, image.active)[own], whole, d);
    return whole && traits(image).proportional ? PHN_OK : PHN_WARNING_OUTSIDE;
  }
};

NodeQuery query_of(int32_t) { return {}; }
PlaceQuery query_of(const phn_image_place*) { return {}; }

/// What is asked for, and how many numbers it has.
enum : int { Force = 3, Energy = 1, Stiffness = 9 };

/// @tparam n  Force, Energy or Stiffness
/// @param where  a node, or a place
template <int n, class Where>
int evaluate(const phn_image* asked, Where where, const Real* d, Real* out) {
  const Header* image = header(asked);
  auto query = query_of(where);
  int refused = image != nullptr && d != nullptr && out != nullptr ? query.ask(*image, where, d) : PHN_ERROR_ARGUMENT;
  if (refused == PHN_OK && n != Force && !traits(*image).has_energy) refused = PHN_ERROR_UNDEFINED;
  if (refused != PHN_OK) return refuse(refused, out, n);
  query.add_others(*image);
  Real result[n], sum[n] = {};
  for (uint32_t i = 0; i < query.n(); ++i) {
    query.respond(*image, i, [&](const auto& response) {
      if constexpr (n == Force) response_force(*image, response, query.d, result);
      if constexpr (n == Energy) *result = response_energy(*image, response, query.d);
      if constexpr (n == Stiffness) response_stiffness(*image, response, query.d, result);
    });
    for (int k = 0; k < n; ++k) sum[k] += query.weight(i) * result[k];
  }
  bool all_finite = true;
  for (int k = 0; k < n; ++k) all_finite = all_finite && sum[k] - sum[k] == 0;
  for (int k = 0; k < n; ++k) out[k] = all_finite ? sum[k] : 0;
  return query.status;
}

void copy_number(const uint32_t (&from)[2], double& to) { __builtin_memcpy(&to, from, sizeof to); }

}  // namespace

extern "C" {

int32_t phn_image_n_active(const phn_image* image) {
  return image ? static_cast<int32_t>(header(image)->active_nodes.n) : 0;
}
const int32_t* phn_image_active_nodes(const phn_image* image) {
  return image ? at<int32_t>(*header(image), header(image)->active_nodes) : nullptr;
}
const Real* phn_image_active_points(const phn_image* image) {
  return image ? at<Real>(*header(image), header(image)->active_points) : nullptr;
}

int phn_image_provenance(const phn_image* opened, phn_provenance* out) {
  const Header* image = header(opened);
  if (out == nullptr) return PHN_ERROR_ARGUMENT;
  phn_provenance found = {};
  found.mesh_hash = found.physics_hash = found.element = found.reference = "";
  if (image != nullptr) {
    const auto& from = *at<image::Provenance>(*image, image->provenance);
    found.mesh_hash = from.mesh_hash;
    found.physics_hash = from.physics_hash;
    found.element = from.element;
    found.reference = from.reference;
    copy_number(from.shear_modulus_Pa, found.shear_modulus_Pa);
    copy_number(from.finer_mean, found.finer_mean);
    copy_number(from.finer_p95, found.finer_p95);
    copy_number(from.finer_tool_radius_m, found.finer_tool_radius_m);
    found.finer_probes = from.finer_probes;
    found.finer_nodes = from.finer_nodes;
  }
  *out = found;
  return image == nullptr ? PHN_ERROR_ARGUMENT : PHN_OK;
}

int32_t phn_image_n_output(const phn_image* image) {
  return image ? static_cast<int32_t>(header(image)->output_nodes.n) : 0;
}
const int32_t* phn_image_output_nodes(const phn_image* image) {
  return image ? at<int32_t>(*header(image), header(image)->output_nodes) : nullptr;
}
const Real* phn_image_output_points(const phn_image* image) {
  return image ? at<Real>(*header(image), header(image)->output_points) : nullptr;
}
int phn_image_force(const phn_image* image, int32_t node, const Real d[3], Real force_N[3]) {
  return evaluate<Force>(image, node, d, force_N);
}
int phn_image_energy(const phn_image* image, int32_t node, const Real d[3], Real* energy_J) {
  return evaluate<Energy>(image, node, d, energy_J);
}
int phn_image_stiffness(const phn_image* image, int32_t node, const Real d[3], Real stiffness_N_per_m[9]) {
  return evaluate<Stiffness>(image, node, d, stiffness_N_per_m);
}

int phn_image_trained_depth(const phn_image* opened, int32_t node, const Real* d, Real* out) {
  const Header* image = header(opened);
  NodeQuery query;
  const int refused =
      image != nullptr && d != nullptr && out != nullptr ? query.ask(*image, node, d) : PHN_ERROR_ARGUMENT;
  if (refused != PHN_OK) return refuse(refused, out, 1);
  *out = trained_depth(*image, *query.found, query.d);
  return query.status & PHN_WARNING_OUTSIDE;
}

size_t phn_image_scratch_size(const phn_image* image) { return image ? header(image)->n_scratch * sizeof(Real) : 0; }

int phn_image_deform(const phn_image* opened, Real* scratch, int32_t node, const Real* d, Real* out) {
  const Header* image = header(opened);
  if (image == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  const size_t n = 3 * static_cast<size_t>(image->output_nodes.n);
  if (d == nullptr || (scratch == nullptr && image->n_scratch > 0)) return refuse(PHN_ERROR_ARGUMENT, out, n);
  if (overlap(scratch, image->n_scratch * sizeof(Real), out, n * sizeof(Real)))
    return refuse(PHN_ERROR_OVERLAP, out, n);
  NodeQuery query;
  const int refused = query.ask(*image, node, d);
  if (refused != PHN_OK) return refuse(refused, out, n);
  if (!image_has_deformation(*image, *query.found)) return refuse(PHN_ERROR_UNDEFINED, out, n);
  image_field_at(*image, *query.found, query.d, scratch, out);
  return query.status;
}

int phn_image_nearest(const phn_image* opened, int32_t from, const Real* x, phn_image_place* place, Real* point) {
  const Header* image = header(opened);
  Nearest<Real> found = {image::none, {0, 0, 0}, {0, 0, 0}, 0};
  int status = PHN_ERROR_ARGUMENT;
  const auto* surface = image != nullptr ? surface_of(*image) : nullptr;
  const uint32_t n_triangles = surface == nullptr ? 0 : surface->triangle.n / 6;
  if (image != nullptr && x != nullptr && place != nullptr &&
      (surface == nullptr || from < static_cast<int32_t>(n_triangles))) {
    status = surface == nullptr                                        ? PHN_ERROR_UNDEFINED
             : overlap(place, sizeof *place, point, 3 * sizeof *point) ? PHN_ERROR_OVERLAP
             : !finite(x)                                              ? PHN_ERROR_NOT_FINITE
                                                                       : PHN_OK;
  }
  if (status == PHN_OK) {
    Real asked[3];
    for (int k = 0; k < 3; ++k) asked[k] = cut(x[k], Real(image::Bounds<Real>::value));
    const Search<Real> search(*image, *surface, asked);
    if (from < 0) {
      found = search.everywhere(n_triangles);
    } else {
      found = search.on(static_cast<uint32_t>(from));
      if (!search.walk(found)) status = PHN_WARNING_UNSETTLED;
    }
    search.leave_fixed_edge(at<image::VertexCorners>(*image, surface->vertex), found);
  }
  for (int k = 0; k < 3 && place != nullptr; ++k) place->weights[k] = found.weight[k];
  if (place != nullptr) place->triangle = status < 0 ? -1 : static_cast<int32_t>(found.triangle);
  for (int k = 0; k < 3 && point != nullptr; ++k) point[k] = found.point[k];
  return status;
}

int phn_image_force_at(const phn_image* image, const phn_image_place* place, const Real d[3], Real force_N[3]) {
  return evaluate<Force>(image, place, d, force_N);
}
int phn_image_energy_at(const phn_image* image, const phn_image_place* place, const Real d[3], Real* energy_J) {
  return evaluate<Energy>(image, place, d, energy_J);
}
int phn_image_stiffness_at(const phn_image* image, const phn_image_place* place, const Real d[3],
                           Real stiffness_N_per_m[9]) {
  return evaluate<Stiffness>(image, place, d, stiffness_N_per_m);
}

/// As bound_at in tools/bounds.cpp.
int phn_image_bound_at(const phn_image* opened, const phn_image_place* place, const Real* d, Real* out) {
  const Header* image = header(opened);
  PlaceQuery query;
  int refused = image != nullptr && d != nullptr && out != nullptr ? query.ask(*image, place, d) : PHN_ERROR_ARGUMENT;
  if (refused == PHN_OK && surface_of(*image)->bound.n == 0) refused = PHN_ERROR_UNDEFINED;
  if (refused != PHN_OK) return refuse(refused, out, 1);
  const image::Surface& surface = *surface_of(*image);
  *out = PHN_IMAGE_NO_BOUND;
  if ((query.status & PHN_WARNING_OUTSIDE) != 0) return query.status;
  const Around<Real>& around = query.around;
  Real force[image::most_corners][3], mean[3] = {0, 0, 0}, largest = 0, spread = 0;
  for (uint32_t i = 0; i < around.n_corners; ++i) {
    const Real bound = around.counts(i) ? bound_at_node(*image, surface, around.active[i], query.d) : 0;
    largest = bound > largest ? bound : largest;
    query.respond(*image, i, [&](const auto& response) { response_force(*image, response, query.d, force[i]); });
    for (int k = 0; k < 3; ++k) mean[k] += around.share[i] * force[i][k];
  }
  for (uint32_t i = 0; i < around.n_corners; ++i) {
    const Real away[3] = {force[i][0] - mean[0], force[i][1] - mean[1], force[i][2] - mean[2]};
    spread += around.share[i] * square_root(dot(away, away));
  }
  if (around.n_corners > 1) {
    const Real x[] = {largest + spread, spread, square_root(dot(mean, mean))};
    *out = coupled_bound(at<Real>(*image, surface.between), x, Real(PHN_IMAGE_NO_BOUND));
  } else if (largest < *out) {
    *out = largest;
  }
  return query.status;
}

}  // extern "C"
