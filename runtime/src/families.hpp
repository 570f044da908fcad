// The one place where the runtime tells families apart. A family is a response of a node: a type, and overloads of
//
//   response_force, response_energy, response_stiffness   of one node
//   has_deformation, basis_size                           whether the node has a basis, and how large
//   response_basis, response_gradient, response_field     the basis at a displacement, its derivatives, the field of a
//   basis worth_preparing, prepare_response                     what a deformation needs that does not depend on the
//   displacement vertex_sum                                            sums what vertices do (local_response.hpp)
//
// in a folder of its own.
#pragma once

#include "linear/response.hpp"
#include "modal/response.hpp"
#include "rbfn/response.hpp"

namespace PHN_RUNTIME {

/// f(response of the node)
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
