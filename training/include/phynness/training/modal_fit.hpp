// Fits modes and amplitudes to the displacement fields of active nodes (formats/model.md, family modal).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Proper orthogonal decomposition of the displacement fields of one active node, without the nodes that the probe
/// itself moves because their displacements are known, or of a scalar field at all output nodes. Unit: m; for a field,
/// its scale.
struct NodeModes {
  int components = 3;                    ///< rows per output node: 3 for displacements, 1 for a scalar field
  std::vector<std::int32_t> row;         ///< n states: row of TrainingTables::displacements
  std::vector<std::int32_t> direction;   ///< n states
  std::vector<std::int32_t> increments;  ///< as TrainingStates::increments
  Eigen::MatrixXd modes;                 ///< components * n_output x n_modes, orthonormal columns
  Eigen::MatrixXd amplitudes;            ///< n states x n_modes
  Eigen::VectorXd singular_values;       ///< n_modes
  double truncation_error = 0;           ///< mean over states and nodes, over the largest displacement
  double largest_value = 0;      ///< largest displacement or value at a node that the probe itself does not move
  std::vector<char> prescribed;  ///< n_output: flags of nodes that the probe itself moves
};
/// @param max_modes  largest number of modes, which is also limited by the number of states
/// @throws Error (failure) if a displacement of a converged increment is not finite
NodeModes node_modes(const TrainingTables& tables, const TouchedNodes& tool, const std::vector<Ray>& rays,
                     int max_modes);

/// The same for a scalar field in units of `scale`. @param field  index in DatabaseHeader::fields
/// @throws Error (failure) if a value of a converged increment is not finite
NodeModes field_modes(const TrainingTables& tables, const std::vector<Ray>& rays, std::size_t field, double scale,
                      int max_modes);

/// Terms of the amplitudes of fields beside kernels and linear terms: x_j x_k |x|^(degree - 2) for the pairs xx xy xz
/// yy yz zz, 0 at x = 0. Near rest a field has the same value for x and -x. It is a norm (degree 1) or a quadratic form
/// (degree 2), which linear terms cannot represent.
Eigen::Matrix<double, 6, 1> even_features(const Eigen::Vector3d& x, int degree);

/// Orthonormal basis that best approximates the modes of all given nodes, each weighted by its singular value: the
/// leading left singular vectors, computed by subspace iteration from a start that depends only on the seed (Halko,
/// Martinsson & Tropp 2011, doi 10.1137/090771806).
Eigen::MatrixXd shared_basis(const std::vector<NodeModes>& nodes, int n_shared, std::uint64_t seed);

/// Centers and kernel of the amplitudes of all nodes.
struct AmplitudeCenters {
  std::vector<std::int32_t> row;    ///< rows of TrainingTables::displacements, ascending
  std::vector<std::int32_t> order;  ///< the same rows in the order of their selection
  double shape = 0.3;
  double left_out_error = 0;  ///< median over nodes: error at left-out directions over the largest displacement
};
/// Selects the centers by orthogonal least squares for the amplitudes of all given nodes. The shape is the candidate
/// with the smallest left-out error.
AmplitudeCenters choose_amplitude_centers(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                          int max_centers);

/// A level of the amplitudes: its centers, and its number of modes of each node.
struct AmplitudeLevel {
  std::vector<std::int32_t> centers;  ///< as SharedModes::centers
  int modes = 0;                      ///< at least 1; also limited by the number of modes of the node
};

/// The modes of a node as sums of shared modes, least squares, and at the nodes where those have the largest errors,
/// weighted by the sizes of the modes, as they are.
struct MixedModes {
  Eigen::MatrixXd mixing;          ///< n_shared x n_modes
  std::vector<std::int32_t> near;  ///< positions among the output nodes, ascending
  Eigen::MatrixXd near_modes;      ///< components * n_near x n_modes
};
/// @param basis  components * n_output x n_shared, orthonormal columns up to rounding
MixedModes mix_modes(const Eigen::MatrixXd& basis, const NodeModes& node, int n_near);

struct ModalFit {
  ModalDeformation deformation;  ///< of a displacement or of a scalar field
  /// Errors on the training states: means of |difference| over states and nodes, over the largest displacement.
  /// Truncation: stored modes compared with the data. Regression: network of the amplitudes compared with the
  /// amplitudes.
  double truncation_error = 0, regression_error = 0;
  struct Level {
    ScaledTable weights;
    /// Leave-one-out error: mean of |difference| over states and nodes, over the largest displacement. It includes
    /// truncation. Amplitudes are predicted by the same least squares with the same centers from all other states.
    double left_out_error = 0;
  };
  std::vector<Level> levels;  ///< of the given levels
};
/// @param n_near  number of nodes with modes of their own, at which shared modes have the largest errors
/// @param degree  degree of a field, which adds even_features() to the amplitudes; 0: a displacement
/// @param levels  smallest first, the last is the full model; empty: one level
ModalFit fit_modal(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node, int n_near,
                   int degree = 0, const std::vector<AmplitudeLevel>& levels = {});

}  // namespace phynness
