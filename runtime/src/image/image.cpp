// The C interface of phynness_image.h: argument checks and statuses, for doubles and for floats.
#include "image/image.hpp"

using namespace PHN_RUNTIME;

namespace {

/// The node and the displacement of a call, and the status of their check.
template <class Real>
struct Query {
  const phynness::image::ActiveNode<Real>* node = nullptr;
  Real d[3] = {0, 0, 0};  ///< clamped
  bool whole = true;      ///< whether d was not clamped
};

/// Sets the outputs of a refused call to zeros. They are written last because they may overlap the displacement.
template <class Real>
int refuse(int status, Real* out, size_t n) {
  if (out != nullptr) clear(out, n);
  return status;
}

template <class Real>
int ask(const ImageHeader<Real>* image, int32_t node, const Real* d, const Real* out, Query<Real>& query) {
  if (image == nullptr || d == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  query.node = find_active(*image, node);
  if (query.node == nullptr) return PHN_ERROR_NOT_ACTIVE;
  if (!finite(d)) return PHN_ERROR_NOT_FINITE;
  query.whole = cut_displacement(*image, d, query.d);
  return PHN_OK;
}

template <class Real>
int answered(const ImageHeader<Real>& image, const Query<Real>& query) {
  return image_warnings(image, *query.node, query.whole, query.d);
}

template <class Real>
int force(const ImageHeader<Real>* image, int32_t node, const Real* d, Real* out) {
  Query<Real> query;
  const int refused = ask(image, node, d, out, query);
  if (refused != PHN_OK) return refuse(refused, out, 3);
  with_response(*image, *query.node, [&](const auto& response) { response_force(*image, response, query.d, out); });
  return answered(*image, query);
}

template <class Real>
int energy(const ImageHeader<Real>* image, int32_t node, const Real* d, Real* out) {
  Query<Real> query;
  const int refused = ask(image, node, d, out, query);
  if (refused != PHN_OK) return refuse(refused, out, 1);
  if (!traits(*image).has_energy) return refuse(PHN_ERROR_UNDEFINED, out, 1);
  *out = with_response(*image, *query.node,
                       [&](const auto& response) { return response_energy(*image, response, query.d); });
  return answered(*image, query);
}

template <class Real>
int stiffness(const ImageHeader<Real>* image, int32_t node, const Real* d, Real* out) {
  Query<Real> query;
  const int refused = ask(image, node, d, out, query);
  if (refused != PHN_OK) return refuse(refused, out, 9);
  if (!traits(*image).has_energy) return refuse(PHN_ERROR_UNDEFINED, out, 9);
  with_response(*image, *query.node, [&](const auto& response) { response_stiffness(*image, response, query.d, out); });
  return answered(*image, query);
}

template <class Real>
int depth(const ImageHeader<Real>* image, int32_t node, const Real* d, Real* out) {
  Query<Real> query;
  const int refused = ask(image, node, d, out, query);
  if (refused != PHN_OK) return refuse(refused, out, 1);
  *out = trained_depth(*image, *query.node, query.d);
  return answered(*image, query) & PHN_WARNING_OUTSIDE;
}

template <class Real>
int deform(const ImageHeader<Real>* image, Real* scratch, int32_t node, const Real* d, Real* out) {
  if (image == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  const size_t n = 3 * static_cast<size_t>(image->output_nodes.n);
  if (scratch == nullptr && image->n_scratch > 0) return refuse(PHN_ERROR_ARGUMENT, out, n);
  if (overlap(scratch, image->n_scratch * sizeof(Real), out, n * sizeof(Real)))
    return refuse(PHN_ERROR_OVERLAP, out, n);
  Query<Real> query;
  const int refused = ask(image, node, d, out, query);
  if (refused != PHN_OK) return refuse(refused, out, n);
  if (!image_has_deformation(*image, *query.node)) return refuse(PHN_ERROR_UNDEFINED, out, n);
  image_field_at(*image, *query.node, query.d, scratch, out);
  return answered(*image, query);
}

void copy_number(const uint32_t (&from)[2], double& to) { __builtin_memcpy(&to, from, sizeof to); }

template <class Real>
int provenance(const ImageHeader<Real>* image, phn_provenance* out) {
  if (out == nullptr) return PHN_ERROR_ARGUMENT;
  phn_provenance found = {};
  found.mesh_hash = found.physics_hash = found.element = found.reference = "";
  if (image != nullptr && image->provenance != 0) {
    const auto& from = *at<phynness::image::Provenance>(*image, image->provenance);
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
    found.element_revision = from.element_revision;
  }
  *out = found;
  return image == nullptr ? PHN_ERROR_ARGUMENT : PHN_OK;
}

}  // namespace

// NAME is phn_image or phn_imagef. Both are incomplete types that stand for a Header, so that C compilers distinguish
// them.
#define PHN_IMAGE_FUNCTIONS(NAME, Real)                                                                         \
  static const ImageHeader<Real>* header(const NAME* image) {                                                   \
    return reinterpret_cast<const ImageHeader<Real>*>(image);                                                   \
  }                                                                                                             \
  extern "C" {                                                                                                  \
  int32_t NAME##_n_active(const NAME* image) {                                                                  \
    return image ? static_cast<int32_t>(header(image)->active_nodes.n) : 0;                                     \
  }                                                                                                             \
  const int32_t* NAME##_active_nodes(const NAME* image) {                                                       \
    return image ? at<int32_t>(*header(image), header(image)->active_nodes) : nullptr;                          \
  }                                                                                                             \
  const Real* NAME##_active_points(const NAME* image) {                                                         \
    return image ? at<Real>(*header(image), header(image)->active_points) : nullptr;                            \
  }                                                                                                             \
  int NAME##_provenance(const NAME* image, phn_provenance* out) { return provenance(header(image), out); }      \
  int32_t NAME##_n_output(const NAME* image) {                                                                  \
    return image ? static_cast<int32_t>(header(image)->output_nodes.n) : 0;                                     \
  }                                                                                                             \
  const int32_t* NAME##_output_nodes(const NAME* image) {                                                       \
    return image ? at<int32_t>(*header(image), header(image)->output_nodes) : nullptr;                          \
  }                                                                                                             \
  const Real* NAME##_output_points(const NAME* image) {                                                         \
    return image ? at<Real>(*header(image), header(image)->output_points) : nullptr;                            \
  }                                                                                                             \
  int NAME##_force(const NAME* image, int32_t node, const Real d[3], Real force_N[3]) {                         \
    return force(header(image), node, d, force_N);                                                              \
  }                                                                                                             \
  int NAME##_energy(const NAME* image, int32_t node, const Real d[3], Real* energy_J) {                         \
    return energy(header(image), node, d, energy_J);                                                            \
  }                                                                                                             \
  int NAME##_stiffness(const NAME* image, int32_t node, const Real d[3], Real stiffness_N_per_m[9]) {           \
    return stiffness(header(image), node, d, stiffness_N_per_m);                                                \
  }                                                                                                             \
  int NAME##_trained_depth(const NAME* image, int32_t node, const Real d[3], Real* depth_m) {                   \
    return depth(header(image), node, d, depth_m);                                                              \
  }                                                                                                             \
  size_t NAME##_scratch_size(const NAME* image) { return image ? header(image)->n_scratch * sizeof(Real) : 0; } \
  int NAME##_deform(const NAME* image, Real* scratch, int32_t node, const Real d[3], Real* out) {               \
    return deform(header(image), scratch, node, d, out);                                                        \
  }                                                                                                             \
  }

PHN_IMAGE_FUNCTIONS(phn_image, double)
PHN_IMAGE_FUNCTIONS(phn_imagef, float)
