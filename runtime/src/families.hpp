// The only place where the runtime distinguishes families. Each family has a folder with the type of a node's response
// and overloads of these functions:
//
//   response_force, response_energy, response_derivatives of one node: force, energy, and force with any of both and
//                                                         stiffness
//   has_deformation, basis_size                           whether the node has a basis, and its size
//   response_basis, response_gradient                     the basis at a displacement, and its derivatives
//   response_field                                        the field of a basis
//   worth_preparing, prepare_response                     parts of a deformation that are independent of d
//   vertex_sum                                            sums of displacements of vertices (local_response.hpp)
#pragma once

#include "linear/response.hpp"
#include "modal/response.hpp"
#include "rbfn/response.hpp"

namespace PHN_RUNTIME {

/// Calls f with the node's response in the type of its family.
template <class Function>
PHN_INLINE decltype(auto) with_response(const phn_model& model, const ActiveNode& node, Function&& f) {
  switch (model.family) {
    case Family::rbfn:
      return f(*node.networks);
    case Family::linear:
      return f(*node.linear);
    case Family::modal:
      break;
  }
  return f(*node.modal);
}

}  // namespace PHN_RUNTIME
