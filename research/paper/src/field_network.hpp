// A deformation network at all output nodes at once.
#pragma once

#include <phynness/formats/model.hpp>

namespace phynness::study {

/// (11)-(12) as the product that a Gaussian of (displacement, place) is: the factors of the places are a
/// table.
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
