// The model in memory: structure of arrays, all pointers into the caller's memory.
#pragma once

#include <phynness/phynness.h>

#include <cstddef>
#include <cstdint>

namespace phynness::runtime {

/// Gaussian network on scaled inputs and outputs, (11)-(12).
struct Network {
  std::int32_t n_neurons, n_inputs;  ///< n_inputs: 3 or 6
  double input_center[6], input_half_range[6];
  double output_center[3], output_half_range[3];
  double bias[3];
  double inverse_square_spread;  ///< 1 / r^2
  const double* center[6];       ///< per input: n_neurons, scaled
  const double* weight[3];       ///< per output: n_neurons
};

enum class Family : std::uint8_t { rbfn, linear };

/// Displacements of a linear model are cut to this size per component [m], and no coefficient of one is
/// larger: their products and sums stay finite.
inline constexpr double largest_linear = 1e100;

/// Force = stiffness d; u = d_x U_x + d_y U_y + d_z U_z.
struct LinearResponse {
  double stiffness[6];             ///< xx xy xz yy yz zz [N/m]
  const double* unit_response[3];  ///< U per axis of d: n_output x 3 [m/m]
};

/// Of the responses, only those of the model's family are filled in.
struct ActiveNode {
  double point[3];                 ///< reference coordinates [m]
  std::int32_t output;             ///< position among the output nodes, or -1
  std::int32_t n_prescribed;       ///< output nodes that the probe moves itself
  const std::int32_t* prescribed;  ///< their positions among the output nodes
  const double* prescribed_weight;
  const double* trained_depth;  ///< n_directions [m]
  bool incomplete;
  Network force, deformation;
  LinearResponse linear;
};

}  // namespace phynness::runtime

struct phn_model {
  phynness::runtime::Family family;
  std::int32_t n_nodes, n_active, n_output, n_directions, max_neurons;
  const std::int32_t *active_nodes, *output_nodes;
  const double* output_points;  ///< n_output x 3
  const double* directions;     ///< n_directions x 3
  const phynness::runtime::ActiveNode* active;
};

namespace phynness::runtime {

class Arena;

/// Walks the whole text; fills the model if the arena has memory, otherwise only counts.
/// @param model  set to the model inside the arena, or null
/// @return a status of phynness.h
int load_model(const char* text, std::size_t length, Arena& arena, const phn_model** model);

/// Position of `node` among the active nodes, or -1.
std::int32_t find_active(const phn_model& model, std::int32_t node);
/// Position of `node` in an ascending list of n, or -1.
std::int32_t find_sorted(const std::int32_t* list, std::int32_t n, std::int32_t node);

}  // namespace phynness::runtime
