// The field of several tools: sums of responses of their nodes, in sets that are each turned as a whole.
#pragma once

#include "tools/point_response.hpp"

namespace PHN_RUNTIME {

class CoupledField : protected PointResponses {
 protected:
  CoupledField(const phn_model& model, Coupling& coupling, const Vector* targets)
      : PointResponses(model, coupling), _targets(targets) {}

  void clear_field();
  /// Adds to the field `weight` times the latest response of tool s.
  void add_response(std::int32_t set, std::int32_t s, double weight);
  /// Adds to the field `weight` times the response of the undeformed body that moves tool s's point.
  /// @param r  displacement of the point [m]
  void add_at_rest(std::int32_t set, std::int32_t s, const Vector& r, double weight);
  /// right = targets minus displacements of the points in the field. @return the largest distance
  double constraint_residual();
  /// Whether forces and field are finite.
  bool finite() const;

  const Vector* _targets;

 private:
  FieldPart& field(std::int32_t set, std::int32_t s, std::int32_t i) const { return _c.field[at(set, s, i)]; }
  double* field_basis(std::int32_t set, std::int32_t s, std::int32_t i) const {
    return _c.field_basis + at(set, s, i) * _model.n_basis;
  }
  std::size_t basis_of_set() const { return static_cast<std::size_t>(_c.n_corners * _c.n_tools) * _model.n_basis; }
};

}  // namespace PHN_RUNTIME
