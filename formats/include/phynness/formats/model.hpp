// The model as the host sees it: what training writes and model.txt holds. Grammar: formats/model.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

/// Gaussian network (11)-(12) on scaled inputs and outputs: scaled = (value - center) / half_range, in [-1, 1].
/// y_j = b_j + sum_i w_ij exp(-|x - c_i|^2 / spread^2).
struct RbfNetwork {
  Eigen::VectorXd input_center, input_half_range;    ///< n_inputs
  Eigen::VectorXd output_center, output_half_range;  ///< 3
  double spread = 1;                                 ///< in scaled inputs
  Eigen::MatrixXd centers;                           ///< n_neurons x n_inputs, scaled
  Eigen::MatrixXd weights;                           ///< n_neurons x 3
  Eigen::Vector3d bias{0, 0, 0};
};

/// One active node of the `rbfn` family.
struct ActiveNodeModel {
  std::int32_t node = 0;                ///< mesh node number
  std::vector<std::int32_t> prescribed; ///< nodes moved by the probe itself, with `prescribed_weight` (node probe: one, weight 1)
  std::vector<double> prescribed_weight;
  std::vector<double> trained_depth_m;  ///< per direction: last good increment; 0 if none
  RbfNetwork force;                     ///< d [m] -> force [N]
  RbfNetwork deformation;               ///< (d, X) [m] -> u [m]
};

struct Model {
  Family family = Family::rbfn;
  std::string title;
  std::string mesh_hash, physics_hash, software_version;
  std::vector<Vec3> directions;
  double max_displacement_m = 0;
  std::vector<std::int32_t> fixed, output;  ///< mesh node numbers, ascending
  std::vector<ActiveNodeModel> nodes;       ///< ascending by node
};

/// model.txt as one string. Bit-for-bit round trip: write(read(write(m))) == write(m).
std::string write_model_text(const Model& model);
/// @throws Error: truncated, corrupted (checksum), wrong version, malformed number: each its own message
Model read_model_text(const std::string& text, const std::string& source_name);

/// MODEL_DIR: exactly model.txt and mesh.txt. Written beside and renamed, so a reader never sees half of one.
void write_model_dir(const std::filesystem::path& dir, const Model& model, const Mesh& mesh);
struct ModelDir {
  Model model;
  Mesh mesh;
  std::string model_text, mesh_text;
};
/// @throws Error if a file is missing or the mesh is not the model's
ModelDir read_model_dir(const std::filesystem::path& dir);

}  // namespace phynness
