// Evaluation of images in place. Each family has a type of response (image_layout.hpp) and, in a file of its name,
// overloads of these functions:
//
//   response_force, response_energy, response_stiffness   of one node
//   response_field                                        its field; false: it has forces only
//
// They take most of the time. Others are optimized for size where that costs little, by the attribute `cold`.
#pragma once

#include "image/linear_response.hpp"
#include "image/modal_response.hpp"
#include "image/rbfn_response.hpp"

namespace PHN_IMAGES {

/// Calls f with a null pointer to the type of a response. No other place distinguishes the families of images.
template <class Function>
PHN_INLINE auto with_response_type(Family family, Function&& f) {
  if (family == RbfnResponse::family) return f(static_cast<const RbfnResponse*>(nullptr));
  if (family == LinearResponse::family) return f(static_cast<const LinearResponse*>(nullptr));
  return f(static_cast<const ModalResponse*>(nullptr));
}

template <class Response>
constexpr schema::FamilyTraits traits_of(const Response*) {
  constexpr schema::FamilyTraits found = schema::traits(Response::family);
  return found;
}

/// Traits of the family as constants in the code. Position-independent code would access a table through a global
/// offset table in memory, which a device without an operating system does not initialize.
inline schema::FamilyTraits traits(const Header& image) {
  return with_response_type(image.family, [](const auto* type) { return traits_of(type); });
}

template <class Response>
const Response& response_at(const Header& image, uint32_t offset, const Response*) {
  return *at<Response>(image, offset);
}

/// Null: the image has none.
inline const image::Surface* surface_of(const Header& image) {
  const uint32_t found = at<image::Provenance>(image, image.provenance)->surface;
  return found == 0 ? nullptr : at<image::Surface>(image, found);
}

/// The node at a position; null: a linear point, which has no field and no trained depth. Active nodes come first.
inline const ActiveNode* active_node(const Header& image, uint32_t position) {
  return position < image.active_nodes.n ? at<ActiveNode>(image, image.active) + position : nullptr;
}

/// Calls f with the response at a position; the stiffness of a linear point is the start of a LinearResponse.
/// @pre the image was checked
template <class Function>
PHN_INLINE auto with_response(const Header& image, uint32_t position, Function&& f) {
  const ActiveNode* node = active_node(image, position);
  const uint32_t linear = position - image.active_nodes.n;
  const uint32_t offset =
      node != nullptr ? node->response : surface_of(image)->rest_stiffness.at + 6 * uint32_t{sizeof(Real)} * linear;
  return with_response_type(node != nullptr ? image.family : Family::linear,
                            [&](const auto* type) { return f(response_at(image, offset, type)); });
}

/// A result, as the number of its components.
enum Quantity : int { Force = 3, Energy = 1, Stiffness = 9 };

/// @tparam n  Force, Energy or Stiffness
/// @param d  clamped, also in the functions below
template <int n>
[[gnu::noinline]] void respond(const Header& image, uint32_t position, const Real* d, Real* out) {
  with_response(image, position, [&](const auto& response) {
    if constexpr (n == Force) response_force(image, response, d, out);
    if constexpr (n == Energy) *out = response_energy(image, response, d);
    if constexpr (n == Stiffness) response_stiffness(image, response, d, out);
  });
}

[[gnu::noinline]] inline Real trained_depth(const Header& image, uint32_t position, const Real* d) {
  const ActiveNode* node = active_node(image, position);
  if (node == nullptr) return 0;
  return depth_along(at<Real>(image, image.directions), at<Real>(image, node->trained_depth),
                     static_cast<int32_t>(node->trained_depth.n), d, square_root(dot(d, d)), image.max_displacement);
}

/// @param is_unclamped  false if d was clamped
inline int warnings(const Header& image, uint32_t position, bool is_unclamped, const Real* d) {
  const ActiveNode* node = active_node(image, position);
  const bool outside =
      !is_unclamped ||
      (!traits(image).proportional &&
       (node == nullptr || square_root(dot(d, d)) > depth_slack<Real> * trained_depth(image, position, d)));
  return (outside ? PHN_WARNING_OUTSIDE : 0) | (node != nullptr && node->incomplete ? PHN_WARNING_INCOMPLETE : 0);
}

}  // namespace PHN_IMAGES
