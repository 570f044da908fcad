#include "force_curves.hpp"

namespace phynness::study {

void measure_curves(ProbeSolver& solver, const NodeUnderStudy& node, const NamedOrgan& ours, const Vec3& inward,
                    double deepest_m, const StudySizes& sizes, NodeMeasurements& out) {
  solver.touch({out.node});
  const Eigen::Vector3d direction(inward[0], inward[1], inward[2]);
  const Eigen::Matrix3d stiffness = solver.rest().stiffness_N_per_m;
  out.stiffness_N_per_m = direction.dot(stiffness * direction);
  std::vector<NetworkFit> fits;
  for (const int neurons : sizes.curve_neurons) fits.push_back(fit_force(node, neurons));
  std::vector<double> depths;
  for (int i = 1; i <= sizes.curve_points; ++i) depths.push_back(deepest_m * i / sizes.curve_points);
  auto& curves = out.curves;
  curves.networks.resize(fits.size());
  solver.follow({inward}, depths, false, [&](std::size_t i, const Response& response) {
    if (response.status != Status::converged) return false;
    const auto along = [&](const Vec3& f) { return f[0] * direction[0] + f[1] * direction[1] + f[2] * direction[2]; };
    const double s = depths[i];
    curves.depth_m.push_back(s);
    curves.finite_elements.push_back(along(response.force_N[0]));
    curves.linear.push_back(s * out.stiffness_N_per_m);
    curves.ours.push_back(along(ours.force(out.node, {s * inward[0], s * inward[1], s * inward[2]})));
    for (std::size_t f = 0; f < fits.size(); ++f)
      curves.networks[f].push_back(evaluate(fits[f].network, s * direction).dot(direction));
    return true;
  });
}

}  // namespace phynness::study
