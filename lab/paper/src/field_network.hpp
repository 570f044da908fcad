// A deformation network evaluated at all output nodes.
#pragma once

#include <phynness/formats/model.hpp>

namespace phynness::study {

/// (11)-(12) as a product, because a Gaussian of (displacement, place) is the product of two factors. The factors of
/// the places are stored in a table.
class FieldNetwork {
 public:
  /// @param network  of six inputs; @param places  n x 3 [m]
  FieldNetwork(const RbfNetwork& network, const Points& places);
  /// n x 3 [m]
  Points field(const Vec3& displacement_m) const;

 private:
  const RbfNetwork& _network;
  Eigen::MatrixXd _places;  ///< n x neurons
};

}  // namespace phynness::study
