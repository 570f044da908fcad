// Evaluation of images in place. Each family has a type of response (image_layout.hpp) and, in a file of its name,
// overloads of these functions:
//
//   response_force, response_energy, response_stiffness   of one node
//   has_deformation, response_field                       whether a node has a deformation, and the field
#pragma once

#include "image/linear_response.hpp"
#include "image/modal_response.hpp"
#include "image/rbfn_response.hpp"

namespace PHN_RUNTIME {

/// Calls f with a null pointer to the type of a response. The only place that distinguishes the families of images.
template <class Real, class Function>
auto with_response_type(Family family, Function&& f) {
  using image::LinearResponse, image::ModalResponse, image::RbfnResponse;
  if (family == RbfnResponse<Real>::family) return f(static_cast<const RbfnResponse<Real>*>(nullptr));
  if (family == LinearResponse<Real>::family) return f(static_cast<const LinearResponse<Real>*>(nullptr));
  return f(static_cast<const ModalResponse<Real>*>(nullptr));
}

template <class Response>
constexpr schema::FamilyTraits traits_of(const Response*) {
  constexpr schema::FamilyTraits found = schema::traits(Response::family);
  return found;
}

/// Traits of the family as constants in the code. Position-independent code would access a table through a global
/// offset table in memory, which a device without an operating system does not initialize.
template <class Real>
schema::FamilyTraits traits(const ImageHeader<Real>& image) {
  return with_response_type<Real>(image.family, [](const auto* type) { return traits_of(type); });
}

/// @param whole  false if d was clamped
template <class Real>
int image_warnings(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, bool whole, const Real* d) {
  const bool outside = !whole || (!traits(image).proportional &&
                                  square_root(dot(d, d)) > depth_slack<Real> * trained_depth(image, node, d));
  return (outside ? PHN_WARNING_OUTSIDE : 0) | (node.incomplete ? PHN_WARNING_INCOMPLETE : 0);
}

template <class Real, class Response>
const Response& response_at(const ImageHeader<Real>& image, uint32_t offset, const Response*) {
  return *at<Response>(image, offset);
}

/// Calls f with the response of the node. @pre the image was checked
template <class Real, class Function>
auto with_response(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, Function&& f) {
  return with_response_type<Real>(image.family,
                                  [&](const auto* type) { return f(response_at(image, node.response, type)); });
}

template <class Real>
bool image_has_deformation(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node) {
  return image.output_nodes.n > 0 &&
         with_response(image, node, [](const auto& response) { return has_deformation(response); });
}

/// @param d  clamped. @pre image_has_deformation(image, node)
template <class Real>
void image_field_at(const ImageHeader<Real>& image, const image::ActiveNode<Real>& node, const Real* d, Real* scratch,
                    Real* field) {
  with_response(image, node, [&](const auto& response) { response_field(image, response, d, scratch, field); });
  const auto* moved = at<uint16_t>(image, node.prescribed);
  const Real* weight = at<Real>(image, node.prescribed_weight);
  for (uint32_t p = 0; p < node.prescribed.n; ++p) {
    for (uint32_t k = 0; k < 3; ++k) field[3 * moved[p] + k] = weight[p] * d[k];
  }
}

}  // namespace PHN_RUNTIME
