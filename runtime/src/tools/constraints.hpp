// The points that tools touch, each with the weighted mean displacement that its tool prescribes, their responses in
// the undeformed body (equation (o) of docs/theory.md), and responses to each tool alone, at its own point and at those
// of the other tools, which follow from the responses of the nodes around its point.
#pragma once

#include "tools/coupled.hpp"

namespace PHN_RUNTIME {

class Constraints {
 protected:
  Constraints(const phn_model& model, Coupling& coupling) : _model(model), _c(coupling) {}

  std::size_t at(std::int32_t t, std::int32_t s, std::int32_t i) const {
    return static_cast<std::size_t>(_c.n_corners) * at(t, s) + static_cast<std::size_t>(i);
  }
  std::size_t at(std::int32_t t, std::int32_t s) const {
    return static_cast<std::size_t>(t) * static_cast<std::size_t>(_c.max_tools) + static_cast<std::size_t>(s);
  }
  const ActiveNode& node(const Constraint& point, std::int32_t i) const { return _model.active[point.active[i]]; }
  double* gradient_at_rest(std::int32_t s, std::int32_t i) const {
    return _c.rest_gradient + 3 * static_cast<std::size_t>(_c.n_corners * s + i) * _model.n_basis;
  }
  /// Whether rotations caused by one tool are taken into account for the others.
  bool turns() const { return _c.n_sets > 1; }
  /// Index of place k of 2 n: displacements of the points, then rotations of the surface around them.
  std::int32_t place(std::int32_t k) const { return k < _c.n_tools ? k : _c.max_tools + k - _c.n_tools; }
  std::int32_t n_places() const { return turns() ? 2 * _c.n_tools : _c.n_tools; }

  /// Computes the quantities of a tool that do not depend on its displacement.
  void prepare(std::int32_t s);
  /// Computes the rotation of the surface around tool t's point by the nodes of the other tools; the rotation by its
  /// own nodes is not needed.
  /// @pre prepare of all tools
  void prepare_turn(std::int32_t t);
  /// Derivatives of all places by the p in the undeformed body.
  void set_rest_matrix();
  /// Derivative of place t of 2 n by the p of tool s in the undeformed body. @pre set_rest_matrix
  Matrix rest_block(std::int32_t t, std::int32_t s) const;
  /// Adds `weight` times node i's part of the response of the undeformed body that moves tool s's point.
  /// @param r    displacement of the point [m]
  /// @param own  see Constraint::response_own
  void move_at_rest(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis, Vector& own) const;

  double* response_basis(std::int32_t s, std::int32_t i) const {
    return _c.response_basis + static_cast<std::size_t>(_c.n_corners * s + i) * _model.n_basis;
  }

  /// Computes force and response of tool s at p. @return energy
  double respond(std::int32_t s, const Vector& p);
  /// Derivatives of all places by the p of tool t, at the p of its latest response.
  void find_derivatives(std::int32_t t);
  /// Displacement or rotation of place t in the latest response of tool s.
  Vector displaced(std::int32_t t, std::int32_t s) const;

  const phn_model& _model;
  Coupling& _c;

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
  /// Derivative of a local response at rest.
  Matrix rest_response(const NodeField& local, std::int32_t n, const double* gradient) const;
  /// The mean displacement of the vertices of several active nodes.
  void prepare_field(const ActiveNode& by, std::int32_t n, const std::int32_t* active, const double* weight,
                     NodeField& local) const;
};

}  // namespace PHN_RUNTIME
