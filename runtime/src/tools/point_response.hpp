// Responses to each tool alone, at its own point and at the points of the other tools.
#pragma once

#include "tools/constraints.hpp"

namespace PHN_RUNTIME {

/// Response to one tool at a time, computed from the responses of the nodes around its point.
class PointResponses : protected Constraints {
 protected:
  using Constraints::Constraints;

  double* response_basis(std::int32_t s, std::int32_t i) const {
    return _c.response_basis + static_cast<std::size_t>(_c.n_corners * s + i) * _model.n_basis;
  }

  /// Computes force and response of tool s at p. @return energy
  double respond(std::int32_t s, const Vector& p);
  /// Derivatives of all places by the p of tool t, at the p of its latest response.
  void find_derivatives(std::int32_t t);
  /// Displacement or rotation of place t in the latest response of tool s.
  Vector displaced(std::int32_t t, std::int32_t s) const;

 private:
  /// Adds node i's part of the derivatives of all places by the p of tool t.
  void add_derivatives(std::int32_t t, std::int32_t i);
  /// Contributions of tool s's nodes at p: node i's response at e_i, scaled to q_i. The remaining displacement of the
  /// tool's point is added as in the undeformed body.
  void take_response(std::int32_t s);
  /// sum_i s_i E_i(e_i) at p; 0 in families without energy.
  double energy_of_nodes(const Constraint& point) const;
  /// Force and energy of tool s at its p. The force is the gradient of
  ///   p . A p / 2 + sum_i s_i [E_i(e_i) - e_i . K_i e_i / 2] - sum_g w_g / x_g psi(x_g p),
  ///   psi(p) = sum_i s_i A p . z_i(M_i p),  z_i(e) = u_i(e) - u_i'(0) e at the point.
  /// The energy is computed without the E_i.
  void pull(std::int32_t s);
  /// The part of psi that belongs to node i, at x p. @return w / x times this part
  double pull_of_coupling(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x, double w);
};

}  // namespace PHN_RUNTIME
