// What each tool does alone, and what that does at the places of all.
#pragma once

#include "coupled.hpp"

namespace PHN_RUNTIME {

/// Tools as the model knows them: one at a time, from the responses of the nodes that its point lies between.
class ToolResponses {
 protected:
  ToolResponses(const phn_model& model, Coupling& coupling) : _model(model), _c(coupling) {}

  std::size_t at(std::int32_t t, std::int32_t s, std::int32_t i) const {
    return 3 * (static_cast<std::size_t>(t) * static_cast<std::size_t>(_c.max_tools) + static_cast<std::size_t>(s)) +
           static_cast<std::size_t>(i);
  }
  std::size_t at(std::int32_t t, std::int32_t s) const { return at(t, s, 0) / 3; }
  const ActiveNode& node(const HeldPoint& point, std::int32_t i) const { return _model.active[point.active[i]]; }
  double* gradient_at_rest(std::int32_t s, std::int32_t i) const {
    return _c.rest_gradient + 3 * static_cast<std::size_t>(3 * s + i) * _model.n_basis;
  }
  double* node_basis(std::int32_t s, std::int32_t i) const {
    return _c.node_basis + static_cast<std::size_t>(3 * s + i) * _model.n_basis;
  }
  /// Whether what one tool does turns the body for the others.
  bool turns() const { return _c.n_sets > 1; }
  /// Place k of 2 n: the points, then how the surface turns around them.
  std::int32_t place(std::int32_t k) const { return k < _c.n_tools ? k : _c.max_tools + k - _c.n_tools; }
  std::int32_t n_places() const { return turns() ? 2 * _c.n_tools : _c.n_tools; }

  /// Force of tool s at p, and its response. @return energy
  double respond(std::int32_t s, const Vector& p);
  /// Everything about a tool that does not depend on its displacement.
  void prepare(std::int32_t s);
  /// How the surface turns around tool t's point under the nodes of the others; a tool's own rotation is not needed.
  /// @pre prepare of all tools
  void prepare_turn(std::int32_t t);
  /// Derivatives of all places by the p in the undeformed body.
  void set_rest_matrix();
  /// Derivatives of all places by the p of tool t, at the p of its latest response.
  void find_derivatives(std::int32_t t);
  /// Displacement or rotation of place t in the latest response of tool s.
  Vector displaced(std::int32_t t, std::int32_t s) const;
  /// Derivative of place t of 2 n by the p of tool s in the undeformed body. @pre set_rest_matrix
  Matrix rest_block(std::int32_t t, std::int32_t s) const;
  /// Adds to node i's part what moves tool s's point by `weight` r in the undeformed body.
  void move_at_rest(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis, Vector& own) const;

  const phn_model& _model;
  Coupling& _c;

 private:
  /// Node i's part of the derivatives of all places by the p of tool t.
  void add_derivatives(std::int32_t t, std::int32_t i);
  /// Derivative of a local response at rest.
  Matrix rest_response(const LocalResponse& local, std::int32_t n, const double* gradient) const;
  /// The mean displacement of up to three vertices.
  void prepare_local(const ActiveNode& by, std::int32_t n, const std::int32_t* vertices, const double* weight,
                     LocalResponse& local) const;
  void vertices_of(const HeldPoint& point, std::int32_t* vertex) const;
  /// Square root of the stiffness at rest, its inverse, and the compliance, all of a stiffness that resists
  /// everywhere.
  static void find_roots(HeldPoint& point);
  /// Contributions of tool s's nodes at p: node i's response through e_i, scaled to q_i; what is missing at
  /// the tool's own point is added as the undeformed body has it.
  void take_response(std::int32_t s);
  /// sum_i s_i E_i(e_i) of (p), 0 where there is none.
  double energy_of_nodes(const HeldPoint& point) const;
  /// Force and energy of tool s at its p, the force as gradient of
  ///   p . A p / 2 + sum_i s_i [E_i(e_i) - e_i . K_i e_i / 2] - sum_g w_g / x_g psi(x_g p),
  ///   psi(p) = sum_i s_i A p . z_i(M_i p),  z_i(e) = u_i(e) - u_i'(0) e at the point.
  /// the energy without the E_i.
  void pull(std::int32_t s);
  /// The part of node i in psi, at x p. @return w / x times it
  double pull_of_coupling(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x, double w);
};

}  // namespace PHN_RUNTIME
