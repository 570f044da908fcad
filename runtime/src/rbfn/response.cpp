#include "rbfn/response.hpp"

#include "rbfn/network_kernels.hpp"

namespace PHN_RUNTIME {

void response_force(const Networks& nets, const double* d, double* force) {
  best_network_kernels().force(nets.force, d, force);
}

void response_basis(const phn_model&, const Networks& nets, const double* d, double* basis, double*) {
  best_network_kernels().of_inputs(nets.deformation, 0, d, basis);
}

void response_gradient(const phn_model&, const Networks& nets, const double* d, double* basis, double* gradient,
                       double*) {
  const Network& net = nets.deformation;
  const std::int32_t n = net.n_neurons;
  best_network_kernels().of_inputs(net, 0, d, basis);
  for (std::int32_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double y = (d[k] - net.input_center[k]) / net.input_half_range[k] - net.center[k][i];
      gradient[k * n + i] = -2 * y * net.inverse_square_spread / net.input_half_range[k] * basis[i];
    }
  }
}

void response_field(const phn_model& model, const Networks& nets, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field) {
  best_network_kernels().field(nets.deformation, model.n_output, prepared->gaussians, basis, share, scratch, field);
}

void prepare_response(const phn_model& model, const Networks& nets, PreparedNode& entry) {
  best_network_kernels().of_coordinates(nets.deformation, model.n_output, model.output_points, entry.gaussians);
}

void NetworkSum::add(std::int32_t output, const Matrix& map, LocalResponse& local) const {
  best_network_kernels().of_inputs(_net, 3, _model.output_points + 3 * static_cast<std::size_t>(output), _gaussian);
  for (std::int32_t i = 0; i < _net.n_neurons; ++i) {
    Vector u;
    for (int k = 0; k < 3; ++k)
      u[k] = _gaussian[i] * _net.output_half_range[k] * static_cast<double>(_net.weight[k][i]);
    const Vector sum = map * u;
    for (int k = 0; k < 3; ++k) local.rows[k * _net.n_neurons + i] += sum[k];
  }
  Vector constant;
  for (int k = 0; k < 3; ++k) constant[k] = _net.output_center[k] + _net.output_half_range[k] * _net.bias[k];
  local.constant += map * constant;
}

}  // namespace PHN_RUNTIME
