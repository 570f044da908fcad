// Stores for the numbers of a model.txt (phynness/schema/model_grammar.hpp), in the memory layout of the evaluation.
// Without memory they only count bytes.
#pragma once

#include <cmath>
#include <new>
#include <phynness/schema/model_grammar.hpp>
#include "core/text_lines.hpp"

#include "core/arena.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {

inline bool has_memory(const Arena& arena) { return !arena.counting() && !arena.overflow(); }

/// A copy in the model's memory; null without memory.
template <class T>
const T* place(Arena& arena, const T& value) {
  T* at = arena.take<T>(1);
  if (at) *at = value;
  return at;
}

/// State shared by all stores during loading.
struct Load {
  TextReader& in;
  Arena& arena;
  phn_model& model;
  bool has_memory() const { return PHN_RUNTIME::has_memory(arena); }
  void fail() { in.fail(PHN_ERROR_RANGE); }
  void require(bool condition) {
    if (!condition) fail();
  }
};

/// A table, row by row.
template <class T>
struct Table {
  T* at = nullptr;
  std::int64_t n = 0, n_cols = 1;

  std::int64_t rows() const { return n; }
  std::int64_t cols() const { return n_cols; }
  void shape(Load& load, std::int64_t rows, std::int64_t cols) {
    n = rows;
    n_cols = cols;
    at = load.arena.take<T>(static_cast<std::size_t>(rows), static_cast<std::size_t>(cols));
  }
  template <class V>
  void set(Load&, std::int64_t i, std::int64_t k, V value) {
    if (at) at[i * n_cols + k] = static_cast<T>(value);
  }
};

/// A few numbers that are not stored in the model's memory.
template <std::int32_t most>
struct Row {
  double at[most] = {};
  std::int32_t n = 0;
  void shape(Load&, std::int64_t rows, std::int64_t) { n = static_cast<std::int32_t>(rows); }
  void set(Load&, std::int64_t i, std::int64_t, double value) { at[i] = value; }
};

/// A symmetric matrix: xx xy xz yy yz zz.
struct Stiffness {
  double at[6] = {};
  void set(Load&, std::int64_t i, std::int64_t k, double value) { at[i == 0 ? k : i + k + 1] = value; }
};

/// A null-terminated string.
struct Text {
  const char* at = nullptr;
  void set(Load& load, const TextReader::Token& token) {
    char* to = load.arena.take<char>(token.length() + 1);
    at = to;
    if (to == nullptr) return;
    memcpy(to, token.begin, token.length());
    to[token.length()] = 0;
  }
};
struct SkippedText {
  void set(Load&, const TextReader::Token&) {}
};

/// Displacements [m]; in family modal divided by max_displacement_m.
struct Displacements : Table<double> {
  double divisor = 1;
  void set(Load&, std::int64_t i, std::int64_t k, double value) {
    if (at) at[i * n_cols + k] = value / divisor;
  }
};

/// Corners of triangles, converted from node numbers to vertices. Without memory they are not looked up.
struct Corners : Table<std::int32_t> {
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t node);
};

/// Covered nodes, by their position among the output nodes.
struct Covered : Table<std::int32_t> {
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t value) {
    if (!load.has_memory()) return;
    const phn_model& model = load.model;
    at[4 * i + k] = k == 0 ? find_sorted(model.output_nodes, model.n_output, value) : value;
    load.require(at[4 * i + k] >= 0);
  }
};

/// Output nodes that a probe moves, by their position. Other moved nodes have no results and are not stored.
struct Prescribed {
  std::int32_t* position = nullptr;
  std::int32_t n_kept = 0, last = -1;
  std::int64_t n = 0;
  std::int64_t rows() const { return n; }
  void shape(Load& load, std::int64_t rows, std::int64_t) {
    n = rows;
    position = load.arena.take<std::int32_t>(static_cast<std::size_t>(rows));
  }
  void set(Load& load, std::int64_t, std::int64_t, std::int32_t node) {
    const phn_model& model = load.model;
    last = model.output_nodes ? find_sorted(model.output_nodes, model.n_output, node) : -1;
    if (last >= 0 && position) position[n_kept] = last;
    if (last >= 0) ++n_kept;
  }
};
struct PrescribedWeight {
  const Prescribed* of = nullptr;
  double* weight = nullptr;
  void shape(Load& load, std::int64_t rows, std::int64_t) {
    weight = load.arena.take<double>(static_cast<std::size_t>(rows));
  }
  void set(Load&, std::int64_t, std::int64_t, double value) {
    if (of->last >= 0 && weight) weight[of->n_kept - 1] = value;
  }
};

/// Trained depths. Most nodes have the same depths as the node before; equal depths are stored once.
struct Depths {
  struct Known {
    TextReader text{nullptr, 0};  ///< positioned at their first line
    const double* values = nullptr;
    std::int32_t n = -1;
    double least = 0, fill_distance = 0;
  };
  Known* known = nullptr;  ///< depths of the node before; updated to this node's
  double* own = nullptr;
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load& load, std::int64_t i, std::int64_t, double value);
};

// Family rbfn.

struct NetworkStore;
/// Scaled coordinates of centers, taken from the rows of a table.
struct Centers {
  NetworkStore* net = nullptr;
  std::int32_t first_input = 0;
  void shape(Load& load, std::int64_t rows, std::int64_t cols);
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t row);
};

/// Weights of neurons for each output, padded with 0 to whole blocks.
struct Weights {
  double* at[3] = {};
  double size[3] = {};  ///< sums of absolute values
  std::int64_t n = 0;
  std::int64_t rows() const { return n; }
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load&, std::int64_t i, std::int64_t k, double value) {
    size[k] += std::fabs(value);
    if (at[k]) at[k][i] = value;
  }
};

struct NetworkStore {
  Row<6> input_center, input_half_range;
  Row<3> output_center, output_half_range, bias;
  double spread = 1;
  Centers center_displacement, center_output;
  Weights weights;
  double* center[6] = {};
  Network made = {};

  NetworkStore() {
    center_displacement.net = center_output.net = this;
    center_output.first_input = 3;
  }
  NetworkStore(const NetworkStore&) = delete;
};

/// Bias and weights of a level, which uses the first neurons of a network.
struct FirstNeurons {
  const NetworkStore* full = nullptr;
  Row<3> bias;
  Weights weights;
  Network made = {};
};

// Family linear.

struct LinearStore {
  Stiffness stiffness;
  struct UnitResponses {
    double* at[3] = {};
    void shape(Load& load, std::int64_t rows, std::int64_t);
    void set(Load&, std::int64_t i, std::int64_t k, double value) {
      if (at[k / 3]) at[k / 3][3 * i + k % 3] = value;
    }
  } unit_responses;
  const LinearResponse* made = nullptr;
};

// Family modal.

struct ScaledTable {
  Table<double> scale;
  Table<std::int16_t> entries;
};

/// Modes shared by all nodes, as floats in blocks of rows.
struct SharedTableStore {
  Table<double> scale;
  struct Entries {
    const SharedTableStore* of = nullptr;
    float* at = nullptr;
    std::int64_t n = 0, n_cols = 0;
    std::int64_t rows() const { return n; }
    std::int64_t cols() const { return n_cols; }
    void shape(Load& load, std::int64_t rows, std::int64_t cols);
    void set(Load&, std::int64_t r, std::int64_t c, std::int32_t entry) {
      constexpr std::int64_t rows = rows_per_block;
      if (at) at[((r / rows) * n_cols + c) * rows + r % rows] = static_cast<float>(of->scale.at[c] * entry);
    }
  } entries;
  SharedTableStore() { entries.of = this; }
  SharedTableStore(const SharedTableStore&) = delete;
  void make(SharedTable& shared, std::int32_t components, std::int32_t n_output) const {
    shared.components = components;
    shared.n_rows = components * n_output;
    shared.n_modes = static_cast<std::int32_t>(entries.n_cols);
    shared.modes = entries.at;
  }
};

/// Centers of amplitudes, stored by component.
struct AmplitudeCenters {
  double* at[3] = {};
  double* at_rest = nullptr;
  std::int64_t n = 0;
  std::int64_t rows() const { return n; }
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load& load, std::int64_t i, std::int64_t, std::int32_t row);
  /// Sets the centers and the values whose subtraction makes amplitudes at rest exactly 0. @pre shared.shape is set
  void make(Load& load, SharedModes& shared) const;
};

struct SharedStore {
  SharedTableStore modes;
  AmplitudeCenters centers;
  double shape = 1;
};

struct FieldStore {
  Text name, unit;
  std::int32_t degree = 1;
  double scale = 1;
  SharedTableStore modes;
};

/// Rows of the displacements, which must be within largest_center.
struct ForceCenters : Table<std::int32_t> {
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t row);
};
/// Coefficients, stored as floats if all of them are exact in float, else as doubles.
struct Coefficients {
  float* short_values = nullptr;
  double* values = nullptr;
  bool floats = false;
  double size = 0;
  void shape(Load& load, std::int64_t rows, std::int64_t cols);
  void set(Load& load, std::int64_t i, std::int64_t k, double value) {
    size += std::fabs(value);
    load.require(std::isfinite(size));
    if (short_values) short_values[3 * i + k] = static_cast<float>(value);
    if (values) values[3 * i + k] = value;
  }
};
struct ForceStore {
  double shape = 1;
  Stiffness stiffness;
  ForceCenters centers;
  Coefficients coefficients;
  ModalForce made = {};
};

struct ModesStore {
  ScaledTable weights, mixing, near_modes;
  Table<std::int32_t> near;
  ModalTables made() const;
};

// Lists of items.

template <class T, std::int32_t most>
struct Parts {
  T part[most];
  std::int64_t n = 0;
  std::int64_t rows() const { return n; }
  void shape(Load&, std::int64_t rows, std::int64_t) { n = rows; }
  T& item(std::int64_t i) { return part[i]; }
};

struct BoundStore {
  double coverage = 0;
  std::int32_t n_rays = 0, n_nodes = 0, reference = 0;
  Table<double> coupled;
};

/// Of the finite elements, which no answer depends on.
struct SolvedBody {
  bool is_recorded = false;
  Text element;
  std::int32_t revision = 0;
  double shear_modulus_Pa = 0;
};

struct FinerDistance {
  bool is_measured = false;
  Text element, reference;
  std::int32_t revision = 0, probes = 0, nodes = 0, solved = 0;
  double tool_radius_m = 0, mean = 0, p95 = 0;
};

struct LevelStore {
  double error_force = 0, error_displacement = 0;
  AmplitudeCenters centers;
};

/// Response of an active node at a smaller level.
struct NodeLevelStore {
  FirstNeurons force, deformation;
  ForceStore conservative;
  ScaledTable weights;
  Parts<ScaledTable, largest_field_count> field_weights;
};

struct NodeStore {
  std::int32_t node = -1, n_incomplete = 0;
  bool moves_mean = false;
  Row<3> point;
  Prescribed prescribed;
  PrescribedWeight prescribed_weight;
  Depths trained_depth_m;
  NetworkStore force, deformation;  // rbfn
  LinearStore linear;
  ForceStore conservative;  // modal, and the members below
  ModesStore modal;
  Parts<ModesStore, largest_field_count> fields;
  Parts<NodeLevelStore, largest_level_count - 1> levels;
  Parts<ScaledTable, schema::largest_bound_count> bounds;

  explicit NodeStore(Depths::Known& known) {
    prescribed_weight.of = &prescribed;
    trained_depth_m.known = &known;
    for (std::int32_t l = 0; l + 1 < largest_level_count; ++l) {
      levels.part[l].force.full = &force;
      levels.part[l].deformation.full = &deformation;
    }
  }
};

/// The active nodes, which are built one after the other.
struct Nodes {
  Depths::Known known;
  alignas(NodeStore) unsigned char memory[sizeof(NodeStore)];
  std::int32_t* numbers = nullptr;
  ActiveNode* active = nullptr;
  ActiveNode* at_level[largest_level_count - 1] = {};  ///< smaller levels
  std::int64_t n = 0, in_work = -1;

  std::int64_t rows() const { return n; }
  NodeStore& item(std::int64_t i) {
    in_work = i;
    return *new (memory) NodeStore(known);
  }
};

struct ModelStore {
  Family family{};
  Text title, mesh_hash, physics_hash;
  SkippedText software_version;
  double max_displacement_m = 1;
  std::int32_t n_mesh_nodes = 0;
  Table<double> directions, fixed_points, output_points;
  Displacements displacements;
  Table<std::int32_t> fixed, output;
  Corners surface;
  SharedStore shared;
  Parts<FieldStore, largest_field_count> fields;
  Parts<LevelStore, largest_level_count> levels;
  Parts<BoundStore, schema::largest_bound_count> bounds;
  SolvedBody solved;
  FinerDistance finer;
  Nodes nodes;
  Table<std::int32_t> probe_triangles;
  Covered covered;
};

}  // namespace PHN_RUNTIME
