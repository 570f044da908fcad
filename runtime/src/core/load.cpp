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
  template <std::size_t n>
  static void set(double (&row)[n], std::int64_t i, std::int64_t, double value) {
    row[i] = value;
  }
  template <class Store>
  void shape(const char*, Store& store, std::int64_t rows, std::int64_t cols) {
    const bool sound = good();
    store.shape(_load, sound ? rows : 0, sound ? cols : 0);
  }
  template <std::size_t n>
  static void shape(const char*, double (&)[n], std::int64_t, std::int64_t) {}
  void shape(const char*, Displacements& store, std::int64_t rows, std::int64_t cols);
  void shape(const char*, Nodes& nodes, std::int64_t rows, std::int64_t);
  void shape(const char*, LinearPoints& points, std::int64_t rows, std::int64_t);

  template <class Store>
  static void done(Store&) {}
  void done(NetworkStore& net);
  void done(FirstNeurons& first);
  void done(SharedStore& shared);
  void done(FieldStore& field);
  void done(ForceStore& force);
  void done(NodeStore& node);
  void done(LinearPointStore& point);

  /// Completes the model after the whole text is read. @param placed  null: without memory
  int finish(phn_model* placed);

 private:
  void within(const Network& full, const double* bias, const Weights& weights);
  void respond(schema::RbfnGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  void respond(schema::LinearGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  void respond(schema::ModalGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller);
  void place_linear_points();
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
    family = static_cast<Family>(f);
    _model.family = schema::word(family);
    _model.has_energy = schema::traits(family).has_energy ? 1 : 0;
    return;
  }
  _in.fail_next(PHN_ERROR_FAMILY);
}

void ModelLoader::shape(const char*, Displacements& store, std::int64_t rows, std::int64_t cols) {
  if (modal()) {
    store.divisor = _model.max_displacement_m;
    require(store.divisor >= 1 / largest_max_displacement && store.divisor <= largest_max_displacement, nullptr);
  }
  store.shape(_load, good() ? rows : 0, cols);
}

void ModelLoader::shape(const char*, Nodes& nodes, std::int64_t rows, std::int64_t) {
  const std::int64_t n = good() ? rows : 0, n_all = good() ? rows + _model.n_linear : 0;
  nodes.numbers.shape(_load, n, 1);
  nodes.active.shape(_load, n_all, 1);
  for (std::int64_t l = 0; l < n_smaller(); ++l)
    nodes.at_level[l] = _arena.take<ActiveNode>(static_cast<std::size_t>(n_all));
}

void ModelLoader::shape(const char*, LinearPoints& points, std::int64_t rows, std::int64_t) {
  points.n = good() ? rows : 0;
  points.data = _arena.take<RestResponse>(static_cast<std::size_t>(points.n));
  _model.n_linear = static_cast<std::int32_t>(points.n);
  _store.rest_modes.make(_model.rest_modes, 3, _model.n_output);
}

/// Requires that sums over a network's neurons stay within the range of their type.
void ModelLoader::within(const Network& full, const double* bias, const Weights& weights) {
  for (int k = 0; k < 3; ++k) {
    const double largest = std::fabs(bias[k]) + weights.size[k];
    const double bound = std::fabs(full.output_center[k]) + full.output_half_range[k] * largest;
    require(bound < largest_output, nullptr);
  }
}

void ModelLoader::done(NetworkStore& net) {
  within(net, net.bias, net.weights);
  net.n_prepared = net.n_neurons;
  net.inverse_square_spread = 1 / (net.spread * net.spread);
  if (net.n_inputs == 3) return;
  raise(_model.n_basis, static_cast<std::size_t>(net.n_neurons));
  _model.prepared_neurons = _model.n_basis;
}

void ModelLoader::done(FirstNeurons& first) {
  within(*first.full, first.bias, first.weights);
  const Network own = first;
  static_cast<Network&>(first) = *first.full;
  first.n_neurons = own.n_neurons;
  for (int k = 0; k < 3; ++k) {
    first.bias[k] = own.bias[k];
    first.weight[k] = own.weight[k];
  }
}

void ModelLoader::done(SharedStore& shared) {
  shared.modes.make(_model.shared, 3, _model.n_output);
  shared.centers.make(_load, _model.shared);
}

void ModelLoader::done(FieldStore& field) {
  field.modes.make(field, 1, _model.n_output);
  _model.field_names[_model.n_fields] = field.label;
  _model.field_units[_model.n_fields] = field.label_of_unit;
  _model.fields[_model.n_fields++] = field;
}

void ModelLoader::done(ForceStore& force) {
  force.max_displacement = _model.max_displacement_m;
  if (_load.has_memory() && good()) set_rest(force, force.centers.terms);
}

ModalTables with_weights(ModalTables tables, const ScaledTable& weights) {
  tables.n_modes = static_cast<std::int32_t>(weights.entries.cols());
  tables.weight_scale = weights.scale.data;
  tables.weight = weights.entries.data;
  return tables;
}

void ModelLoader::respond(schema::ModalGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller) {
  const auto n_fields = static_cast<std::size_t>(_model.n_fields);
  ModalResponse full = {};
  static_cast<ModalTables&>(full) = node.modal;
  const auto n_modes = static_cast<std::size_t>(full.n_modes);
  raise(_model.n_basis, n_modes);
  if (worth_preparing(_model.shared, full)) {
    raise(_model.prepared_modes, full.n_modes);
    raise(_model.prepared_near, 3 * static_cast<std::size_t>(full.n_near) * n_modes);
  }
  for (std::size_t f = 0; f < n_fields; ++f)
    raise(_model.n_field_scratch, static_cast<std::size_t>(_model.shared.n_centers) + schema::n_field_terms +
                                      static_cast<std::size_t>(node.fields.part[f].n_modes) +
                                      static_cast<std::size_t>(_model.fields[f].n_modes));
  const auto place_at = [&](ModalResponse response, const ModalForce& force, const auto& field) {
    response.force = force;
    auto* fields = _arena.take<ModalTables>(n_fields);
    for (std::size_t f = 0; fields && f < n_fields; ++f) fields[f] = field(f);
    response.fields = fields;
    return place(_arena, response);
  };
  made.modal = place_at(full, node.conservative, [&](std::size_t f) { return ModalTables(node.fields.part[f]); });
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    const NodeLevelStore& level = node.levels.part[l];
    ModalResponse response = full;
    static_cast<ModalTables&>(response) = with_weights(full, level.weights);
    smaller[l].modal = place_at(response, level.conservative, [&](std::size_t f) {
      return with_weights(node.fields.part[f], level.field_weights.part[f]);
    });
  }
}

void ModelLoader::respond(schema::RbfnGrammar, NodeStore& node, ActiveNode& made, ActiveNode* smaller) {
  made.networks = place(_arena, Networks{node.force, node.deformation});
  for (std::int64_t l = 0; l < n_smaller(); ++l) {
    const NodeLevelStore& level = node.levels.part[l];
    smaller[l].networks = place(_arena, Networks{level.force, level.deformation});
  }
}

void ModelLoader::respond(schema::LinearGrammar, NodeStore& node, ActiveNode& made, ActiveNode*) {
  made.linear = place(_arena, node.linear.made);
}

void ModelLoader::done(NodeStore& node) {
  if (!good()) return;
  Nodes& nodes = _store.nodes;
  ActiveNode &made = node.made, smaller[largest_level_count - 1];
  made.output = _model.output_nodes ? find_sorted(_model.output_nodes, _model.n_output, node.node) : -1;
  if (made.moves_mean && made.n_prescribed < node.prescribed.n) made.output = -1;  // the mean is not known
  made.least_depth = DBL_MAX;
  for (std::int32_t k = 0; made.trained_depth && k < _model.n_directions; ++k)
    made.least_depth = std::fmin(made.least_depth, made.trained_depth[k]);
  made.incomplete = node.n_incomplete > 0;
  if (node.bounds.part[0].scale.data != nullptr) {
    made.bound = node.bounds.part[0].entries.data;
    made.bound_scale = node.bounds.part[0].scale.data[0];
  }
  for (auto& level : smaller) level = made;
  schema::with_grammar(_store.family, [&](auto family) { respond(family, node, made, smaller); });
  if (!_load.has_memory()) return;
  const double rest[3] = {0, 0, 0};
  double force[3];
  evaluate_force(_model, made, rest, force);
  // Rounded up, so that no other order of this sum is larger; a bound, however large.
  made.bound_at_rest = std::fmin(length(force) * (1 + 4 * DBL_EPSILON), 0.99 * PHN_NO_BOUND);
  nodes.numbers.data[nodes.in_work] = node.node;
  nodes.active.data[nodes.in_work] = made;
  for (std::int64_t l = 0; l < n_smaller(); ++l) nodes.at_level[l][nodes.in_work] = smaller[l];
}

void ModelLoader::done(LinearPointStore& point) {
  if (!good() || !_load.has_memory()) return;
  RestResponse made = {};
  static_cast<ModalTables&>(made) = point;
  made.n_modes = _model.rest_modes.n_modes > 0 || made.n_near > 0 ? 3 : 0;
  for (int k = 0; k < 6; ++k) made.stiffness[k] = point.k[k];
  for (int k = 0; k < 3; ++k) made.point[k] = point.point[k];
  made.output = find_sorted(_model.output_nodes, _model.n_output, point.node);
  _store.linear_points.data[_store.linear_points.in_work] = made;
}

/// Adds the linear points behind the active nodes of each level.
void ModelLoader::place_linear_points() {
  for (std::int32_t i = 0; i < _model.n_linear; ++i) {
    ActiveNode made = {};
    made.rest = _store.linear_points.data + i;
    for (int k = 0; k < 3; ++k) made.point[k] = made.rest->point[k];
    made.output = made.rest->output;
    made.moves_mean = true;
    _store.nodes.active.data[_model.n_active + i] = made;
    for (std::int64_t l = 0; l < n_smaller(); ++l) _store.nodes.at_level[l][_model.n_active + i] = made;
  }
}

int ModelLoader::finish(phn_model* placed) {
  phn_model& model = _model;
  model.mesh_hash = model.provenance.mesh_hash;
  if (!_store.solved.is_recorded) model.provenance.element = _store.finer.its_element;
  model.provenance.bound_reference = _store.bounds.part[0].reference;
  model.bound_between = _store.bounds.part[0].between.data;
  model.n_levels = static_cast<std::int32_t>(n_smaller()) + 1;
  if (_store.levels.n > 0) {
    const LevelStore& last = _store.levels.part[_store.levels.n - 1];
    model.errors = {last.error_force, last.error_displacement};
  }
  const auto n_kernels = static_cast<std::size_t>(model.shared.n_centers) + 3;
  const auto n_shared = static_cast<std::size_t>(model.shared.n_modes);
  model.n_scratch = n_kernels > n_shared ? n_kernels : n_shared;
  raise(model.n_scratch, 3 * model.prepared_neurons);
  raise(model.n_scratch, static_cast<std::size_t>(model.rest_modes.n_modes));
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
  place_linear_points();
  const double unit = modal() ? model.max_displacement_m : 1;
  const double first = length(model.displacements) * unit;
  model.first_increment = model.max_displacement_m / 10;
  if (first > 1e-6 * model.max_displacement_m && first < 1e3 * model.max_displacement_m) model.first_increment = first;
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
  model.provenance.reference = "";
  model.n_basis = 3;
  auto* placed = arena.take<phn_model>(1);
  ModelStore store(model);
  ModelLoader loader(in, arena, model, store);
  schema::model(loader, store);
  const int status = loader.finish(placed);
  wrong_byte = in.wrong_byte();
  if (status == PHN_OK) *result = placed;
  return status;
}

}  // namespace PHN_RUNTIME
