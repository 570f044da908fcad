// The model of training and of model.txt on the host. Grammar: formats/model.md.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <phynness/formats/described.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/schema/bounds.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Gaussian network, equations (11)-(12), y_j = b_j + sum_i w_ij exp(-|x - c_i|^2 / spread^2), with scaled inputs and
/// outputs: scaled = (value - center) / half_range, in [-1, 1].
struct RbfNetwork {
  Eigen::VectorXd input_center, input_half_range;    ///< n_inputs
  Eigen::VectorXd output_center, output_half_range;  ///< 3
  double spread = 1;                                 ///< in scaled inputs
  /// Every center is a training point: a prescribed displacement (row of Model::displacements) and, in deformation
  /// networks, an output node (position in Model::output). n_neurons each; `center_output` is empty in force networks.
  /// The file contains these indices; fill_centers computes `centers` from them.
  std::vector<std::int32_t> center_displacement, center_output;
  Eigen::MatrixXd centers;  ///< n_neurons x n_inputs, scaled
  Eigen::MatrixXd weights;  ///< n_neurons x 3
  Eigen::Vector3d bias{0, 0, 0};
};

/// Response of a linear body at one active node, exact at any depth: force = stiffness d, energy = d . stiffness d / 2,
/// u = d_x U_x + d_y U_y + d_z U_z with the unit responses U.
struct LinearResponse {
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  ///< [N/m], bitwise symmetric
  /// n_output x 9 [m/m]: columns 3 k ... 3 k + 2 are the displacement (x, y, z) of the output node per metre of
  /// prescribed displacement along axis k.
  Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> unit_responses;
};

/// Force of one active node as the gradient of a potential, so that closed paths do no work. With x = d / R,
/// R = max_displacement_m, and the kernel Phi(y) = q I + y y^T / q, q = sqrt(|y|^2 + shape^2), which is the Hessian of
/// q^3 / 3,
///   force = K d + sum_i [Phi(x - c_i) - Phi(x) - Phi(c_i) + Phi(0)] b_i.
struct ConservativeNetwork {
  double shape = 0.1;                                   ///< dimensionless, in units of R
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  ///< K [N/m], bitwise symmetric; dominates at large |d|
  std::vector<std::int32_t> centers;                    ///< rows of Model::displacements; c_i = row / R
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> coefficients;  ///< b_i [N], one row per center
};

/// A matrix of 16-bit integers with a factor for each column: value(r, c) = scale[c] * entries(r, c). The rounding
/// error is at most 1 / 65534 of a column's largest value.
struct ScaledTable {
  Eigen::VectorXd scale;  ///< per column, >= 0
  Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> entries;

  Eigen::Index rows() const { return entries.rows(); }
  Eigen::Index cols() const { return entries.cols(); }
  Eigen::MatrixXd values() const { return entries.cast<double>() * scale.asDiagonal(); }
};
/// Rounds to nearest. @pre all values are finite
ScaledTable scaled_table(const Eigen::MatrixXd& values);

/// The part of the deformations that all active nodes of a modal model share.
struct SharedModes {
  ScaledTable modes;                  ///< 3 n_output x n_shared: row 3 o + k is component k at output node o
  std::vector<std::int32_t> centers;  ///< of the amplitudes; rows of Model::displacements
  double shape = 0.3;                 ///< of the amplitudes' kernel, in units of max_displacement_m
};

/// Deformation of one active node: amplitudes a(x), x = d / R, of its own modes. With q(y) = sqrt(|y|^2 + shape^2),
///   a = sum_i w_i [q(x - c_i) - q(x) - q(c_i) + q(0)] + w_x x_x + w_y x_y + w_z x_z   [m],
/// so a(0) = 0; u = near_modes a at the nodes of `near`, and u = shared modes (mixing a) elsewhere.
struct ModalDeformation {
  ScaledTable weights;             ///< (n_centers + 3) x n_modes: w_i, then w_x, w_y, w_z [m]
  ScaledTable mixing;              ///< n_shared x n_modes
  std::vector<std::int32_t> near;  ///< positions in Model::output with modes of their own, ascending
  ScaledTable near_modes;          ///< 3 n_near x n_modes
};

/// The part of a scalar field that all active nodes of a modal model share. Each active node has a ModalDeformation for
/// the field, with one row for each output node instead of three, and with six further weights: with e_jk(x) = x_j x_k
/// |x|^(degree - 2), which is 0 at x = 0,
///   a = (as above) + w_xx e_xx + w_xy e_xy + w_xz e_xz + w_yy e_yy + w_yz e_yz + w_zz e_zz,   field = max(0, scale u).
struct FieldModes {
  std::string name, unit;  ///< words of 1 to 40 visible ASCII characters
  int degree = 1;          ///< power of the displacement with which the field grows near rest, 1 or 2
  double scale = 1;        ///< [unit]; unit of the tables
  ScaledTable modes;       ///< n_output x n_shared
};

/// A level of a network: bias and weights for its first neurons. Centers, scales and spread are those of the network.
struct FirstNeurons {
  Eigen::MatrixXd weights;  ///< n_neurons x 3
  Eigen::Vector3d bias{0, 0, 0};
};

/// Response of an active node at a smaller level. Families as in ActiveNodeModel.
struct LevelResponse {
  FirstNeurons force, deformation;   ///< rbfn
  ConservativeNetwork conservative;  ///< modal; at most as many centers as the full network
  ScaledTable weights;               ///< modal: (centers of the level + 3) x modes, for the first modes of the node
  std::vector<ScaledTable> field_weights;  ///< of each field, (centers of the level + 9) x modes
};

/// A level of a model: smaller networks that are fitted separately, or the full networks.
struct ModelLevel {
  /// Medians over the active nodes of the mean leave-one-out error at the trained displacements, as a fraction of each
  /// node's largest force or displacement; 0: not estimated.
  double error_force = 0, error_displacement = 0;
  std::vector<std::int32_t> centers;  ///< modal, smaller levels: of the amplitudes, as SharedModes::centers
};
using schema::largest_level_count;

/// The finite elements with which forces are compared, by ModelBound::reference: those of the training; Taylor-Hood
/// elements on the same mesh; those of the training on cells of half the size.
inline constexpr std::array reference_names{"scene", "taylor-hood", "half-size"};
static_assert(reference_names.size() == schema::n_bound_references + 1);

/// How the bounds of the force's error were calibrated (formats/model.md, Bounds).
struct ModelBound {
  double coverage = 0;  ///< share of random displacements inside the range whose error is below the bound
  std::int32_t n_rays = 0, n_nodes = 0;  ///< of the calibration
  std::int32_t reference = 0;            ///< with what forces are compared, of reference_names
  /// The reference behind "the error of the force": " from taylor-hood elements on the same mesh"; empty for 0.
  std::string from() const;
  /// Coefficients of one tool between nodes.
  Eigen::Matrix<double, schema::n_coupled_terms, 1> between = {schema::no_coupled_bound, 0, 0, 0};
};

/// What the finite elements solved, of a model that was trained on a database.
struct SolvedBody {
  bool is_recorded = false;
  std::string element;
  double shear_modulus_Pa = 0;  ///< at rest
  static void describe(auto& result, auto&& see) { PHYNNESS_SEE(element, shear_modulus_Pa); }
};

/// A figure that is undefined unless it is known; one that is read is written in any case.
inline double if_known(bool known, const double& value) { return known ? value : undefined; }
inline double& if_known(bool, double& value) { return value; }

/// Errors at some of the places of a check.
struct DistancePart {
  std::int32_t places = 0;  ///< without any the errors are 0, in JSON null
  double mean = 0, p95 = 0;
  static void describe(auto& result, auto&& see) {
    PHYNNESS_SEE(places);
    see("mean", if_known(result.places > 0, result.mean));
    see("p95", if_known(result.places > 0, result.p95));
  }
};

/// Distance of the scene's finite elements from a finer solution (`phynness check`). Errors of a probe: the difference
/// of the forces at the largest displacement that both solve, over the size of the finer one. That is the force of the
/// reference, changed as cells of half the size and the scene's own surface change the stiffness at rest.
struct FinerDistance {
  bool is_measured = false;
  std::string element, reference;          ///< names: of the scene's element; of reference_names
  std::int32_t probes = 0;                 ///< that both have solved; without any the errors are 0, in JSON null
  double tool_radius_m = 0;                ///< of the round tool of these probes, which may stand for single nodes
  double mean = 0, p95 = 0;                ///< of the errors
  std::int32_t nodes = 0;                  ///< of the mesh of the finer solution; 0: not recorded, nor is `solved`
  std::int32_t solved = 0;                 ///< probes of the finer solution, with those that failed
  bool has_parts = false;                  ///< the following are recorded
  DistancePart near_fixed{}, elsewhere{};  ///< probes nearer than the tool's radius to a fixed node, and the others
  /// Steps of the stiffness at rest, if they are compared: to Taylor-Hood on the same mesh, to cells of half the size,
  /// to the scene's own surface (0 if it is that of the mesh).
  DistancePart element_at_rest{}, cells_at_rest{}, shape_at_rest{};
  DistancePart of_reference{};  ///< what the error of the reference itself is, if cells are compared
  double unknowns_factor = 0;   ///< unknowns of the reference over those of the scene
  double force_ratio = 0;       ///< mean size of the probes' forces over that of the finer ones; 0: not recorded
  /// The parts in the order of the file.
  const DistancePart& part(std::int32_t i) const { return this->*parts[i]; }
  DistancePart& part(std::int32_t i) { return this->*parts[i]; }
  static void describe(auto& result, auto&& see) {
    PHYNNESS_SEE(element, reference, probes, tool_radius_m);
    see("mean", if_known(result.probes > 0, result.mean));
    see("p95", if_known(result.probes > 0, result.p95));
    PHYNNESS_SEE(nodes, solved, near_fixed, elsewhere, element_at_rest, cells_at_rest, shape_at_rest, of_reference);
    PHYNNESS_SEE(unknowns_factor);
    see("force_ratio", if_known(result.force_ratio > 0, result.force_ratio));
  }
  /// "4.1 % on average, below 9.3 % in 95 %, at 20 probes of a round tool of 30.0 mm radius. The finer ...".
  std::string sentence() const;

 private:
  static constexpr DistancePart FinerDistance::*parts[] = {
      &FinerDistance::near_fixed,    &FinerDistance::elsewhere,     &FinerDistance::element_at_rest,
      &FinerDistance::cells_at_rest, &FinerDistance::shape_at_rest, &FinerDistance::of_reference};
};

using schema::largest_coordinate;
using schema::largest_field_count;
using schema::largest_linear_entry;
using schema::largest_mode_count;

/// One active node. Only the responses of the model's family are set.
struct ActiveNodeModel {
  std::int32_t node = 0;    ///< mesh node number
  Vec3 point{0, 0, 0};      ///< its reference coordinates [m]
  bool moves_mean = false;  ///< the weighted mean of the nodes moves by d; otherwise each node by its weight times d
  std::vector<std::int32_t> prescribed;  ///< nodes that the tool moves (node probe: one node, weight 1)
  std::vector<double> prescribed_weight;
  std::vector<double> trained_depth_m;   ///< per direction: last converged increment; 0 if none
  std::int32_t n_incomplete = 0;         ///< requested directions that did not reach the largest displacement
  RbfNetwork force;                      ///< rbfn: d [m] -> force [N]
  RbfNetwork deformation;                ///< rbfn: (d, X) [m] -> u [m]
  LinearResponse linear;                 ///< linear
  ConservativeNetwork conservative;      ///< modal: d [m] -> force [N], energy [J], stiffness [N/m]
  ModalDeformation modal;                ///< modal: d [m] -> u [m]; without modes the model has forces only
  std::vector<ModalDeformation> fields;  ///< one for each of Model::fields
  std::vector<LevelResponse> levels;     ///< of the smaller levels, in the order of Model::levels
  /// One for each of Model::bounds [N]: one column, rows as Model::displacements.
  std::vector<ScaledTable> bounds;
};

/// A point of the surface that was not probed. It answers as the body at rest: force = stiffness d, energy = d .
/// stiffness d / 2, and u = near_modes d at the nodes of `near`, and u = rest_modes (mixing d) elsewhere.
struct LinearPoint {
  std::int32_t node = 0;                                ///< mesh node number
  Vec3 point{0, 0, 0};                                  ///< its reference coordinates [m]
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  ///< [N/m], bitwise symmetric
  ScaledTable mixing;                                   ///< n_rest_modes x 3
  std::vector<std::int32_t> near;                       ///< positions in Model::output, ascending
  ScaledTable near_modes;                               ///< 3 n_near x 3
};

struct Model {
  Family family{};
  std::string title;
  std::string mesh_hash, physics_hash, software_version;
  std::vector<Vec3> directions;
  double max_displacement_m = 0;
  Points displacements;  ///< n_directions * n_increments x 3 [m], row direction * n_increments + increment
  std::int32_t n_mesh_nodes = 0;
  std::vector<std::int32_t> fixed, output;  ///< mesh node numbers, ascending
  Points fixed_points;                      ///< n_fixed x 3 [m], reference coordinates of the fixed nodes
  Points output_points;                     ///< n_output x 3 [m], reference coordinates of the output nodes
  Triangles surface;                        ///< mesh node numbers, each output or fixed; normals outward
  SharedModes shared;                       ///< modal
  std::vector<FieldModes> fields;           ///< modal; empty unless the database has fields
  std::vector<ModelLevel> levels;  ///< empty, or 2 to largest_level_count; the last is the full model; not linear
  std::vector<ModelBound> bounds;  ///< empty, or one: of the force; not linear
  SolvedBody solved;               ///< if it is recorded
  Relaxation relaxation;
  FinerDistance finer;                     ///< if it is measured
  std::vector<ActiveNodeModel> nodes;      ///< ascending by node
  std::vector<LinearPoint> linear_points;  ///< of round tools on the rest of the surface, ascending by node
  ScaledTable rest_modes;                  ///< 3 n_output x n_rest_modes: shared by the linear points
  /// Triangles of positions in `nodes`; those that also have linear points, whose positions follow those of `nodes`;
  /// and rows of node, triangle (of both lists, one after the other), weight of its first corner, and part of the rest
  /// that its second has, in parts of schema::whole_weight. Empty unless tools are answered from other nodes than those
  /// of their triangle.
  Triangles probe_triangles, outer_triangles;
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor> covered;
};

/// Nodes of the surface that active nodes alone answer: these, and those that are covered between them. Ascending.
std::vector<std::int32_t> probed_nodes(const Model& model);

/// Of a scene as a model or a body has it, with its length.
Relaxation carried_relaxation(const Scene& scene);

struct DatabaseHeader;
/// A model with all properties that follow from the database alone. Tried displacements and active nodes are not set.
Model model_of_database(const DatabaseHeader& header, Family family, const std::string& title);

/// Computes network.centers from its indices: (value - input_center) / input_half_range for each column. One
/// subtraction and one division give the same bits in every IEEE 754 reader.
/// @pre input_center and input_half_range are set, and the indices are within the model's tables
void fill_centers(const Model& model, RbfNetwork& network);

/// Text of model.txt. Writing is exact: write(read(write(m))) == write(m).
/// @throws Error (failure) if the format cannot represent the model: unknown family, inconsistent counts, NaN,
/// infinity, or a stiffness that is not symmetric
std::string write_model_text(const Model& model);
/// @throws Error (input) if the text is truncated, corrupted (checksum), of another version, or malformed (with the
/// line)
Model read_model_text(const std::string& text, const std::string& source_name);

/// Writes MODEL_DIR, which contains model.txt and mesh.txt. They are written to temporary files and renamed, so that a
/// reader never sees an incomplete file.
/// @throws Error (input) if the directory cannot be made, (failure) if writing fails
void write_model_dir(const std::filesystem::path& dir, const Model& model, const Mesh& mesh);
struct ModelTexts {
  std::string model, mesh;
};
/// As write_model_dir(). @pre the mesh is that of the model
void write_model_texts(const std::filesystem::path& dir, const ModelTexts& texts);
/// @throws Error (input) if a file is missing
ModelTexts read_model_texts(const std::filesystem::path& dir);
/// @param hash  mesh hash of a model. @throws Error (input) if it is not the hash of the mesh
void require_mesh(const Mesh& mesh, const std::string& hash);

}  // namespace phynness
