// Units of the dimensionless solver: lengths in units of the body's size, moduli in units of the shear modulus.
// Therefore the same scene in other units takes the same steps, and force and pressure rows of a residual have
// comparable sizes in a norm.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

struct Scaling {
  double length_m = 1, modulus_Pa = 1;

  double force_N() const { return modulus_Pa * length_m * length_m; }
  double energy_J() const { return force_N() * length_m; }
  double stiffness_N_per_m() const { return modulus_Pa * length_m; }

  /// Length: diagonal of the bounding box. Modulus: shear modulus at rest.
  static Scaling of(const Mesh& mesh, const Material& material) {
    const Eigen::RowVector3d extent = mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff();
    return {extent.norm(), material.shear_modulus_Pa};
  }
};

}  // namespace phynness
