// Reads a model.txt into a phn_model by the grammar of phynness/schema/model_grammar.hpp.
#include <cfloat>

#include "core/evaluate.hpp"
#include "core/load_stores.hpp"
#include "core/text_lines.hpp"

namespace PHN_RUNTIME {
namespace {

// Largest output of a network: a sum of several outputs does not overflow.
constexpr double largest_output = 1e300;

/// The `io` of the grammar for reading, which prepares each part for evaluation once it is read.
class ModelLoader : public LinesReader {
 public:
  ModelLoader(TextReader& in, Arena& arena, phn_model& model, ModelStore& store)
      : LinesReader(in), _load{in, arena, model}, _arena(arena), _model(model), _store(store) {}

  template <class Line>
  void text(Line& line) {
    line.set(_load, _in.rest_of_line());
    end();
  }
  template <class Word>
  void word(const char*, Word& word) {
    word.set(_load, _in.word(static_cast<std::size_t>(schema::longest_word)));
  }
  void family(Family& family);
  /// Always true here, because the stores of corners and covered nodes look up the vertices themselves.
  static bool has_place(const ModelStore&, std::int32_t) { return true; }
  static bool has_output(const ModelStore&, std::int32_t) { return true; }

  template <class Store>
  static std::int64_t rows(const Store& store) {
    return store.rows();
  }
  template <class Store>
  static std::int64_t cols(const Store& store) {
    return store.cols();
  }
  template <class Store>
  static auto& item(Store& store, std::int64_t i) {
    return store.item(i);
  }
  template <class Store, class Value>
  void set(Store& store, std::int64_t i, std::int64_t k, Value value) {
    store.set(_load, i, k, value);
  }
  template <class Store>
  void shape(const char*, Store& store, std::int64_t rows, std::int64_t cols) {
    const bool sound = good();
    store.shape(_load, sound ? rows : 0, sound ? cols : 0);
  }
  void shape(const char*, Displacements& store, std::int64_t rows, std::int64_t cols);
  void shape(const char*, Nodes& nodes, std::int64_t rows, std::int64_t);

  /// Copies a table that later lines refer to into the model before the rest is read.
  template <class T>
  void done(Table<T>&) {
    _model.directions = _store.directions.at;
    _model.n_directions = static_cast<std::int32_t>(_store.directions.n);
    _model.displacements = _store.displacements.at;
    _model.n_displacements = static_cast<std::int32_t>(_store.displacements.n);
    _model.fixed_nodes = _store.fixed.at;
    _model.n_fixed = static_cast<std::int32_t>(_store.fixed.n);
    _model.fixed_points = _store.fixed_points.at;
    _model.output_nodes = _store.output.at;
    _model.n_output = static_cast<std::int32_t>(_store.output.n);
    _model.output_points = _store.output_points.at;
  }
  void done(NetworkStore& net);
  void done(FirstNeurons& first);
  void done(LinearStore& linear);
  void done(SharedStore& shared);
  void done(FieldStore& field);
  void done(ForceStore& force);
  void done(LevelStore&) {}
  void done(NodeLevelStore&) {}
  void done(NodeStore& node);

  /// Completes the model after the whole text is read. @param placed  null: without memory
  int finish(phn_model* placed);

 private:
  void within(const Row<3>& center, const Row<3>& half_range, const Row<3>& bias, const Weights& weights);
  void respond(schema::RbfnGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  void respond(schema::LinearGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  void respond(schema::ModalGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  bool modal() const { return schema::traits(_store.family).has_modes; }
  std::int64_t n_smaller() const { return _store.levels.n > 0 ? _store.levels.n - 1 : 0; }

  Load _load;
  Arena& _arena;
  phn_model& _model;
  ModelStore& _store;
};

template <class T>
void raise(T& largest, T value) {
  if (largest < value) largest = value;
}

void ModelLoader::family(Family& family) {
  for (std::uint32_t f = 0; f < schema::n_families; ++f) {
    TextReader attempt = _in;
    attempt.keyword(schema::family_words[f]);
    if (!attempt.good()) continue;
    _in = attempt;
    _model.family = family = static_cast<Family>(f);
    return;
  }
  _in.fail_next(PHN_ERROR_FAMILY);
}

void ModelLoader::shape(const char*, Displacements& store, std::int64_t rows, std::int64_t cols) {
  _model.max_displacement = _store.max_displacement_m;
  if (modal()) {
    store.divisor = _model.max_displacement;
    require(store.divisor >= 1 / largest_max_displacement && store.divisor <= largest_max_displacement, nullptr);
  }
  store.shape(_load, good() ? rows : 0, cols);
}

void ModelLoader::shape(const char*, Nodes& nodes, std::int64_t rows, std::int64_t) {
  nodes.n = good() ? rows : 0;
  const auto n = static_cast<std::size_t>(nodes.n);
  nodes.numbers = _arena.take<std::int32_t>(n);
  nodes.active = _arena.take<ActiveNode>(n);
  for (std::int64_t l = 0; l < n_smaller(); ++l) nodes.at_level[l] = _arena.take<ActiveNode>(n);
}

/// Requires that sums over a network's neurons stay within the range of their type.
void ModelLoader::within(const Row<3>& center, const Row<3>& half_range, const Row<3>& bias, const Weights& weights) {
  for (int k = 0; k < 3; ++k) {
    const double largest = std::fabs(bias.at[k]) + weights.size[k];
    const double bound = std::fabs(center.at[k]) + half_range.at[k] * largest;
    require(bound < largest_output, nullptr);
  }
}

void ModelLoader::done(NetworkStore& net) {
  const bool deforms = net.input_center.n == 6;
  within(net.output_center, net.output_half_range, net.bias, net.weights);
  Network& made = net.made;
  made.n_neurons = made.n_prepared = static_cast<std::int32_t>(net.weights.n);
  made.n_inputs = deforms ? 6 : 3;
  for (int k = 0; k < made.n_inputs; ++k) {
    made.input_center[k] = net.input_center.at[k];
    made.input_half_range[k] = net.input_half_range.at[k];
    made.center[k] = net.center[k];
  }
  for (int k = 0; k < 3; ++k) {
    made.output_center[k] = net.output_center.at[k];
    made.output_half_range[k] = net.output_half_range.at[k];
    made.bias[k] = net.bias.at[k];
    made.weight[k] = net.weights.at[k];
  }
  made.inverse_square_spread = 1 / (net.spread * net.spread);
  if (!deforms) return;
  raise(_model.n_basis, static_cast<std::size_t>(made.n_neurons));
  _model.prepared_neurons = _model.n_basis;
}

void ModelLoader::done(FirstNeurons& first) {
  const NetworkStore& full = *first.full;
  within(full.output_center, full.output_half_range, first.bias, first.weights);
  first.made = full.made;
  first.made.n_neurons = static_cast<std::int32_t>(first.weights.n);
  for (int k = 0; k < 3; ++k) {
    first.made.bias[k] = first.bias.at[k];
    first.made.weight[k] = first.weights.at[k];
  }
}

void ModelLoader::done(LinearStore& linear) {
  LinearResponse made = {};
  memcpy(made.stiffness, linear.stiffness.at, sizeof made.stiffness);
  for (int k = 0; k < 3; ++k) made.unit_response[k] = linear.unit_responses.at[k];
  linear.made = place(_arena, made);
}

void ModelLoader::done(SharedStore& shared) {
  shared.modes.make(_model.shared, 3, _model.n_output);
  _model.shared.shape = shared.shape;
  shared.centers.make(_load, _model.shared);
}

void ModelLoader::done(FieldStore& field) {
  SharedField& made = _model.fields[_model.n_fields++];
  made.name = field.name.at;
  made.unit = field.unit.at;
  made.degree = field.degree;
  made.scale = field.scale;
  field.modes.make(made, 1, _model.n_output);
}

/// Copies centers and coefficients to the layout of the force kernel and computes the constants that make forces at
/// rest 0.
void ModelLoader::done(ForceStore& store) {
  ModalForce& made = store.made;
  made.n_centers = static_cast<std::int32_t>(store.centers.n);
  made.max_displacement = _model.max_displacement;
  made.displacements = _model.displacements;
  made.shape = store.shape;
  memcpy(made.stiffness, store.stiffness.at, sizeof made.stiffness);
  made.center = store.centers.at;
  made.short_coefficient = store.coefficients.short_values;
  made.coefficient = store.coefficients.values;
  const bool in_table = made.n_centers > most_gathered;
  auto* table = _arena.take<double>(in_table ? 6 * static_cast<std::size_t>(whole_blocks(made.n_centers + 1)) : 0);
  if (!in_table) table = nullptr;
  made.table = table;
  if (_load.has_memory() && good()) set_rest(made, table);
}

ModalTables with_weights(ModalTables tables, const ScaledTable& weights) {
  tables.n_modes = static_cast<std::int32_t>(weights.entries.cols());
  tables.weight_scale = weights.scale.at;
  tables.weight = weights.entries.at;
  return tables;
}

void ModelLoader::respond(schema::ModalGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller) {
  const auto n_fields = static_cast<std::size_t>(_model.n_fields);
  ModalTables of_field[largest_field_count];
  ModalResponse full = {};
  static_cast<ModalTables&>(full) = node.modal.made();
  const auto n_modes = static_cast<std::size_t>(full.n_modes);
  raise(_model.n_basis, n_modes);
  if (worth_preparing(_model.shared, full)) {
    raise(_model.prepared_modes, full.n_modes);
    raise(_model.prepared_near, 3 * static_cast<std::size_t>(full.n_near) * n_modes);
  }
  for (std::size_t f = 0; f < n_fields; ++f) {
    of_field[f] = node.fields.part[f].made();
    raise(_model.n_field_scratch, static_cast<std::size_t>(_model.shared.n_centers) + schema::n_field_terms +
                                      static_cast<std::size_t>(of_field[f].n_modes) +
                                      static_cast<std::size_t>(_model.fields[f].n_modes));
  }
  const auto place_at = [&](ModalResponse response, const ForceStore& force, const auto& field) {
    response.force = force.made;
    auto* fields = _arena.take<ModalTables>(n_fields);
    for (std::size_t f = 0; fields && f < n_fields; ++f) fields[f] = field(f);
    response.fields = fields;
    return place(_arena, response);
  };
  made.modal = place_at(full, node.conservative, [&](std::size_t f) { return of_field[f]; });
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    const NodeLevelStore& level = node.levels.part[l];
    ModalResponse response = full;
    static_cast<ModalTables&>(response) = with_weights(full, level.weights);
    smaller[l].modal = place_at(response, level.conservative,
                                [&](std::size_t f) { return with_weights(of_field[f], level.field_weights.part[f]); });
  }
}

void ModelLoader::respond(schema::RbfnGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller) {
  made.networks = place(_arena, Networks{node.force.made, node.deformation.made});
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    const NodeLevelStore& level = node.levels.part[l];
    smaller[l].networks = place(_arena, Networks{level.force.made, level.deformation.made});
  }
}

void ModelLoader::respond(schema::LinearGrammar, NodeStore& node, ActiveNode& made, ActiveNode*) {
  made.linear = node.linear.made;
}

void ModelLoader::done(NodeStore& node) {
  if (!good()) return;
  Nodes& nodes = _store.nodes;
  ActiveNode made = {}, smaller[largest_level_count - 1];
  memcpy(made.point, node.point.at, sizeof made.point);
  made.output = _model.output_nodes ? find_sorted(_model.output_nodes, _model.n_output, node.node) : -1;
  made.moves_mean = node.moves_mean;
  if (node.moves_mean && node.prescribed.n_kept < node.prescribed.n) made.output = -1;  // the mean is not known
  made.n_prescribed = node.prescribed.n_kept;
  made.prescribed = node.prescribed.position;
  made.prescribed_weight = node.prescribed_weight.weight;
  made.trained_depth = nodes.known.values;
  made.least_depth = nodes.known.least;
  made.fill_distance = nodes.known.fill_distance;
  made.incomplete = node.n_incomplete > 0;
  if (node.bounds.n > 0 && node.bounds.part[0].scale.at != nullptr) {
    made.bound = node.bounds.part[0].entries.at;
    made.bound_scale = node.bounds.part[0].scale.at[0];
  }
  for (auto& level : smaller) level = made;
  schema::with_grammar(_store.family, [&](auto family) { respond(family, node, made, smaller); });
  if (!_load.has_memory()) return;
  const double rest[3] = {0, 0, 0};
  double force[3];
  evaluate_force(_model, made, rest, force);
  // Rounded up, so that no other order of this sum is larger; a bound, however large.
  made.bound_at_rest = std::fmin(length(force) * (1 + 4 * DBL_EPSILON), 0.99 * PHN_NO_BOUND);
  nodes.numbers[nodes.in_work] = node.node;
  nodes.active[nodes.in_work] = made;
  for (std::int64_t l = 0; l < n_smaller(); ++l) nodes.at_level[l][nodes.in_work] = smaller[l];
}

phn_provenance provenance_of(const ModelStore& store) {
  const auto said = [](const Text& text) { return text.at != nullptr ? text.at : ""; };
  const SolvedBody& solved = store.solved;
  const FinerDistance& finer = store.finer;
  phn_provenance out = {};
  out.mesh_hash = said(store.mesh_hash);
  out.physics_hash = said(store.physics_hash);
  out.element = said(solved.is_recorded ? solved.element : finer.element);
  out.reference = said(finer.reference);
  out.shear_modulus_Pa = solved.shear_modulus_Pa;
  out.finer_mean = finer.mean;
  out.finer_p95 = finer.p95;
  out.finer_tool_radius_m = finer.tool_radius_m;
  out.finer_probes = finer.probes;
  out.finer_nodes = finer.nodes;
  out.element_revision = solved.is_recorded ? solved.revision : finer.revision;
  out.bound_reference = store.bounds.part[0].reference;
  return out;
}

int ModelLoader::finish(phn_model* placed) {
  phn_model& model = _model;
  model.title = _store.title.at;
  model.provenance = provenance_of(_store);
  model.n_nodes = _store.n_mesh_nodes;
  model.n_triangles = static_cast<std::int32_t>(_store.surface.n);
  model.triangles = _store.surface.at;
  model.n_active = static_cast<std::int32_t>(_store.nodes.n);
  model.active_nodes = _store.nodes.numbers;
  model.active = _store.nodes.active;
  model.n_probe_triangles = static_cast<std::int32_t>(_store.probe_triangles.n);
  model.probe_triangles = _store.probe_triangles.at;
  model.n_covered = static_cast<std::int32_t>(_store.covered.n);
  model.covered = _store.covered.at;
  model.coupled_bound = _store.bounds.part[0].coupled.at;
  model.n_levels = static_cast<std::int32_t>(n_smaller()) + 1;
  if (_store.levels.n > 0) {
    const LevelStore& last = _store.levels.part[_store.levels.n - 1];
    model.errors = {last.error_force, last.error_displacement};
  }
  const auto n_kernels = static_cast<std::size_t>(model.shared.n_centers) + 3;
  const auto n_shared = static_cast<std::size_t>(model.shared.n_modes);
  model.n_scratch = n_kernels > n_shared ? n_kernels : n_shared;
  raise(model.n_scratch, 3 * model.prepared_neurons);
  model.n_scratch += model.n_basis;
  raise(model.n_scratch, model.n_field_scratch);
  auto* smaller = _arena.take<phn_model>(static_cast<std::size_t>(n_smaller()));
  // Each smaller level has its own centers of amplitudes.
  SharedModes of_level[largest_level_count];
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    of_level[l] = model.shared;
    if (modal()) _store.levels.part[l].centers.make(_load, of_level[l]);
  }
  if (!_in.at_end()) _in.fail_next(PHN_ERROR_SYNTAX);
  if (!good()) return _in.status();
  if (_arena.overflow()) return PHN_ERROR_BUFFER;
  if (placed == nullptr) return PHN_OK;
  const double unit = modal() ? model.max_displacement : 1;
  const double first = length(model.displacements) * unit;
  model.first_increment = model.max_displacement / 10;
  if (first > 1e-6 * model.max_displacement && first < 1e3 * model.max_displacement) model.first_increment = first;
  model.full = placed;
  model.smaller = smaller;
  model.bytes = _arena.used();
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    smaller[l] = model;
    smaller[l].shared = of_level[l];
    smaller[l].errors = {_store.levels.part[l].error_force, _store.levels.part[l].error_displacement};
    smaller[l].active = _store.nodes.at_level[l];
  }
  *placed = model;
  return PHN_OK;
}

}  // namespace

int load_model(const char* text, std::size_t length, Arena& arena, const phn_model** result, std::size_t& wrong_byte) {
  *result = nullptr;
  const int envelope = schema::check_envelope(schema::model_first_line, text, length, wrong_byte);
  if (envelope != PHN_OK) return envelope;
  TextReader in(text, length);
  in.rest_of_line();  // identity and version are already checked
  in.end_line();
  phn_model model = {};
  model.n_basis = 3;
  model.n_levels = 1;
  auto* placed = arena.take<phn_model>(1);
  ModelStore store;
  ModelLoader loader(in, arena, model, store);
  schema::model(loader, store);
  const int status = loader.finish(placed);
  wrong_byte = in.wrong_byte();
  if (status == PHN_OK) *result = placed;
  return status;
}

}  // namespace PHN_RUNTIME
