// The nodes around a tool, and one tool that is answered from their responses alone (docs/theory.md, tools anywhere).
#pragma once

#include <phynness/phynness.h>

#include <phynness/schema/surface_gradient.hpp>

#include "core/arena.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Largest number of active nodes from which a place is answered: the corners of its triangle, or three for each corner
/// that has coordinates between active nodes.
inline constexpr std::int32_t most_corners = 9;

/// An active node or linear point and its weight in a node of the surface.
struct Corner {
  std::int32_t active;
  double weight;
};
/// Finds the active nodes whose responses give that of a node of the surface, with weights > 0: the node itself, or the
/// nodes between which it lies. @return their number; 0: the node is neither active nor covered
std::int32_t find_corners(const phn_model& model, std::int32_t node, Corner corner[3]);

/// The active nodes around a point of the surface.
struct Place {
  std::int32_t n_nodes;
  std::int32_t active[most_corners];  ///< positions among the active nodes and linear points
  double weight[most_corners];        ///< parts of the barycentric weights of corners that are not fixed
  Vector point;                       ///< on the surface; of fixed corners' weights the others take shares
  double fixed_weight;                ///< of the fixed corners
  double least_weight;                ///< see least_share
  bool counts(std::int32_t i) const { return weight[i] > least_weight; }
};

inline bool is_of_this_version(const phn_tool& tool) { return (tool.reserved[0] | tool.reserved[1]) == 0; }

/// Checks a tool and finds its nodes. @return a status of phynness.h
int find_place(const phn_model& model, const phn_tool& tool, Place& place);

/// Whether the tools at all nodes of the place are round: each moves a mean.
bool is_round(const phn_model& model, const Place& place);

/// Whether the place is between nodes and so close to a fixed one that no mean of responses is that of a round tool.
bool is_beside_fixed(const phn_model& model, const Place& place);

/// Whether one tool there needs no coupling: it is at a node, or it is round.
inline bool needs_no_coupling(const phn_model& model, const Place& place) {
  return place.n_nodes == 1 || is_round(model, place);
}

/// Whether a tool of the model is round; such a model answers one tool only.
bool has_round_tools(const phn_model& model);

/// Neighbours of each active node and each linear point. They are of the same kind, so that no linear point changes a
/// trained response. Models without round tools have none.
const schema::Neighbours* find_neighbours(Arena& arena, const phn_model& model);

/// Weights of the energies of nodes in the energy of one tool: E(d) = sum_i w_i E_i(d / transmission).
struct Mean {
  std::int32_t n;
  std::int32_t active[most_corners * (1 + schema::most_neighbours)];
  double weight[most_corners * (1 + schema::most_neighbours)];
  double share[most_corners];  ///< of the nodes of the place, with the sum 1
  /// Displacement of the point over that of the node: below 1 for a single node beside fixed ones, 1 for round tools.
  double transmission;
};
double transmission_of(const phn_model& model, const Place& place);
/// The nodes of the place come first. @pre needs_no_coupling(model, place)
Mean mean_at(const phn_model& model, const schema::Neighbours* neighbours, const Place& place);

/// Computes the energy E(d) of one tool, its gradient and its second derivative.
/// @param energy, stiffness  may be null; if not, model.has_energy
void respond_as_mean(const phn_model& model, const Mean& mean, const Vector& d, Vector& force, double* energy,
                     Matrix* stiffness);

}  // namespace PHN_RUNTIME
