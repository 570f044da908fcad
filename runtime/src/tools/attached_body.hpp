// A reduced body that answers for coupled tools in place of the model (src/body/attach.cpp).
#pragma once

#include <phynness/phynness_body.h>

#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Functions, so that a program without bodies does not link them.
struct AttachedBody {
  const phn_body* body;  ///< null: none
  phn_body_state* state;
  std::int32_t steps;  ///< of each phn_body_press, at most
  std::int32_t used;   ///< by the last one

  decltype(phn_body_press)* press;
  decltype(phn_body_bound)* bound;
  /// Displacements of nodes of the mesh, n x 3. @pre all are nodes of the body. @return the last status
  int (*deform)(const AttachedBody&, std::int32_t n, const std::int32_t* nodes, double* out);
  /// Mean displacement under a tool [m]; zeros where that is not defined.
  void (*displacement)(const AttachedBody&, const phn_tool&, double*);
  /// Of one of the tools of the last press, with the others held [N/m].
  Matrix (*stiffness)(const AttachedBody&, std::int32_t tool);
};

}  // namespace PHN_RUNTIME
