// Applies the grammar of models (phynness/schema/model_grammar.hpp) to a model whose sizes are known but whose numbers
// are not.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <phynness/formats/model_stores.hpp>
#include <phynness/formats/tool.hpp>
#include <phynness/planning/model_size.hpp>
#include <phynness/schema/model_grammar.hpp>
#include <phynness/schema/text_reader.hpp>

namespace phynness {
namespace {

/// Mean number of characters of a hexadecimal number: half a sign, a 1 and a point, the digits of 52 or 23 bits without
/// zeros at their end, and an exponent between p-1 and p-9, which most fitted numbers have.
constexpr double full_characters = 0.5 + 2 + 12.93 + 3, float_characters = 0.5 + 2 + 5.86 + 3;

/// A table of numbers that training will compute.
struct Unknown {
  std::int64_t n_rows = 0, n_cols = 1;
  double characters = full_characters;  ///< of a number; for integers the mean over their range
};
Unknown floats(std::int64_t rows, std::int64_t cols) { return {rows, cols, float_characters}; }

struct PlannedTable {
  Unknown scale, entries;
  PlannedTable(std::int64_t rows = 0, std::int64_t cols = 0) : scale{cols}, entries{rows, cols} {}
};

struct PlannedNetwork {
  Unknown input_center, input_half_range, output_center{3}, output_half_range{3}, bias{3};
  double spread = 0.75;
  Unknown center_displacement, center_output, weights;
  PlannedNetwork(int neurons = 0, int n_inputs = 3)
      : input_center{n_inputs},
        input_half_range{n_inputs},
        center_displacement{neurons},
        center_output{n_inputs == 6 ? neurons : 0},
        weights{neurons, 3} {}
};

struct PlannedFirstNeurons {
  Unknown bias{3}, weights;
};

struct PlannedForce {
  double shape = 0.1;
  Unknown stiffness = floats(3, 3), centers, coefficients;
  PlannedForce(std::int64_t n = 0) : centers{n}, coefficients(floats(n, 3)) {}
};

struct PlannedModes {
  PlannedTable weights, mixing, near_modes;
  Unknown near;
  PlannedModes(std::int64_t n_basis = 0, std::int64_t n_shared = 0, std::int64_t n_near = 0, int components = 3,
               std::int64_t m = 0)
      : weights(n_basis, m), mixing(n_shared, m), near_modes(components * n_near, m), near{n_near} {}
};

struct PlannedField {
  std::string name, unit;
  int degree = 1;
  double scale = 1;
  PlannedTable modes;
};

struct PlannedLevel {
  double error_force = 0.1, error_displacement = 0.1;
  Unknown centers;
};

struct PlannedNodeLevel {
  PlannedFirstNeurons force, deformation;
  PlannedForce conservative;
  PlannedTable weights;
  std::vector<PlannedTable> field_weights;
};

struct PlannedNode {
  bool moves_mean = false;
  std::int32_t node = 0, n_incomplete = 0;
  Vec3 point{};
  std::vector<std::int32_t> prescribed;
  std::vector<double> prescribed_weight, trained_depth_m;
  PlannedNetwork force, deformation{0, 6};
  struct {
    Unknown stiffness, unit_responses;
  } linear;
  PlannedForce conservative;
  PlannedModes modal;
  std::vector<PlannedModes> fields;
  std::vector<PlannedNodeLevel> levels;
  std::vector<PlannedTable> bounds;
};

/// The properties of a model that the database determines, and the sizes of the rest.
struct PlannedModel : Model {
  Unknown displacements;
  struct {
    PlannedTable modes;
    Unknown centers;
    double shape = 0.3;
  } shared;
  std::vector<PlannedField> fields;
  std::vector<PlannedLevel> levels;
  std::vector<PlannedNode> nodes;
};

/// Mean number of digits, and of signs, of the integers from low to high.
double mean_characters(double low, double high) {
  if (low < 0) return 0.5 + mean_characters(0, high);
  double characters = 0;
  for (double first = 0, end = 10, digits = 1; first <= high; first = end, end *= 10, ++digits)
    characters += digits * std::max(0.0, std::min(end, high + 1) - std::max(first, low));
  return characters / (high - low + 1);
}

/// Counts the bytes of the text that the grammar writes.
class TextCount : public ModelStores {
 public:
  double bytes() const { return _bytes; }

  void keyword(std::string_view word) { _bytes += 1 + static_cast<double>(word.size()); }
  void end() {}  // a line feed has the same size as the space that is counted in its place
  void text(const std::string& line) { _bytes += line.empty() ? 0 : 1 + static_cast<double>(line.size()); }
  void word(const char*, const std::string& word) { keyword(word); }
  void family(Family family) { keyword(name(family)); }
  void real(const char*, double value, const schema::Bound&) {
    char buffer[40];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::hex).ptr;
    _bytes += 1 + (_unknown ? _unknown->characters : static_cast<double>(end - buffer));
    _unknown = nullptr;
  }
  void integer(const char*, std::int32_t value, std::int32_t low, std::int32_t high) {
    _bytes += 1 + (_unknown ? mean_characters(low, high) : static_cast<double>(std::to_string(value).size()));
    _unknown = nullptr;
  }
  void count(const char* what, std::int32_t n, std::int32_t low) { integer(what, n, low, n); }
  void room(const char*, std::uint64_t) {}
  bool optional(const char*, bool present) { return present; }
  void require(bool, const char*) {}
  static constexpr bool good() { return true; }

  using ModelStores::cols;
  using ModelStores::rows;
  static std::int64_t rows(const Unknown& table) { return table.n_rows; }
  static std::int64_t cols(const Unknown& table) { return table.n_cols; }
  template <class Store>
  void shape(const char*, const Store&, std::int64_t, std::int64_t) {}
  template <class Store>
  auto get(const Store& store, std::int64_t i, std::int64_t k) const {
    return cell(store, i, k);
  }
  /// The next number is not known.
  double get(const Unknown& table, std::int64_t, std::int64_t) {
    _unknown = &table;
    return 0;
  }
  template <class Store, class T>
  void set(const Store&, std::int64_t, std::int64_t, T) {}
  template <class T>
  void done(const T&) {}
  static bool has_place(const Model&, std::int32_t) { return true; }

 private:
  double _bytes = 0;
  const Unknown* _unknown = nullptr;
};

/// Halves all numbers for each level below the full one; the smallest sizes of training have little influence.
template <class Count>
Count halved(Count full, std::size_t below) {
  const Count step = Count{1} << below;
  return (full + step - 1) / step;
}

/// The largest numbers that the database allows.
void plan_shared(const TrainingSpec& spec, const std::vector<Field>& fields, PlannedModel& model) {
  const auto n_output = static_cast<std::int64_t>(model.output.size());
  const auto modes = [&](std::int64_t rows) { return std::min<std::int64_t>(spec.shared_modes, rows); };
  const bool deforms = schema::traits(model.family).has_modes && spec.modes > 0;
  model.shared.modes = PlannedTable(3 * n_output, deforms ? modes(3 * n_output) : 0);
  model.shared.centers = {deforms ? std::min<std::int64_t>(spec.amplitude_centers, model.displacements.n_rows) : 0};
  for (std::size_t f = 0; deforms && f < fields.size(); ++f)
    model.fields.push_back(
        {name(fields[f]), unit(fields[f]), degree(fields[f]), 1, PlannedTable(n_output, modes(n_output))});
  if (spec.levels < 2 || !schema::traits(model.family).has_levels) return;
  model.levels.resize(static_cast<std::size_t>(spec.levels));
  for (std::size_t l = 0; l < model.levels.size(); ++l)
    model.levels[l].centers = {halved(model.shared.centers.n_rows, model.levels.size() - 1 - l)};
}

void plan_response(const TrainingSpec& spec, const PlannedModel& model, PlannedNode& node) {
  const std::int64_t states = model.displacements.n_rows, n_centers = model.shared.centers.n_rows;
  const auto n_output = static_cast<std::int64_t>(model.output.size());
  const std::int64_t m = std::min<std::int64_t>(spec.modes, states);
  const std::int64_t n_near = m > 0 ? std::min<std::int64_t>(spec.near_nodes, n_output) : 0;
  node.force = PlannedNetwork(spec.force_neurons, 3);
  node.deformation = PlannedNetwork(spec.deformation_neurons, 6);
  // Training rounds these values to float32 if they are stored as float32.
  node.linear = {Unknown{3, 3}, floats(n_output, 9)};
  node.conservative = PlannedForce(std::min<std::int64_t>(spec.force_centers, states));
  node.modal = PlannedModes(n_centers + schema::n_linear_terms, model.shared.modes.entries.n_cols, n_near, 3, m);
  for (const auto& field : model.fields)
    node.fields.emplace_back(n_centers + schema::n_field_terms, field.modes.entries.n_cols, n_near, 1, m);
  for (std::size_t l = 0; l + 1 < model.levels.size(); ++l) {
    const std::size_t below = model.levels.size() - 1 - l;
    const std::int64_t n_of_level = model.levels[l].centers.n_rows, m_of_level = halved(m, below);
    PlannedNodeLevel& level = node.levels.emplace_back();
    level.force.weights = {halved(node.force.weights.n_rows, below), 3};
    level.deformation.weights = {halved(node.deformation.weights.n_rows, below), 3};
    level.conservative = PlannedForce(halved(node.conservative.centers.n_rows, below));
    level.weights = PlannedTable(n_of_level + schema::n_linear_terms, m_of_level);
    level.field_weights.assign(model.fields.size(), PlannedTable(n_of_level + schema::n_field_terms, m_of_level));
  }
}

double text_bytes(const Scene& scene, const DatabaseHeader& header, std::size_t n_nodes) {
  PlannedModel model;
  static_cast<Model&>(model) = model_of_database(header, scene.training.family, scene.title);
  model.displacements = {static_cast<std::int64_t>(header.directions.size() * header.magnitudes_m.size()), 3};
  plan_shared(scene.training, header.fields, model);
  const auto& active = header.sets.active;
  for (std::size_t k = 0; k < n_nodes; ++k) {
    PlannedNode& node = model.nodes.emplace_back();
    node.node = active[std::min(active.size() - 1, k * active.size() / n_nodes + active.size() / (2 * n_nodes))];
    for (int i = 0; i < 3; ++i) node.point[static_cast<std::size_t>(i)] = header.mesh.nodes(node.node, i);
    const auto tool = touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, node.node, scene.probe);
    node.moves_mean = tool.mean;
    node.prescribed = tool.nodes;
    node.prescribed_weight = tool.weights;
    node.trained_depth_m.assign(header.directions.size(), model.max_displacement_m);
    plan_response(scene.training, model, node);
  }
  TextCount count;
  schema::model(count, model);
  return static_cast<double>(sizeof schema::model_first_line - 1 + schema::checksum_line_length) + count.bytes();
}

}  // namespace

ModelSize predict_model_size(const Scene& scene, const DatabaseHeader& header) {
  const double one = text_bytes(scene, header, 1);
  const double two = text_bytes(scene, header, 2);
  const auto n = static_cast<double>(header.sets.active.size());
  return {one + (n - 1) * (two - one), static_cast<double>(write_mesh_text(header.mesh).size())};
}

}  // namespace phynness
