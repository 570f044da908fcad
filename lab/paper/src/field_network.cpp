#include "field_network.hpp"

namespace phynness::study {
namespace {

Eigen::RowVectorXd scaled(const RbfNetwork& network, const Eigen::RowVector3d& inputs, Eigen::Index first) {
  return (inputs - network.input_center.segment(first, 3).transpose())
      .cwiseQuotient(network.input_half_range.segment(first, 3).transpose());
}

}  // namespace

FieldNetwork::FieldNetwork(const RbfNetwork& network, const Points& places)
    : _network(network), _places(places.rows(), network.centers.rows()) {
  const double s = 1 / (network.spread * network.spread);
  for (Eigen::Index p = 0; p < places.rows(); ++p)
    _places.row(p) =
        (-s *
         (network.centers.rightCols(3).rowwise() - scaled(network, places.row(p), 3)).rowwise().squaredNorm().array())
            .exp()
            .transpose();
}

Points FieldNetwork::field(const Vec3& d) const {
  const auto& net = _network;
  const double s = 1 / (net.spread * net.spread);
  const Eigen::VectorXd factor =
      (-s * (net.centers.leftCols(3).rowwise() - scaled(net, Eigen::RowVector3d(d[0], d[1], d[2]), 0))
                .rowwise()
                .squaredNorm()
                .array())
          .exp();
  Eigen::MatrixXd out = _places * (factor.asDiagonal() * net.weights);
  out.rowwise() += net.bias.transpose();
  return (out * net.output_half_range.asDiagonal()).rowwise() + net.output_center.transpose();
}

}  // namespace phynness::study
