// From the displacement fields of active nodes to modes and amplitudes (formats/model.md, family modal).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Proper orthogonal decomposition of the displacement fields of one active node (the fields without the
/// nodes that the probe moves itself, where the answer is known), or of a scalar field at all output nodes.
/// Units: m; of a field, its scale.
struct NodeModes {
  int components = 3;                   ///< at each output node: 3 of a displacement, 1 of a field
  std::vector<std::int32_t> row;        ///< n states: of TrainingTables::displacements
  std::vector<std::int32_t> direction;  ///< n states
  Eigen::MatrixXd modes;                ///< components * n_output x n_modes, orthonormal columns
  Eigen::MatrixXd amplitudes;           ///< n states x n_modes
  Eigen::VectorXd size;                 ///< n_modes: singular values
  double lost = 0;          ///< mean over states and nodes of what n_modes modes miss, over the largest displacement
  double largest = 0;       ///< largest displacement or value at a node that the probe does not move itself
  std::vector<char> moved;  ///< n_output: moved by the probe itself
};
/// @param max_modes  fewer if there are fewer states
/// @throws Error (failure) if a converged increment holds a displacement that is not finite
NodeModes node_modes(const TrainingTables& tables, const TouchedNodes& prescribed, const std::vector<Ray>& rays,
                     int max_modes);

/// The same of a scalar field, counted in `scale`. @param field  index into DatabaseHeader::fields
/// @throws Error (failure) if a converged increment holds a value that is not finite
NodeModes field_modes(const TrainingTables& tables, const std::vector<Ray>& rays, std::size_t field, double scale,
                      int max_modes);

/// What the amplitudes of fields have beside kernels and linear terms: x_j x_k |x|^(degree - 2) for the pairs
/// xx xy xz yy yz zz, zero at x = 0. A field takes the same value at rest for x and -x: of degree 1 (a norm)
/// or 2 (a quadratic form), which no linear term can follow.
Eigen::Matrix<double, 6, 1> even_features(const Eigen::Vector3d& x, int degree);

/// Orthonormal columns that serve the modes of all given nodes best, each weighted by its size: the leading
/// left singular vectors, by subspace iteration from a start that depends on the seed only (Halko, Martinsson
/// & Tropp 2011, doi 10.1137/090771806).
Eigen::MatrixXd shared_basis(const std::vector<NodeModes>& nodes, int n_shared, std::uint64_t seed);

/// Which displacements the amplitudes of all nodes are centered at, and their kernel.
struct AmplitudeCenters {
  std::vector<std::int32_t> row;    ///< of TrainingTables::displacements, ascending
  std::vector<std::int32_t> order;  ///< the same as they were chosen
  double shape = 0.3;
  double left_out_error = 0;  ///< median over nodes: amplitudes at directions left out, over the largest displacement
};
/// Chosen by orthogonal least squares on the pooled amplitudes of the given nodes; the shape is the candidate
/// with the smallest left-out error.
AmplitudeCenters choose_amplitude_centers(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                          int max_centers);
/// Shapes that a search tries, ascending.
std::vector<double> amplitude_shape_candidates();

/// A level of the amplitudes: its centers and how many of a node's modes it has.
struct AmplitudeLevel {
  std::vector<std::int32_t> centers;  ///< as SharedModes::centers
  int modes = 0;                      ///< at least 1; a node that has fewer has fewer
};

struct ModalFit {
  ModalDeformation deformation;  ///< or, of a field, its tables
  /// Means over states and nodes of |difference|, over the largest displacement: of the modes as stored from
  /// the data (truncation), and of the amplitudes' network from the amplitudes (regression), on the training
  /// states.
  double truncation_error = 0, regression_error = 0;
  struct Level {
    ScaledTable weights;
    /// Mean over states and nodes of |difference|, over the largest displacement: truncation, and amplitudes
    /// predicted by the same least squares, centers given, of all other states.
    double left_out_error = 0;
  };
  std::vector<Level> levels;  ///< of the levels asked for
};
/// @param n_near  nodes whose rows are stored as they are: those that the shared modes serve worst
/// @param degree  of a field: adds even_features() to the amplitudes; 0: a displacement
/// @param levels  smallest first, the last that of the model; none: one level
ModalFit fit_modal(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node, int n_near,
                   int degree = 0, const std::vector<AmplitudeLevel>& levels = {});

}  // namespace phynness
