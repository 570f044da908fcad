// The points that tools touch, each with the weighted mean displacement that its tool prescribes, and their responses
// in the undeformed body (equation (o) of docs/theory.md).
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

  const phn_model& _model;
  Coupling& _c;

 private:
  /// Derivative of a local response at rest.
  Matrix rest_response(const NodeField& local, std::int32_t n, const double* gradient) const;
  /// The mean displacement of the vertices of several active nodes.
  void prepare_field(const ActiveNode& by, std::int32_t n, const std::int32_t* active, const double* weight,
                     NodeField& local) const;
};

}  // namespace PHN_RUNTIME
