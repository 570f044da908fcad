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
  T* data = arena.take<T>(1);
  if (data) *data = value;
  return data;
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

/// A table, row by row. A part of the model refers to it if it is given.
template <class T>
struct Table {
  Table() = default;
  explicit Table(const T*& made, std::int32_t* made_n = nullptr) : _made(&made), _made_n(made_n) {}

  T* data = nullptr;
  std::int64_t n = 0, n_cols = 1;

  std::int64_t rows() const { return n; }
  std::int64_t cols() const { return n_cols; }
  void shape(Load& load, std::int64_t rows, std::int64_t cols) {
    n = rows;
    n_cols = cols;
    data = load.arena.take<T>(static_cast<std::size_t>(rows), static_cast<std::size_t>(cols));
    if (_made != nullptr) *_made = data;
    if (_made_n != nullptr) *_made_n = static_cast<std::int32_t>(n);
  }
  template <class V>
  void set(Load&, std::int64_t i, std::int64_t k, V value) {
    if (data) data[i * n_cols + k] = static_cast<T>(value);
  }

 private:
  const T** _made = nullptr;
  std::int32_t* _made_n = nullptr;
};

/// A symmetric matrix: xx xy xz yy yz zz.
struct Stiffness {
  double* data;
  void set(Load&, std::int64_t i, std::int64_t k, double value) { data[i == 0 ? k : i + k + 1] = value; }
};

/// A null-terminated string.
struct Text {
  const char*& data;
  void set(Load& load, const TextReader::Token& token) {
    char* to = load.arena.take<char>(token.length() + 1);
    data = to;
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
  using Table::Table;
  double divisor = 1;
  void set(Load&, std::int64_t i, std::int64_t k, double value) {
    if (data) data[i * n_cols + k] = value / divisor;
  }
};

/// Corners of triangles, converted from node numbers to vertices. Without memory they are not looked up.
struct Corners : Table<std::int32_t> {
  using Table::Table;
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t node);
};

/// Covered nodes, by their position among the output nodes.
struct Covered : Table<std::int32_t> {
  using Table::Table;
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t value) {
    if (!load.has_memory()) return;
    const phn_model& model = load.model;
    data[4 * i + k] = k == 0 ? find_sorted(model.output_nodes, model.n_output, value) : value;
    load.require(data[4 * i + k] >= 0);
  }
};

/// Output nodes that a probe moves, by their position. Other moved nodes have no results and are not stored.
struct Prescribed : Table<std::int32_t> {
  explicit Prescribed(ActiveNode& made) : Table(made.prescribed), n_kept(made.n_prescribed) {}
  std::int32_t& n_kept;
  std::int32_t last = -1;
  void set(Load& load, std::int64_t, std::int64_t, std::int32_t node) {
    const phn_model& model = load.model;
    last = model.output_nodes ? find_sorted(model.output_nodes, model.n_output, node) : -1;
    if (last >= 0 && data) data[n_kept] = last;
    if (last >= 0) ++n_kept;
  }
};
struct PrescribedWeight : Table<double> {
  PrescribedWeight(ActiveNode& made, const Prescribed& nodes) : Table(made.prescribed_weight), of(nodes) {}
  const Prescribed& of;
  void set(Load&, std::int64_t, std::int64_t, double value) {
    if (of.last >= 0 && data) data[of.n_kept - 1] = value;
  }
};

// Family rbfn.

/// Scaled coordinates of centers, taken from the rows of a table.
struct Centers {
  Network& net;
  std::int32_t first_input;
  double* data[3] = {};
  void shape(Load& load, std::int64_t rows, std::int64_t cols);
  void set(Load& load, std::int64_t i, std::int64_t k, std::int32_t row);
};

/// Weights of neurons for each output, padded with 0 to whole blocks.
struct Weights {
  Network& net;
  double* data[3] = {};
  double size[3] = {};  ///< sums of absolute values
  std::int64_t rows() const { return net.n_neurons; }
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load&, std::int64_t i, std::int64_t k, double value) {
    size[k] += std::fabs(value);
    if (data[k]) data[k][i] = value;
  }
};

struct NetworkStore : Network {
  double spread = 1;
  Centers center_displacement{*this, 0}, center_output{*this, 3};
  Weights weights{*this};
  explicit NetworkStore(std::int32_t inputs) : Network{} { n_inputs = inputs; }
  NetworkStore(const NetworkStore&) = delete;
};

/// Bias and weights of a level, which uses the first neurons of a network.
struct FirstNeurons : Network {
  const NetworkStore* full = nullptr;
  Weights weights{*this};
  FirstNeurons() : Network{} {}
  FirstNeurons(const FirstNeurons&) = delete;
};

// Family linear.

struct LinearStore {
  LinearResponse made = {};
  Stiffness stiffness{made.stiffness};
  struct UnitResponses {
    const double** made;
    double* data[3] = {};
    void shape(Load& load, std::int64_t rows, std::int64_t);
    void set(Load&, std::int64_t i, std::int64_t k, double value) {
      if (data[k / 3]) data[k / 3][3 * i + k % 3] = value;
    }
  } unit_responses{made.unit_response};
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
    float* data = nullptr;
    std::int64_t n = 0, n_cols = 0;
    std::int64_t rows() const { return n; }
    std::int64_t cols() const { return n_cols; }
    void shape(Load& load, std::int64_t rows, std::int64_t cols);
    void set(Load&, std::int64_t r, std::int64_t c, std::int32_t entry) {
      constexpr std::int64_t rows = rows_per_block;
      if (data) data[((r / rows) * n_cols + c) * rows + r % rows] = static_cast<float>(of->scale.data[c] * entry);
    }
  } entries;
  SharedTableStore() { entries.of = this; }
  SharedTableStore(const SharedTableStore&) = delete;
  void make(SharedTable& shared, std::int32_t components, std::int32_t n_output) const {
    shared.components = components;
    shared.n_rows = components * n_output;
    shared.n_modes = static_cast<std::int32_t>(entries.n_cols);
    shared.modes = entries.data;
  }
};

/// Centers of amplitudes, stored by component.
struct AmplitudeCenters {
  double* data[3] = {};
  double* at_rest = nullptr;
  std::int64_t n = 0;
  std::int64_t rows() const { return n; }
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load& load, std::int64_t i, std::int64_t, std::int32_t row);
  /// Sets the centers and the values whose subtraction makes amplitudes at rest exactly 0. @pre shared.shape is set
  void make(Load& load, SharedModes& shared) const;
};

struct SharedStore {
  double& shape;
  SharedTableStore modes = {};
  AmplitudeCenters centers = {};
};

struct FieldStore : SharedField {
  const char *label = nullptr, *label_of_unit = nullptr;
  Text name{label}, unit{label_of_unit};
  SharedTableStore modes;
  FieldStore() : SharedField{} {}
};

/// The terms of a force (ModalForce::table). Centers must be within largest_center.
struct ForceCenters {
  ModalForce& force;
  double* terms = nullptr;
  std::int32_t n_whole = 0;
  std::int64_t rows() const { return force.n_centers; }
  void shape(Load& load, std::int64_t rows, std::int64_t);
  void set(Load& load, std::int64_t i, std::int64_t, std::int32_t row);
};
struct Coefficients {
  const ForceCenters& of;
  double size = 0;
  void shape(Load&, std::int64_t, std::int64_t) {}
  void set(Load& load, std::int64_t i, std::int64_t k, double value) {
    size += std::fabs(value);
    load.require(std::isfinite(size));
    if (of.terms) of.terms[(3 + k) * of.n_whole + i] = value;
  }
};
struct ForceStore : ModalForce {
  Stiffness stiffness{ModalForce::stiffness};
  ForceCenters centers{*this};
  Coefficients coefficients{centers};
  ForceStore() : ModalForce{} {}
  ForceStore(const ForceStore&) = delete;
};

struct ModesStore : ModalTables {
  ScaledTable weights{Table<double>(weight_scale, &n_modes), Table<std::int16_t>(weight)};
  ScaledTable mixing{Table<double>(mixing_scale, &n_columns), Table<std::int16_t>(ModalTables::mixing)};
  Table<std::int32_t> near{ModalTables::near, &n_near};
  ScaledTable near_modes{Table<double>(near_mode_scale), Table<std::int16_t>(near_mode)};
  ModesStore() : ModalTables{} {}
  ModesStore(const ModesStore&) = delete;
};

struct LinearPointStore : ModesStore {
  std::int32_t node = -1;
  double point[3] = {}, k[6] = {};
  Stiffness stiffness{k};
};

// Lists of items.

/// The linear points, which are built one after the other.
struct LinearPoints {
  RestResponse* data = nullptr;
  std::int64_t n = 0, in_work = -1;
  alignas(LinearPointStore) unsigned char memory[sizeof(LinearPointStore)];
  std::int64_t rows() const { return n; }
  LinearPointStore& item(std::int64_t i) {
    in_work = i;
    return *new (memory) LinearPointStore;
  }
};

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
  Table<double> between;
};

/// Of the finite elements, which no answer depends on.
struct SolvedBody {
  phn_provenance& made;
  bool is_recorded = false;
  Text element{made.element};
  double& shear_modulus_Pa = made.shear_modulus_Pa;
};

struct DistancePart {
  std::int32_t places = 0;
  double mean = 0, p95 = 0;
};

struct FinerDistance {
  phn_provenance& made;
  bool is_measured = false;
  const char* its_element = "";
  Text element{its_element}, reference{made.reference};
  std::int32_t solved = 0;
  std::int32_t &probes = made.finer_probes, &nodes = made.finer_nodes;
  double &tool_radius_m = made.finer_tool_radius_m, &mean = made.finer_mean, &p95 = made.finer_p95;
  bool has_parts = false;
  DistancePart skipped{};
  DistancePart& part(std::int32_t) { return skipped; }
  double unknowns_factor = 0, force_ratio = 0;
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
  ActiveNode made = {};
  std::int32_t node = -1, n_incomplete = 0;
  bool& moves_mean = made.moves_mean;
  double (&point)[3] = made.point;
  Prescribed prescribed{made};
  PrescribedWeight prescribed_weight{made, prescribed};
  Table<double> trained_depth_m{made.trained_depth};
  NetworkStore force{3}, deformation{6};  // rbfn
  LinearStore linear;
  ForceStore conservative;  // modal, and the members below
  ModesStore modal;
  Parts<ModesStore, largest_field_count> fields;
  Parts<NodeLevelStore, largest_level_count - 1> levels;
  Parts<ScaledTable, schema::largest_bound_count> bounds;

  NodeStore() {
    for (auto& level : levels.part) {
      level.force.full = &force;
      level.deformation.full = &deformation;
    }
  }
};

/// The active nodes, which are built one after the other.
struct Nodes {
  phn_model& made;
  alignas(NodeStore) unsigned char memory[sizeof(NodeStore)];
  Table<std::int32_t> numbers{made.active_nodes, &made.n_active};
  Table<ActiveNode> active{made.active};
  ActiveNode* at_level[largest_level_count - 1] = {};  ///< smaller levels
  std::int64_t in_work = -1;

  explicit Nodes(phn_model& model) : made(model) {}
  std::int64_t rows() const { return numbers.n; }
  NodeStore& item(std::int64_t i) {
    in_work = i;
    return *new (memory) NodeStore;
  }
};

/// Sections of the text, most of which go into the model at once.
struct ModelStore {
  phn_model& made;
  Family& family = made.kind;
  Text title{made.title}, mesh_hash{made.provenance.mesh_hash}, physics_hash{made.provenance.physics_hash};
  SkippedText software_version;
  double& max_displacement_m = made.max_displacement_m;
  std::int32_t& n_mesh_nodes = made.n_nodes;
  Table<double> directions{made.directions, &made.n_directions};
  Displacements displacements{made.displacements, &made.n_displacements};
  Table<std::int32_t> fixed{made.fixed_nodes, &made.n_fixed}, output{made.output_nodes, &made.n_output};
  Table<double> fixed_points{made.fixed_points}, output_points{made.output_points};
  Corners surface{made.triangles, &made.n_triangles};
  SharedStore shared{made.shared.shape};
  Parts<FieldStore, largest_field_count> fields;
  Parts<LevelStore, largest_level_count> levels;
  Parts<BoundStore, schema::largest_bound_count> bounds;
  SolvedBody solved{made.provenance};
  RelaxationStore relaxation{{made.relaxation}};
  FinerDistance finer{made.provenance};
  SharedTableStore rest_modes;
  LinearPoints linear_points;
  Nodes nodes{made};
  Table<std::int32_t> probe_triangles{made.probe_triangles, &made.n_probe_triangles};
  Table<std::int32_t> outer_triangles{made.outer_triangles, &made.n_outer_triangles};
  Covered covered{made.covered, &made.n_covered};

  explicit ModelStore(phn_model& model) : made(model) {}
};

}  // namespace PHN_RUNTIME
