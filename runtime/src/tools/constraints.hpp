// The points that tools touch, each with the weighted mean displacement that its tool prescribes, their responses in
// the undeformed body (equation (o) of docs/theory.md), and responses to each tool alone, at its own point and at those
// of the other tools, which follow from the responses of the nodes around its point.
#pragma once

#include "tools/coupled.hpp"

namespace PHN_RUNTIME {

class Constraints {
 protected:
  Constraints(const phn_model& model, Coupling& coupling) : _model(model), _c(coupling) {}

  const ActiveNode& node(const Constraint& point, std::int32_t i) const { return _model.active[point.active[i]]; }
  /// Whether rotations by one tool are taken into account for the others.
  bool has_rotations() const { return _c.n_sets > 1; }
  /// The k-th quantity of 2 n_tools: displacements of the points, then rotations of the surface around them.
  std::int32_t quantity(std::int32_t k) const { return k < _c.n_tools ? k : _c.max_tools + k - _c.n_tools; }
  std::int32_t n_quantities() const { return has_rotations() ? 2 * _c.n_tools : _c.n_tools; }

  /// Computes the quantities of a tool that do not depend on its displacement.
  void prepare(std::int32_t s);
  /// Computes the rotation of the surface around tool t's point by the nodes of the other tools; the rotation by its
  /// own nodes is not needed.
  /// @pre prepare of all tools
  void prepare_rotation(std::int32_t t);
  /// Sets the derivatives of all quantities by the p in the undeformed body.
  void set_rest_matrix();
  /// Derivative of the t-th quantity by the p of tool s in the undeformed body. @pre set_rest_matrix
  Matrix rest_block(std::int32_t t, std::int32_t s) const;
  /// Adds `weight` times node i's part of the response of the undeformed body that moves tool s's point.
  /// @param r             displacement of the point [m]
  /// @param displacement  see Constraint::response_displacement
  void add_rest_response(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis,
                         Vector& displacement) const;

  /// Computes force and response of tool s at p. @return energy
  double respond(std::int32_t s, const Vector& p);
  /// Computes the derivatives of all quantities by the p of tool t, at the p of its latest response.
  void find_derivatives(std::int32_t t);
  /// Quantity t in the latest response of tool s.
  Vector response_at(std::int32_t t, std::int32_t s) const;

  const phn_model& _model;
  Coupling& _c;

 private:
  /// Adds node i's part of the derivatives of all quantities by the p of tool t.
  void add_derivatives(std::int32_t t, std::int32_t i);
  /// Computes the contributions of tool s's nodes at p: node i's response at e_i, scaled to q_i. The remaining
  /// displacement of the tool's point is added as in the undeformed body.
  void set_response(std::int32_t s);
  /// sum_i s_i E_i(e_i) at p; 0 in families without energy.
  double energy_of_nodes(const Constraint& point) const;
  /// Computes force and energy of tool s at its p. The force is the gradient of
  ///   p . A p / 2 + sum_i s_i [E_i(e_i) - e_i . K_i e_i / 2] - sum_g w_g / x_g psi(x_g p),
  ///   psi(p) = sum_i s_i A p . z_i(M_i p),  z_i(e) = u_i(e) - u_i'(0) e at the point.
  /// where g are the points x_g of a quadrature with weights w_g. The energy is computed without the E_i.
  void set_force(std::int32_t s);
  /// Adds the force of node i's part of psi at a quadrature point x with weight w. @return w / x times this part
  double add_coupling_force(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x, double w);
  /// Derivative of a local response at rest.
  Matrix rest_response(const NodeField& local, std::int32_t n, const double* gradient) const;
  /// The mean displacement of the vertices of several active nodes.
  void prepare_field(const ActiveNode& by, std::int32_t n, const std::int32_t* active, const double* weight,
                     NodeField& local) const;
};

}  // namespace PHN_RUNTIME
